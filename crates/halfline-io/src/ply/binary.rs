//! Pass two over a binary body: numbers into the mesh's arrays, in parallel.

use std::path::Path;

use rayon::prelude::*;

use super::Parts;
use super::faces::{FaceChunk, Strips, Triangles, vertex_index};
use super::header::{Element, Header, Kind};
use super::layout::{self, CHUNK_RECORDS, Extent, Failure, FixedProperty, Records};
use super::scalar::{Number, Scalar};
use super::schema::Schema;
use halfline::error::{Error, Result};
use halfline::mesh::Positions;
use halfline::progress::Observer;
use halfline::progress::SharedProgress;
use halfline::storage::zeroed;

/// Reads the parts of a mesh from `bytes`, the whole file; `BIG` says the byte order.
pub fn read<const BIG: bool>(
    path: &Path,
    header: &Header,
    schema: &Schema,
    bytes: &[u8],
    observer: &dyn Observer,
    progress: &SharedProgress,
) -> Result<Parts> {
    let extents = layout::locate(header, bytes, observer)
        .map_err(|failure| layout_error(path, header, failure))?;
    let table = |index: usize| Table::<BIG> {
        path,
        element: &header.elements[index],
        extent: &extents[index],
        bytes,
        progress,
    };
    let vertices = table(schema.vertex);
    let positions = read_positions(&vertices, schema)?;
    let colors = match schema.color {
        Some((rgb, alpha)) => Some(read_colors(&vertices, rgb, alpha)?),
        None => None,
    };
    let mut triangles = match schema.face {
        Some((element, list)) => read_faces(&table(element), list, &positions)?,
        None => Triangles::default(),
    };
    if let Some((element, list)) = schema.strips {
        let faces = schema.face.map_or(0, |(face, _)| header.elements[face].count as usize);
        triangles.append_strips(read_strips(&table(element), list, positions.len())?, faces);
    }
    Ok(Parts { positions, colors, triangles })
}

fn layout_error(path: &Path, header: &Header, failure: Failure) -> Error {
    match failure {
        Failure::Short { element, record } => {
            let element = &header.elements[element];
            let count = element.count;
            let reason = format!("the file ends before its end; the header promises {count} of it");
            Error::format(path, element.place(record), reason)
        }
        Failure::Wrong { element, record, reason } => {
            Error::format(path, header.elements[element].place(record), reason)
        }
        Failure::Stopped(error) => error,
    }
}

/// An element's records in the file.
struct Table<'a, const BIG: bool> {
    path: &'a Path,
    element: &'a Element,
    extent: &'a Extent,
    bytes: &'a [u8],
    progress: &'a SharedProgress<'a>,
}

