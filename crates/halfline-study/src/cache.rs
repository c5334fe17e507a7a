//! Where the cache ends: from which size on the same step costs more.
//!
//! A step is a fetch from memory and little else: what is counted does not know whether the fetch was
//! answered by a cache, but its time does. In small trees a step seems dear too, for a ray costs
//! something before its first one; from there on the cost of a step falls to a floor, and rises again
//! where trees outgrow the caches.

use super::FamilyStudy;
use super::engine::Engine;

/// From so many times the floor on, a step is said to cost more: noise is a tenth of that.
pub const DEARER: f64 = 1.25;

/// What a step costs, as trees grow.
#[derive(Clone, Debug, PartialEq)]
pub struct CacheEnd {
    /// The engine.
    pub engine: Engine,
    /// (bytes walked, nanoseconds a visit), size by size.
    pub steps: Vec<(f64, f64)>,
    /// The least nanoseconds that a visit costs at any size.
    pub floor: f64,
    /// The smallest size beyond that of the floor from which on a visit costs 1.25 times as much at
    /// least; `None` if there is none.
    pub end: Option<End>,
    /// At the largest size: its triangles, and by how much a visit costs more than at the floor.
    pub largest: (usize, f64),
}

/// The smallest size that is too large for the cache.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct End {
    /// Triangles of the mesh.
    pub triangles: usize,
    /// Bytes of the tree, and of the mesh unless the tree holds the triangles.
    pub bytes: f64,
}

impl FamilyStudy {
    /// Where the cache ends for an engine; `None` if there is no tree to step through, or too little was
    /// measured.
    pub fn cache_end(&self, engine: Engine) -> Option<CacheEnd> {
        let measured: Vec<(usize, f64, f64)> = self
            .measured(engine, false)
            .filter(|(_, cost)| cost.steps() > 0.0)
            .filter_map(|(measurement, cost)| {
                let bytes = measurement.bytes_walked? as f64;
                Some((measurement.triangles, bytes, cost.nanoseconds / cost.visits(engine)))
            })
            .collect();
        end_of(engine, &measured)
    }
}

/// From (triangles, bytes, nanoseconds a visit) in rising order.
fn end_of(engine: Engine, measured: &[(usize, f64, f64)]) -> Option<CacheEnd> {
    let floor_at = (0..measured.len()).min_by(|&i, &j| measured[i].2.total_cmp(&measured[j].2))?;
    let floor = measured[floor_at].2;
    let dear = measured[floor_at..].iter().rev().take_while(|(.., cost)| *cost >= DEARER * floor);
    let end = dear.last().map(|&(triangles, bytes, _)| End { triangles, bytes });
    let &(triangles, _, cost) = measured.last()?;
    Some(CacheEnd {
        engine,
        steps: measured.iter().map(|&(_, bytes, cost)| (bytes, cost)).collect(),
        floor,
        end,
        largest: (triangles, cost / floor),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_end_is_where_steps_become_and_stay_dearer() {
        let costs = [90.0, 50.0, 40.0, 52.0, 41.0, 44.0, 51.0, 80.0];
        let measured: Vec<_> = costs
            .iter()
            .enumerate()
            .map(|(i, &c)| (10 << i, 1000.0 * (1 << i) as f64, c))
            .collect();
        let found = end_of(Engine::Fast, &measured).unwrap();
        assert_eq!(found.floor, 40.0);
        assert_eq!(found.end, Some(End { triangles: 640, bytes: 64_000.0 }));
        assert_eq!(found.largest, (1280, 2.0));

        let flat = end_of(Engine::Fast, &measured[..6]).unwrap();
        assert_eq!((flat.end, flat.largest), (None, (320, 1.1)));
        assert!(end_of(Engine::Fast, &[]).is_none());
    }
}
