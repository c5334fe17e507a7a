//! One ray, cast as in a batch, and every node and leaf that it comes to.

use std::cell::RefCell;
use std::ops::Range;

use super::batch::Target;
use super::cast::{Batch, Cast, Ending, RayState};
use super::query::ClosestHit;
use super::ray_group::{RayLanes, RayRows};
use crate::geometry::{Hit, Ray};
use crate::numeric::PreparedRay;
use crate::simd::{LANES, Simd};
use crate::tree::Word;

/// A node or leaf that a ray comes to.
#[derive(Clone, Copy, Debug)]
pub struct Visit {
    /// Which.
    pub word: Word,
    /// About the t beyond which nothing matters any more.
    pub t_limit: f64,
}

struct Watched<'a> {
    ray: [Ray; 1],
    hit: &'a mut Hit,
    visits: RefCell<Vec<Visit>>,
}

impl Batch for Watched<'_> {
    type Query = ClosestHit;
    const ENDING: Ending = Ending::Double;
    const IS_WATCHED: bool = true;

    fn count(&self) -> usize {
        1
    }

    fn ray(&self, number: usize) -> Ray {
        self.ray[number]
    }

    #[inline(always)]
    fn lanes<S: Simd>(&self, simd: S, numbers: Range<usize>) -> RayLanes<S> {
        Ray::lanes(simd, &self.ray[numbers])
    }

    #[inline(always)]
    fn gather<S: Simd>(&self, simd: S, numbers: &[usize; LANES]) -> RayLanes<S> {
        Ray::gather(simd, &self.ray, numbers)
    }

    fn watch(&self, word: Word, ray: &RayState) {
        let t_limit = ray.parameter.t(ray.wide.limit);
        self.visits.borrow_mut().push(Visit { word, t_limit });
    }

    fn finish_double(&mut self, _number: usize, hit: Hit) {
        *self.hit = hit;
    }

    fn finish(&mut self, _number: usize, ray: &PreparedRay, query: &mut ClosestHit) {
        *self.hit = query.finish(ray);
    }
}

/// The closest hit of a ray, and what it came to on its way there.
pub fn watch(Target { tree, mesh, level }: Target, ray: &Ray) -> (Hit, Vec<Visit>) {
    let mut hit = Hit::MISS;
    let watched = Watched { ray: [*ray], hit: &mut hit, visits: RefCell::default() };
    let (watched, _) = level.run(Cast::new(tree, mesh, watched));
    let visits = watched.visits.into_inner();
    (hit, visits)
}
