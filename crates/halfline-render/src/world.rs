//! Everything that a ray can meet, and what it finds there.

use halfline::Scene;
use halfline::geometry::{Hit, NO_FACE, Ray, Vec3};
use halfline::mesh::{Material, linear_from_srgb};
use halfline::numeric::SurfacePoint;

use crate::color::Color;
use crate::field::VertexField;
use crate::ground::GroundPlane;
use crate::intersector::Intersector;
use crate::smooth_normals::SmoothNormals;

/// The model and the ground.
pub(crate) struct World<'a> {
    pub(crate) scene: &'a Scene,
    /// Who answers rays at it.
    pub(crate) intersector: &'a dyn Intersector,
    pub(crate) ground: Option<GroundPlane>,
    /// The model's up axis.
    pub(crate) up: Vec3,
    /// The material of all faces, instead of what the mesh says.
    pub(crate) material: Option<Material>,
    /// The material of faces to which the mesh gives none.
    pub(crate) default_material: Material,
    /// The materials of the mesh, every value brought into its range.
    pub(crate) materials: &'a [Material],
    /// True if light may pass through anything.
    pub(crate) has_clear_material: bool,
    pub(crate) smooth: Option<&'a SmoothNormals>,
    /// Numbers whose colours take the place of all materials.
    pub(crate) field: Option<&'a VertexField>,
    /// The linear value of each code of a vertex colour.
    pub(crate) srgb: [f64; 256],
}

/// A point on a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surface {
    /// The ray's parameter there.
    pub(crate) t: f64,
    /// The point, with the normal of the flat face by its orientation.
    pub(crate) at: SurfacePoint,
    /// The unit normal to shade with, on the same side as that of the face.
    pub(crate) normal: Vec3,
    /// Index of the triangle; [`NO_FACE`] for the ground.
    pub(crate) face: u32,
    /// Barycentric weights of the second and third corner.
    pub(crate) uv: [f64; 2],
}

impl Surface {
    /// True if this is the ground and not the model.
    pub(crate) fn is_ground(&self) -> bool {
        self.face == NO_FACE
    }

    /// The shading normal, turned towards where a ray along `direction` comes from.
    pub(crate) fn normal_against(&self, direction: Vec3) -> Vec3 {
        // The flat normal decides: near the outline the shading normal may already look away.
        if self.at.normal.dot(direction) > 0.0 { -self.normal } else { self.normal }
    }
}

impl World<'_> {
    /// How much of a surface is left: the ground fades with distance.
    pub(crate) fn opacity(&self, surface: &Surface) -> f64 {
        match &self.ground {
            Some(ground) if surface.is_ground() => ground.opacity(surface.at.point),
            _ => 1.0,
        }
    }

    /// The first surface on `ray`, which hits the model at `hit`.
    pub(crate) fn surface(&self, ray: &Ray, hit: Hit) -> Option<Surface> {
        if let Some(ground) = &self.ground
            && let Some(t) = ground.intersect(ray)
            && t < hit.t
        {
            let at = ground.point(ray, t);
            return Some(Surface { t, at, normal: at.normal, face: NO_FACE, uv: [0.0; 2] });
        }
        if !hit.is_hit() {
            return None;
        }
        let mesh = self.scene.mesh();
        let at = self.scene.surface_point(&hit);
        let normal = match &self.smooth {
            Some(smooth) => smooth.at(mesh, hit.face, at.normal, hit.u, hit.v),
            None => at.normal,
        };
        Some(Surface { t: hit.t, at, normal, face: hit.face, uv: [hit.u, hit.v] })
    }

    /// The material of a point on the model, vertex colours included.
    pub(crate) fn material(&self, surface: &Surface) -> Material {
        if let Some(field) = self.field {
            let [r, g, b] = field.color(self.scene.mesh(), surface).map(linear_from_srgb);
            return Material { base_color: [r, g, b, 1.0], ..self.default_material };
        }
        if let Some(material) = self.material {
            return material;
        }
        let mesh = self.scene.mesh();
        let mut material = mesh
            .triangle_materials
            .as_ref()
            .and_then(|of_face| self.materials.get(*of_face.get(surface.face as usize)? as usize))
            .copied()
            .unwrap_or(self.default_material);
        if let Some(color) = self.vertex_color(surface) {
            for (channel, factor) in color.to_array().into_iter().enumerate() {
                material.base_color[channel] *= factor as f32;
            }
        }
        material
    }

    /// The colour between the colours of the corners, interpolated in linear light.
    fn vertex_color(&self, surface: &Surface) -> Option<Color> {
        let mesh = self.scene.mesh();
        let colors = mesh.vertex_colors.as_ref()?;
        let [u, v] = surface.uv;
        let weights = [1.0 - u - v, u, v];
        let mut sum = Vec3::ZERO;
        for (corner, &vertex) in mesh.triangles()[surface.face as usize].iter().enumerate() {
            let [r, g, b, _] = *colors.get(vertex as usize)?;
            let linear = [r, g, b].map(|code| self.srgb[usize::from(code)]);
            sum += Vec3::from(linear) * weights[corner];
        }
        Some(sum)
    }
}
