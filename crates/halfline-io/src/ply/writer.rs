//! Meshes as binary little-endian PLY.

use std::io::Write;
use std::path::Path;

use halfline::error::{Error, Result};
use halfline::mesh::{Mesh, Positions};
use halfline::progress::SharedProgress;
use halfline::progress::{Observer, Stage};
use halfline::storage::AtomicFile;

/// Records encoded between two writes.
const CHUNK_RECORDS: usize = 1 << 15;

/// Writes the vertices, their colours if there are any, and the triangles of `mesh` to `path` as
/// binary little-endian PLY. Coordinates keep their precision. The file appears whole or not at
/// all.
///
/// # Errors
/// [`Error::Io`] if the file cannot be written, [`Error::Interrupted`] if `observer` says so.
pub fn save(mesh: &Mesh, path: &Path, observer: &dyn Observer) -> Result<()> {
    let columns = Columns { colors: mesh.vertex_colors.as_deref(), distances: None };
    save_columns(mesh, columns, path, observer)
}

/// Writes `mesh` as [`save`] does, with a distance and a colour for each vertex instead of its own
/// colours. The distance is there twice: as `quality`, in single precision, where MeshLab looks for it,
/// and as `scalar_distance`, where CloudCompare does.
///
/// # Errors
/// Those of [`save`], and [`Error::Invalid`] unless there is one of each for each vertex.
pub fn save_distances(
    mesh: &Mesh,
    distances: &[f64],
    colors: &[[u8; 4]],
    path: &Path,
    observer: &dyn Observer,
) -> Result<()> {
    let vertices = mesh.positions().len();
    for (what, found) in [("distances", distances.len()), ("colors", colors.len())] {
        if found != vertices {
            let reason = format!("expected one for each of {vertices} vertices, found {found}");
            return Err(Error::invalid(what, reason));
        }
    }
    let columns = Columns { colors: Some(colors), distances: Some(distances) };
    save_columns(mesh, columns, path, observer)
}

/// What vertices have besides a position.
#[derive(Clone, Copy)]
struct Columns<'a> {
    colors: Option<&'a [[u8; 4]]>,
    distances: Option<&'a [f64]>,
}

fn save_columns(mesh: &Mesh, columns: Columns, path: &Path, observer: &dyn Observer) -> Result<()> {
    let header = header(mesh, columns);
    let (coordinate_bytes, vertices) = match mesh.positions() {
        Positions::F32(p) => (12, p.len()),
        Positions::F64(p) => (24, p.len()),
    };
    let vertex_bytes =
        coordinate_bytes + columns.colors.map_or(0, |_| 4) + columns.distances.map_or(0, |_| 4 + 8);
    let total = header.len() + vertices * vertex_bytes + mesh.triangle_count() * 13;
    let mut writer = Writer {
        file: AtomicFile::create(path)?,
        buffer: Vec::new(),
        path,
        progress: SharedProgress::new(observer, Stage::Write, total),
    };
    writer.buffer.extend_from_slice(header.as_bytes());
    match mesh.positions() {
        Positions::F32(p) => {
            writer.vertices(p, columns, |position, buffer| {
                position.iter().for_each(|c| buffer.extend_from_slice(&c.to_le_bytes()));
            })?;
        }
        Positions::F64(p) => {
            writer.vertices(p, columns, |position, buffer| {
                position.iter().for_each(|c| buffer.extend_from_slice(&c.to_le_bytes()));
            })?;
        }
    }
    for chunk in mesh.triangles().chunks(CHUNK_RECORDS) {
        for &[a, b, c] in chunk {
            let mut record = [3; 13];
            record[1..5].copy_from_slice(&a.to_le_bytes());
            record[5..9].copy_from_slice(&b.to_le_bytes());
            record[9..].copy_from_slice(&c.to_le_bytes());
            writer.buffer.extend_from_slice(&record);
        }
        writer.write()?;
    }
    writer.write()?;
    writer.file.commit()
}

fn header(mesh: &Mesh, columns: Columns) -> String {
    let (coordinate, vertices) = match mesh.positions() {
        Positions::F32(p) => ("float", p.len()),
        Positions::F64(p) => ("double", p.len()),
    };
    let colors = match columns.colors {
        Some(_) => {
            "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n"
        }
        None => "",
    };
    let distances = match columns.distances {
        Some(_) => "property float quality\nproperty double scalar_distance\n",
        None => "",
    };
    // Many readers know only signed indices, so those are written as long as they serve.
    let index = if vertices <= 1 << 31 { "int" } else { "uint" };
    let faces = mesh.triangle_count();
    format!(
        "ply\nformat binary_little_endian 1.0\ncomment written by halfline\n\
         element vertex {vertices}\n\
         property {coordinate} x\nproperty {coordinate} y\nproperty {coordinate} z\n\
         {colors}{distances}\
         element face {faces}\nproperty list uchar {index} vertex_indices\nend_header\n"
    )
}

struct Writer<'a> {
    file: AtomicFile,
    buffer: Vec<u8>,
    path: &'a Path,
    progress: SharedProgress<'a>,
}

impl Writer<'_> {
    fn vertices<P>(
        &mut self,
        positions: &[P],
        columns: Columns,
        encode: impl Fn(&P, &mut Vec<u8>),
    ) -> Result<()> {
        for (chunk, positions) in positions.chunks(CHUNK_RECORDS).enumerate() {
            for (i, position) in positions.iter().enumerate() {
                encode(position, &mut self.buffer);
                let vertex = chunk * CHUNK_RECORDS + i;
                if let Some(colors) = columns.colors {
                    // A colour that is missing is opaque white, as for a mesh without colours.
                    let color = colors.get(vertex).unwrap_or(&[255; 4]);
                    self.buffer.extend_from_slice(color);
                }
                if let Some(distances) = columns.distances {
                    let distance = distances[vertex];
                    self.buffer.extend_from_slice(&(distance as f32).to_le_bytes());
                    self.buffer.extend_from_slice(&distance.to_le_bytes());
                }
            }
            self.write()?;
        }
        Ok(())
    }

    fn write(&mut self) -> Result<()> {
        self.file.write_all(&self.buffer).map_err(|e| Error::io(self.path, e))?;
        self.progress.advance(self.buffer.len())?;
        self.buffer.clear();
        Ok(())
    }
}
