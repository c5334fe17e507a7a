//! What one thread needs to ask the world about rays.

use halfline::geometry::Ray;
use halfline::scene::{Caster, RayCounters};

use crate::statistics::RayCounts;
use crate::world::{Surface, World};

/// Casts rays at the model and the ground. Whoever casts one adds it to `counts`, since only he
/// knows what it is for.
pub(crate) struct Tracer<'a> {
    world: &'a World<'a>,
    caster: Caster<'a>,
    pub(crate) counts: RayCounts,
}

impl<'a> Tracer<'a> {
    pub(crate) fn new(world: &'a World<'a>) -> Tracer<'a> {
        Tracer { world, caster: world.scene.caster(), counts: RayCounts::default() }
    }

    /// The first surface on `ray`.
    pub(crate) fn closest(&mut self, ray: &Ray) -> Option<Surface> {
        self.closest_counted(ray, &mut RayCounters::default())
    }

    /// [`Tracer::closest`], adding what it cost to `counters`.
    pub(crate) fn closest_counted(
        &mut self,
        ray: &Ray,
        counters: &mut RayCounters,
    ) -> Option<Surface> {
        let hit = self.caster.closest_counted(ray, counters);
        self.world.surface(ray, hit)
    }

    /// True if anything lies on `ray`: the model, or the ground.
    pub(crate) fn is_hidden(&mut self, ray: &Ray) -> bool {
        let meets_ground =
            self.world.ground.as_ref().is_some_and(|ground| ground.intersect(ray).is_some());
        meets_ground || self.caster.any(ray)
    }
}
