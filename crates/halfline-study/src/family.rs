//! Meshes that differ in nothing but how many triangles they have.

use std::sync::Arc;

use halfline::Mesh;
use halfline::error::Result;
use halfline::progress::Observer;
use halfline_io::models::{self, Kind};

use super::resolution::{sampled, subdivided};

/// A family of meshes.
#[derive(Clone, Debug)]
pub enum Family {
    /// Generated ones of a kind, with seed 0.
    Generated(Kind),
    /// A mesh of the user's, coarser and finer.
    Own {
        /// What it is called.
        name: String,
        /// The mesh itself.
        mesh: Arc<Mesh>,
    },
}

impl Family {
    /// The kinds that are studied if nobody chooses: one surface at many resolutions, random
    /// triangles, and two that are hard.
    pub const USUAL: [Kind; 4] = [Kind::Scan, Kind::Soup, Kind::Layers, Kind::Sticks];

    /// The name of the family.
    pub fn name(&self) -> &str {
        match self {
            Family::Generated(kind) => kind.name(),
            Family::Own { name, .. } => name,
        }
    }

    /// What the family is, in some words.
    pub fn description(&self) -> String {
        match self {
            Family::Generated(Kind::Scan) => "one closed surface at many resolutions".into(),
            Family::Generated(Kind::Soup) => {
                "random triangles in a cube, edges about n^(-1/3) long".into()
            }
            Family::Generated(Kind::Layers) => {
                "tilted sheets, stacked ever closer than their triangles are wide".into()
            }
            Family::Generated(Kind::Sticks) => "long thin sticks in all directions".into(),
            Family::Generated(kind) => kind.description().into(),
            Family::Own { mesh, .. } => format!(
                "the mesh of {} triangles; fewer: a random sample of them, more: each cut into four",
                mesh.triangle_count()
            ),
        }
    }

    /// True for the random triangles of which theory says that a ray costs the same however many there
    /// are.
    pub fn is_uniform_soup(&self) -> bool {
        matches!(self, Family::Generated(Kind::Soup))
    }

    /// The sizes at which to study it, in rising order, where `wanted` are the sizes of any family: all
    /// of them if it is generated; else those below the mesh's own, that itself, and beyond it four times
    /// as many again and again, up to the largest that is wanted.
    pub fn sizes(&self, wanted: &[usize]) -> Vec<usize> {
        let mut sizes = wanted.to_vec();
        if let Family::Own { mesh, .. } = self {
            let own = mesh.triangle_count();
            let largest = wanted.iter().copied().max().unwrap_or(own);
            sizes.retain(|&size| size < own);
            let finer = std::iter::successors(Some(own), |&size| size.checked_mul(4));
            sizes.extend(finer.take_while(|&size| size == own || size <= largest));
        }
        sizes.sort_unstable();
        sizes.dedup();
        sizes
    }

    /// The family's mesh of so many triangles, or all of a user's mesh that has fewer.
    ///
    /// # Errors
    /// Those of [`Family::mesh`].
    pub fn mesh_of_at_most(&self, triangles: usize, observer: &dyn Observer) -> Result<Arc<Mesh>> {
        match self {
            Family::Own { mesh, .. } if mesh.triangle_count() <= triangles => Ok(Arc::clone(mesh)),
            _ => self.mesh(triangles, observer),
        }
    }

    /// The family's mesh of about `triangles` triangles.
    ///
    /// # Errors
    /// Those of [`models::generate`].
    pub fn mesh(&self, triangles: usize, observer: &dyn Observer) -> Result<Arc<Mesh>> {
        let (mesh, own) = match self {
            Family::Generated(kind) => {
                return Ok(Arc::new(models::generate(*kind, triangles, 0, observer)?));
            }
            Family::Own { mesh, .. } => (mesh, mesh.triangle_count()),
        };
        if triangles < own {
            return Ok(Arc::new(sampled(mesh, triangles, observer)?));
        }
        let mut finer = Arc::clone(mesh);
        while finer.triangle_count() < triangles {
            finer = Arc::new(subdivided(&finer, observer)?);
        }
        Ok(finer)
    }
}
