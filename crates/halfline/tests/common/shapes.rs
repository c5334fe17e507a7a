//! Meshes whose triangles can be counted beforehand.

use halfline::mesh::Positions;
use halfline::{Mesh, Vec3};

/// A mesh from triangles that share no vertex.
pub fn soup(triangles: impl IntoIterator<Item = [Vec3; 3]>) -> Mesh {
    let vertices: Vec<[f64; 3]> = triangles.into_iter().flatten().map(Vec3::to_array).collect();
    let faces: Vec<_> =
        (0..vertices.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    Mesh::new(Positions::F64(vertices.into()), faces).expect("a valid mesh")
}

/// The surface of the cube [-n, n]^3 in unit squares, each cut in two.
pub fn grid_cube(n: i32) -> Mesh {
    let mut triangles = Vec::new();
    for axis in 0..3 {
        for (side, flip) in [(-n, true), (n, false)] {
            for (i, j) in (-n..n).flat_map(|i| (-n..n).map(move |j| (i, j))) {
                let corner = |di: i32, dj: i32| {
                    let mut p = Vec3::ZERO;
                    p[axis] = f64::from(side);
                    p[(axis + 1) % 3] = f64::from(i + di);
                    p[(axis + 2) % 3] = f64::from(j + dj);
                    p
                };
                let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                triangles.extend(if flip {
                    [[a, c, b], [a, d, c]]
                } else {
                    [[a, b, c], [a, c, d]]
                });
            }
        }
    }
    soup(triangles)
}

/// A sphere from an octahedron subdivided `levels` times, with shared vertices.
pub fn sphere(levels: u32, center: Vec3, radius: f64) -> Mesh {
    let mut triangles = Vec::new();
    for signs in 0..8 {
        let sign = |bit: i32| if signs >> bit & 1 == 0 { 1.0 } else { -1.0 };
        let [x, y, z] = [
            Vec3::from([sign(0), 0.0, 0.0]),
            Vec3::from([0.0, sign(1), 0.0]),
            Vec3::from([0.0, 0.0, sign(2)]),
        ];
        let outward = sign(0) * sign(1) * sign(2) > 0.0;
        triangles.push(if outward { [x, y, z] } else { [x, z, y] });
    }
    for _ in 0..levels {
        triangles = triangles
            .into_iter()
            .flat_map(|[a, b, c]| {
                let middle = |p: Vec3, q: Vec3| (p + q).normalized();
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    soup(triangles.into_iter().map(|t| t.map(|p| p * radius + center)))
}
