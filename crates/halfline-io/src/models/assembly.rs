//! Scenes put together from simple solids.

use libm::{cos, sin};

use halfline::error::{Error, Result};
use halfline::geometry::{Vec3, vec3};
use halfline::mesh::{Material, Mesh, Positions};

use super::fill::{reserved, single};

/// A mesh in the making, with a material for each triangle.
pub struct Assembly {
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    triangle_materials: Vec<u32>,
    materials: Vec<Material>,
}

impl Assembly {
    /// Nothing yet, with room for the given numbers.
    pub fn new(vertices: usize, triangles: usize) -> Result<Assembly> {
        Ok(Assembly {
            positions: reserved(vertices)?,
            triangles: reserved(triangles)?,
            triangle_materials: reserved(triangles)?,
            materials: Vec::new(),
        })
    }

    /// Adds a material and returns its index.
    pub fn material(&mut self, material: Material) -> u32 {
        self.materials.push(material);
        self.materials.len() as u32 - 1
    }

    /// Number of triangles so far.
    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    /// Number of vertices so far.
    pub fn vertex_count(&self) -> usize {
        self.positions.len()
    }

    /// Adds a vertex and returns its index.
    ///
    /// More than 2^32 wrap here and are then refused by [`Mesh::new`].
    pub fn vertex(&mut self, p: Vec3) -> u32 {
        self.positions.push(single(p));
        (self.positions.len() - 1) as u32
    }

    /// Adds a triangle of vertices that were added before.
    pub fn triangle(&mut self, corners: [u32; 3], material: u32) {
        self.triangles.push(corners);
        self.triangle_materials.push(material);
    }

    /// Adds a flat four-sided polygon of its own four vertices, corners counter-clockwise as seen
    /// from its front.
    pub fn quad(&mut self, corners: [Vec3; 4], material: u32) {
        let [a, b, c, d] = corners.map(|p| self.vertex(p));
        self.triangle([a, b, c], material);
        self.triangle([a, c, d], material);
    }

    /// Adds a shape, each of its vertices moved by `place`.
    pub fn shape(&mut self, shape: &Shape, material: u32, place: impl Fn(Vec3) -> Vec3) {
        let first = self.positions.len() as u32;
        self.positions.extend(shape.positions.iter().map(|&p| single(place(p))));
        self.triangles.extend(shape.triangles.iter().map(|t| t.map(|v| first + v)));
        self.triangle_materials.extend(std::iter::repeat_n(material, shape.triangles.len()));
    }

    /// Adds vertices and triangles that point into them.
    pub fn raw(&mut self, positions: &[[f32; 3]], triangles: &[[u32; 3]], material: u32) {
        let first = self.positions.len() as u32;
        self.positions.extend_from_slice(positions);
        self.triangles.extend(triangles.iter().map(|t| t.map(|v| first + v)));
        self.triangle_materials.extend(std::iter::repeat_n(material, triangles.len()));
    }

    /// Adds a box with sides along the axes.
    pub fn block(&mut self, min: Vec3, max: Vec3, material: u32) {
        self.shape(&Shape::cube(), material, |p| min + p * (max - min));
    }

    /// Adds a shape that lies along the z axis from 0 to 1, laid from `base` to `apex` and
    /// widened by the radius that goes linearly from one to the other.
    pub fn along(
        &mut self,
        shape: &Shape,
        (base, base_radius): (Vec3, f64),
        (apex, apex_radius): (Vec3, f64),
        material: u32,
    ) {
        let axis = apex - base;
        let (u, v) = frame(axis.normalized());
        self.shape(shape, material, |p| {
            let radius = base_radius + p.z * (apex_radius - base_radius);
            base + axis * p.z + (u * p.x + v * p.y) * radius
        });
    }

    /// The mesh.
    pub fn finish(self) -> Result<Mesh> {
        if self.positions.len() >= u32::MAX as usize {
            return Err(Error::invalid("number of triangles", "more than 2^32 - 2 vertices"));
        }
        let mut mesh = Mesh::new(Positions::F32(self.positions.into()), self.triangles)?;
        mesh.materials = self.materials;
        mesh.triangle_materials = Some(self.triangle_materials.into());
        Ok(mesh)
    }
}

/// Two unit vectors that form a right-handed frame with the unit vector `n` (Duff et al.,
/// "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017).
pub fn frame(n: Vec3) -> (Vec3, Vec3) {
    let sign = 1f64.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    (vec3(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), vec3(b, sign + n.y * n.y * a, -n.y))
}

