//! Object File Format: OFF and its variants with normals (N), colours (C) and texture
//! coordinates (ST).
//!
//! One line for each vertex and each face, as all known writers have it. Vertex colours are used
//! also where the header does not announce them; normals, texture coordinates and face colours
//! are passed over, and so are faces of one or two corners. Coordinates are kept in double
//! precision unless every one of them fits single precision without loss.

use std::path::Path;

use super::colors;
use super::lines::{Fields, Lines, integer, number, quoted};
use crate::triangulate::Triangulator;
use halfline::error::Result;
use halfline::geometry::Vec3;
use halfline::mesh::{Mesh, Positions};
use halfline::progress::{Observer, Stage};

/// True if a file that begins with `start` announces itself by the keyword of the format.
pub(super) fn is_off(start: &[u8]) -> bool {
    let mut lines = Lines::new(start);
    let first = next_line(&mut lines).unwrap_or_default();
    let keyword = first.split(u8::is_ascii_whitespace).next().unwrap_or_default();
    keyword
        .strip_suffix(b"OFF")
        .is_some_and(|variant| variant.iter().all(|letter| b"STCN4n".contains(letter)))
}

/// Reads the content `bytes` of the file `path`.
///
/// # Errors
/// [`Error::Format`](halfline::Error::Format) with the line, or
/// [`Error::Interrupted`](halfline::Error::Interrupted).
pub fn read(path: &Path, bytes: &[u8], observer: &dyn Observer) -> Result<Mesh> {
    let mut lines = Lines::new(bytes);
    let header = match Header::read(&mut lines) {
        Ok(header) => header,
        Err(reason) => return Err(lines.error(path, reason)),
    };

    let mut vertices = Vertices::default();
    // The header's counts were checked against the size of the file.
    vertices.positions.reserve_exact(header.vertex_count);
    for vertex in 0..header.vertex_count {
        let line = match next_line(&mut lines) {
            Some(line) => line,
            None => {
                let of = header.vertex_count;
                return Err(
                    lines.error(path, format!("the file ends before vertex {vertex} of {of}"))
                );
            }
        };
        if let Err(reason) = vertices.push(line, &header) {
            return Err(lines.error(path, reason));
        }
        lines.report(observer, 0, 1)?;
    }

    let mut faces = Faces::default();
    faces.triangles.reserve(header.face_count);
    for face in 0..header.face_count {
        let line = match next_line(&mut lines) {
            Some(line) => line,
            None => {
                let of = header.face_count;
                return Err(lines.error(path, format!("the file ends before face {face} of {of}")));
            }
        };
        if let Err(reason) = faces.push(line, face as u32, &vertices.positions) {
            return Err(lines.error(path, reason));
        }
        lines.report(observer, 0, 1)?;
    }
    observer.report(Stage::Load, bytes.len() as u64, bytes.len() as u64);

    let mut mesh = Mesh::new(Positions::without_loss(vertices.positions), faces.triangles)?;
    mesh.source_faces = faces.source_faces.map(Into::into);
    if !vertices.colors.is_empty() {
        mesh.vertex_colors = Some(colors::to_bytes(&vertices.colors).into());
    }
    Ok(mesh)
}

/// The next line with anything on it, less its comment.
fn next_line<'a>(lines: &mut Lines<'a>) -> Option<&'a [u8]> {
    loop {
        let line = lines.next()?;
        let end = memchr::memchr(b'#', line).unwrap_or(line.len());
        let line = line[..end].trim_ascii();
        if !line.is_empty() {
            return Some(line);
        }
    }
}

#[derive(Default)]
struct Header {
    normals: bool,
    colors: bool,
    texture_coordinates: bool,
    vertex_count: usize,
    face_count: usize,
}

impl Header {
    fn read(lines: &mut Lines) -> std::result::Result<Header, String> {
        let mut header = Header::default();
        let first = next_line(lines).ok_or("the file is empty")?;
        let mut rest = header.keyword(first)?;
        if rest.starts_with(b"BINARY") {
            return Err("binary OFF is not supported; write the file as text".to_owned());
        }
        if rest.is_empty() {
            rest = next_line(lines).ok_or("the file ends before the number of vertices")?;
        }
        let counts: Vec<_> = Fields::of(rest).take(4).map(integer).collect();
        let (vertices, faces) = match counts[..] {
            [Some(vertices), Some(faces)] | [Some(vertices), Some(faces), Some(_)] => {
                (vertices, faces)
            }
            _ => {
                let found = quoted(rest);
                return Err(format!(
                    "expected the numbers of vertices, faces and edges, found {found}"
                ));
            }
        };
        let (Ok(vertex_count), Ok(face_count)) =
            (usize::try_from(vertices), usize::try_from(faces))
        else {
            return Err(format!("negative count in {}", quoted(rest)));
        };
        // The shortest vertex is "0 0 0" and a line feed, the shortest face "1 0".
        let least = vertex_count.saturating_mul(6).saturating_add(face_count.saturating_mul(4));
        let left = lines.bytes_left();
        if least > left + 1 || vertex_count >= u32::MAX as usize || face_count >= u32::MAX as usize
        {
            return Err(format!(
                "the header promises {vertex_count} vertices and {face_count} faces, \
                 more than the {left} bytes after it can hold"
            ));
        }
        Ok(Header { vertex_count, face_count, ..header })
    }

