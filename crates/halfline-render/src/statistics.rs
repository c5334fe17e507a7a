//! What a picture cost.

use std::ops::AddAssign;

/// Rays by what they were for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct RayCounts {
    /// Rays from the eye.
    pub primary: u64,
    /// Rays from a surface into its surroundings, to see how much sky it gets.
    pub occlusion: u64,
    /// Rays from a surface to a light.
    pub shadow: u64,
    /// Rays from a mirror.
    pub reflection: u64,
    /// Rays through glass.
    pub refraction: u64,
}

impl RayCounts {
    /// The number of all rays.
    pub fn total(&self) -> u64 {
        [self.occlusion, self.shadow, self.reflection, self.refraction]
            .into_iter()
            .fold(self.primary, u64::saturating_add)
    }
}

impl AddAssign for RayCounts {
    fn add_assign(&mut self, other: RayCounts) {
        // What comes from another machine may be anything, and must not end the process.
        let add = |sum: &mut u64, count: u64| *sum = sum.saturating_add(count);
        add(&mut self.primary, other.primary);
        add(&mut self.occlusion, other.occlusion);
        add(&mut self.shadow, other.shadow);
        add(&mut self.reflection, other.reflection);
        add(&mut self.refraction, other.refraction);
    }
}

/// What a picture cost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RenderStatistics {
    /// Rays cast.
    pub rays: RayCounts,
    /// Wall-clock time from the first ray to the last; of a picture put together from parts, the sum of
    /// theirs.
    pub trace_seconds: f64,
}

impl RenderStatistics {
    /// Rays of all kinds cast in a second, or 0 if nothing was cast.
    pub fn rays_per_second(&self) -> f64 {
        if self.trace_seconds > 0.0 { self.rays.total() as f64 / self.trace_seconds } else { 0.0 }
    }
}
