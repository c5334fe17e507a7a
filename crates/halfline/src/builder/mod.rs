//! From a mesh to the tree that rays walk.
//!
//! M. Stich, H. Friedrich, A. Dietrich, "Spatial Splits in Bounding Volume Hierarchies", HPG 2009: a node is
//! divided by a plane, with triangles clipped to both sides, or into two groups of whole triangles, whichever
//! has the lower expected cost. The planes are those of a kd-tree:
//!
//! I. Wald, V. Havran, "On Building Fast kd-Trees for Ray Tracing, and on Doing That in O(N log N)",
//! IEEE Symposium on Interactive Ray Tracing 2006: planes by the surface-area heuristic, triangles
//! clipped to the cells that they reach into. Candidates come from bins and not from a sweep over
//! all ends (M. Shevtsov et al., "Highly Parallel Fast KD-tree Construction", EG 2007).
//!
//! Different here:
//! 1. Cells shrink to the tight box of what they hold, so no plane is spent on empty space.
//! 2. A leaf costs blocks of eight triangles, as the machine does, not triangles.
//! 3. While candidates are compared, boxes are merely chopped at the bins; a triangle is clipped
//!    only when a split that it straddles is carried out.
//! 4. Cells of few triangles are not cut any further: the triangles are divided by object splits alone.
//! 5. All references live in one array from the start, with slots to spare that are shared out
//!    among the cells (after P. Ganestam, M. Doggett, "SAH guided spatial split partitioning", CGF
//!    2016, and Embree's builders). A cell that has used up its slots is divided by object splits alone. So memory is
//!    bounded whatever the input, and nothing is allocated for a node.
//! 6. What is walked is the tree collapsed to nodes of eight children.
//! 7. Loops over references are compiled for the machine's instruction set, and have no branch that
//!    depends on where a single reference lies.

mod built;
mod clip;
mod coarse_grid;
mod collapse;
mod node;
mod object_split;
mod partition;
mod primitive_ref;
mod simd_bounds;
mod spatial_split;
mod subdivide;

pub use crate::tree::{BuildParameters, Preset};
pub(crate) use subdivide::{build, build_without_area};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vec3;
    use crate::geometry::random::Random;
    use crate::mesh::{Mesh, Positions};
    use crate::progress::NoProgress;
    use crate::simd::Level;

    /// Triangles in random places of a cube, most of them small and some as large as the cube, so that
    /// planes cut many of them.
    fn soup(triangles: usize) -> Mesh {
        let mut random = Random::new(1, 0);
        let mut point = |center: Vec3, size: f64| center + random.direction() * size;
        let mut positions = Vec::with_capacity(3 * triangles);
        for i in 0..triangles {
            let center = point(Vec3::ZERO, (i % 97) as f64 / 97.0);
            let size = 0.5_f64.powi((i % 11) as i32);
            positions.extend([(); 3].map(|()| point(center, size).to_array().map(|x| x as f32)));
        }
        let corner = |i: usize| 3 * i as u32;
        let faces: Vec<_> = (0..triangles).map(corner).map(|c| [c, c + 1, c + 2]).collect();
        Mesh::new(Positions::F32(positions.into()), faces).expect("a valid mesh")
    }

    /// Minima, counts and costs are computed by the same operations in each.
    #[test]
    fn every_instruction_set_builds_the_same_tree() {
        let mesh = soup(20_000);
        for preset in Preset::ALL {
            let parameters = BuildParameters::preset(preset);
            let trees: Vec<_> = Level::available()
                .into_iter()
                .map(|level| build(&mesh, &parameters, level, &NoProgress).expect("builds"))
                .collect();
            let bytes = |i: usize| bytemuck::cast_slice::<_, u8>(&trees[i].nodes);
            for i in 1..trees.len() {
                assert!(bytes(i) == bytes(0), "{preset:?}, {}", Level::available()[i].name());
            }
        }
    }
}