impl<const BIG: bool> Table<'_, BIG> {
    fn count(&self) -> usize {
        // Layout has found a place in the file for each.
        self.element.count as usize
    }

    /// Shows to `visit` each record of the given chunk: its number, its bytes and where its
    /// properties are in them. Returns the bytes of the chunk.
    #[inline]
    fn visit_chunk(
        &self,
        chunk: usize,
        mut visit: impl FnMut(usize, &[u8], &[FixedProperty]) -> Result<()>,
    ) -> Result<usize> {
        self.progress.check()?;
        let first = chunk * CHUNK_RECORDS;
        let last = (first + CHUNK_RECORDS).min(self.count());
        match &self.extent.records {
            Records::Fixed { stride, properties } => {
                let start = self.extent.bytes.start;
                let records = &self.bytes[start + first * stride..start + last * stride];
                for (i, record) in records.chunks_exact(*stride).enumerate() {
                    visit(first + i, record, properties)?;
                }
                Ok(records.len())
            }
            Records::Varying { checkpoints } => {
                let start = checkpoints[chunk];
                let mut position = start;
                let mut properties = Vec::new();
                for record in first..last {
                    properties.clear();
                    let rest = &self.bytes[position..];
                    let size = layout::walk_record::<BIG>(self.element, rest, &mut properties)
                        .map_err(|_| {
                            self.error(record, "the file changed while it was read".to_owned())
                        })?;
                    visit(record, &rest[..size], &properties)?;
                    position += size;
                }
                Ok(position - start)
            }
        }
    }

    /// Sets each item of an array from the record of the same number, and shows each chunk of it,
    /// while the processor's caches still hold it, with its first number to `check`.
    fn fill<T: Copy + Send>(
        &self,
        zero: T,
        convert: impl Fn(&[u8], &[FixedProperty]) -> T + Sync,
        check: impl Fn(usize, &[T]) -> Result<()> + Sync,
    ) -> Result<Vec<T>> {
        let mut items = zeroed(zero, self.count());
        let results: Vec<Result<()>> = items
            .par_chunks_mut(CHUNK_RECORDS)
            .enumerate()
            .map(|(chunk, items)| {
                let first = chunk * CHUNK_RECORDS;
                let size = match &self.extent.records {
                    Records::Fixed { stride, properties } => {
                        self.progress.check()?;
                        let start = self.extent.bytes.start + first * stride;
                        let records = &self.bytes[start..start + items.len() * stride];
                        for (item, record) in items.iter_mut().zip(records.chunks_exact(*stride)) {
                            *item = convert(record, properties);
                        }
                        records.len()
                    }
                    Records::Varying { .. } => {
                        self.visit_chunk(chunk, |record, bytes, properties| {
                            items[record - first] = convert(bytes, properties);
                            Ok(())
                        })?
                    }
                };
                check(first, items)?;
                self.progress.advance(size)
            })
            .collect();
        results.into_iter().collect::<Result<()>>()?;
        Ok(items)
    }

    fn scalar(&self, property: usize) -> Scalar {
        match self.element.properties[property].kind {
            Kind::Scalar(scalar) => scalar,
            Kind::List { item, .. } => item,
        }
    }

    fn error(&self, record: usize, reason: String) -> Error {
        Error::format(self.path, self.element.place(record as u64), reason)
    }
}

/// For what needs no check.
fn unchecked<T>(_: usize, _: &[T]) -> Result<()> {
    Ok(())
}

fn read_positions<const BIG: bool>(vertices: &Table<BIG>, schema: &Schema) -> Result<Positions> {
    let xyz = schema.position;
    let [x, y, z] = xyz;
    let types = xyz.map(|property| vertices.scalar(property));
    let real = |axis: usize, bytes: &[u8], properties: &[FixedProperty]| {
        types[axis].real::<BIG>(&bytes[properties[xyz[axis]].offset..])
    };
    Ok(if types == [Scalar::F32; 3] {
        Positions::F32(
            vertices
                .fill(
                    [0.0; 3],
                    |bytes, properties| {
                        let read = |property: usize| {
                            f32::read::<BIG>(&bytes[properties[property].offset..])
                        };
                        [read(x), read(y), read(z)]
                    },
                    unchecked,
                )?
                .into(),
        )
    } else if types == [Scalar::F64; 3] {
        Positions::F64(
            vertices
                .fill(
                    [0.0; 3],
                    |bytes, properties| {
                        let read = |property: usize| {
                            f64::read::<BIG>(&bytes[properties[property].offset..])
                        };
                        [read(x), read(y), read(z)]
                    },
                    unchecked,
                )?
                .into(),
        )
    } else if schema.double {
        Positions::F64(
            vertices
                .fill(
                    [0.0; 3],
                    |bytes, properties| [0, 1, 2].map(|axis| real(axis, bytes, properties)),
                    unchecked,
                )?
                .into(),
        )
    } else {
        // Exact: each type is one whose values single precision holds.
        Positions::F32(
            vertices
                .fill(
                    [0.0; 3],
                    |bytes, properties| [0, 1, 2].map(|axis| real(axis, bytes, properties) as f32),
                    unchecked,
                )?
                .into(),
        )
    })
}

fn read_colors<const BIG: bool>(
    vertices: &Table<BIG>,
    rgb: [usize; 3],
    alpha: Option<usize>,
) -> Result<Vec<[u8; 4]>> {
    let component = |property: usize, bytes: &[u8], properties: &[FixedProperty]| {
        let scalar = vertices.scalar(property);
        scalar.color_byte(scalar.real::<BIG>(&bytes[properties[property].offset..]))
    };
    vertices.fill(
        [0; 4],
        |bytes, properties| {
            let [r, g, b] = rgb.map(|property| component(property, bytes, properties));
            [r, g, b, alpha.map_or(255, |property| component(property, bytes, properties))]
        },
        unchecked,
    )
}

