//! The first page of a tree file.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};

use super::ContentHash;
use crate::tree::Bounds;

/// What every tree file begins with. As in PNG, a file that was copied as text or as seven-bit data
/// shows it.
pub const MAGIC: [u8; 8] = *b"\x89HLT\r\n\x1a\n";

/// The version of the format that this code writes, and the only one that it reads.
pub const VERSION: u32 = 2;

/// A number that reads otherwise where numbers have their bytes the other way round.
pub const BYTE_ORDER: u32 = 0x0102_0304;

/// The header has a page of its own, and every section begins on one.
pub const PAGE: usize = 4096;

/// Where an array lies in the file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Section {
    /// Bytes from the file's beginning.
    pub offset: u64,
    /// How many bytes it has; none if the mesh has no such array.
    pub bytes: u64,
}

impl Section {
    /// The places of sections in [`Header::sections`], in the order of the file.
    pub const NODES: usize = 0;
    pub const LEAF_BLOCKS: usize = 1;
    pub const COLLINEAR: usize = 2;
    pub const POSITIONS: usize = 3;
    pub const TRIANGLES: usize = 4;
    pub const SOURCE_FACES: usize = 5;
    pub const VERTEX_COLORS: usize = 6;
    pub const MATERIALS: usize = 7;
    pub const TRIANGLE_MATERIALS: usize = 8;
    pub const CHECKSUMS: usize = 9;
    pub const COUNT: usize = 10;

    /// The names of the sections, for errors.
    pub const NAMES: [&'static str; Section::COUNT] = [
        "nodes",
        "leaf blocks",
        "collinear faces",
        "vertices",
        "triangles",
        "source faces",
        "vertex colours",
        "materials",
        "materials of triangles",
        "checksums",
    ];

    /// The bytes of the section in the file. Only for sections that were checked to lie there.
    pub fn range(&self) -> Range<usize> {
        self.offset as usize..(self.offset + self.bytes) as usize
    }
}

/// Which optional arrays a mesh has, and other yes or no, as bits of [`Header::flags`].
pub struct Flag;

impl Flag {
    pub const DOUBLE_POSITIONS: u32 = 1;
    pub const EXACT_BLOCKS: u32 = 2;
    pub const SOURCE_FACES: u32 = 4;
    pub const VERTEX_COLORS: u32 = 8;
    pub const TRIANGLE_MATERIALS: u32 = 16;
    pub const WEIGH_OBJECT_SPLITS: u32 = 32;
    pub const COARSE_GRID: u32 = 64;
}

/// The header: numbers are little endian, and there is no padding.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Header {
    /// Always [`MAGIC`].
    pub magic: [u8; 8],
    /// Always [`VERSION`].
    pub version: u32,
    /// Always [`BYTE_ORDER`].
    pub byte_order: u32,
    /// Length of the whole file.
    pub file_bytes: u64,
    /// The time of modification that the file got when it was written, in seconds since 1970.
    pub written_at: i64,
    /// The checksum of the header with zero in this field, as `checksums.rs` computes it.
    pub header_checksum: u64,
    /// The hash of all content, its lower half first.
    pub content_hash: [u64; 2],
    pub mesh_hash: [u64; 2],
    pub sections: [Section; Section::COUNT],
    pub frame_offset: [f64; 3],
    pub frame_unit: f64,
    pub bounds: Bounds,
    /// Bits of a [`NodeRef`](crate::tree::NodeRef).
    pub root: u32,
    pub max_stack_size: u32,
    pub reach: f32,
    /// Bits of [`Flag`].
    pub flags: u32,
    pub references: u64,
    pub skipped_zero_area: u64,
    pub skipped_non_finite: u64,
    pub spatial_splits: u64,
    pub object_splits: u64,
    pub spatial_split_min_triangles: u64,
    pub duplication_budget: f64,
    pub spatial_bins: u32,
    pub object_bins: u32,
    pub build_seconds: f64,
    /// Name and version of the program that wrote the file, for people.
    pub program: [u8; 32],
    /// Always zeros.
    pub unused: [u8; 3688],
}

impl Header {
    /// The hash of what the file holds.
    pub fn content_hash(&self) -> ContentHash {
        joined(self.content_hash)
    }

    /// The hash of the mesh.
    pub fn mesh_hash(&self) -> ContentHash {
        joined(self.mesh_hash)
    }

    /// True if a bit of [`Flag`] is set.
    pub fn has(&self, flag: u32) -> bool {
        self.flags & flag != 0
    }
}

/// The two halves of a hash, the lower one first.
pub fn halves(hash: ContentHash) -> [u64; 2] {
    [hash.0 as u64, (hash.0 >> 64) as u64]
}

fn joined([low, high]: [u64; 2]) -> ContentHash {
    ContentHash(u128::from(high) << 64 | u128::from(low))
}

const _: () = assert!(size_of::<Header>() == PAGE);
