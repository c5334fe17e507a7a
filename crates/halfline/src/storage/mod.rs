//! Files and memory: bytes of files as memory, arrays that lie in one, what happens when somebody cuts
//! such a file short, and files that appear whole or not at all. The only `unsafe` outside of `simd/`.

mod atomic_file;
mod buffer;
mod bytes;
mod huge_pages;
mod mapped_file;
mod regular;
#[cfg(unix)]
mod shortened;

pub use atomic_file::{AtomicFile, abandon_all};
pub use buffer::{Buffer, BufferOutOfFile};
pub use bytes::Bytes;
pub(crate) use huge_pages::advise_huge_pages;
pub use huge_pages::zeroed;
pub use mapped_file::MappedFile;
pub use regular::{open_regular, stream_name};
