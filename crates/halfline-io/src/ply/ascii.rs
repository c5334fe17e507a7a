//! ASCII bodies: one record a line, parsed in parallel.
//!
//! A first pass counts the lines of each block of the body, so that a second one knows, block by
//! block, which records and which line numbers it has before it.

use std::ops::Range;
use std::path::Path;

use rayon::prelude::*;

use super::Parts;
use super::faces::{FaceChunk, Strips, Triangles, vertex_index};
use super::header::{Element, Header, Kind};
use super::scalar::Scalar;
use super::schema::Schema;
use crate::text::{excerpt, parse_f32, parse_f64, parse_integer};
use halfline::error::{Error, Result};
use halfline::mesh::Positions;
use halfline::progress::SharedProgress;

/// Bytes parsed as one parallel piece of work; up to the next end of a line.
const BLOCK_BYTES: usize = 256 << 10;

/// Some whole lines of the body.
struct Block {
    bytes: Range<usize>,
    /// The number of the first line, counted from 1 at the file's start.
    first_line: usize,
    /// The lines of the block that are not blank, counted from the body's start.
    records: Range<u64>,
}

struct Body<'a> {
    path: &'a Path,
    header: &'a Header,
    bytes: &'a [u8],
    blocks: Vec<Block>,
    progress: &'a SharedProgress<'a>,
}

/// True if `bytes` have at least as many records as `header` promises.
pub fn is_complete(header: &Header, bytes: &[u8]) -> bool {
    let body = &bytes[header.byte_length..];
    let lines = lines(body, header.line_end).filter(|line| !line.is_empty()).count() as u64;
    // The last line may go on.
    lines > records(&header.elements).end
}

/// Reads the parts of a mesh from `bytes`, the whole file.
pub fn read(
    path: &Path,
    header: &Header,
    schema: &Schema,
    bytes: &[u8],
    progress: &SharedProgress,
) -> Result<Parts> {
    let body =
        Body { path, header, bytes, blocks: find_blocks(header, bytes, progress)?, progress };
    body.check_counts()?;
    let (positions, colors) = body.read_vertices(schema)?;
    let mut triangles = match schema.face {
        Some((element, list)) => body.read_faces(element, list, &positions)?,
        None => Triangles::default(),
    };
    if let Some((element, list)) = schema.strips {
        let faces = schema.face.map_or(0, |(face, _)| header.elements[face].count as usize);
        let strips = body.read_strips(element, list, positions.len())?;
        triangles.append_strips(strips, faces);
    }
    Ok(Parts { positions, colors, triangles })
}

/// The records of the elements, which are one line each unless they have no properties.
fn records(elements: &[Element]) -> Range<u64> {
    let lines = elements.iter().filter(|e| !e.is_void()).map(|e| e.count);
    0..lines.fold(0, u64::saturating_add)
}

fn lines(bytes: &[u8], line_end: u8) -> impl Iterator<Item = &[u8]> {
    let mut start = 0;
    memchr::memchr_iter(line_end, bytes)
        .chain((!bytes.is_empty() && bytes.last() != Some(&line_end)).then_some(bytes.len()))
        .map(move |end| {
            let line = &bytes[start..end];
            start = end + 1;
            line.trim_ascii()
        })
}

fn find_blocks(header: &Header, bytes: &[u8], progress: &SharedProgress) -> Result<Vec<Block>> {
    let mut ranges = Vec::new();
    let mut start = header.byte_length;
    while start < bytes.len() {
        let least = (start + BLOCK_BYTES).min(bytes.len());
        let end = memchr::memchr(header.line_end, &bytes[least..])
            .map_or(bytes.len(), |length| least + length + 1);
        ranges.push(start..end);
        start = end;
    }
    let counts: Vec<(usize, u64)> = ranges
        .par_iter()
        .map(|range| {
            progress.check()?;
            Ok(lines(&bytes[range.clone()], header.line_end)
                .fold((0, 0), |(all, full), line| (all + 1, full + u64::from(!line.is_empty()))))
        })
        .collect::<Result<_>>()?;
    let (mut first_line, mut first_record) = (header.line_count + 1, 0);
    let blocks = ranges.into_iter().zip(counts).map(|(bytes, (line_count, record_count))| {
        let records = first_record..first_record + record_count;
        let block = Block { bytes, first_line, records };
        first_line += line_count;
        first_record += record_count;
        block
    });
    Ok(blocks.collect())
}

