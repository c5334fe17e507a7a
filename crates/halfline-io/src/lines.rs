//! Text formats in lines: lines, fields, progress.

use std::path::Path;

use memchr::{memchr, memchr_iter};

use super::text;
pub(super) use super::text::parse_integer as integer;
use halfline::error::{Error, Result};
use halfline::progress::{Observer, Stage};

/// How many bytes are read between two reports to the observer: under a millisecond of work.
const BYTES_BETWEEN_REPORTS: usize = 1 << 18;

/// The lines of a text, numbered from 1. A text without any line feed may end its lines with
/// carriage returns.
pub(super) struct Lines<'a> {
    bytes: &'a [u8],
    position: usize,
    number: usize,
    line_end: u8,
    joined: Vec<u8>,
    report_at: usize,
}

impl<'a> Lines<'a> {
    /// The lines of `bytes`, less a byte order mark.
    pub fn new(bytes: &'a [u8]) -> Lines<'a> {
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let line_end = if memchr(b'\n', bytes).is_some() { b'\n' } else { b'\r' };
        Lines { bytes, position: 0, number: 0, line_end, joined: Vec::new(), report_at: 0 }
    }

    /// The next line as it stands.
    pub fn next(&mut self) -> Option<&'a [u8]> {
        let rest = &self.bytes[self.position..];
        if rest.is_empty() {
            return None;
        }
        self.number += 1;
        let length = memchr(self.line_end, rest).unwrap_or(rest.len());
        self.position = (self.position + length + 1).min(self.bytes.len());
        Some(&rest[..length])
    }

    /// The next line, with the lines after it as long as each ends with a backslash. A line with a
    /// comment that ends with one, as paths do, is not continued.
    pub fn next_continued(&mut self) -> Option<&[u8]> {
        let first = self.next()?;
        let Some(start) = without_backslash(first) else { return Some(first) };
        self.joined.clear();
        self.joined.extend_from_slice(start);
        while let Some(line) = self.next() {
            self.joined.push(b' ');
            match without_backslash(line) {
                Some(part) => self.joined.extend_from_slice(part),
                None => {
                    self.joined.extend_from_slice(line);
                    break;
                }
            }
        }
        Some(&self.joined)
    }

    /// Bytes not yet read.
    pub fn bytes_left(&self) -> usize {
        self.bytes.len() - self.position
    }

    /// The number of the line read last, for an error message.
    pub fn place(&self) -> String {
        format!("line {}", self.number.max(1))
    }

    /// An error about the line read last.
    pub fn error(&self, path: &Path, reason: impl Into<String>) -> Error {
        Error::format(path, self.place(), reason)
    }

    /// Now and then tells the observer how far the text is read and asks it whether to stop.
    /// The text is passage `pass` of `passes` over the same bytes.
    #[inline]
    pub fn report(&mut self, observer: &dyn Observer, pass: u64, passes: u64) -> Result<()> {
        if self.position < self.report_at {
            return Ok(());
        }
        self.report_at = self.position + BYTES_BETWEEN_REPORTS;
        let total = self.bytes.len() as u64;
        let done = (pass * total + self.position as u64) / passes;
        observer.report(Stage::Load, done, total);
        observer.check()
    }
}

/// What stands before the backslash of a line that is continued.
fn without_backslash(line: &[u8]) -> Option<&[u8]> {
    let start = line.trim_ascii_end().strip_suffix(b"\\")?;
    (without_comment(line).len() == line.len()).then_some(start)
}

/// What stands before the comment of a line, which begins with a `#` at its start or after a blank. One
/// within a word, as in `1.#INF`, begins none.
pub(super) fn without_comment(line: &[u8]) -> &[u8] {
    let is_start = |&at: &usize| at == 0 || is_blank(line[at - 1]);
    memchr_iter(b'#', line).find(is_start).map_or(line, |at| &line[..at])
}

/// A name less the comment behind it. A `#` with which the name begins is part of it.
pub(super) fn name_without_comment(name: &[u8]) -> &[u8] {
    let after_first = name.len().min(1);
    let kept = after_first + without_comment(&name[after_first..]).len();
    name[..kept].trim_ascii_end()
}

/// The fields of a line: what stands between blanks.
#[derive(Clone)]
pub(super) struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    pub fn of(line: &'a [u8]) -> Fields<'a> {
        Fields(line)
    }

    /// All that follows the fields read so far.
    pub fn rest(&self) -> &'a [u8] {
        self.0.trim_ascii()
    }
}

impl<'a> Iterator for Fields<'a> {
    type Item = &'a [u8];

    #[inline]
    fn next(&mut self) -> Option<&'a [u8]> {
        let start = self.0.iter().position(|&byte| !is_blank(byte))?;
        let rest = &self.0[start..];
        let length = rest.iter().position(|&byte| is_blank(byte)).unwrap_or(rest.len());
        let (field, rest) = rest.split_at(length);
        self.0 = rest;
        Some(field)
    }
}

/// Blanks are the control characters too: none has a meaning in these formats.
#[inline]
fn is_blank(byte: u8) -> bool {
    byte <= b' '
}

/// A decimal number; not finite ones are numbers too.
#[inline]
pub(super) fn number(field: &[u8]) -> std::result::Result<f64, String> {
    text::parse_f64(field).ok_or_else(|| format!("{} is not a number", quoted(field)))
}

/// A field as it can stand in an error message.
pub(super) fn quoted(field: &[u8]) -> String {
    format!("`{}`", text::excerpt(field))
}