/// A closed surface that is added many times.
pub struct Shape {
    /// Vertices.
    pub positions: Vec<Vec3>,
    /// Triangles, counter-clockwise as seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// (cos, sin) of `segments` angles, evenly spread over the full turn.
pub fn circle(segments: usize) -> Vec<(f64, f64)> {
    (0..segments)
        .map(|i| {
            let angle = std::f64::consts::TAU * i as f64 / segments as f64;
            (cos(angle), sin(angle))
        })
        .collect()
}

impl Shape {
    /// The unit cube.
    pub fn cube() -> Shape {
        let positions = (0..8)
            .map(|i| vec3(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)))
            .collect();
        let sides =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [3, 2, 6, 7], [2, 0, 4, 6], [1, 3, 7, 5]];
        let triangles = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        Shape { positions, triangles }
    }

    /// A surface of revolution about the z axis with `segments` sides. The profile of (radius, z)
    /// runs upwards on the outside, with its two ends on the axis: their radius must be 0, that
    /// of the other points more than 0.
    pub fn lathe(profile: &[(f64, f64)], segments: usize) -> Shape {
        let n = segments as u32;
        let circle = circle(segments);
        let inner = &profile[1..profile.len() - 1];
        let mut positions = vec![vec3(0.0, 0.0, profile[0].1)];
        for &(radius, z) in inner {
            positions.extend(circle.iter().map(|&(c, s)| vec3(radius * c, radius * s, z)));
        }
        positions.push(vec3(0.0, 0.0, profile[profile.len() - 1].1));
        let top = positions.len() as u32 - 1;
        let mut triangles = Vec::with_capacity(2 * segments * inner.len());
        for i in 0..n {
            triangles.push([0, 1 + (i + 1) % n, 1 + i]);
        }
        for row in 0..inner.len() as u32 - 1 {
            let (lower, upper) = (1 + row * n, 1 + (row + 1) * n);
            for i in 0..n {
                let j = (i + 1) % n;
                triangles.push([lower + i, lower + j, upper + j]);
                triangles.push([lower + i, upper + j, upper + i]);
            }
        }
        let last = top - n;
        for i in 0..n {
            triangles.push([top, last + i, last + (i + 1) % n]);
        }
        Shape { positions, triangles }
    }

    /// A sphere of radius 1 with `segments` meridians and `stacks` bands between its poles.
    pub fn sphere(segments: usize, stacks: usize) -> Shape {
        let profile: Vec<(f64, f64)> = (0..=stacks)
            .map(|i| {
                let angle = std::f64::consts::PI * i as f64 / stacks as f64;
                let radius = if i == 0 || i == stacks { 0.0 } else { sin(angle) };
                (radius, -cos(angle))
            })
            .collect();
        Shape::lathe(&profile, segments)
    }

    /// Number of triangles of [`Shape::sphere`].
    pub const fn sphere_triangles(segments: usize, stacks: usize) -> usize {
        2 * segments * (stacks - 1)
    }

    /// A cylinder of radius 1 about the z axis from 0 to 1, with its two ends.
    pub fn cylinder(segments: usize) -> Shape {
        let n = segments as u32;
        let circle = circle(segments);
        let mut positions: Vec<Vec3> = circle.iter().map(|&(c, s)| vec3(c, s, 0.0)).collect();
        positions.extend(circle.iter().map(|&(c, s)| vec3(c, s, 1.0)));
        let mut triangles = Vec::with_capacity(Shape::cylinder_triangles(segments));
        for i in 0..n {
            let j = (i + 1) % n;
            triangles.push([i, j, n + j]);
            triangles.push([i, n + j, n + i]);
        }
        for i in 1..n - 1 {
            triangles.push([0, i + 1, i]);
            triangles.push([n, n + i, n + i + 1]);
        }
        Shape { positions, triangles }
    }

    /// Number of triangles of [`Shape::cylinder`].
    pub const fn cylinder_triangles(segments: usize) -> usize {
        4 * segments - 4
    }
}

/// The material nearest to a surface of the Standard Procedural Databases, whose light is
/// `diffuse` scattered, `specular` mirrored and `transmitted` refracted.
pub fn haines_material(
    color: [f32; 3],
    diffuse: f32,
    specular: f32,
    transmitted: f32,
    ior: f32,
) -> Material {
    let [r, g, b] = color;
    let clear = transmitted > 0.0;
    Material {
        base_color: [r, g, b, 1.0],
        metallic: if clear { 0.0 } else { specular / (diffuse + specular) },
        roughness: if clear || specular > 0.0 { 0.0 } else { 1.0 },
        transmission: transmitted,
        ior,
    }
}

/// Of the pairs of `segments` and `stacks` that give well-shaped spheres, the one for which
/// `count(segments, stacks)` is nearest to `wanted`. The count must grow with both.
pub fn nearest_tessellation(
    wanted: usize,
    smallest: usize,
    count: impl Fn(usize, usize) -> usize,
) -> (usize, usize) {
    let mut best = (smallest, smallest.div_ceil(2));
    for segments in smallest.. {
        let lowest = segments.div_ceil(2);
        for stacks in lowest..=lowest + 2 {
            if count(segments, stacks).abs_diff(wanted) < count(best.0, best.1).abs_diff(wanted) {
                best = (segments, stacks);
            }
        }
        if count(segments, lowest) > wanted {
            break;
        }
    }
    best
}