impl<'a> Body<'a> {
    /// Refuses a body with fewer lines than the header promises.
    fn check_counts(&self) -> Result<()> {
        let found = self.blocks.last().map_or(0, |block| block.records.end);
        let mut first = 0_u64;
        for element in self.header.elements.iter().filter(|e| !e.is_void()) {
            let last = first.saturating_add(element.count);
            if last > found {
                return Err(Error::format(
                    self.path,
                    element.place(found - first),
                    format!("the file ends before it; the header promises {} of it", element.count),
                ));
            }
            first = last;
        }
        Ok(())
    }

    /// Makes something of each block that has records of the element, by showing `visit` what it
    /// has made so far, and the number and the words of each record's line.
    fn read_element<T: Send>(
        &self,
        element: usize,
        begin: impl Fn(usize) -> T + Sync,
        visit: impl Fn(&mut T, &mut Line<'a>) -> Parsed<()> + Sync,
    ) -> Result<Vec<T>> {
        let before = records(&self.header.elements[..element]).end;
        let wanted = before..before + self.header.elements[element].count;
        let results: Vec<Result<T>> = self
            .blocks
            .par_iter()
            .filter(|b| b.records.start < wanted.end && wanted.start < b.records.end)
            .map(|block| {
                self.progress.check()?;
                let mut record = block.records.start;
                let mut made = begin(record.saturating_sub(before) as usize);
                let text = &self.bytes[block.bytes.clone()];
                for (i, line) in lines(text, self.header.line_end).enumerate() {
                    if line.is_empty() {
                        continue;
                    }
                    if wanted.contains(&record) {
                        let mut line = Line::new(line);
                        let visited = visit(&mut made, &mut line).and_then(|()| line.end());
                        visited.map_err(|reason| {
                            let place = format!("line {}", block.first_line + i);
                            Error::format(self.path, place, reason)
                        })?;
                    }
                    record += 1;
                }
                self.progress.advance(text.len())?;
                Ok(made)
            })
            .collect();
        results.into_iter().collect()
    }

    fn read_vertices(&self, schema: &Schema) -> Result<(Positions, Option<Vec<[u8; 4]>>)> {
        let element = &self.header.elements[schema.vertex];
        let slots = Slots::of(element, schema);
        let chunks = self.read_element(
            schema.vertex,
            |_| (Vec::new(), Vec::new(), Vec::new()),
            |(single, double, colors), line| {
                let (position, color) = slots.read(element, line)?;
                if schema.double {
                    double.push(position);
                } else {
                    // Exact: the type was one whose values single precision holds.
                    single.push(position.map(|value| value as f32));
                }
                if schema.color.is_some() {
                    colors.push(color);
                }
                Ok(())
            },
        )?;
        let count = element.count as usize;
        let (mut single, mut double, mut colors) = (Vec::new(), Vec::new(), Vec::new());
        if schema.double {
            double.reserve_exact(count)
        } else {
            single.reserve_exact(count)
        }
        for (mut s, mut d, mut c) in chunks {
            single.append(&mut s);
            double.append(&mut d);
            colors.append(&mut c);
        }
        let positions = if schema.double {
            Positions::F64(double.into())
        } else {
            Positions::F32(single.into())
        };
        Ok((positions, schema.color.map(|_| colors)))
    }

    fn read_faces(&self, element: usize, list: usize, positions: &Positions) -> Result<Triangles> {
        let properties = &self.header.elements[element];
        let chunks = self.read_element(
            element,
            |first| (FaceChunk::new(first), Vec::new()),
            |(chunk, polygon), line| {
                polygon.clear();
                line.visit_list(properties, list, |index| {
                    polygon.push(vertex_index(index, positions.len())?);
                    Ok(())
                })?;
                chunk.push(polygon, positions);
                Ok(())
            },
        )?;
        Ok(Triangles::join(chunks.into_iter().map(|(chunk, _)| chunk).collect()))
    }

    fn read_strips(&self, element: usize, list: usize, vertices: usize) -> Result<Strips> {
        let properties = &self.header.elements[element];
        let restart = match properties.properties[list].kind {
            Kind::List { item: Scalar::U32, .. } => i64::from(u32::MAX),
            _ => -1,
        };
        // In one piece: a strip's indices are gathered before they become triangles.
        let chunks = self.read_element(
            element,
            |_| Vec::new(),
            |indices: &mut Vec<Option<u32>>, line| {
                indices.push(None);
                line.visit_list(properties, list, |index| {
                    let ends = index == restart || index == -1;
                    indices.push(if ends { None } else { Some(vertex_index(index, vertices)?) });
                    Ok(())
                })
            },
        )?;
        let mut strips = Strips::default();
        for index in chunks.into_iter().flatten() {
            match index {
                Some(index) => strips.push(index),
                None => strips.restart(),
            }
        }
        Ok(strips)
    }
}

/// What each property of a vertex is for.
struct Slots(Vec<Slot>);

#[derive(Clone, Copy)]
enum Slot {
    Coordinate(usize),
    Color(usize),
    Other,
}

impl Slots {
    fn of(element: &Element, schema: &Schema) -> Slots {
        let mut slots = vec![Slot::Other; element.properties.len()];
        for (axis, &property) in schema.position.iter().enumerate() {
            slots[property] = Slot::Coordinate(axis);
        }
        if let Some((rgb, alpha)) = schema.color {
            for (component, property) in rgb.into_iter().chain(alpha).enumerate() {
                slots[property] = Slot::Color(component);
            }
        }
        Slots(slots)
    }

