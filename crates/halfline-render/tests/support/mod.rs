//! Small meshes, built in code, for pictures that tests look at. No test uses all of it.
#![allow(dead_code)]

use halfline::mesh::{Material, Positions};
use halfline::{Mesh, Scene};

/// A triangle mesh in the making.
#[derive(Default)]
pub struct Builder {
    positions: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    materials: Vec<Material>,
    triangle_materials: Vec<u32>,
}

impl Builder {
    /// An icosahedron whose faces were cut in four `cuts` times, its vertices at `radius` from
    /// `center`, its faces outwards.
    pub fn icosphere(
        mut self,
        center: [f64; 3],
        radius: f64,
        cuts: u32,
        material: Material,
    ) -> Self {
        let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
        let mut triangles: Vec<[[f64; 3]; 3]> = Vec::new();
        let corners: Vec<[f64; 3]> = [-1.0, 1.0]
            .into_iter()
            .flat_map(|a| [-golden, golden].map(|b| (a, b)))
            .flat_map(|(a, b)| [[0.0, a, b], [a, b, 0.0], [b, 0.0, a]])
            .collect();
        // Its faces join the corners that are two apart, three by three.
        let near = |a: [f64; 3], b: [f64; 3]| distance(a, b) < 2.1;
        for i in 0..12 {
            for j in i + 1..12 {
                for k in j + 1..12 {
                    let [a, b, c] = [corners[i], corners[j], corners[k]];
                    if near(a, b) && near(b, c) && near(c, a) {
                        let outwards = dot(cross(minus(b, a), minus(c, a)), a) > 0.0;
                        triangles.push(if outwards { [a, b, c] } else { [a, c, b] });
                    }
                }
            }
        }
        assert_eq!(triangles.len(), 20);
        for _ in 0..cuts {
            triangles = triangles
                .into_iter()
                .flat_map(|[a, b, c]| {
                    let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
                    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
                })
                .collect();
        }
        for triangle in triangles {
            self.triangle(
                triangle.map(|p| {
                    let scale = radius / dot(p, p).sqrt();
                    std::array::from_fn(|axis| center[axis] + p[axis] * scale)
                }),
                material,
            );
        }
        self
    }

    /// The axis-aligned box between two corners, its faces outwards.
    pub fn cuboid(mut self, low: [f64; 3], high: [f64; 3], material: Material) -> Self {
        let corner = |bits: usize| -> [f64; 3] {
            std::array::from_fn(|axis| if bits >> axis & 1 == 1 { high[axis] } else { low[axis] })
        };
        let quads =
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        for quad in quads {
            let [a, b, c, d] = quad.map(corner);
            self.triangle([a, b, c], material);
            self.triangle([a, c, d], material);
        }
        self
    }

    fn triangle(&mut self, corners: [[f64; 3]; 3], material: Material) {
        let id = self.materials.iter().position(|m| *m == material).unwrap_or_else(|| {
            self.materials.push(material);
            self.materials.len() - 1
        });
        // Corners are shared, as in a file: smooth shading and watertightness need it.
        let indices = corners.map(|corner| {
            let found = self.positions.iter().position(|p| distance(*p, corner) < 1e-9);
            found.unwrap_or_else(|| {
                self.positions.push(corner);
                self.positions.len() - 1
            }) as u32
        });
        self.triangles.push(indices);
        self.triangle_materials.push(id as u32);
    }

    /// The mesh with its materials.
    pub fn mesh(self) -> Mesh {
        let mut mesh = Mesh::new(Positions::F64(self.positions.into()), self.triangles).unwrap();
        mesh.materials = self.materials;
        mesh.triangle_materials = Some(self.triangle_materials.into());
        mesh
    }

    /// The mesh without materials, ready for rays.
    pub fn plain_scene(self) -> Scene {
        let mut mesh = self.mesh();
        mesh.materials.clear();
        mesh.triangle_materials = None;
        Scene::new(mesh).unwrap()
    }

    /// The mesh with its materials, ready for rays.
    pub fn scene(self) -> Scene {
        Scene::new(self.mesh()).unwrap()
    }
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|axis| a[axis] - b[axis])
}

fn middle(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|axis| 0.5 * (a[axis] + b[axis]))
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    dot(minus(a, b), minus(a, b)).sqrt()
}

/// A mirror without a tint.
pub const MIRROR: Material =
    Material { base_color: [1.0; 4], metallic: 1.0, roughness: 0.0, transmission: 0.0, ior: 1.5 };

/// Window glass.
pub const GLASS: Material =
    Material { base_color: [1.0; 4], metallic: 0.0, roughness: 0.0, transmission: 1.0, ior: 1.5 };

/// A rough surface of the given linear colour.
pub const fn matte(red: f32, green: f32, blue: f32) -> Material {
    Material {
        base_color: [red, green, blue, 1.0],
        metallic: 0.0,
        roughness: 1.0,
        transmission: 0.0,
        ior: 1.5,
    }
}