    /// Reads the keyword, which may be missing; returns what follows it on its line.
    fn keyword<'a>(&mut self, line: &'a [u8]) -> std::result::Result<&'a [u8], String> {
        let mut rest = line;
        loop {
            rest = match rest {
                [b'O', b'F', b'F', rest @ ..] => return Ok(rest.trim_ascii()),
                [b'S', b'T', rest @ ..] if !self.texture_coordinates => {
                    self.texture_coordinates = true;
                    rest
                }
                [b'C', rest @ ..] if !self.colors => {
                    self.colors = true;
                    rest
                }
                [b'N', rest @ ..] if !self.normals => {
                    self.normals = true;
                    rest
                }
                [b'4', b'O', ..] | [b'4', b'n', ..] | [b'n', ..] => {
                    let keyword = quoted(Fields::of(line).next().unwrap_or(line));
                    return Err(format!(
                        "{keyword}: vertices with more than three dimensions are not supported"
                    ));
                }
                [b'0'..=b'9', ..] if rest.len() == line.len() => return Ok(rest),
                _ => return Err(format!("expected the keyword OFF, found {}", quoted(line))),
            };
        }
    }
}

#[derive(Default)]
struct Vertices {
    positions: Vec<[f64; 3]>,
    /// Empty, or a colour for each vertex.
    colors: Vec<[f32; 4]>,
}

impl Vertices {
    /// A vertex is `x y z`, the normal, the colour of three or four parts, `s t`.
    fn push(&mut self, line: &[u8], header: &Header) -> std::result::Result<(), String> {
        const MOST: usize = 3 + 3 + 4 + 2;
        let mut values = [0.0; MOST];
        let mut count = 0;
        for field in Fields::of(line) {
            if count == MOST {
                return Err(format!("more than {MOST} numbers for one vertex"));
            }
            values[count] = number(field)?;
            count += 1;
        }
        let color_start = 3 + 3 * usize::from(header.normals);
        let others = color_start + 2 * usize::from(header.texture_coordinates);
        let color = match count.checked_sub(others) {
            Some(parts @ (3 | 4)) => Some(&values[color_start..color_start + parts]),
            Some(0) if !header.colors => None,
            _ => {
                let expected = match header.colors {
                    true => format!("{} or {}", others + 3, others + 4),
                    false => others.to_string(),
                };
                return Err(format!("expected {expected} numbers for a vertex, found {count}"));
            }
        };
        if let Some(color) = color {
            self.colors.resize(self.positions.len(), [colors::UNSET; 4]);
            let alpha = color.get(3).map_or(colors::UNSET, |&alpha| alpha as f32);
            self.colors.push([color[0] as f32, color[1] as f32, color[2] as f32, alpha]);
        } else if !self.colors.is_empty() {
            self.colors.push([colors::UNSET; 4]);
        }
        self.positions.push([values[0], values[1], values[2]]);
        Ok(())
    }
}

#[derive(Default)]
struct Faces {
    triangles: Vec<[u32; 3]>,
    /// Set once a face did not become exactly one triangle.
    source_faces: Option<Vec<u32>>,
    triangulator: Triangulator,
    corners: Vec<u32>,
    points: Vec<Vec3>,
}

impl Faces {
    /// A face is the number of its corners, their vertices, and perhaps a colour.
    fn push(
        &mut self,
        line: &[u8],
        face: u32,
        positions: &[[f64; 3]],
    ) -> std::result::Result<(), String> {
        let mut fields = Fields::of(line);
        let count = fields.next().unwrap_or_default();
        let corner_count = match integer(count) {
            Some(corner_count) if corner_count >= 1 => corner_count as usize,
            _ => return Err(format!("expected a number of corners, found {}", quoted(count))),
        };
        self.corners.clear();
        for field in fields.take(corner_count) {
            match integer(field) {
                Some(index) if (0..positions.len() as i64).contains(&index) => {
                    self.corners.push(index as u32);
                }
                Some(index) => {
                    let vertex_count = positions.len();
                    return Err(format!(
                        "vertex index {index}, but there are {vertex_count} vertices"
                    ));
                }
                None => return Err(format!("{} is not a vertex index", quoted(field))),
            }
        }
        if self.corners.len() < corner_count {
            let found = self.corners.len();
            return Err(format!("the face promises {corner_count} corners and has {found}"));
        }
        if let [a, b, c] = self.corners[..] {
            self.triangles.push([a, b, c]);
        } else {
            self.points.clear();
            self.points.extend(self.corners.iter().map(|&i| Vec3::from(positions[i as usize])));
            let (triangles, corners) = (&mut self.triangles, &self.corners);
            self.triangulator.triangulate(&self.points, |t| triangles.push(t.map(|i| corners[i])));
        }
        if self.source_faces.is_none() && self.triangles.len() != face as usize + 1 {
            self.source_faces = Some((0..face).collect());
        }
        if let Some(source_faces) = &mut self.source_faces {
            source_faces.resize(self.triangles.len(), face);
        }
        Ok(())
    }
}
