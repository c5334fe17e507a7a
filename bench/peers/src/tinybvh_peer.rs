//! tinybvh, with its quickest trees for processors: nodes of four children and SSE, nodes of eight and
//! AVX2.

use std::ffi::c_void;

use halfline::{HitF32, RayF32};

use crate::embree::SingleMesh;

unsafe extern "C" {
    fn tinybvh_version(version: *mut u32);
    fn tinybvh_build(corners: *const f32, triangles: u32) -> *const c_void;
    fn tinybvh_intersect(
        trees: *const c_void,
        is_wide: bool,
        rays: *const RayF32,
        hits: *mut HitF32,
        count: usize,
    );
    fn tinybvh_occluded(
        trees: *const c_void,
        is_wide: bool,
        rays: *const RayF32,
        flags: *mut bool,
        count: usize,
    );
}

/// Both trees of a mesh; never released.
#[derive(Clone, Copy)]
pub struct TinyBvh(*const c_void);

// SAFETY: built trees are only read.
unsafe impl Sync for TinyBvh {}
// SAFETY: as above.
unsafe impl Send for TinyBvh {}

/// The version, as in 1.6.8.
pub fn version() -> String {
    let mut version = [0; 3];
    // SAFETY: it writes three numbers.
    unsafe { tinybvh_version(version.as_mut_ptr()) };
    version.map(|part| part.to_string()).join(".")
}

impl TinyBvh {
    /// Builds both trees with spatial splits, as well as tinybvh can; none without AVX2.
    pub fn new(mesh: &SingleMesh) -> Option<TinyBvh> {
        if !std::arch::is_x86_feature_detected!("avx2") {
            return None;
        }
        let corner = |&i: &u32| {
            let [x, y, z] = mesh.positions[i as usize];
            [x, y, z, 0.0]
        };
        let corners: Vec<[f32; 4]> = mesh.triangles.iter().flatten().map(corner).collect();
        let corners = corners.leak().as_ptr().cast();
        // SAFETY: there are three corners for each triangle, and they are never released.
        Some(TinyBvh(unsafe { tinybvh_build(corners, mesh.triangles.len() as u32) }))
    }

    /// The closest hit of each ray, whose smallest t is zero.
    pub fn intersect(self, is_wide: bool, rays: &[RayF32], hits: &mut [HitF32]) {
        assert_eq!(rays.len(), hits.len());
        let (from, to) = (rays.as_ptr(), hits.as_mut_ptr());
        // SAFETY: there is a place for each ray, and both are as the functions declare them.
        unsafe { tinybvh_intersect(self.0, is_wide, from, to, rays.len()) };
    }

    /// Whether each ray, whose smallest t is zero, hits anything.
    pub fn occluded(self, is_wide: bool, rays: &[RayF32], flags: &mut [bool]) {
        assert_eq!(rays.len(), flags.len());
        let (from, to) = (rays.as_ptr(), flags.as_mut_ptr());
        // SAFETY: as above.
        unsafe { tinybvh_occluded(self.0, is_wide, from, to, rays.len()) };
    }
}
