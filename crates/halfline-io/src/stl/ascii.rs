//! ASCII STL, parsed in parallel.
//!
//! The text is cut into blocks after lines `endfacet`, between which a parser needs to know
//! nothing but whether it is inside a solid. That is put together afterwards.

use std::path::Path;

use rayon::prelude::*;

use crate::text::{excerpt, parse_f32, parse_f64, single_precision_reproduces};
use halfline::error::{Error, Result};
use halfline::progress::SharedProgress;

/// Bytes parsed as one parallel piece of work; up to the end of a facet.
pub(super) const BLOCK_BYTES: usize = 256 << 10;

/// The corners of all facets.
pub struct Facets {
    blocks: Vec<Vec<[[f64; 3]; 3]>>,
    /// The number of facets before each block, and after the last.
    starts: Vec<usize>,
    /// True if single precision does not reproduce all digits.
    pub double: bool,
}

impl Facets {
    pub fn count(&self) -> usize {
        self.starts.last().copied().unwrap_or(0)
    }

    pub fn corners(&self, facet: usize) -> [[f64; 3]; 3] {
        let block = self.starts.partition_point(|&start| start <= facet) - 1;
        self.blocks[block][facet - self.starts[block]]
    }
}

/// Parses `bytes`, a whole file.
pub fn parse(path: &Path, bytes: &[u8], progress: &SharedProgress) -> Result<Facets> {
    let start = bytes.len() - super::without_mark(bytes).len();
    let mut cuts = vec![start];
    while let Some(&last) = cuts.last()
        && last < bytes.len()
    {
        cuts.push(end_of_block(bytes, last + BLOCK_BYTES));
        progress.check()?;
    }
    let parsed: Vec<Result<Block>> = cuts
        .par_windows(2)
        .map(|cut| {
            let block = Block::parse(&bytes[..cut[1]], cut[0]);
            progress.advance(cut[1] - cut[0])?;
            Ok(block)
        })
        .collect();

    let wrong = |position: usize, reason: String| {
        Error::format(path, format!("line {}", line_number(bytes, position)), reason)
    };
    let mut facets = Facets { blocks: Vec::new(), starts: vec![0], double: false };
    let mut inside = false;
    for block in parsed {
        let block = block?;
        if let Some((inside_at_first, position)) = block.first
            && inside_at_first != inside
        {
            return Err(wrong(position, nesting_error(inside)));
        }
        inside = block.last.unwrap_or(inside);
        facets.double |= block.double;
        facets.starts.push(facets.count() + block.corners.len());
        facets.blocks.push(block.corners);
        match block.stop {
            None => {}
            Some(Stop::Wrong(position, reason)) => return Err(wrong(position, reason)),
            Some(Stop::Stray(position, word)) if inside => {
                let reason = format!("expected 'facet' or 'endsolid', not '{word}'");
                return Err(wrong(position, reason));
            }
            // Bytes after the end.
            Some(Stop::Stray(..)) => break,
        }
    }
    if inside {
        return Err(wrong(bytes.len(), "the file ends without 'endsolid'".to_owned()));
    }
    Ok(facets)
}

fn nesting_error(inside: bool) -> String {
    if inside {
        "a 'solid' inside of a solid: 'endsolid' is missing".to_owned()
    } else {
        "a facet or an 'endsolid' outside of a solid".to_owned()
    }
}

/// The end of the first line `endfacet` that ends after `least`, or of the file.
pub(super) fn end_of_block(bytes: &[u8], least: usize) -> usize {
    let mut start = least;
    while start < bytes.len() {
        let Some(length) = memchr::memchr2(b'\n', b'\r', &bytes[start..]) else {
            return bytes.len();
        };
        let line = &bytes[start..start + length];
        start += length + 1;
        if line.trim_ascii().eq_ignore_ascii_case(b"endfacet") {
            return start;
        }
    }
    bytes.len()
}

/// The number of the line with the byte at `position`, counted from 1.
fn line_number(bytes: &[u8], position: usize) -> usize {
    let before = &bytes[..position];
    let feeds = memchr::memchr_iter(b'\n', before).count();
    1 + if feeds > 0 { feeds } else { memchr::memchr_iter(b'\r', before).count() }
}

/// What was found between two cuts.
struct Block {
    corners: Vec<[[f64; 3]; 3]>,
    double: bool,
    /// Whether the first keyword can only be inside of a solid, and where it is.
    first: Option<(bool, usize)>,
    /// Whether the last keyword leaves the parser inside of a solid.
    last: Option<bool>,
    stop: Option<Stop>,
}