    fn read(&self, element: &Element, line: &mut Line) -> Parsed<([f64; 3], [u8; 4])> {
        let (mut position, mut color) = ([0.0; 3], [255; 4]);
        for (property, slot) in element.properties.iter().zip(&self.0) {
            match property.kind {
                Kind::Scalar(scalar) => {
                    let value = line.number(scalar)?;
                    match *slot {
                        Slot::Coordinate(axis) => position[axis] = value,
                        Slot::Color(component) => color[component] = scalar.color_byte(value),
                        Slot::Other => {}
                    }
                }
                Kind::List { count, item } => line.skip_list(count, item)?,
            }
        }
        Ok((position, color))
    }
}

/// What is still to be read of a line.
struct Line<'a> {
    rest: &'a [u8],
}

type Parsed<T> = std::result::Result<T, String>;

impl<'a> Line<'a> {
    fn new(line: &'a [u8]) -> Line<'a> {
        Line { rest: line }
    }

    /// The next word; empty at the line's end.
    #[inline]
    fn word(&mut self) -> &'a [u8] {
        let text = self.rest.trim_ascii_start();
        let length = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
        let (word, rest) = text.split_at(length);
        self.rest = rest;
        word
    }

    #[inline]
    fn number(&mut self, scalar: Scalar) -> Parsed<f64> {
        let word = self.word();
        let value = match scalar {
            Scalar::F32 => parse_f32(word).map(f64::from),
            Scalar::F64 => parse_f64(word),
            // Exact up to 2^53; coordinates beyond that are rounded.
            _ => return Ok(in_range(word, scalar)? as f64),
        };
        value.ok_or_else(|| not_a(word, "number"))
    }

    fn integer(&mut self, scalar: Scalar) -> Parsed<i64> {
        in_range(self.word(), scalar)
    }

    fn count(&mut self, scalar: Scalar) -> Parsed<i64> {
        match self.integer(scalar)? {
            count if count < 0 => Err(format!("a list has the count {count}")),
            count => Ok(count),
        }
    }

    fn skip_list(&mut self, count: Scalar, item: Scalar) -> Parsed<()> {
        for _ in 0..self.count(count)? {
            self.number(item)?;
        }
        Ok(())
    }

    /// Reads all properties of a record of `element`, and shows the items of its property `list`.
    #[inline]
    fn visit_list(
        &mut self,
        element: &Element,
        list: usize,
        mut visit: impl FnMut(i64) -> Parsed<()>,
    ) -> Parsed<()> {
        for (i, property) in element.properties.iter().enumerate() {
            match property.kind {
                Kind::List { count, item } if i == list => {
                    for _ in 0..self.count(count)? {
                        visit(self.integer(item)?)?;
                    }
                }
                Kind::List { count, item } => self.skip_list(count, item)?,
                Kind::Scalar(scalar) => {
                    self.number(scalar)?;
                }
            }
        }
        Ok(())
    }

    /// Refuses anything that follows: a line with too much on it is not what the header describes.
    fn end(&mut self) -> Parsed<()> {
        match self.word() {
            [] => Ok(()),
            word => Err(format!("'{}' is one value too many for the header", excerpt(word))),
        }
    }
}

#[inline]
fn in_range(word: &[u8], scalar: Scalar) -> Parsed<i64> {
    let value = parse_integer(word).ok_or_else(|| not_a(word, "whole number"))?;
    let (least, largest) = scalar.range();
    if value < least || value > largest {
        return Err(format!("{value} is outside its type's range from {least} to {largest}"));
    }
    Ok(value)
}

#[cold]
fn not_a(word: &[u8], what: &str) -> String {
    if word.is_empty() {
        format!("the line ends where a {what} should be")
    } else {
        format!("'{}' is not a {what}", excerpt(word))
    }
}
