//! Wavefront OBJ.
//!
//! The crate tobj was considered and does not serve: it cuts polygons into fans, so that concave
//! ones come out wrong, fails without naming the line, and does not tell from which face of the
//! file a triangle came.
//!
//! Read are `v` (with colours, as `x y z r g b` or `x y z r g b a`; a fourth value alone is a
//! weight and ignored), `f`, `mtllib` and `usemtl`; all else is passed over. A comment begins with a
//! `#` at the start of a line or after a blank; where names may hold one, the whole name is tried
//! first and then the part before the `#`. Coordinates are kept
//! in double precision unless every one of them fits single precision without loss. Two passes:
//! a face may name vertices that come after it.

use std::path::Path;

use super::lines::{Fields, Lines, integer, name_without_comment, number, quoted};
use super::mtl::MaterialLibrary;
use super::{colors, sibling};
use crate::triangulate::Triangulator;
use halfline::error::{Error, Result};
use halfline::geometry::Vec3;
use halfline::mesh::{Material, Mesh, Positions};
use halfline::progress::{Observer, Stage};

/// Reads the content `bytes` of the file `path`. Material libraries are read where they lie in
/// the file's folder or below; one that is missing or elsewhere is passed over.
///
/// # Errors
/// [`Error::Format`] with the line, or [`Error::Interrupted`].
pub fn read(path: &Path, bytes: &[u8], observer: &dyn Observer) -> Result<Mesh> {
    let vertices = Vertices::read(path, bytes, observer)?;
    let faces = Faces::read(path, bytes, observer, &vertices)?;
    observer.report(Stage::Load, bytes.len() as u64, bytes.len() as u64);

    let mut mesh = Mesh::new(Positions::without_loss(vertices.positions), faces.triangles)?;
    mesh.source_faces = faces.source_faces.map(Into::into);
    if !vertices.colors.is_empty() {
        mesh.vertex_colors = Some(colors::to_bytes(&vertices.colors).into());
    }
    if let Some(mut triangle_materials) = faces.triangle_materials {
        mesh.materials = vertices.library.materials;
        let default = mesh.materials.len() as u32;
        for material in &mut triangle_materials {
            *material = (*material).min(default);
        }
        if triangle_materials.contains(&default) {
            mesh.materials.push(Material::default());
        }
        mesh.triangle_materials = Some(triangle_materials.into());
    }
    Ok(mesh)
}

/// What the first pass collects.
#[derive(Default)]
struct Vertices {
    positions: Vec<[f64; 3]>,
    /// Empty, or a colour for each vertex.
    colors: Vec<[f32; 4]>,
    library: MaterialLibrary,
}

impl Vertices {
    fn read(path: &Path, bytes: &[u8], observer: &dyn Observer) -> Result<Vertices> {
        let mut vertices = Vertices::default();
        let mut foreign_line = None;
        let mut lines = Lines::new(bytes);
        while let Some(line) = lines.next_continued() {
            let mut fields = Fields::of(line);
            match fields.next() {
                Some(b"v") => {
                    if let Err(reason) = vertices.push(fields) {
                        return Err(lines.error(path, reason));
                    }
                }
                Some(b"mtllib") => vertices.load_libraries(path, fields.rest())?,
                Some(keyword) if foreign_line.is_none() && !is_statement(keyword) => {
                    let keyword = quoted(keyword);
                    foreign_line = Some((lines.place(), keyword));
                }
                _ => {}
            }
            lines.report(observer, 0, 2)?;
        }
        if vertices.positions.len() >= u32::MAX as usize {
            return Err(lines.error(path, "more than 2^32 - 2 vertices"));
        }
        match foreign_line {
            Some((place, keyword)) if vertices.positions.is_empty() => Err(Error::format(
                path,
                place,
                format!("{keyword} is no statement of Wavefront OBJ, and the file has no vertex"),
            )),
            _ => Ok(vertices),
        }
    }

