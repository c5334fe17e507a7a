//! The same surface with fewer triangles, or with more.

use halfline::Mesh;
use halfline::error::Result;
use halfline::geometry::random::Random;
use halfline::mesh::Positions;
use halfline::progress::Observer;

/// A constant seed, so that the same faces are drawn every time.
const SEED: u64 = 2;

/// Faces that are looked at between two looks at the observer.
const CHUNK: usize = 1 << 16;

/// `count` faces of `mesh`, drawn at random, in their order and with the vertices that they use. The
/// surface gets holes and keeps its extent; what a decimation that closes them again would give is
/// another surface.
///
/// D. E. Knuth, "The Art of Computer Programming" 2, section 3.4.2, algorithm S.
///
/// # Errors
/// [`Error::Interrupted`](halfline::Error::Interrupted).
pub fn sampled(mesh: &Mesh, count: usize, observer: &dyn Observer) -> Result<Mesh> {
    let faces = mesh.triangles();
    let mut random = Random::new(SEED, 0);
    let mut place = vec![u32::MAX; mesh.positions().len()];
    let (mut vertices, mut triangles) = (Vec::new(), Vec::with_capacity(count));
    for (i, face) in faces.iter().enumerate() {
        if i % CHUNK == 0 {
            observer.check()?;
        }
        let (wanted, left) = (count.saturating_sub(triangles.len()), faces.len() - i);
        if random.unit() * left as f64 >= wanted as f64 {
            continue;
        }
        triangles.push(face.map(|vertex| {
            let place = &mut place[vertex as usize];
            if *place == u32::MAX {
                *place = vertices.len() as u32;
                vertices.push(vertex as usize);
            }
            *place
        }));
    }
    let positions = match mesh.positions() {
        Positions::F32(p) => Positions::F32(vertices.iter().map(|&v| p[v]).collect()),
        Positions::F64(p) => Positions::F64(vertices.iter().map(|&v| p[v]).collect()),
    };
    Mesh::new(positions, triangles)
}

/// Each face cut into four at the middles of its edges: the same surface, up to rounding. Faces that
/// share an edge compute its middle to the same bits, so a closed surface stays closed; but each has
/// vertices of its own there.
///
/// # Errors
/// [`Error::Interrupted`](halfline::Error::Interrupted), and
/// [`Error::Invalid`](halfline::Error::Invalid) beyond what a mesh can hold.
pub fn subdivided(mesh: &Mesh, observer: &dyn Observer) -> Result<Mesh> {
    let faces = mesh.triangles();
    let first_new = mesh.positions().len();
    let mut triangles = Vec::with_capacity(4 * faces.len());
    for (i, &[a, b, c]) in faces.iter().enumerate() {
        if i % CHUNK == 0 {
            observer.check()?;
        }
        let [ab, bc, ca] = [0, 1, 2].map(|edge| (first_new + 3 * i + edge) as u32);
        triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    let positions = match mesh.positions() {
        Positions::F32(p) => {
            let middle = |x: f32, y: f32| ((f64::from(x) + f64::from(y)) / 2.0) as f32;
            Positions::F32(with_middles(p, faces, middle).into())
        }
        Positions::F64(p) => {
            Positions::F64(with_middles(p, faces, |x, y| x / 2.0 + y / 2.0).into())
        }
    };
    Mesh::new(positions, triangles)
}

/// The vertices, and after them the middles of each face's edges.
fn with_middles<T: Copy>(
    vertices: &[[T; 3]],
    faces: &[[u32; 3]],
    middle: impl Fn(T, T) -> T,
) -> Vec<[T; 3]> {
    let mut all = Vec::with_capacity(vertices.len() + 3 * faces.len());
    all.extend_from_slice(vertices);
    for &[a, b, c] in faces {
        for (start, end) in [(a, b), (b, c), (c, a)] {
            let (start, end) = (vertices[start as usize], vertices[end as usize]);
            all.push([0, 1, 2].map(|axis| middle(start[axis], end[axis])));
        }
    }
    all
}
