//! Instances and primitives to one mesh.

use std::collections::HashMap;
use std::collections::btree_map::{BTreeMap, Entry};

use super::accessor::{Accessor, Component};
use super::buffers::{Buffers, unsupported_extension};
use super::document::Shape;
use super::material;
use super::scene_graph::{Instance, instances};
use super::vertex_colors::{self, Coloring};
use halfline::error::{Error, Result};
use halfline::geometry::Transform;
use halfline::mesh::{Mesh, Positions};
use halfline::progress::{Observer, Stage};

/// A scene may use a mesh, and a mesh an accessor, many times, so that a short file can ask for
/// any amount of memory. The mesh may take this many times the size of the files read ...
const MOST_BYTES_PER_BYTE: u64 = 64;
/// ... or this many bytes, whichever is more.
const BYTES_ALWAYS_ALLOWED: u64 = 64 << 20;

/// A triangle: three indices and the index of its material. A vertex: three doubles and a colour.
const BYTES_PER_TRIANGLE: u64 = 16;
const BYTES_PER_VERTEX: u64 = 28;

/// Elements handled between two questions whether to stop.
const ELEMENTS_BETWEEN_CHECKS: usize = 1 << 16;

/// A mesh of the document, as primitives of triangles over blocks of vertices. Primitives that
/// use the same positions and colours share a block.
#[derive(Default)]
struct Parts {
    blocks: Vec<Block>,
    primitives: Vec<Primitive>,
    vertices: u64,
    triangles: u64,
}

#[derive(PartialEq, Eq)]
struct Block {
    positions: u32,
    coloring: Option<Coloring>,
}

struct Primitive {
    /// Index in the document's mesh.
    number: usize,
    block: usize,
    indices: Option<u32>,
    mode: Mode,
    material: Option<u32>,
}

#[derive(Clone, Copy)]
enum Mode {
    Triangles,
    Strip,
    Fan,
}

pub(super) fn assemble(buffers: &Buffers, bytes: u64, observer: &dyn Observer) -> Result<Mesh> {
    let path = buffers.path;
    let instances = instances(path, buffers.document)?;

    // See what the meshes are made of, and what they will need.
    let mut parts: BTreeMap<u32, Parts> = BTreeMap::new();
    let (mut vertices, mut triangles) = (0_u64, 0_u64);
    for instance in &instances {
        let parts = match parts.entry(instance.mesh) {
            Entry::Occupied(entry) => entry.into_mut(),
            Entry::Vacant(entry) => {
                observer.check()?;
                entry.insert(Parts::of(buffers, instance.mesh)?)
            }
        };
        vertices = vertices.saturating_add(parts.vertices);
        triangles = triangles.saturating_add(parts.triangles);
    }
    let needed = vertices
        .saturating_mul(BYTES_PER_VERTEX)
        .saturating_add(triangles.saturating_mul(BYTES_PER_TRIANGLE));
    let allowed =
        buffers.bytes_read().saturating_mul(MOST_BYTES_PER_BYTE).max(BYTES_ALWAYS_ALLOWED);
    if needed > allowed || vertices >= u32::MAX.into() || triangles >= u32::MAX.into() {
        return Err(Error::format(
            path,
            "scene",
            format!(
                "its nodes repeat {} bytes into {vertices} vertices and {triangles} triangles, \
                 more than are allowed",
                buffers.bytes_read()
            ),
        ));
    }

    // Compute the colours, and then place every block and every primitive.
    let blocks = parts.values().flat_map(|parts| &parts.blocks);
    let colorings = blocks.filter_map(|block| block.coloring).collect();
    let colors = vertex_colors::compute(buffers, colorings, observer)?;
    let mut output = Output {
        positions: Vec::with_capacity(vertices as usize),
        triangles: Vec::with_capacity(triangles as usize),
        colors: (!colors.is_empty()).then(|| Vec::with_capacity(vertices as usize)),
        materials: Vec::new(),
        observer,
    };
    let default_material = buffers.document.materials.len() as u32;
    for instance in &instances {
        let parts = &parts[&instance.mesh];
        let mut first_vertices = Vec::with_capacity(parts.blocks.len());
        for block in &parts.blocks {
            first_vertices.push(output.positions.len() as u32);
            let colors = block.coloring.map(|coloring| colors[&coloring].as_slice());
            output.push_block(buffers, block, colors, &instance.transform)?;
        }
        for primitive in &parts.primitives {
            let block = &parts.blocks[primitive.block];
            let vertex_count = Accessor::new(buffers, block.positions)?.count;
            let first_vertex = first_vertices[primitive.block];
            output.push_primitive(buffers, instance, primitive, first_vertex, vertex_count)?;
            let material = primitive.material.unwrap_or(default_material);
            output.materials.resize(output.triangles.len(), material);
            let share = output.triangles.len() as f64 / triangles.max(1) as f64;
            observer.report(Stage::Load, (bytes as f64 * share) as u64, bytes);
        }
    }

    let mut mesh = Mesh::new(Positions::without_loss(output.positions), output.triangles)?;
    mesh.vertex_colors = output.colors.map(Into::into);
    if output.materials.iter().any(|&material| material != default_material) {
        mesh.materials = buffers.document.materials.iter().map(material::convert).collect();
        if output.materials.contains(&default_material) {
            mesh.materials.push(Default::default());
        }
        mesh.triangle_materials = Some(output.materials.into());
    }
    Ok(mesh)
}

