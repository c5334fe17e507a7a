//! Rays out of a NumPy `.npy` file, some at a time.
//!
//! Written here and not taken from a crate since those read one number at a time, or the whole
//! file at once.

mod header;

use std::fs::File;
use std::io::{ErrorKind, Read, Seek, SeekFrom, Stdin};
use std::path::{Path, PathBuf};

use halfline::error::Result;
use halfline::{Error, Ray};

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

/// An open file of rays, of shape (n, 6) or (n, 8).
pub struct RayFile {
    path: PathBuf,
    data: Data,
    layout: Layout,
    /// Where the first number lies.
    data_offset: u64,
    rays_read: u64,
    bytes: Vec<u8>,
}

impl RayFile {
    /// Opens the regular file at `path`, or standard input for `-`, and reads its header.
    ///
    /// # Errors
    /// If the file cannot be read, is no `.npy` file, or does not hold what rays look like.
    pub fn open(path: &Path) -> Result<RayFile> {
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
            .layout()
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
        Ok(RayFile {
            path: path.to_owned(),
            data,
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
        let outcome = if let Data::File(file) = &mut self.data
            && fortran_order
            && count > 0
        {
            // Each column is contiguous: column by column into a block of the same order.
            self.bytes.chunks_exact_mut(count * size).enumerate().try_for_each(|(i, column)| {
                let at = (i as u64 * rows + self.rays_read) * size as u64;
                file.seek(SeekFrom::Start(self.data_offset + at))?;
                file.read_exact(column)
            })
        } else {
            self.data.read_exact(&mut self.bytes)
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

        let (row_stride, column_stride) = if fortran_order { (1, count) } else { (columns, 1) };
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
            let mut ray = Ray::new([at(0), at(1), at(2)].into(), [at(3), at(4), at(5)].into());
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
        format!(
            "the file ends before the ({rows}, {columns}) float{bits} that its header promises"
        ),
    )
}
