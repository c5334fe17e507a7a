//! Opens a tree file.

use std::io::Read;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, UNIX_EPOCH};

use bytemuck::Pod;

use super::TreeFile;
use super::checksums::{CHUNK, Verify, damage, header_checksum};
use super::header::{BYTE_ORDER, Flag, Header, MAGIC, PAGE, Section, VERSION};
use crate::error::{Error, Result};
use crate::mesh::{Material, Mesh, Positions};
use crate::numeric::Frame;
use crate::progress::Observer;
use crate::storage::{Buffer, MappedFile, open_regular};
use crate::tree::{BuildParameters, CollinearFaces, LeafBlocks, MAX_STACK_SIZE, NodeRef, Tree};

/// What a tree file holds.
pub struct Opened {
    /// The mesh in the file.
    pub mesh: Mesh,
    /// The tree over the mesh.
    pub tree: Tree,
    /// How the tree was built.
    pub parameters: BuildParameters,
    /// How long the tree took to build.
    pub build_time: Duration,
    /// The file, mapped.
    pub file: TreeFile,
}

/// True if the file at `path` is a tree, or at least claims to be one: by its first bytes, or by its
/// name if it has none.
pub fn is_tree_file(path: &Path) -> bool {
    let mut start = Vec::new();
    // A pipe would lose what is read here, and cannot be a tree.
    let read = open_regular(path)
        .is_ok_and(|(file, _)| file.take(MAGIC.len() as u64).read_to_end(&mut start).is_ok());
    let is_named = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("hlt"));
    read && start == MAGIC || is_named && !path.is_dir()
}

/// Maps the tree file at `path`.
///
/// # Errors
/// [`Error::Io`] if it cannot be mapped, [`Error::Format`] if it is not a tree, or one of another
/// version, cut short or damaged; [`Error::Interrupted`] if `observer` ends the work.
pub fn open(path: &Path, verify: Verify, observer: &dyn Observer) -> Result<Opened> {
    let absolute = std::path::absolute(path).map_err(|error| Error::io(path, error))?;
    let (map, is_touched) = map(path)?;
    let header = header_of(path, &map)?;
    let is_checked = match verify {
        Verify::Always => true,
        Verify::IfTouched => is_touched(&header),
        Verify::Never => false,
    };
    if is_checked && let Some(range) = damage(&map, &header, observer)? {
        let name = (0..Section::COUNT)
            .filter(|&section| header.sections[section].bytes > 0)
            .find(|&section| header.sections[section].range().end > range.start)
            .map_or("end", |section| Section::NAMES[section]);
        let place = format!("bytes {} to {}", range.start, range.end);
        let reason = format!("the file is damaged: its {name} are not what was written");
        return Err(Error::format(path, place, reason));
    }
    let file = TreeFile {
        path: absolute,
        content_hash: header.content_hash(),
        mesh_hash: header.mesh_hash(),
        map: Arc::new(map),
    };
    let opened = assemble(path, &header, file)?;
    opened.file.check()?;
    Ok(opened)
}

/// The map of a regular file, and whether anybody has touched it since it was written.
fn map(path: &Path) -> Result<(MappedFile, impl Fn(&Header) -> bool)> {
    let (file, metadata) = open_regular(path)?;
    if metadata.len() == 0 {
        return Err(Error::format(path, "byte 0", "the file is empty"));
    }
    let map = MappedFile::new(&file).ok_or_else(|| {
        Error::format(path, "file", "the file system cannot map files, and a tree is mapped")
    })?;
    let modified = metadata.modified();
    let is_touched = move |header: &Header| {
        let seconds = Duration::from_secs(header.written_at.try_into().unwrap_or(0));
        !modified.as_ref().is_ok_and(|modified| Some(*modified) == UNIX_EPOCH.checked_add(seconds))
    };
    Ok((map, is_touched))
}

/// The header, if all that it says of itself and of the file's length is true.
fn header_of(path: &Path, bytes: &[u8]) -> Result<Header> {
    let refused = |place: &str, reason: String| Err(Error::format(path, place, reason));
    if !bytes.starts_with(&MAGIC[..MAGIC.len().min(bytes.len())]) {
        return refused("byte 0", "this is not a tree of halfline".into());
    }
    if bytes.len() < PAGE {
        let reason =
            format!("the file was cut short: it has {} bytes, not even {PAGE}", bytes.len());
        return refused("end", reason);
    }
    let header: Header = bytemuck::pod_read_unaligned(&bytes[..PAGE]);
    if header.byte_order != BYTE_ORDER {
        let reason = "its numbers have their bytes in another order than those of this machine";
        return refused("byte 12", reason.into());
    }
    if header.version != VERSION {
        let reason = format!(
            "the file is of version {}, and this program reads version {VERSION}: build it anew from its \
             mesh (halfline build MESH -o TREE)",
            header.version
        );
        return refused("byte 8", reason);
    }
    if header_checksum(&header) != header.header_checksum {
        return refused("header", "the file is damaged: its header is not what was written".into());
    }
    if header.file_bytes != bytes.len() as u64 {
        let change =
            if header.file_bytes > bytes.len() as u64 { "cut short" } else { "made longer" };
        let reason = format!(
            "the file was {change}: it has {} bytes and should have {}",
            bytes.len(),
            header.file_bytes
        );
        return refused("end", reason);
    }
    if !is_laid_out(&header) {
        return refused("header", "its sections are not where they can be".into());
    }
    Ok(header)
}

