//! Pass one over a binary body: where each element's records lie.
//!
//! Records without lists have one size. Records with lists mostly have one size too, since nearly
//! all meshes are of triangles alone: so the counts of the first record are taken for all, and
//! checked in parallel. Where they differ, the records are walked one by one, and the places of
//! some of them are kept, so that pass two can start at any of these.

use std::ops::Range;

use rayon::prelude::*;

use super::header::{Element, Encoding, Header, Kind};
use crate::text::excerpt;
use halfline::error::Error;
use halfline::progress::Observer;

/// Records between two checkpoints, and of one parallel piece of work.
pub const CHUNK_RECORDS: usize = 1 << 15;

/// Where the records of an element lie.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Extent {
    /// Bytes of the file.
    pub bytes: Range<usize>,
    /// How to find a record among them.
    pub records: Records,
}

/// How the records of an element follow each other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Records {
    /// All have `stride` bytes, and `properties` are at the same places in each.
    Fixed { stride: usize, properties: Vec<FixedProperty> },
    /// Record `i * CHUNK_RECORDS` begins at byte `checkpoints[i]` of the file.
    Varying { checkpoints: Vec<usize> },
}

/// A property of records of one size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FixedProperty {
    /// Of its first number (in a list, after the count), from the record's first byte.
    pub offset: usize,
    /// Numbers: one, or the list's count.
    pub count: usize,
}

/// Why a body has no layout.
pub enum Failure {
    /// The bytes end too early; more of them might do.
    Short { element: usize, record: u64 },
    /// No further bytes can make it right.
    Wrong { element: usize, record: u64, reason: String },
    /// The observer stopped the work.
    Stopped(Error),
}

/// The extents of all elements of `header` in `bytes`, the whole file.
pub fn locate(
    header: &Header,
    bytes: &[u8],
    observer: &dyn Observer,
) -> Result<Vec<Extent>, Failure> {
    let mut start = header.byte_length;
    let mut extents = Vec::with_capacity(header.elements.len());
    for (index, element) in header.elements.iter().enumerate() {
        let least = element.least_bytes(header.encoding);
        if least > (bytes.len() - start) as u128 {
            let fitting = (bytes.len() - start) as u128 * u128::from(element.count) / least;
            return Err(Failure::Short { element: index, record: fitting as u64 });
        }
        let extent = match header.encoding {
            Encoding::BigEndian => extent::<true>(index, element, bytes, start, observer)?,
            _ => extent::<false>(index, element, bytes, start, observer)?,
        };
        start = extent.bytes.end;
        extents.push(extent);
    }
    Ok(extents)
}

fn extent<const BIG: bool>(
    index: usize,
    element: &Element,
    bytes: &[u8],
    start: usize,
    observer: &dyn Observer,
) -> Result<Extent, Failure> {
    let empty =
        || Extent { bytes: start..start, records: Records::Varying { checkpoints: Vec::new() } };
    if element.count == 0 || element.is_void() {
        return Ok(empty());
    }
    let failure = |record, walk: Walk| match walk {
        Walk::Short => Failure::Short { element: index, record },
        Walk::Wrong(reason) => Failure::Wrong { element: index, record, reason },
    };
    // The caller has seen that each record has at least a byte in `bytes`: the count is a usize.
    let count = element.count as usize;

    // Take the first record for the model of all.
    let mut properties = Vec::with_capacity(element.properties.len());
    let stride = walk_record::<BIG>(element, &bytes[start..], &mut properties)
        .map_err(|walk| failure(0, walk))?;
    let model = &bytes[start..start + stride];
    if let Some(length) = stride.checked_mul(count).filter(|&n| n <= bytes.len() - start) {
        let bodies = &bytes[start..start + length];
        if all_like_the_first(element, &properties, model, bodies, observer)? {
            return Ok(Extent {
                bytes: start..start + length,
                records: Records::Fixed { stride, properties },
            });
        }
    }

    // Walk the records one by one.
    let mut checkpoints = Vec::with_capacity(count.div_ceil(CHUNK_RECORDS));
    let mut position = start;
    for record in 0..count {
        if record % CHUNK_RECORDS == 0 {
            observer.check().map_err(Failure::Stopped)?;
            checkpoints.push(position);
        }
        properties.clear();
        position += walk_record::<BIG>(element, &bytes[position..], &mut properties)
            .map_err(|walk| failure(record as u64, walk))?;
    }
    Ok(Extent { bytes: start..position, records: Records::Varying { checkpoints } })
}

/// Why a record ends nowhere.
pub enum Walk {
    /// It is longer than the bytes there are.
    Short,
    /// A list's count makes no sense.
    Wrong(String),
}

/// Finds the properties of the record that `bytes` begin with; returns its size.
#[inline]
pub fn walk_record<const BIG: bool>(
    element: &Element,
    bytes: &[u8],
    properties: &mut Vec<FixedProperty>,
) -> Result<usize, Walk> {
    let mut position = 0;
    for property in &element.properties {
        let (count, size) = match property.kind {
            Kind::Scalar(scalar) => (1, scalar.size()),
            Kind::List { count, item } => {
                let raw = bytes.get(position..position + count.size()).ok_or(Walk::Short)?;
                position += count.size();
                let length = count.integer::<BIG>(raw);
                let length = usize::try_from(length).map_err(|_| {
                    let name = excerpt(property.name.as_bytes());
                    Walk::Wrong(format!("list {name} has the count {length}"))
                })?;
                (length, item.size())
            }
        };
        // A product that saturates is more than any file holds.
        let length = count.saturating_mul(size);
        if length > bytes.len() - position {
            return Err(Walk::Short);
        }
        properties.push(FixedProperty { offset: position, count });
        position += length;
    }
    Ok(position)
}

/// True if every record of the size of `model` has the counts of `model`, compared as raw bytes.
fn all_like_the_first(
    element: &Element,
    properties: &[FixedProperty],
    model: &[u8],
    records: &[u8],
    observer: &dyn Observer,
) -> Result<bool, Failure> {
    let counts: Vec<Range<usize>> = element
        .properties
        .iter()
        .zip(properties)
        .filter_map(|(property, place)| match property.kind {
            Kind::Scalar(_) => None,
            Kind::List { count, .. } => Some(place.offset - count.size()..place.offset),
        })
        .collect();
    let stride = model.len();
    let chunks = records.par_chunks(stride * CHUNK_RECORDS);
    let like = match &counts[..] {
        [] => true,
        // The one list of bytes that nearly all files have.
        [count] if count.len() == 1 => {
            let (place, value) = (count.start, model[count.start]);
            chunks.all(|chunk| {
                observer.cancelled() || {
                    let mut difference = 0;
                    for record in chunk.chunks_exact(stride) {
                        difference |= record[place] ^ value;
                    }
                    difference == 0
                }
            })
        }
        counts => chunks.all(|chunk| {
            observer.cancelled()
                || chunk.chunks_exact(stride).all(|record| {
                    counts.iter().all(|count| record[count.clone()] == model[count.clone()])
                })
        }),
    };
    observer.check().map_err(Failure::Stopped)?;
    Ok(like)
}
