//! A file's polygons and strips as the triangles of a mesh.

use crate::triangulate::triangulate;
use halfline::mesh::Positions;

/// Triangles cut from consecutive faces, and which face each was cut from.
#[derive(Debug, Default)]
pub struct FaceChunk {
    first_face: usize,
    faces: usize,
    triangles: Vec<[u32; 3]>,
    /// Empty as long as each face was one triangle.
    sources: Vec<u32>,
    all_triangles: bool,
    corners: Vec<halfline::geometry::Vec3>,
}

/// The triangles of a file, and for each the face it was cut from unless triangle i is face i.
#[derive(Debug, Default, PartialEq)]
pub struct Triangles {
    /// The triangles, in the order of the file.
    pub triangles: Vec<[u32; 3]>,
    /// For each triangle the face of the file, as
    /// [`Mesh::source_faces`](halfline::Mesh::source_faces) has it.
    pub source_faces: Option<Vec<u32>>,
}

impl FaceChunk {
    /// No face yet; the first will be the file's face `first_face`.
    pub fn new(first_face: usize) -> FaceChunk {
        FaceChunk { first_face, all_triangles: true, ..FaceChunk::default() }
    }

    /// Adds the next face. One with fewer than three corners gives no triangle.
    #[inline]
    pub fn push(&mut self, polygon: &[u32], positions: &Positions) {
        match *polygon {
            [a, b, c] if self.all_triangles => self.triangles.push([a, b, c]),
            _ => self.push_other(polygon, positions),
        }
        self.faces += 1;
    }

    fn push_other(&mut self, polygon: &[u32], positions: &Positions) {
        if self.all_triangles {
            self.all_triangles = false;
            self.sources = self.numbers().collect();
        }
        match *polygon {
            [] | [_] | [_, _] => {}
            [a, b, c] => self.triangles.push([a, b, c]),
            _ => {
                self.corners.clear();
                self.corners.extend(polygon.iter().map(|&v| positions.get(v as usize)));
                let triangles = &mut self.triangles;
                triangulate(&self.corners, |t| triangles.push(t.map(|corner| polygon[corner])));
            }
        }
        self.sources.resize(self.triangles.len(), (self.first_face + self.faces) as u32);
    }

    /// The numbers of the faces so far.
    fn numbers(&self) -> impl Iterator<Item = u32> + use<> {
        // Schema::of refuses files whose faces cannot be numbered in 32 bits.
        self.first_face as u32..(self.first_face + self.faces) as u32
    }
}

impl Triangles {
    /// Puts chunks of consecutive faces together.
    pub fn join(chunks: Vec<FaceChunk>) -> Triangles {
        let count = chunks.iter().map(|chunk| chunk.triangles.len()).sum();
        let mut triangles = Vec::with_capacity(count);
        let mut source_faces =
            chunks.iter().any(|chunk| !chunk.all_triangles).then(|| Vec::with_capacity(count));
        for chunk in chunks {
            if let Some(sources) = &mut source_faces {
                if chunk.all_triangles {
                    sources.extend(chunk.numbers());
                } else {
                    sources.extend_from_slice(&chunk.sources);
                }
            }
            triangles.extend_from_slice(&chunk.triangles);
        }
        Triangles { triangles, source_faces }
    }

    /// Adds the triangles of strips after those of `faces` faces; each counts as a face.
    pub fn append_strips(&mut self, strips: Strips, faces: usize) {
        if let Some(sources) = &mut self.source_faces {
            // Numbers past 32 bits belong to a mesh that Mesh::new refuses.
            sources.extend((0..strips.triangles.len()).map(|i| (faces + i) as u32));
        }
        if self.triangles.is_empty() {
            self.triangles = strips.triangles;
        } else {
            self.triangles.extend_from_slice(&strips.triangles);
        }
    }
}

/// Triangle strips taken in index by index: each index after the second makes a triangle with the
/// two before it, turned over every second time so that all have the orientation of the first.
#[derive(Debug, Default)]
pub struct Strips {
    triangles: Vec<[u32; 3]>,
    previous: [u32; 2],
    length: usize,
}

impl Strips {
    /// Goes on with the strip.
    #[inline]
    pub fn push(&mut self, index: u32) {
        let [a, b] = self.previous;
        if self.length >= 2 {
            self.triangles.push(if self.length.is_multiple_of(2) {
                [a, b, index]
            } else {
                [b, a, index]
            });
        }
        self.previous = [b, index];
        self.length += 1;
    }

    /// Begins a new strip.
    pub fn restart(&mut self) {
        self.length = 0;
    }
}

/// `index` as the index of one of `vertices` vertices, or why it is none.
#[inline]
pub fn vertex_index(index: i64, vertices: usize) -> Result<u32, String> {
    match usize::try_from(index) {
        Ok(valid) if valid < vertices => Ok(valid as u32),
        _ => Err(index_error(index, vertices)),
    }
}

#[cold]
fn index_error(index: i64, vertices: usize) -> String {
    if index < 0 {
        format!("vertex index {index} is negative")
    } else {
        format!("vertex index {index} is not below the number of vertices, {vertices}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> Positions {
        Positions::F32(vec![[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]].into())
    }

    #[test]
    fn triangles_alone_need_no_sources() {
        let mut chunks = vec![FaceChunk::new(0), FaceChunk::new(1)];
        chunks[0].push(&[0, 1, 2], &square());
        chunks[1].push(&[2, 3, 0], &square());
        let joined = Triangles::join(chunks);
        assert_eq!(joined.triangles, [[0, 1, 2], [2, 3, 0]]);
        assert_eq!(joined.source_faces, None);
    }

    #[test]
    fn face_numbers_stay_the_files() {
        let mut chunks = vec![FaceChunk::new(0), FaceChunk::new(2)];
        chunks[0].push(&[0, 1, 2], &square());
        chunks[0].push(&[1, 2, 3], &square());
        chunks[1].push(&[0, 1], &square());
        chunks[1].push(&[0, 1, 2, 3], &square());
        chunks[1].push(&[], &square());
        chunks[1].push(&[3, 2, 1], &square());
        let mut joined = Triangles::join(chunks);
        assert_eq!(joined.source_faces, Some(vec![0, 1, 3, 3, 5]));
        let mut strips = Strips::default();
        [0, 1, 2].into_iter().for_each(|i| strips.push(i));
        joined.append_strips(strips, 6);
        assert_eq!(joined.source_faces, Some(vec![0, 1, 3, 3, 5, 6]));
    }

    #[test]
    fn strips_alternate_and_restart_with_the_first_orientation() {
        let mut strips = Strips::default();
        [0, 1, 2, 3].into_iter().for_each(|i| strips.push(i));
        strips.restart();
        [4, 5].into_iter().for_each(|i| strips.push(i));
        strips.restart();
        [1, 2, 3].into_iter().for_each(|i| strips.push(i));
        assert_eq!(strips.triangles, [[0, 1, 2], [2, 1, 3], [1, 2, 3]]);
    }
}
