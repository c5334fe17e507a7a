//! An array in memory of its own, or in a mapped file.

use std::fmt;
use std::ops::{Deref, Range};
use std::sync::Arc;

use bytemuck::Pod;

use super::MappedFile;

/// Items that stand one after another and do not change: a `Vec`, or a part of a mapped file, which
/// is shared by all that map it. Read as a slice; made from a `Vec` by `into()`.
pub struct Buffer<T> {
    /// Where they are: within `owner`, which never moves them.
    items: *const T,
    count: usize,
    owner: Owner<T>,
}

enum Owner<T> {
    Memory(Vec<T>),
    File(Arc<MappedFile>),
}

/// A range of bytes that does not lie in the file, or is no array of the items that are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BufferOutOfFile;

// SAFETY: a buffer is read through shared references only, as a slice of its items is.
#[allow(unsafe_code)]
unsafe impl<T: Send + Sync> Send for Buffer<T> {}

// SAFETY: as above.
#[allow(unsafe_code)]
unsafe impl<T: Send + Sync> Sync for Buffer<T> {}

impl<T: Pod> Buffer<T> {
    /// The items in a range of bytes of a file.
    pub(crate) fn of_file(
        file: &Arc<MappedFile>,
        bytes: Range<usize>,
    ) -> Result<Buffer<T>, BufferOutOfFile> {
        let bytes = file.get(bytes).ok_or(BufferOutOfFile)?;
        let items: &[T] = bytemuck::try_cast_slice(bytes).map_err(|_| BufferOutOfFile)?;
        let (items, count) = (items.as_ptr(), items.len());
        Ok(Buffer { items, count, owner: Owner::File(Arc::clone(file)) })
    }
}

impl<T> Buffer<T> {
    /// Bytes of memory of its own: none in a file.
    pub fn bytes_in_memory(&self) -> usize {
        match &self.owner {
            Owner::Memory(items) => size_of_val(&items[..]),
            Owner::File(_) => 0,
        }
    }
}

impl<T> Deref for Buffer<T> {
    type Target = [T];

    #[inline(always)]
    #[allow(unsafe_code)]
    fn deref(&self) -> &[T] {
        // SAFETY: `items` and `count` are those of a slice of `owner`. A vector that is not changed
        // stays where it is, even if the buffer moves, and so does a map. Items in a file are plain
        // data, for which every bit pattern is valid; for what other programs do to them meanwhile
        // see `MappedFile`.
        unsafe { std::slice::from_raw_parts(self.items, self.count) }
    }
}

impl<T> From<Vec<T>> for Buffer<T> {
    fn from(items: Vec<T>) -> Buffer<T> {
        Buffer { items: items.as_ptr(), count: items.len(), owner: Owner::Memory(items) }
    }
}

impl<T, const N: usize> From<[T; N]> for Buffer<T> {
    fn from(items: [T; N]) -> Buffer<T> {
        Vec::from(items).into()
    }
}

impl<T> FromIterator<T> for Buffer<T> {
    fn from_iter<I: IntoIterator<Item = T>>(items: I) -> Buffer<T> {
        Vec::from_iter(items).into()
    }
}

impl<T> Default for Buffer<T> {
    fn default() -> Buffer<T> {
        Vec::new().into()
    }
}

impl<T: Clone> Clone for Buffer<T> {
    fn clone(&self) -> Buffer<T> {
        match &self.owner {
            Owner::Memory(items) => items.clone().into(),
            Owner::File(file) => Buffer {
                items: self.items,
                count: self.count,
                owner: Owner::File(Arc::clone(file)),
            },
        }
    }
}

impl<T: fmt::Debug> fmt::Debug for Buffer<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self[..].fmt(f)
    }
}

impl<T: PartialEq> PartialEq for Buffer<T> {
    fn eq(&self, other: &Buffer<T>) -> bool {
        self[..] == other[..]
    }
}

impl<T: PartialEq, const N: usize> PartialEq<[T; N]> for Buffer<T> {
    fn eq(&self, other: &[T; N]) -> bool {
        self[..] == other[..]
    }
}

impl<'a, T> IntoIterator for &'a Buffer<T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_buffer_is_what_it_was_made_of_wherever_it_moves() {
        let buffer: Buffer<[u32; 3]> = (0..1000).map(|i| [i, 2 * i, 3 * i]).collect();
        let moved = Box::new([buffer]);
        assert_eq!(moved[0][999], [999, 1998, 2997]);
        assert_eq!((moved[0].len(), moved[0].bytes_in_memory()), (1000, 12_000));
        let copy = moved[0].clone();
        drop(moved);
        assert_eq!(copy[1], [1, 2, 3]);
        assert!(Buffer::<u8>::default().is_empty());
    }

    #[test]
    fn only_whole_items_that_lie_in_the_file_are_mapped() {
        let mut file = tempfile::tempfile().unwrap();
        std::io::Write::write_all(&mut file, &[1, 0, 0, 0, 2, 0, 0, 0, 3]).unwrap();
        let map = Arc::new(MappedFile::new(&file).expect("maps"));
        let part = |bytes| Buffer::<u32>::of_file(&map, bytes);
        let [both, first] = [0..8, 0..4].map(|bytes| part(bytes).unwrap());
        drop(map.clone());
        assert_eq!((&both[..], &first[..]), (&[1, 2][..], &[1][..]));
        assert_eq!((both.clone(), both.bytes_in_memory()), (vec![1, 2].into(), 0));
        for wrong in [0..7, 1..5, 8..12, 12..12, 4..usize::MAX] {
            assert_eq!(part(wrong.clone()).err(), Some(BufferOutOfFile), "{wrong:?}");
        }
    }
}