/// True if the sections follow each other within the file, each on a page of its own.
fn is_laid_out(header: &Header) -> bool {
    let mut end = PAGE as u64;
    for section in &header.sections {
        let Some(section_end) = section.offset.checked_add(section.bytes) else { return false };
        let is_next = Some(section.offset) == end.checked_next_multiple_of(PAGE as u64);
        if !is_next || section_end > header.file_bytes {
            return false;
        }
        end = section_end;
    }
    let chunks = |section: &Section| section.bytes.div_ceil(CHUNK as u64);
    let checksums: u64 = header.sections[..Section::CHECKSUMS].iter().map(chunks).sum();
    end == header.file_bytes && header.sections[Section::CHECKSUMS].bytes == 8 * checksums
}

/// The mesh and the tree, whose arrays lie in the file.
fn assemble(path: &Path, header: &Header, file: TreeFile) -> Result<Opened> {
    let sections = Sections { path, header, file: &file };
    let positions = if header.has(Flag::DOUBLE_POSITIONS) {
        Positions::F64(sections.array(Section::POSITIONS)?)
    } else {
        Positions::F32(sections.array(Section::POSITIONS)?)
    };
    let vertex_count = positions.len();
    let mut mesh = Mesh::unchecked(positions, sections.array(Section::TRIANGLES)?);
    let triangle_count = mesh.triangle_count();
    mesh.source_faces =
        sections.optional(Section::SOURCE_FACES, Flag::SOURCE_FACES, triangle_count)?;
    mesh.vertex_colors =
        sections.optional(Section::VERTEX_COLORS, Flag::VERTEX_COLORS, vertex_count)?;
    mesh.triangle_materials =
        sections.optional(Section::TRIANGLE_MATERIALS, Flag::TRIANGLE_MATERIALS, triangle_count)?;
    mesh.materials =
        sections.array::<[f32; 8]>(Section::MATERIALS)?.iter().map(material_of).collect();

    // A walk's stack is as large as the header says, so see that it is no larger than it can be.
    let max_stack_size = header.max_stack_size as usize;
    let unit = header.frame_unit;
    let counts = [header.skipped_zero_area, header.skipped_non_finite];
    let skipped = counts.iter().try_fold(0_u64, |sum, count| sum.checked_add(*count));
    let corners = header.bounds.min.into_iter().chain(header.bounds.max);
    let reach = corners.fold(0.0, |reach: f32, x| reach.max(x.abs()));
    let is_possible = max_stack_size <= MAX_STACK_SIZE
        && header.reach == reach
        && unit.is_normal()
        && (1.0 / unit).is_normal()
        && unit > 0.0
        && skipped.is_some_and(|skipped| skipped <= triangle_count as u64)
        && header.build_seconds.is_finite();
    if !is_possible {
        return Err(Error::format(path, "header", "it describes a tree that cannot be"));
    }
    let tree = Tree {
        frame: Frame::from_parts(header.frame_offset.into(), unit),
        bounds: header.bounds,
        root: NodeRef(header.root),
        nodes: sections.array(Section::NODES)?,
        max_stack_size,
        reach: header.reach,
        leaves: LeafBlocks {
            blocks: sections.array(Section::LEAF_BLOCKS)?,
            are_exact: header.has(Flag::EXACT_BLOCKS),
        },
        references: header.references as usize,
        spatial_splits: header.spatial_splits as usize,
        object_splits: header.object_splits as usize,
        collinear: CollinearFaces::from_corners(sections.array(Section::COLLINEAR)?),
        skipped_zero_area: header.skipped_zero_area as usize,
        skipped_non_finite: header.skipped_non_finite as usize,
    };
    let parameters = BuildParameters {
        spatial_split_min_triangles: header.spatial_split_min_triangles as usize,
        duplication_budget: header.duplication_budget,
        spatial_bins: header.spatial_bins as usize,
        object_bins: header.object_bins as usize,
        weigh_object_splits: header.has(Flag::WEIGH_OBJECT_SPLITS),
        coarse_grid: header.has(Flag::COARSE_GRID),
    };
    let build_time = Duration::try_from_secs_f64(header.build_seconds).unwrap_or_default();
    Ok(Opened { mesh, tree, parameters, build_time, file })
}

/// The sections of a file.
struct Sections<'a> {
    path: &'a Path,
    header: &'a Header,
    file: &'a TreeFile,
}

impl Sections<'_> {
    /// The array of a section.
    fn array<T: Pod>(&self, section: usize) -> Result<Buffer<T>> {
        let range = self.header.sections[section].range();
        Buffer::of_file(&self.file.map, range).map_err(|_| self.wrong_length(section))
    }

    /// The array of a section that the mesh may lack, with an item for each vertex or triangle.
    fn optional<T: Pod>(
        &self,
        section: usize,
        flag: u32,
        count: usize,
    ) -> Result<Option<Buffer<T>>> {
        let array = self.array(section)?;
        let expected = if self.header.has(flag) { count } else { 0 };
        if array.len() != expected {
            return Err(self.wrong_length(section));
        }
        Ok(self.header.has(flag).then_some(array))
    }

    fn wrong_length(&self, section: usize) -> Error {
        let reason = format!("its {} have a length that they cannot have", Section::NAMES[section]);
        Error::format(self.path, "header", reason)
    }
}

/// A material as it stands in the file.
fn material_of(numbers: &[f32; 8]) -> Material {
    let [r, g, b, a, metallic, roughness, transmission, ior] = *numbers;
    Material { base_color: [r, g, b, a], metallic, roughness, transmission, ior }
}