/// Why a block was not parsed to its end.
enum Stop {
    /// Something that is wrong, at a position.
    Wrong(usize, String),
    /// A word that is no keyword, between facets.
    Stray(usize, String),
}

impl Block {
    /// Parses `text` from `position`.
    fn parse(text: &[u8], position: usize) -> Block {
        let mut block =
            Block { corners: Vec::new(), double: false, first: None, last: None, stop: None };
        let mut words = Words { text, position };
        block.stop = block.parse_words(&mut words).err();
        block
    }

    fn parse_words(&mut self, words: &mut Words) -> std::result::Result<(), Stop> {
        loop {
            let (start, word) = words.next();
            let inside_before = if is(word, "facet") {
                let corners = words.facet(&mut self.double)?;
                self.corners.push(corners);
                true
            } else if is(word, "solid") {
                words.skip_line();
                false
            } else if is(word, "endsolid") {
                words.skip_line();
                true
            } else if word.is_empty() {
                return Ok(());
            } else {
                return Err(Stop::Stray(start, excerpt(word)));
            };
            match self.last {
                None => self.first = Some((inside_before, start)),
                Some(inside) if inside == inside_before => {}
                Some(inside) => return Err(Stop::Wrong(start, nesting_error(inside))),
            }
            self.last = Some(!is(word, "endsolid"));
        }
    }
}

fn is(word: &[u8], keyword: &str) -> bool {
    word.eq_ignore_ascii_case(keyword.as_bytes())
}

/// The words of a text that are still to be read.
struct Words<'a> {
    text: &'a [u8],
    position: usize,
}

impl<'a> Words<'a> {
    /// Where the next word starts, and the word; empty at the end of the text.
    #[inline]
    fn next(&mut self) -> (usize, &'a [u8]) {
        let rest = &self.text[self.position..];
        let word = rest.trim_ascii_start();
        let start = self.position + rest.len() - word.len();
        let length = word.iter().position(u8::is_ascii_whitespace).unwrap_or(word.len());
        self.position = start + length;
        (start, &word[..length])
    }

    fn skip_line(&mut self) {
        let rest = &self.text[self.position..];
        self.position += memchr::memchr2(b'\n', b'\r', rest).unwrap_or(rest.len());
    }

    fn expect(&mut self, keyword: &str) -> std::result::Result<(), Stop> {
        let (start, word) = self.next();
        if is(word, keyword) { Ok(()) } else { Err(unexpected(start, word, keyword)) }
    }

    /// What follows the word `facet`.
    fn facet(&mut self, double: &mut bool) -> std::result::Result<[[f64; 3]; 3], Stop> {
        self.expect("normal")?;
        for _ in 0..3 {
            let (start, word) = self.next();
            parse_f32(word).ok_or_else(|| unexpected(start, word, "a number"))?;
        }
        self.expect("outer")?;
        self.expect("loop")?;
        let mut corners = [[0.0; 3]; 3];
        for (i, corner) in corners.iter_mut().enumerate() {
            let (start, word) = self.next();
            if is(word, "endloop") {
                let reason = format!("a facet with {i} vertices instead of 3");
                return Err(Stop::Wrong(start, reason));
            }
            if !is(word, "vertex") {
                return Err(unexpected(start, word, "vertex"));
            }
            for coordinate in corner {
                let (start, word) = self.next();
                *coordinate = parse_f64(word).ok_or_else(|| unexpected(start, word, "a number"))?;
                *double |= !single_precision_reproduces(word, *coordinate);
            }
        }
        let (start, word) = self.next();
        if is(word, "vertex") {
            let reason = "a facet with more than 3 vertices".to_owned();
            return Err(Stop::Wrong(start, reason));
        }
        if !is(word, "endloop") {
            return Err(unexpected(start, word, "endloop"));
        }
        self.expect("endfacet")?;
        Ok(corners)
    }
}

#[cold]
fn unexpected(position: usize, word: &[u8], expected: &str) -> Stop {
    let found = match word {
        [] => "the end of the file".to_owned(),
        word => format!("'{}'", excerpt(word)),
    };
    let expected =
        if expected == "a number" { expected.to_owned() } else { format!("'{expected}'") };
    Stop::Wrong(position, format!("expected {expected}, not {found}"))
}
