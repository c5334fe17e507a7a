//! Writes a tree and its mesh.

use std::io::Write;
use std::path::Path;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use bytemuck::Zeroable;

use super::TreeFile;
use super::checksums::{checksums_of, content_hash, header_checksum, mesh_hash};
use super::header::{BYTE_ORDER, Flag, Header, MAGIC, PAGE, Section, VERSION, halves};
use crate::error::{Error, Result};
use crate::mesh::{Material, Mesh, Positions};
use crate::progress::{Observer, SharedProgress, Stage};
use crate::storage::AtomicFile;
use crate::tree::{BuildParameters, Tree};

/// Bytes between two looks at the observer.
const PORTION: usize = 4 << 20;

/// Writes `tree` over `mesh` to the file at `path`, which appears whole or not at all, and is durable
/// then. If they come from `source`, they are as they were there. Reports [`Stage::Write`].
///
/// # Errors
/// [`Error::Io`] if the file cannot be written, [`Error::Format`] if the source was damaged, [`Error::Interrupted`] if `observer` ends the work.
pub fn write(
    path: &Path,
    mesh: &Mesh,
    tree: &Tree,
    parameters: &BuildParameters,
    build_time: Duration,
    source: Option<&TreeFile>,
    observer: &dyn Observer,
) -> Result<()> {
    if cfg!(target_endian = "big") {
        return Err(Error::invalid("tree file", "can only be written on little-endian machines"));
    }
    let mut file = AtomicFile::create(path)?;

    // Lay the sections out, and find their checksums.
    let materials: Vec<[f32; 8]> = mesh.materials.iter().map(numbers_of).collect();
    let arrays = arrays_of(mesh, tree, &materials);
    let total: usize = arrays.iter().map(|bytes| bytes.len()).sum();
    let progress = SharedProgress::new(observer, Stage::Write, 2 * total);
    let mut header = header_of(mesh, tree, parameters, build_time);
    let mut checksums = Vec::new();
    let mut end = PAGE;
    for (section, bytes) in header.sections.iter_mut().zip(arrays) {
        *section = Section { offset: end.next_multiple_of(PAGE) as u64, bytes: bytes.len() as u64 };
        end = section.range().end;
        checksums.extend(checksums_of(bytes, &progress)?);
    }
    let table: &[u8] = bytemuck::cast_slice(&checksums);
    let offset = end.next_multiple_of(PAGE);
    header.sections[Section::CHECKSUMS] =
        Section { offset: offset as u64, bytes: table.len() as u64 };
    header.file_bytes = (offset + table.len()) as u64;

    // Whole seconds, which every file system keeps as they are.
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_secs();
    header.written_at = now as i64;
    header.mesh_hash = halves(mesh_hash(mesh));
    header.content_hash = halves(content_hash(&header, &checksums));
    header.header_checksum = header_checksum(&header);
    // What is copied from another file must be what was written there.
    let is_damaged = |source: &TreeFile| source.content_hash() != header.content_hash();
    if let Some(source) = source.filter(|source| is_damaged(source)) {
        return Err(source.damaged());
    }

    // Write them.
    let mut written = PAGE;
    let mut put = |bytes: &[u8]| file.write_all(bytes).map_err(|error| Error::io(path, error));
    put(bytemuck::bytes_of(&header))?;
    for (section, bytes) in header.sections.iter().zip(arrays.into_iter().chain([table])) {
        put(&[0; PAGE][..section.range().start - written])?;
        for portion in bytes.chunks(PORTION) {
            put(portion)?;
            progress.advance(portion.len())?;
        }
        written = section.range().end;
    }
    progress.check()?;
    source.map_or(Ok(()), TreeFile::check)?;
    file.commit_as_of(UNIX_EPOCH + Duration::from_secs(now))?;
    progress.finish();
    Ok(())
}

/// The bytes of all sections but the last.
fn arrays_of<'a>(
    mesh: &'a Mesh,
    tree: &'a Tree,
    materials: &'a [[f32; 8]],
) -> [&'a [u8]; Section::COUNT - 1] {
    let mut arrays: [&[u8]; Section::COUNT - 1] = Default::default();
    arrays[Section::NODES] = bytemuck::cast_slice(&tree.nodes);
    arrays[Section::LEAF_BLOCKS] = bytemuck::cast_slice(&tree.leaves.blocks);
    arrays[Section::COLLINEAR] = bytemuck::cast_slice(tree.collinear.corners());
    arrays[Section::POSITIONS] = match mesh.positions() {
        Positions::F32(positions) => bytemuck::cast_slice(positions),
        Positions::F64(positions) => bytemuck::cast_slice(positions),
    };
    arrays[Section::TRIANGLES] = bytemuck::cast_slice(mesh.triangles());
    arrays[Section::SOURCE_FACES] =
        mesh.source_faces.as_deref().map_or(&[], |faces| bytemuck::cast_slice(faces));
    arrays[Section::VERTEX_COLORS] =
        mesh.vertex_colors.as_deref().map_or(&[], |colors| bytemuck::cast_slice(colors));
    arrays[Section::MATERIALS] = bytemuck::cast_slice(materials);
    arrays[Section::TRIANGLE_MATERIALS] =
        mesh.triangle_materials.as_deref().map_or(&[], |numbers| bytemuck::cast_slice(numbers));
    arrays
}

/// A material as it stands in the file.
fn numbers_of(material: &Material) -> [f32; 8] {
    let Material { base_color: [r, g, b, a], metallic, roughness, transmission, ior } = *material;
    [r, g, b, a, metallic, roughness, transmission, ior]
}

/// All that does not depend on where the sections are.
fn header_of(
    mesh: &Mesh,
    tree: &Tree,
    parameters: &BuildParameters,
    build_time: Duration,
) -> Header {
    let flags = [
        (Flag::DOUBLE_POSITIONS, matches!(mesh.positions(), Positions::F64(_))),
        (Flag::EXACT_BLOCKS, tree.leaves.are_exact),
        (Flag::SOURCE_FACES, mesh.source_faces.is_some()),
        (Flag::VERTEX_COLORS, mesh.vertex_colors.is_some()),
        (Flag::TRIANGLE_MATERIALS, mesh.triangle_materials.is_some()),
        (Flag::WEIGH_OBJECT_SPLITS, parameters.weigh_object_splits),
        (Flag::COARSE_GRID, parameters.coarse_grid),
    ];
    let mut program = [0; 32];
    let name = concat!("halfline ", env!("CARGO_PKG_VERSION")).as_bytes();
    program[..name.len()].copy_from_slice(name);
    Header {
        magic: MAGIC,
        version: VERSION,
        byte_order: BYTE_ORDER,
        frame_offset: tree.frame.offset().to_array(),
        frame_unit: tree.frame.unit(),
        bounds: tree.bounds,
        root: tree.root.0,
        max_stack_size: tree.max_stack_size as u32,
        reach: tree.reach,
        flags: flags.into_iter().filter(|(_, is_set)| *is_set).map(|(flag, _)| flag).sum(),
        references: tree.references as u64,
        skipped_zero_area: tree.skipped_zero_area as u64,
        skipped_non_finite: tree.skipped_non_finite as u64,
        spatial_splits: tree.spatial_splits as u64,
        object_splits: tree.object_splits as u64,
        spatial_split_min_triangles: parameters.spatial_split_min_triangles as u64,
        duplication_budget: parameters.duplication_budget,
        spatial_bins: parameters.spatial_bins as u32,
        object_bins: parameters.object_bins as u32,
        build_seconds: build_time.as_secs_f64(),
        program,
        ..Header::zeroed()
    }
}
