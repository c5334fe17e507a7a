//! Named arrays into a NumPy `.npz` archive, which is a zip of `.npy` files.
//!
//! Nothing is compressed, as in `numpy.savez`: hits are nearly random bits, and writing them at
//! the disk's speed beats waiting for a tenth less. Times are the zip format's zero, so that equal
//! hits give equal files.

use std::io::{self, Seek, Write};

use halfline::progress::{Observer, Stage};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

/// Bytes gathered before they go to the archive.
const BLOCK: usize = 1 << 18;

/// What one array's elements are.
pub trait Element: Copy {
    /// The name that NumPy has for the type.
    const DTYPE: &'static str;
    /// Bytes of one element.
    const SIZE: usize;
    /// Appends the element's bytes.
    fn put(self, bytes: &mut Vec<u8>);
}

impl Element for f64 {
    const DTYPE: &'static str = "<f8";
    const SIZE: usize = 8;
    fn put(self, bytes: &mut Vec<u8>) {
        bytes.extend_from_slice(&self.to_le_bytes());
    }
}

impl Element for i64 {
    const DTYPE: &'static str = "<i8";
    const SIZE: usize = 8;
    fn put(self, bytes: &mut Vec<u8>) {
        bytes.extend_from_slice(&self.to_le_bytes());
    }
}

impl Element for bool {
    const DTYPE: &'static str = "|b1";
    const SIZE: usize = 1;
    fn put(self, bytes: &mut Vec<u8>) {
        bytes.push(self.into());
    }
}

/// An archive under way.
pub struct Archive<'a, W: Write + Seek> {
    zip: ZipWriter<W>,
    observer: &'a dyn Observer,
    written: u64,
    total: u64,
}

impl<'a, W: Write + Seek> Archive<'a, W> {
    /// Begins an archive of about `total` bytes, of which `observer` hears, in `file`.
    pub fn new(file: W, total: u64, observer: &'a dyn Observer) -> Archive<'a, W> {
        Archive { zip: ZipWriter::new(file), observer, written: 0, total }
    }

    /// Adds an array of shape (n,) if N is 1, else (n, N).
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn add<const N: usize, E: Element>(
        &mut self,
        name: &str,
        elements: impl ExactSizeIterator<Item = [E; N]>,
    ) -> io::Result<()> {
        let rows = elements.len();
        let size = (rows * N * E::SIZE) as u64;
        let options = SimpleFileOptions::default()
            .compression_method(zip::CompressionMethod::Stored)
            // The header takes 128 bytes of the 4 GiB that an old zip may hold.
            .large_file(size > u64::from(u32::MAX) - 128);
        self.zip.start_file(format!("{name}.npy"), options)?;
        let shape = if N == 1 { format!("({rows},)") } else { format!("({rows}, {N})") };
        let mut bytes = Vec::with_capacity(BLOCK + N * E::SIZE);
        put_header(&mut bytes, E::DTYPE, &shape);
        for row in elements {
            row.into_iter().for_each(|element| element.put(&mut bytes));
            if bytes.len() >= BLOCK {
                self.flush(&mut bytes)?;
            }
        }
        self.flush(&mut bytes)
    }

    /// Writes the archive's table of contents.
    pub fn finish(self) -> io::Result<()> {
        self.zip.finish()?;
        Ok(())
    }

    fn flush(&mut self, bytes: &mut Vec<u8>) -> io::Result<()> {
        self.zip.write_all(bytes)?;
        self.written += bytes.len() as u64;
        bytes.clear();
        self.observer.report(Stage::Write, self.written.min(self.total), self.total);
        Ok(())
    }
}

/// Format version 1.0; the data begins at a multiple of 64 bytes.
fn put_header(bytes: &mut Vec<u8>, dtype: &str, shape: &str) {
    let dictionary = format!("{{'descr': '{dtype}', 'fortran_order': False, 'shape': {shape}, }}");
    let before = b"\x93NUMPY\x01\x00".len() + 2;
    let length = (before + dictionary.len() + 1).next_multiple_of(64) - before;
    bytes.extend_from_slice(b"\x93NUMPY\x01\x00");
    bytes.extend_from_slice(&(length as u16).to_le_bytes());
    bytes.extend_from_slice(format!("{dictionary:<width$}\n", width = length - 1).as_bytes());
}