    fn push(&mut self, mut fields: Fields) -> std::result::Result<(), String> {
        let mut values = [0.0; 7];
        let mut count = 0;
        for value in &mut values {
            let Some(field) = fields.next().filter(|field| !is_comment(field)) else { break };
            *value = number(field)?;
            count += 1;
        }
        let [x, y, z, r, g, b, a] = values;
        if count < 3 {
            return Err(format!("a vertex needs three coordinates, found {count}"));
        }
        if count >= 6 {
            self.colors.resize(self.positions.len(), [colors::UNSET; 4]);
            let alpha = if count == 7 { a as f32 } else { colors::UNSET };
            self.colors.push([r as f32, g as f32, b as f32, alpha]);
        } else if !self.colors.is_empty() {
            self.colors.push([colors::UNSET; 4]);
        }
        self.positions.push([x, y, z]);
        Ok(())
    }

    /// Names of libraries may hold blanks, and a line may name several.
    fn load_libraries(&mut self, path: &Path, names: &[u8]) -> Result<()> {
        if self.load_library(path, names)? {
            return Ok(());
        }
        let names = name_without_comment(names);
        if !self.load_library(path, names)? {
            for name in Fields::of(names) {
                self.load_library(path, name)?;
            }
        }
        Ok(())
    }

    fn load_library(&mut self, path: &Path, name: &[u8]) -> Result<bool> {
        let Ok(name) = std::str::from_utf8(name) else { return Ok(false) };
        match sibling::locate(path, name) {
            Ok(place) => self.library.load(&place),
            Err(_) => Ok(false),
        }
    }
}

/// What the second pass collects.
#[derive(Default)]
struct Faces {
    triangles: Vec<[u32; 3]>,
    /// Set once a face did not become exactly one triangle.
    source_faces: Option<Vec<u32>>,
    /// Set once a face has a known material; `NO_MATERIAL` where there is none.
    triangle_materials: Option<Vec<u32>>,
}

const NO_MATERIAL: u32 = u32::MAX;

impl Faces {
    fn read(
        path: &Path,
        bytes: &[u8],
        observer: &dyn Observer,
        vertices: &Vertices,
    ) -> Result<Faces> {
        let mut faces = Faces::default();
        let mut triangulator = Triangulator::new();
        let mut corners: Vec<u32> = Vec::new();
        let mut points: Vec<Vec3> = Vec::new();
        let mut vertices_so_far = 0;
        let mut face_count = 0;
        let mut material = NO_MATERIAL;
        let mut lines = Lines::new(bytes);
        while let Some(line) = lines.next_continued() {
            let mut fields = Fields::of(line);
            match fields.next() {
                Some(b"v") => vertices_so_far += 1,
                Some(b"f") => {
                    corners.clear();
                    for field in fields.take_while(|field| !is_comment(field)) {
                        match vertex_index(field, vertices_so_far, vertices.positions.len()) {
                            Ok(index) => corners.push(index),
                            Err(reason) => return Err(lines.error(path, reason)),
                        }
                    }
                    match corners[..] {
                        [a, b, c] => faces.triangles.push([a, b, c]),
                        [] | [_] | [_, _] => {
                            let reason =
                                format!("a face needs three corners, found {}", corners.len());
                            return Err(lines.error(path, reason));
                        }
                        _ => {
                            points.clear();
                            let positions = &vertices.positions;
                            points
                                .extend(corners.iter().map(|&i| Vec3::from(positions[i as usize])));
                            triangulator.triangulate(&points, |triangle| {
                                faces.triangles.push(triangle.map(|i| corners[i]));
                            });
                        }
                    }
                    if faces.triangles.len().max(face_count as usize) >= u32::MAX as usize - 1 {
                        return Err(lines.error(path, "more than 2^32 - 2 faces or triangles"));
                    }
                    faces.trace(face_count, material);
                    face_count += 1;
                }
                Some(b"usemtl") => {
                    material = vertices.library.find(fields.rest()).unwrap_or(NO_MATERIAL);
                }
                _ => {}
            }
            lines.report(observer, 1, 2)?;
        }
        Ok(faces)
    }

