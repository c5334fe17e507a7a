//! The header of a `.npy` file.
//!
//! The format is NumPy's `numpy.lib.format`, versions 1 to 3. Its header is a Python dictionary
//! of three known entries. Only these are understood here, not Python, so that a header from a
//! stranger cannot nest until the stack overflows.

use std::io::{ErrorKind, Read};
use std::path::Path;

use halfline::Error;
use halfline::error::Result;

/// NumPy itself refuses longer headers unless told otherwise (`max_header_size`).
const LONGEST_HEADER: u32 = 10_000;

/// How the numbers lie in the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    /// Rays or points.
    pub rows: u64,
    /// Numbers of each.
    pub columns: usize,
    /// What each number is.
    pub number: Number,
    /// Most significant byte first.
    pub big_endian: bool,
    /// Column after column instead of row after row.
    pub fortran_order: bool,
}

/// The types of number that rays and points may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Number {
    /// Single precision.
    Float32,
    /// Double precision.
    Float64,
}

impl Number {
    /// Bytes.
    pub fn size(self) -> usize {
        match self {
            Number::Float32 => 4,
            Number::Float64 => 8,
        }
    }
}

/// The header's text, and where the data begins.
pub fn read_header(file: &mut impl Read, path: &Path) -> Result<(Vec<u8>, u64)> {
    let no_npy = |error: std::io::Error| match error.kind() {
        ErrorKind::UnexpectedEof => Error::format(path, "header", "the file ends within it"),
        _ => Error::io(path, error),
    };
    let mut start = [0; 8];
    file.read_exact(&mut start).map_err(|error| match error.kind() {
        ErrorKind::UnexpectedEof => Error::format(path, "byte 0", "not a NumPy .npy file"),
        _ => Error::io(path, error),
    })?;
    let (magic, version) = start.split_at(6);
    if magic != b"\x93NUMPY" {
        let hint = if magic.starts_with(b"PK") { " but perhaps an .npz archive" } else { "" };
        return Err(Error::format(path, "byte 0", format!("not a NumPy .npy file{hint}")));
    }
    let (length, before) = match version {
        [1, 0] => {
            let mut length = [0; 2];
            file.read_exact(&mut length).map_err(no_npy)?;
            (u16::from_le_bytes(length).into(), 10)
        }
        [2 | 3, 0] => {
            let mut length = [0; 4];
            file.read_exact(&mut length).map_err(no_npy)?;
            (u32::from_le_bytes(length), 12)
        }
        _ => {
            let reason =
                format!("unknown version {}.{}, expected 1.0, 2.0 or 3.0", version[0], version[1]);
            return Err(Error::format(path, "byte 6", reason));
        }
    };
    if length > LONGEST_HEADER {
        let reason = format!("{length} bytes long, expected at most {LONGEST_HEADER}");
        return Err(Error::format(path, "header", reason));
    }
    let mut header = vec![0; length as usize];
    file.read_exact(&mut header).map_err(no_npy)?;
    Ok((header, before + u64::from(length)))
}

/// What was read, or what is wrong.
type Parsed<T> = std::result::Result<T, String>;

/// The three entries of the dictionary.
#[derive(Debug, PartialEq)]
pub struct Header {
    dtype: String,
    fortran_order: bool,
    shape: Vec<u64>,
}

impl Header {
    /// Understands the text of a header.
    pub fn parse(text: &[u8]) -> Parsed<Header> {
        let mut cursor = Cursor { text, at: 0 };
        let (mut dtype, mut fortran_order, mut shape) = (None, None, None);
        cursor.expect(b'{')?;
        while !cursor.accept(b'}') {
            let key = cursor.string()?;
            cursor.expect(b':')?;
            match key.as_str() {
                "descr" => dtype = Some(cursor.dtype()?),
                "fortran_order" => fortran_order = Some(cursor.boolean()?),
                "shape" => shape = Some(cursor.shape()?),
                _ => return Err(format!("unknown entry '{}'", excerpt(&key))),
            }
            if !cursor.accept(b',') {
                cursor.expect(b'}')?;
                break;
            }
        }
        match (dtype, fortran_order, shape) {
            (Some(dtype), Some(fortran_order), Some(shape)) => {
                Ok(Header { dtype, fortran_order, shape })
            }
            (None, ..) => Err("no entry 'descr'".into()),
            (_, None, _) => Err("no entry 'fortran_order'".into()),
            (.., None) => Err("no entry 'shape'".into()),
        }
    }

