//! Rays out of a NumPy `.npy` file, some at a time.
//!
//! The format is NumPy's `numpy.lib.format`, versions 1 to 3. Its header is a Python dictionary
//! of three known entries; only this is understood here, not Python: a header from a stranger
//! cannot nest.

use std::fs::File;
use std::io::{ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use halfline::error::Result;
use halfline::{Error, Ray};

/// NumPy itself refuses longer headers unless told otherwise (`max_header_size`).
const LONGEST_HEADER: u32 = 10_000;

/// An open file of rays, of shape (n, 6) or (n, 8).
pub struct RayFile {
    path: PathBuf,
    file: File,
    layout: Layout,
    /// Where the first number lies.
    data_offset: u64,
    rays_read: u64,
    bytes: Vec<u8>,
}

/// How the numbers lie in the file.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Layout {
    rows: u64,
    columns: usize,
    number: Number,
    big_endian: bool,
    fortran_order: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Number {
    Float32,
    Float64,
}

impl Number {
    fn size(self) -> usize {
        match self {
            Number::Float32 => 4,
            Number::Float64 => 8,
        }
    }
}

impl RayFile {
    /// Opens `path` and reads its header.
    ///
    /// # Errors
    /// If the file cannot be read, is no `.npy` file, or does not hold what rays look like.
    pub fn open(path: &Path) -> Result<RayFile> {
        let mut file = File::open(path).map_err(|error| Error::io(path, error))?;
        let (header, data_offset) = read_header(&mut file, path)?;
        let layout = Header::parse(&header)
            .map_err(|reason| Error::format(path, "header", reason))?
            .layout()
            .map_err(|reason| Error::format(path, "header", reason))?;
        let promised = layout
            .rows
            .checked_mul((layout.columns * layout.number.size()) as u64)
            .and_then(|bytes| bytes.checked_add(data_offset));
        let metadata = file.metadata().map_err(|error| Error::io(path, error))?;
        if metadata.is_file() {
            if promised.is_none_or(|promised| promised > metadata.len()) {
                return Err(too_short(path, &layout, metadata.len()));
            }
        } else if layout.fortran_order {
            return Err(Error::format(
                path,
                "header",
                "Fortran order needs a file to move about in, not a pipe",
            ));
        }
        Ok(RayFile {
            path: path.to_owned(),
            file,
            layout,
            data_offset,
            rays_read: 0,
            bytes: Vec::new(),
        })
    }

    /// How many rays the file holds.
    pub fn ray_count(&self) -> u64 {
        self.layout.rows
    }

    /// Replaces `rays` with the next `at_most` rays of the file; with none at its end.
    pub fn read(&mut self, at_most: usize, rays: &mut Vec<Ray>) -> Result<()> {
        rays.clear();
        let Layout { rows, columns, number, big_endian, fortran_order } = self.layout;
        let count = (rows - self.rays_read).min(at_most as u64) as usize;
        let size = number.size();
        self.bytes.resize(count * columns * size, 0);
        let outcome = if fortran_order && count > 0 {
            // Each column is contiguous: column by column into a block of the same order.
            self.bytes.chunks_exact_mut(count * size).enumerate().try_for_each(|(i, column)| {
                let at = (i as u64 * rows + self.rays_read) * size as u64;
                self.file.seek(SeekFrom::Start(self.data_offset + at))?;
                self.file.read_exact(column)
            })
        } else {
            self.file.read_exact(&mut self.bytes)
        };
        outcome.map_err(|error| match error.kind() {
            ErrorKind::UnexpectedEof => Error::format(
                &self.path,
                format!("ray {} and following", self.rays_read),
                format!("the data ends before the {rows} rays that the header promises"),
            ),
            _ => Error::io(&self.path, error),
        })?;
        self.rays_read += count as u64;

        let (row_stride, column_stride) =
            if fortran_order { (1, count) } else { (columns, 1) };
        let value: fn(&[u8]) -> f64 = match (number, big_endian) {
            (Number::Float32, false) => |b| f32::from_le_bytes(b.try_into().unwrap()).into(),
            (Number::Float32, true) => |b| f32::from_be_bytes(b.try_into().unwrap()).into(),
            (Number::Float64, false) => |b| f64::from_le_bytes(b.try_into().unwrap()),
            (Number::Float64, true) => |b| f64::from_be_bytes(b.try_into().unwrap()),
        };
        let bytes = &self.bytes;
        rays.extend((0..count).map(|row| {
            let at = |column: usize| {
                let start = (row * row_stride + column * column_stride) * size;
                value(&bytes[start..start + size])
            };
            let mut ray =
                Ray::new([at(0), at(1), at(2)].into(), [at(3), at(4), at(5)].into());
            if columns == 8 {
                (ray.t_min, ray.t_max) = (at(6), at(7));
            }
            ray
        }));
        Ok(())
    }
}

fn too_short(path: &Path, layout: &Layout, file_bytes: u64) -> Error {
    let Layout { rows, columns, number, .. } = *layout;
    let bits = number.size() * 8;
    Error::format(
        path,
        format!("byte {file_bytes}"),
        format!("the file ends before the ({rows}, {columns}) float{bits} that its header promises"),
    )
}

/// The header's text, and where the data begins.
fn read_header(file: &mut File, path: &Path) -> Result<(Vec<u8>, u64)> {
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
            let reason = format!(
                "unknown version {}.{}, expected 1.0, 2.0 or 3.0",
                version[0], version[1]
            );
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

/// The three entries of the dictionary.
#[derive(Debug, PartialEq)]
struct Header {
    dtype: String,
    fortran_order: bool,
    shape: Vec<u64>,
}

impl Header {
    fn parse(text: &[u8]) -> Result<Header, String> {
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
                _ => return Err(format!("unknown entry '{}'", key.escape_default())),
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

    fn layout(&self) -> Result<Layout, String> {
        let (big_endian, number) = match self.dtype.as_str() {
            "<f4" => (false, Number::Float32),
            "<f8" => (false, Number::Float64),
            ">f4" => (true, Number::Float32),
            ">f8" => (true, Number::Float64),
            other => {
                return Err(format!(
                    "dtype is '{}', expected float32 or float64",
                    other.escape_default()
                ));
            }
        };
        match self.shape[..] {
            [rows, columns @ (6 | 8)] => Ok(Layout {
                rows,
                columns: columns as usize,
                number,
                big_endian,
                fortran_order: self.fortran_order,
            }),
            _ => {
                let shape: Vec<_> = self.shape.iter().map(u64::to_string).collect();
                let comma = if shape.len() == 1 { "," } else { "" };
                Err(format!(
                    "shape is ({}{comma}), expected (n, 6) for origins and directions, or (n, 8) \
                     with t_min and t_max",
                    shape.join(", ")
                ))
            }
        }
    }
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

    fn expect(&mut self, byte: u8) -> Result<(), String> {
        if self.accept(byte) { Ok(()) } else { Err(self.wrong(&format!("`{}`", byte as char))) }
    }

    fn wrong(&self, expected: &str) -> String {
        match self.text.get(self.at) {
            Some(&byte) => format!(
                "`{}` at character {}, expected {expected}",
                byte.escape_ascii(),
                self.at
            ),
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

    fn string(&mut self) -> Result<String, String> {
        let quote = match self.peek() {
            Some(quote @ (b'\'' | b'"')) => quote,
            _ => return Err(self.wrong("a string")),
        };
        self.at += 1;
        let string = String::from_utf8_lossy(self.run(|&byte| byte != quote)).into_owned();
        self.expect(quote)?;
        Ok(string)
    }

    fn dtype(&mut self) -> Result<String, String> {
        match self.peek() {
            Some(b'[') => Err("dtype is structured, expected float32 or float64".into()),
            _ => self.string(),
        }
    }

    fn boolean(&mut self) -> Result<bool, String> {
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

    fn shape(&mut self) -> Result<Vec<u64>, String> {
        let mut shape = Vec::new();
        self.expect(b'(')?;
        while !self.accept(b')') {
            self.peek();
            let digits = String::from_utf8_lossy(self.run(u8::is_ascii_digit)).into_owned();
            if digits.is_empty() {
                return Err(self.wrong("a length"));
            }
            shape.push(digits.parse().map_err(|_| format!("length {digits} is too large"))?);
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

    fn parse(text: &str) -> Result<Header, String> {
        Header::parse(text.as_bytes())
    }

    #[test]
    fn headers_in_any_order_and_spacing() {
        let expected =
            Header { dtype: "<f8".into(), fortran_order: false, shape: vec![3, 6] };
        for text in [
            "{'descr': '<f8', 'fortran_order': False, 'shape': (3, 6), }      \n",
            "{\"shape\":(3,6),\"descr\":\"<f8\",\"fortran_order\":False}",
            " { 'shape' : ( 3 , 6 , ) , 'fortran_order' : False , 'descr' : '<f8' } ",
        ] {
            assert_eq!(parse(text).as_ref(), Ok(&expected), "{text}");
        }
        assert_eq!(parse("{'descr':'<f4','fortran_order':True,'shape':()}").unwrap().shape, []);
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

    #[test]
    fn only_rays_have_a_layout() {
        let header = |dtype: &str, shape: &[u64]| Header {
            dtype: dtype.into(),
            fortran_order: true,
            shape: shape.to_vec(),
        };
        assert_eq!(
            header(">f4", &[7, 8]).layout(),
            Ok(Layout {
                rows: 7,
                columns: 8,
                number: Number::Float32,
                big_endian: true,
                fortran_order: true
            })
        );
        assert!(header("<i8", &[7, 6]).layout().unwrap_err().starts_with("dtype is '<i8', exp"));
        assert!(header("<f8", &[7]).layout().unwrap_err().starts_with("shape is (7,), exp"));
        assert!(header("<f8", &[6, 7]).layout().unwrap_err().starts_with("shape is (6, 7), exp"));
    }
}
