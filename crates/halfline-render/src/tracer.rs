//! What one thread needs to ask the world about rays: batch by batch, as the engine likes it.

use halfline::error::Result;
use halfline::geometry::{Hit, Ray};
use halfline::inspect::RayCounters;
use halfline::progress::Observer;

use crate::statistics::RayCounts;
use crate::world::{Surface, World};

/// Rays that are handed to the scene at a time: as many as it casts on one thread, so that no thread
/// waits for another in the middle of its tile, and few enough for the wish to end to be heard.
const BATCH: usize = 1 << 12;

/// Casts rays at the model and the ground. Whoever casts some adds them to `counts`, since only he
/// knows what they are for.
pub(crate) struct Tracer<'a> {
    world: &'a World<'a>,
    observer: &'a dyn Observer,
    pub(crate) counts: RayCounts,
}

impl<'a> Tracer<'a> {
    pub(crate) fn new(world: &'a World<'a>, observer: &'a dyn Observer) -> Tracer<'a> {
        Tracer { world, observer, counts: RayCounts::default() }
    }

    /// The first surface on each ray. Rays in a row that are alike are cast quickest.
    pub(crate) fn closest(&self, rays: &[Ray]) -> Result<Vec<Option<Surface>>> {
        let mut surfaces = Vec::with_capacity(rays.len());
        for rays in rays.chunks(BATCH) {
            self.observer.check()?;
            let hits = self.world.intersector.closest(rays);
            surfaces.extend(rays.iter().zip(hits).map(|(ray, hit)| self.world.surface(ray, hit)));
        }
        Ok(surfaces)
    }

    /// [`Tracer::closest`] ray by ray, with what each of them cost.
    pub(crate) fn closest_counted(
        &self,
        rays: &[Ray],
    ) -> Result<(Vec<Option<Surface>>, Vec<RayCounters>)> {
        let mut caster = self.world.scene.caster();
        let mut counters = vec![RayCounters::default(); rays.len()];
        let mut surfaces = Vec::with_capacity(rays.len());
        for (ray, counters) in rays.iter().zip(&mut counters) {
            if surfaces.len() % BATCH == 0 {
                self.observer.check()?;
            }
            let hit = caster.intersect_counted(ray, counters).unwrap_or(Hit::MISS);
            surfaces.push(self.world.surface(ray, hit));
        }
        Ok((surfaces, counters))
    }

    /// Sets `occluded` for the rays on which anything lies: the model, or the ground. Those for which it
    /// is set already are not cast.
    pub(crate) fn occlude(&self, rays: &[Ray], occluded: &mut [bool]) -> Result<()> {
        if let Some(ground) = &self.world.ground {
            for (ray, occluded) in rays.iter().zip(&mut *occluded) {
                *occluded = *occluded || ground.intersect(ray).is_some();
            }
        }
        let open: Vec<usize> = (0..rays.len()).filter(|&i| !occluded[i]).collect();
        for places in open.chunks(BATCH) {
            self.observer.check()?;
            let rays: Vec<Ray> = places.iter().map(|&i| rays[i]).collect();
            for (&i, answer) in places.iter().zip(self.world.intersector.occluded(&rays)) {
                occluded[i] = answer;
            }
        }
        Ok(())
    }
}