    /// How rows of one of the lengths `columns`, told as `expected`, lie in a file with this header.
    pub fn layout(&self, columns: &[u64], expected: &str) -> Parsed<Layout> {
        let (big_endian, number) = match self.dtype.as_str() {
            "<f4" => (false, Number::Float32),
            "<f8" => (false, Number::Float64),
            ">f4" => (true, Number::Float32),
            ">f8" => (true, Number::Float64),
            other => {
                return Err(format!("dtype is '{}', expected float32 or float64", excerpt(other)));
            }
        };
        match self.shape[..] {
            [rows, found] if columns.contains(&found) => Ok(Layout {
                rows,
                columns: found as usize,
                number,
                big_endian,
                fortran_order: self.fortran_order,
            }),
            _ => {
                let lengths: Vec<_> = self.shape.iter().map(u64::to_string).collect();
                let comma = if lengths.len() == 1 { "," } else { "" };
                let shape = format!("({}{comma})", lengths.join(", "));
                Err(format!("shape is {}, expected {expected}", excerpt(&shape)))
            }
        }
    }
}

/// The beginning of `text`, for an error message, which stays one short line.
fn excerpt(text: &str) -> String {
    const MOST_CHARACTERS: usize = 60;
    let mut characters = text.chars();
    let start: String = characters.by_ref().take(MOST_CHARACTERS).collect();
    let rest = if characters.next().is_some() { "..." } else { "" };
    format!("{}{rest}", start.escape_default())
}

/// Reads the few Python literals that a header may hold.
struct Cursor<'a> {
    text: &'a [u8],
    at: usize,
}

