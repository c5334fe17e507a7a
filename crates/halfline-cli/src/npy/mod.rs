//! Rays or points out of a NumPy `.npy` file, some at a time.
//!
//! Written here and not taken from a crate since those read one number at a time, or the whole
//! file at once.

mod header;

use std::fs::File;
use std::io::{ErrorKind, Read, Seek, SeekFrom, Stdin};
use std::marker::PhantomData;
use std::path::{Path, PathBuf};

use halfline::error::Result;
use halfline::{Error, Ray, Vec3};

use crate::input;
use header::{Header, Layout, Number, read_header};

/// Where the bytes come from.
enum Data {
    File(File),
    Stdin(Stdin),
}

impl Read for Data {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        match self {
            Data::File(file) => file.read(buffer),
            Data::Stdin(stdin) => stdin.read(buffer),
        }
    }
}

/// What a row of a file is.
pub trait Row: Sized {
    /// What one is called.
    const NAME: &'static str;
    /// The numbers that a row may have.
    const COLUMNS: &'static [u64];
    /// The shapes that a file may have, for the error about another one.
    const SHAPES: &'static str;

    /// The row of so many `columns`, of which `at` gives each.
    fn of(columns: usize, at: impl Fn(usize) -> f64) -> Self;
}

impl Row for Ray {
    const NAME: &'static str = "ray";
    const COLUMNS: &'static [u64] = &[6, 8];
    const SHAPES: &'static str =
        "(n, 6) for origins and directions, or (n, 8) with t_min and t_max";

    fn of(columns: usize, at: impl Fn(usize) -> f64) -> Ray {
        let mut ray = Ray::new([at(0), at(1), at(2)].into(), [at(3), at(4), at(5)].into());
        if columns == 8 {
            (ray.t_min, ray.t_max) = (at(6), at(7));
        }
        ray
    }
}

impl Row for Vec3 {
    const NAME: &'static str = "point";
    const COLUMNS: &'static [u64] = &[3];
    const SHAPES: &'static str = "(n, 3) for points";

    fn of(_: usize, at: impl Fn(usize) -> f64) -> Vec3 {
        [at(0), at(1), at(2)].into()
    }
}

/// An open file of rays, of shape (n, 6) or (n, 8).
pub type RayFile = RowFile<Ray>;

/// An open file of points, of shape (n, 3).
pub type PointFile = RowFile<Vec3>;

/// An open file of rows.
pub struct RowFile<R> {
    path: PathBuf,
    data: Data,
    layout: Layout,
    /// Where the first number lies.
    data_offset: u64,
    rows_read: u64,
    bytes: Vec<u8>,
    row: PhantomData<R>,
}

impl<R: Row> RowFile<R> {
    /// Opens the regular file at `path`, or standard input for `-`, and reads its header.
    ///
    /// # Errors
    /// If the file cannot be read, is no `.npy` file, or does not hold what such rows look like.
    pub fn open(path: &Path) -> Result<RowFile<R>> {
        let (mut data, most_bytes) = if input::is_stdin(path) {
            (Data::Stdin(std::io::stdin()), input::MOST_STDIN_BYTES)
        } else {
            input::check_regular(path)?;
            let (file, metadata) = halfline::storage::open_regular(path)?;
            (Data::File(file), metadata.len())
        };
        let path = input::name(path);
        let (header, data_offset) = read_header(&mut data, path)?;
        let layout = Header::parse(&header)
            .map_err(|reason| Error::format(path, "header", reason))?
            .layout(R::COLUMNS, R::SHAPES)
            .map_err(|reason| Error::format(path, "header", reason))?;
        let promised = layout
            .rows
            .checked_mul((layout.columns * layout.number.size()) as u64)
            .and_then(|bytes| bytes.checked_add(data_offset));
        let is_within = promised.is_some_and(|promised| promised <= most_bytes);
        let refused = |reason| Err(Error::format(path, "header", reason));
        match data {
            Data::File(_) if !is_within => return Err(too_short(path, &layout, most_bytes)),
            Data::Stdin(_) if !is_within => {
                return refused("promises more bytes than may come this way: save them to a file");
            }
            Data::Stdin(_) if layout.fortran_order => {
                return refused("Fortran order needs a file to move about in, not a stream");
            }
            _ => {}
        }
        Ok(RowFile {
            path: path.to_owned(),
            data,
            layout,
            data_offset,
            rows_read: 0,
            bytes: Vec::new(),
            row: PhantomData,
        })
    }

    /// How many rows the file holds.
    pub fn row_count(&self) -> u64 {
        self.layout.rows
    }

    /// Replaces `some` with the next `at_most` rows of the file; with none at its end.
    pub fn read(&mut self, at_most: usize, some: &mut Vec<R>) -> Result<()> {
        some.clear();
        let Layout { rows, columns, number, big_endian, fortran_order } = self.layout;
        let count = (rows - self.rows_read).min(at_most as u64) as usize;
        let size = number.size();
        self.bytes.resize(count * columns * size, 0);
        let outcome = if let Data::File(file) = &mut self.data
            && fortran_order
            && count > 0
        {
            // Each column is contiguous: column by column into a block of the same order.
            self.bytes.chunks_exact_mut(count * size).enumerate().try_for_each(|(i, column)| {
                let at = (i as u64 * rows + self.rows_read) * size as u64;
                file.seek(SeekFrom::Start(self.data_offset + at))?;
                file.read_exact(column)
            })
        } else {
            self.data.read_exact(&mut self.bytes)
        };
        outcome.map_err(|error| match error.kind() {
            ErrorKind::UnexpectedEof => Error::format(
                &self.path,
                format!("{} {} and following", R::NAME, self.rows_read),
                format!("the data ends before the {rows} {}s that the header promises", R::NAME),
            ),
            _ => Error::io(&self.path, error),
        })?;
        self.rows_read += count as u64;

        let (row_stride, column_stride) = if fortran_order { (1, count) } else { (columns, 1) };
        let value: fn(&[u8]) -> f64 = match (number, big_endian) {
            (Number::Float32, false) => |b| f32::from_le_bytes(b.try_into().unwrap()).into(),
            (Number::Float32, true) => |b| f32::from_be_bytes(b.try_into().unwrap()).into(),
            (Number::Float64, false) => |b| f64::from_le_bytes(b.try_into().unwrap()),
            (Number::Float64, true) => |b| f64::from_be_bytes(b.try_into().unwrap()),
        };
        let bytes = &self.bytes;
        some.extend((0..count).map(|row| {
            R::of(columns, |column| {
                let start = (row * row_stride + column * column_stride) * size;
                value(&bytes[start..start + size])
            })
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
        format!(
            "the file ends before the ({rows}, {columns}) float{bits} that its header promises"
        ),
    )
}