fn read_faces<const BIG: bool>(
    faces: &Table<BIG>,
    list: usize,
    positions: &Positions,
) -> Result<Triangles> {
    let item = faces.scalar(list);
    if let Records::Fixed { properties, .. } = &faces.extent.records
        && properties[list].count == 3
        && matches!(item, Scalar::I32 | Scalar::U32)
    {
        let triangles = read_triangles(faces, list, positions.len())?;
        return Ok(Triangles { triangles, source_faces: None });
    }
    let chunks: Vec<Result<FaceChunk>> = (0..faces.count().div_ceil(CHUNK_RECORDS))
        .into_par_iter()
        .map(|chunk| {
            let mut result = FaceChunk::new(chunk * CHUNK_RECORDS);
            let mut polygon = Vec::new();
            let size = faces.visit_chunk(chunk, |face, bytes, properties| {
                polygon.clear();
                for index in items::<BIG>(item, bytes, properties[list]) {
                    let index = vertex_index(index, positions.len());
                    polygon.push(index.map_err(|reason| faces.error(face, reason))?);
                }
                if polygon.len() > CHUNK_RECORDS {
                    faces.progress.check()?;
                }
                result.push(&polygon, positions);
                Ok(())
            })?;
            faces.progress.advance(size)?;
            Ok(result)
        })
        .collect();
    Ok(Triangles::join(chunks.into_iter().collect::<Result<_>>()?))
}

/// The fast path: each face is a triangle of 32-bit indices.
fn read_triangles<const BIG: bool>(
    faces: &Table<BIG>,
    list: usize,
    vertices: usize,
) -> Result<Vec<[u32; 3]>> {
    let item = faces.scalar(list);
    // A negative index, read as unsigned, is too large as well.
    let limit = vertices.min(if item == Scalar::I32 { 1 << 31 } else { usize::MAX }) as u32;
    faces.fill(
        [0; 3],
        |bytes, properties| {
            let corners = &bytes[properties[list].offset..][..12];
            let corner = |at: usize| u32::read::<BIG>(&corners[at..]);
            [corner(0), corner(4), corner(8)]
        },
        |first, triangles| {
            let largest = triangles.iter().fold(0, |m, &[a, b, c]| m.max(a).max(b).max(c));
            if largest < limit {
                return Ok(());
            }
            let wrong = triangles.iter().position(|t| t.iter().any(|&i| i >= limit));
            let in_chunk = wrong.unwrap_or(0);
            let index = triangles[in_chunk].into_iter().find(|&i| i >= limit).unwrap_or(limit);
            let index =
                if item == Scalar::I32 { i64::from(index as i32) } else { i64::from(index) };
            let reason = vertex_index(index, vertices).err().unwrap_or_default();
            Err(faces.error(first + in_chunk, reason))
        },
    )
}

fn read_strips<const BIG: bool>(
    table: &Table<BIG>,
    list: usize,
    vertices: usize,
) -> Result<Strips> {
    let item = table.scalar(list);
    let mut strips = Strips::default();
    for chunk in 0..table.count().div_ceil(CHUNK_RECORDS) {
        let size = table.visit_chunk(chunk, |record, bytes, properties| {
            strips.restart();
            for (i, index) in items::<BIG>(item, bytes, properties[list]).enumerate() {
                if i % CHUNK_RECORDS == 0 {
                    table.progress.check()?;
                }
                if index == -1 || (item == Scalar::U32 && index == i64::from(u32::MAX)) {
                    strips.restart();
                } else {
                    let index = vertex_index(index, vertices);
                    strips.push(index.map_err(|reason| table.error(record, reason))?);
                }
            }
            Ok(())
        })?;
        table.progress.advance(size)?;
    }
    Ok(strips)
}

/// The numbers of a list in a record.
fn items<const BIG: bool>(
    item: Scalar,
    record: &[u8],
    list: FixedProperty,
) -> impl Iterator<Item = i64> {
    let length = list.count * item.size();
    record[list.offset..list.offset + length]
        .chunks_exact(item.size())
        .map(move |bytes| item.integer::<BIG>(bytes))
}