impl Cursor<'_> {
    fn peek(&mut self) -> Option<u8> {
        while self.text.get(self.at).is_some_and(u8::is_ascii_whitespace) {
            self.at += 1;
        }
        self.text.get(self.at).copied()
    }

    fn accept(&mut self, byte: u8) -> bool {
        let found = self.peek() == Some(byte);
        self.at += usize::from(found);
        found
    }

    fn expect(&mut self, byte: u8) -> Parsed<()> {
        if self.accept(byte) { Ok(()) } else { Err(self.wrong(&format!("`{}`", byte as char))) }
    }

    fn wrong(&self, expected: &str) -> String {
        match self.text.get(self.at) {
            Some(&byte) => {
                format!("`{}` at character {}, expected {expected}", byte.escape_ascii(), self.at)
            }
            None => format!("ends where {expected} was expected"),
        }
    }

    /// The longest run of bytes that satisfy `keep`.
    fn run(&mut self, keep: impl Fn(&u8) -> bool) -> &[u8] {
        let rest = &self.text[self.at..];
        let length = rest.iter().position(|byte| !keep(byte)).unwrap_or(rest.len());
        self.at += length;
        &rest[..length]
    }

    fn string(&mut self) -> Parsed<String> {
        let quote = match self.peek() {
            Some(quote @ (b'\'' | b'"')) => quote,
            _ => return Err(self.wrong("a string")),
        };
        self.at += 1;
        let string = String::from_utf8_lossy(self.run(|&byte| byte != quote)).into_owned();
        self.expect(quote)?;
        Ok(string)
    }

    fn dtype(&mut self) -> Parsed<String> {
        match self.peek() {
            Some(b'[') => Err("dtype is structured, expected float32 or float64".into()),
            _ => self.string(),
        }
    }

    fn boolean(&mut self) -> Parsed<bool> {
        self.peek();
        let start = self.at;
        match self.run(u8::is_ascii_alphabetic) {
            b"True" => Ok(true),
            b"False" => Ok(false),
            _ => {
                self.at = start;
                Err(self.wrong("True or False"))
            }
        }
    }

    fn shape(&mut self) -> Parsed<Vec<u64>> {
        let mut shape = Vec::new();
        self.expect(b'(')?;
        while !self.accept(b')') {
            self.peek();
            let digits = String::from_utf8_lossy(self.run(u8::is_ascii_digit)).into_owned();
            if digits.is_empty() {
                return Err(self.wrong("a length"));
            }
            let length = digits.parse();
            shape.push(length.map_err(|_| format!("length {} is too large", excerpt(&digits)))?);
            if !self.accept(b',') {
                self.expect(b')')?;
                break;
            }
        }
        Ok(shape)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Parsed<Header> {
        Header::parse(text.as_bytes())
    }

    #[test]
    fn headers_in_any_order_and_spacing() {
        let expected = Header { dtype: "<f8".into(), fortran_order: false, shape: vec![3, 6] };
        for text in [
            "{'descr': '<f8', 'fortran_order': False, 'shape': (3, 6), }      \n",
            "{\"shape\":(3,6),\"descr\":\"<f8\",\"fortran_order\":False}",
            " { 'shape' : ( 3 , 6 , ) , 'fortran_order' : False , 'descr' : '<f8' } ",
        ] {
            assert_eq!(parse(text).as_ref(), Ok(&expected), "{text}");
        }
        let scalar = parse("{'descr':'<f4','fortran_order':True,'shape':()}").unwrap();
        assert!(scalar.fortran_order && scalar.shape.is_empty());
    }

    #[test]
    fn broken_headers_say_what_is_wrong() {
        for (text, reason) in [
            ("", "ends where `{` was expected"),
            ("{'descr'", "ends where `:` was expected"),
            ("{'descr': '<f8", "ends where `'` was expected"),
            ("{'descr': [('x', '<f4')]", "dtype is structured, expected float32 or float64"),
            ("{'fortran_order': 1}", "`1` at character 18, expected True or False"),
            ("{'shape': (-3, 6)}", "`-` at character 11, expected a length"),
            ("{'shape': (99999999999999999999,)}", "length 99999999999999999999 is too large"),
            ("{'shape': ((((((3", "`(` at character 11, expected a length"),
            ("{'descr': '<f8', 'fortran_order': False}", "no entry 'shape'"),
            ("{'evil': 1}", "unknown entry 'evil'"),
        ] {
            assert_eq!(parse(text), Err(reason.to_string()), "{text}");
        }
    }

    /// Found by fuzzing: the header's 10,000 bytes came back as 80,000 characters.
    #[test]
    fn long_headers_are_quoted_in_part() {
        let many = |part: &str| part.repeat(2000);
        let shape = format!("({})", many("0, "));
        let number = "9".repeat(1000);
        for text in [
            format!("{{'shap{}': 1}}", many("\u{fffd}")),
            format!("{{'shape': ({number},)}}"),
            format!("{{'descr': '{}', 'fortran_order': True, 'shape': (1, 6)}}", many("\u{fffd}")),
            format!("{{'descr': '<f8', 'fortran_order': True, 'shape': {shape}}}"),
        ] {
            let reason = parse(&text).and_then(|header| header.layout(&[6], "six")).unwrap_err();
            assert!(reason.len() < 600 && reason.contains("..."), "{reason}");
        }
    }

    #[test]
    fn only_rows_of_known_length_have_a_layout() {
        let layout = |header: Header| header.layout(&[6, 8], "six or eight");
        let header = |dtype: &str, shape: &[u64]| Header {
            dtype: dtype.into(),
            fortran_order: true,
            shape: shape.to_vec(),
        };
        assert_eq!(
            layout(header(">f4", &[7, 8])),
            Ok(Layout {
                rows: 7,
                columns: 8,
                number: Number::Float32,
                big_endian: true,
                fortran_order: true
            })
        );
        assert!(layout(header("<i8", &[7, 6])).unwrap_err().starts_with("dtype is '<i8', exp"));
        assert!(layout(header("<f8", &[7])).unwrap_err().starts_with("shape is (7,), exp"));
        assert!(layout(header("<f8", &[6, 7])).unwrap_err().starts_with("shape is (6, 7), exp"));
    }
}
