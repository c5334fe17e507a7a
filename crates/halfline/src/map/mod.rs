//! The file map: bytes of files as memory, arrays that lie in one, and what happens when somebody cuts
//! such a file short. The only `unsafe` outside of `simd/`.

mod buffer;
mod bytes;
mod huge_pages;
mod mapped_file;
mod regular;
#[cfg(unix)]
mod shortened;

pub use buffer::{Buffer, BufferOutOfFile};
pub(crate) use bytes::Bytes;
pub(crate) use huge_pages::{advise_huge_pages, zeroed};
pub(crate) use mapped_file::MappedFile;
pub use regular::{open_regular, stream_name};
