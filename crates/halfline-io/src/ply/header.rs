//! The header of a PLY file: what the body holds, and in what form.

use std::path::Path;

use super::scalar::Scalar;
use crate::text::excerpt;
use halfline::error::{Error, Result};

/// How the body is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// One or several numbers of each record of an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Scalar(Scalar),
    List { count: Scalar, item: Scalar },
}

/// A named part of each record of an element.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Property {
    pub name: String,
    pub kind: Kind,
}

/// A table of the file: `count` records of the same properties.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
}

/// A header.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Header {
    pub encoding: Encoding,
    /// In the order of the body.
    pub elements: Vec<Element>,
    /// Bytes and lines of the header.
    pub byte_length: usize,
    pub line_count: usize,
    /// What ends a line. Where it is the line feed, a carriage return before it is blank space.
    pub line_end: u8,
}

/// A header that does not end within this many bytes is not one.
const MOST_BYTES: usize = 16 << 20;

/// More elements and properties than this in one header are refused: their names are compared
/// with each other.
const MOST_NAMES: usize = 4096;

type Parsed<T> = std::result::Result<T, String>;

impl Element {
    /// The least number of bytes that the element's records can take up.
    pub fn least_bytes(&self, encoding: Encoding) -> u128 {
        let record: usize = self
            .properties
            .iter()
            .map(|property| match (encoding, property.kind) {
                // A digit and what separates it from the next.
                (Encoding::Ascii, _) => 2,
                (_, Kind::Scalar(scalar)) => scalar.size(),
                (_, Kind::List { count, .. }) => count.size(),
            })
            .sum();
        u128::from(self.count) * record as u128
    }

    /// Where record `record` is, for an error message.
    pub fn place(&self, record: u64) -> String {
        format!("{} {record}", excerpt(self.name.as_bytes()))
    }

    /// True if records take up no place in the file at all.
    pub fn is_void(&self) -> bool {
        self.properties.is_empty()
    }
}

/// True if `bytes` begin as a PLY file does.
pub fn is_ply(bytes: &[u8]) -> bool {
    let rest = bytes.strip_prefix(b"ply").map(|rest| rest.trim_ascii_start().len() < rest.len());
    rest == Some(true)
}

/// The header that `bytes` begin with; `None` if it goes on after `bytes`.
pub fn parse(path: &Path, bytes: &[u8]) -> Result<Option<Header>> {
    let line_end = match bytes.iter().position(|&b| b == b'\n' || b == b'\r') {
        None => b'\n',
        Some(end) if bytes[end] == b'\r' && bytes.get(end + 1) != Some(&b'\n') => b'\r',
        Some(_) => b'\n',
    };
    let mut parser = Parser { encoding: None, elements: Vec::new(), names: 0 };
    let mut position = 0;
    let mut line_number = 0;
    while let Some(length) = memchr::memchr(line_end, &bytes[position..]) {
        let line = bytes[position..position + length].trim_ascii();
        position += length + 1;
        line_number += 1;
        let wrong = |reason: String| Error::format(path, format!("line {line_number}"), reason);
        if line_number == 1 {
            if line != b"ply" {
                return Err(wrong("a PLY file begins with a line 'ply'".to_owned()));
            }
        } else if parser.line(line).map_err(wrong)? {
            let Some(encoding) = parser.encoding else {
                return Err(wrong("the header ends without a line 'format'".to_owned()));
            };
            return Ok(Some(Header {
                encoding,
                elements: parser.elements,
                byte_length: position,
                line_count: line_number,
                line_end,
            }));
        }
    }
    if bytes.len() - position > MOST_BYTES || position > MOST_BYTES {
        return Err(Error::format(path, "header", "goes on without a line 'end_header'"));
    }
    Ok(None)
}

struct Parser {
    encoding: Option<Encoding>,
    elements: Vec<Element>,
    names: usize,
}

impl Parser {
    /// Takes in a line after the first; true if it is the last.
    fn line(&mut self, line: &[u8]) -> Parsed<bool> {
        let mut words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        match words.next() {
            None | Some(b"comment" | b"obj_info") => return Ok(false),
            Some(b"end_header") => return Ok(true),
            Some(b"format") => self.format(words.next(), words.next())?,
            Some(b"element" | b"property") if self.names == MOST_NAMES => {
                return Err(format!("more than {MOST_NAMES} elements and properties"));
            }
            Some(b"element") => self.element(words.next(), words.next())?,
            Some(b"property") => self.property(&mut words)?,
            Some(word) => return Err(format!("unknown keyword '{}'", excerpt(word))),
        }
        match words.next() {
            None => Ok(false),
            Some(word) => Err(format!("'{}' is one word too many", excerpt(word))),
        }
    }

    fn format(&mut self, name: Option<&[u8]>, version: Option<&[u8]>) -> Parsed<()> {
        if self.encoding.is_some() {
            return Err("a second line 'format'".to_owned());
        }
        self.encoding = Some(match name {
            Some(b"ascii") => Encoding::Ascii,
            Some(b"binary_little_endian") => Encoding::LittleEndian,
            Some(b"binary_big_endian") => Encoding::BigEndian,
            _ => {
                return Err(format!(
                    "unknown format '{}'; known are ascii, binary_little_endian and \
                     binary_big_endian",
                    excerpt(name.unwrap_or_default())
                ));
            }
        });
        match version {
            Some(b"1.0") => Ok(()),
            _ => Err(format!(
                "unknown format version '{}'; known is 1.0",
                excerpt(version.unwrap_or_default())
            )),
        }
    }

    fn element(&mut self, name: Option<&[u8]>, count: Option<&[u8]>) -> Parsed<()> {
        let (Some(name), Some(count)) = (name, count) else {
            return Err("expected 'element NAME COUNT'".to_owned());
        };
        let name = String::from_utf8_lossy(name).into_owned();
        let number = std::str::from_utf8(count).ok().and_then(|count| count.parse().ok());
        let Some(count) = number else {
            return Err(format!(
                "element {} has the count '{}'; expected a whole number that is not negative",
                excerpt(name.as_bytes()),
                excerpt(count)
            ));
        };
        if self.elements.iter().any(|e| e.name == name) {
            return Err(format!("a second element {}", excerpt(name.as_bytes())));
        }
        self.names += 1;
        self.elements.push(Element { name, count, properties: Vec::new() });
        Ok(())
    }

    fn property<'a>(&mut self, words: &mut impl Iterator<Item = &'a [u8]>) -> Parsed<()> {
        let Some(element) = self.elements.last_mut() else {
            return Err("a property before the first element".to_owned());
        };
        let mut scalar = || {
            let name = words.next().unwrap_or_default();
            Scalar::from_name(name).ok_or(name)
        };
        let unknown = |name: &[u8]| format!("unknown property type '{}'", excerpt(name));
        let kind = match scalar() {
            Ok(scalar) => Kind::Scalar(scalar),
            Err(b"list") => {
                let (count, item) = (scalar().map_err(unknown)?, scalar().map_err(unknown)?);
                if !count.is_integer() {
                    return Err("the count of a list must have an integer type".to_owned());
                }
                Kind::List { count, item }
            }
            Err(name) => return Err(unknown(name)),
        };
        let Some(name) = words.next() else {
            return Err("a property without a name".to_owned());
        };
        let name = String::from_utf8_lossy(name).into_owned();
        if element.properties.iter().any(|p| p.name == name) {
            return Err(format!(
                "a second property {} of element {}",
                excerpt(name.as_bytes()),
                excerpt(element.name.as_bytes())
            ));
        }
        self.names += 1;
        element.properties.push(Property { name, kind });
        Ok(())
    }
}