    /// Notes the face and the material of the triangles since the last call.
    fn trace(&mut self, face: u32, material: u32) {
        let triangle_count = self.triangles.len();
        if self.source_faces.is_none() && triangle_count != face as usize + 1 {
            self.source_faces = Some((0..face).collect());
        }
        if let Some(source_faces) = &mut self.source_faces {
            source_faces.resize(triangle_count, face);
        }
        if self.triangle_materials.is_none() && material != NO_MATERIAL {
            let mut earlier = Vec::new();
            earlier.resize(self.traced(face), NO_MATERIAL);
            self.triangle_materials = Some(earlier);
        }
        if let Some(triangle_materials) = &mut self.triangle_materials {
            triangle_materials.resize(triangle_count, material);
        }
    }

    /// Number of triangles of the faces before `face`.
    fn traced(&self, face: u32) -> usize {
        match &self.source_faces {
            Some(faces) => faces.partition_point(|&f| f < face),
            None => face as usize,
        }
    }
}

/// The vertex of a face's corner `v`, `v/vt`, `v//vn` or `v/vt/vn`. Counts from 1, or backwards
/// from the latest vertex with -1.
fn vertex_index(
    field: &[u8],
    vertices_so_far: usize,
    vertex_count: usize,
) -> std::result::Result<u32, String> {
    let mut parts = field.split(|&byte| byte == b'/');
    let index = parts.next().and_then(integer);
    let others_are_indices =
        parts.clone().count() <= 2 && parts.all(|part| part.is_empty() || integer(part).is_some());
    let Some(index) = index.filter(|_| others_are_indices) else {
        return Err(format!("{} is not a corner v, v/vt, v//vn or v/vt/vn", quoted(field)));
    };
    if index == 0 {
        return Err("vertex index 0: indices count from 1".to_owned());
    }
    // The index fits eighteen digits, and the number of vertices 32 bits.
    let from_zero = if index > 0 { index - 1 } else { index + vertices_so_far as i64 };
    if (0..vertex_count as i64).contains(&from_zero) {
        Ok(from_zero as u32)
    } else if index > 0 {
        Err(format!("vertex index {index}, but the file has {vertex_count} vertices"))
    } else {
        Err(format!("vertex index {index}, but {vertices_so_far} vertices come before it"))
    }
}

/// True if a comment begins with this field.
#[inline]
fn is_comment(field: &[u8]) -> bool {
    field.starts_with(b"#")
}

/// True if `start`, the first bytes of a file, are statements of the format, among them a vertex. No
/// other sign tells an OBJ file by its content.
pub(super) fn is_obj(start: &[u8]) -> bool {
    let mut lines = Lines::new(start);
    let mut has_vertex = false;
    while let Some(line) = lines.next_continued() {
        let mut fields = Fields::of(line);
        match fields.next() {
            Some(b"v") => has_vertex |= Vertices::default().push(fields).is_ok(),
            // The last line may be cut anywhere.
            Some(keyword) if !is_statement(keyword) => {
                return has_vertex && lines.bytes_left() == 0;
            }
            _ => {}
        }
    }
    has_vertex
}

/// True for the keywords of the format, comments included.
fn is_statement(keyword: &[u8]) -> bool {
    const STATEMENTS: [&[u8]; 44] = [
        b"v",
        b"vt",
        b"vn",
        b"vp",
        b"f",
        b"fo",
        b"l",
        b"p",
        b"g",
        b"o",
        b"s",
        b"mg",
        b"usemtl",
        b"mtllib",
        b"usemap",
        b"maplib",
        b"cstype",
        b"deg",
        b"bmat",
        b"step",
        b"curv",
        b"curv2",
        b"surf",
        b"parm",
        b"trim",
        b"hole",
        b"scrv",
        b"sp",
        b"end",
        b"con",
        b"bevel",
        b"c_interp",
        b"d_interp",
        b"lod",
        b"shadow_obj",
        b"trace_obj",
        b"ctech",
        b"stech",
        b"call",
        b"csh",
        b"bsp",
        b"bzp",
        b"cdc",
        b"res",
    ];
    is_comment(keyword) || STATEMENTS.contains(&keyword)
}