impl Parts {
    fn of(buffers: &Buffers, mesh: u32) -> Result<Parts> {
        let mut parts = Parts::default();
        let mut block_numbers = HashMap::new();
        let primitives = &buffers.document.meshes[mesh as usize].primitives;
        for (number, primitive) in primitives.iter().enumerate() {
            let error = |reason: String| {
                Error::format(buffers.path, format!("mesh {mesh} primitive {number}"), reason)
            };
            let mode = match primitive.mode.unwrap_or(4) {
                0..=3 => continue,
                4 => Mode::Triangles,
                5 => Mode::Strip,
                6 => Mode::Fan,
                mode => return Err(error(format!("unknown mode {mode}"))),
            };
            // A primitive without positions has nothing to show.
            let Some(&positions) = primitive.attributes.get("POSITION") else { continue };
            let materials = &buffers.document.materials;
            if let Some(material) = primitive.material.filter(|&m| m as usize >= materials.len()) {
                let count = materials.len();
                return Err(error(format!("material {material}, but the file has {count}")));
            }

            let accessor = Accessor::new(buffers, positions)?;
            check_positions(&accessor)?;
            let vertex_count = accessor.count as u64;
            let has_draco = primitive.extensions.as_ref().is_some_and(|e| e.draco.is_some());
            if accessor.has_no_data() && has_draco {
                let place = format!("mesh {mesh} primitive {number}");
                return Err(unsupported_extension(
                    buffers.path,
                    place,
                    "KHR_draco_mesh_compression",
                ));
            }
            let corners = match primitive.indices {
                Some(indices) => Accessor::new(buffers, indices)?.count as u64,
                None => vertex_count,
            };
            let triangles = match mode {
                Mode::Triangles if corners % 3 != 0 => {
                    return Err(error(format!("{corners} corners do not make whole triangles")));
                }
                Mode::Triangles => corners / 3,
                Mode::Strip | Mode::Fan => corners.saturating_sub(2),
            };
            if triangles == 0 {
                continue;
            }
            let coloring = Coloring::of(buffers, primitive, accessor.count)?;
            let next_block = parts.blocks.len();
            let block = *block_numbers.entry((positions, coloring)).or_insert(next_block);
            if block == next_block {
                parts.blocks.push(Block { positions, coloring });
                parts.vertices = parts.vertices.saturating_add(vertex_count);
            }
            parts.triangles = parts.triangles.saturating_add(triangles);
            let (indices, material) = (primitive.indices, primitive.material);
            parts.primitives.push(Primitive { number, block, indices, mode, material });
        }
        Ok(parts)
    }
}

/// Positions are three floats or, by KHR_mesh_quantization, small integers.
fn check_positions(accessor: &Accessor) -> Result<()> {
    match (accessor.shape, accessor.component) {
        (Shape::Vec3, Component::U32) => {
            Err(accessor.error("positions must be floats or integers of at most 16 bits"))
        }
        (Shape::Vec3, _) => Ok(()),
        (shape, _) => Err(accessor.error(format!("positions must be VEC3, not {shape:?}"))),
    }
}

struct Output<'o> {
    positions: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    colors: Option<Vec<[u8; 4]>>,
    /// One for each triangle.
    materials: Vec<u32>,
    observer: &'o dyn Observer,
}

impl Output<'_> {
    fn push_block(
        &mut self,
        buffers: &Buffers,
        block: &Block,
        colors: Option<&[[u8; 4]]>,
        transform: &Transform,
    ) -> Result<()> {
        let positions = Accessor::new(buffers, block.positions)?.floats_as_declared::<3>(0.0)?;
        let moved = *transform != Transform::IDENTITY;
        for positions in positions.chunks(ELEMENTS_BETWEEN_CHECKS) {
            self.observer.check()?;
            let place = |&position: &[f32; 3]| match moved {
                true => transform.point(position.into()).to_array(),
                false => position.map(f64::from),
            };
            self.positions.extend(positions.iter().map(place));
        }
        if let Some(all) = &mut self.colors {
            match colors {
                Some(colors) => all.extend_from_slice(colors),
                None => all.resize(self.positions.len(), [255; 4]),
            }
        }
        Ok(())
    }

    fn push_primitive(
        &mut self,
        buffers: &Buffers,
        instance: &Instance,
        primitive: &Primitive,
        first_vertex: u32,
        vertex_count: usize,
    ) -> Result<()> {
        let indices = match primitive.indices {
            Some(indices) => {
                let accessor = Accessor::new(buffers, indices)?;
                let indices = accessor.indices()?;
                let outside = indices.iter().position(|&index| index as usize >= vertex_count);
                if let Some(n) = outside {
                    let (mesh, number, index) = (instance.mesh, primitive.number, indices[n]);
                    return Err(accessor.error(format!(
                        "index {n} is {index}, but mesh {mesh} primitive {number} has \
                         {vertex_count} vertices"
                    )));
                }
                Some(indices)
            }
            None => None,
        };
        let corner_count = indices.as_ref().map_or(vertex_count, Vec::len);
        let vertex = |corner: usize| match &indices {
            Some(indices) => first_vertex + indices[corner],
            None => first_vertex + corner as u32,
        };

        // A mirroring transform turns every triangle over; so they are turned back.
        let [x, y, z] = instance.transform.columns;
        let mirrored = x.cross(y).dot(z) < 0.0;
        let triangle_count = match primitive.mode {
            Mode::Triangles => corner_count / 3,
            Mode::Strip | Mode::Fan => corner_count - 2,
        };
        for n in 0..triangle_count {
            if n % ELEMENTS_BETWEEN_CHECKS == 0 {
                self.observer.check()?;
            }
            let corners = match primitive.mode {
                Mode::Triangles => [3 * n, 3 * n + 1, 3 * n + 2],
                Mode::Strip => [n, n + 1 + n % 2, n + 2 - n % 2],
                Mode::Fan => [n + 1, n + 2, 0],
            };
            let [a, b, c] = corners.map(vertex);
            self.triangles.push(if mirrored { [a, c, b] } else { [a, b, c] });
        }
        Ok(())
    }
}
