//! Which vertices lie at exactly the same place.
//!
//! Half of each sorted number is a hash of the place and half the vertex, so that sorting needs
//! neither a table nor a look at the coordinates. Only what has the same hash is compared.

use foldhash::fast::FixedState;
use rayon::prelude::*;
use std::hash::BuildHasher;

use super::CHUNK;
use halfline::error::Result;
use halfline::mesh::Positions;
use halfline::progress::SharedProgress;

/// Where vertices lie.
pub struct Places {
    /// For each vertex the lowest one at its place.
    pub of_vertex: Vec<u32>,
    /// Vertices that are not the lowest ones.
    pub duplicates: usize,
}

fn place_key(positions: &Positions, vertex: u32) -> [u64; 3] {
    positions.get(vertex as usize).place_key()
}

/// Finds the vertices that share a place.
pub fn find(positions: &Positions, progress: &SharedProgress) -> Result<Places> {
    // The answer does not depend on the hash, so that it may be the same always.
    let state = FixedState::default();
    let count = positions.len();
    let mut keys = vec![0_u64; count];
    keys.par_chunks_mut(CHUNK).enumerate().try_for_each(|(chunk, keys)| {
        for (offset, key) in keys.iter_mut().enumerate() {
            let vertex = (chunk * CHUNK + offset) as u32;
            let [x, y, z] = place_key(positions, vertex);
            let hash = state.hash_one((x, y, z));
            *key = hash & 0xffff_ffff_0000_0000 | u64::from(vertex);
        }
        progress.advance(keys.len())
    })?;
    keys.par_sort_unstable();
    progress.advance(count)?;

    let mut of_vertex: Vec<u32> = (0..count as u32).collect();
    let mut duplicates = 0;
    let mut sharers: Vec<([u64; 3], u32)> = Vec::new();
    for keys in keys.chunk_by(|a, b| a >> 32 == b >> 32).filter(|keys| keys.len() > 1) {
        // Different places may have one hash.
        sharers.clear();
        sharers.extend(keys.iter().map(|&key| (place_key(positions, key as u32), key as u32)));
        sharers.sort_unstable();
        for group in sharers.chunk_by(|a, b| a.0 == b.0) {
            duplicates += group.len() - 1;
            group.iter().for_each(|&(_, vertex)| of_vertex[vertex as usize] = group[0].1);
        }
    }
    progress.advance(count)?;
    Ok(Places { of_vertex, duplicates })
}

#[cfg(test)]
mod tests {
    use super::*;
    use halfline::mesh::Mesh;
    use halfline::progress::NoProgress;

    #[test]
    fn the_lowest_vertex_stands_for_its_place() {
        let nan = f32::NAN;
        let vertices = vec![
            [1.0, 0.0, 2.0],
            [-0.0, 0.0, 0.0],
            [1.0, -0.0, 2.0],
            [0.0, 0.0, -0.0],
            [1.0, f32::MIN_POSITIVE, 2.0],
            [nan, 0.0, 0.0],
            [1.0, 0.0, 2.0],
        ];
        let mesh = Mesh::new(Positions::F32(vertices.into()), Vec::new()).unwrap();
        let places = find(mesh.positions(), &super::super::begin(&NoProgress, &mesh)).unwrap();
        assert_eq!(places.of_vertex, [0, 1, 0, 1, 4, 5, 0]);
        assert_eq!(places.duplicates, 3);
    }

    #[test]
    fn places_with_one_hash_stay_apart() {
        // Of so many places some ten pairs share the upper half of their hash.
        let count = 300_000;
        let vertex = |i: usize| [(i % count) as f64, 0.25, -3.0];
        let positions = Positions::F64((0..count + 1000).map(vertex).collect());
        let state = FixedState::default();
        let mut hashes: Vec<u64> = (0..count as u32)
            .map(|v| place_key(&positions, v))
            .map(|[x, y, z]| state.hash_one((x, y, z)) >> 32)
            .collect();
        hashes.sort_unstable();
        hashes.dedup();
        assert!(hashes.len() < count, "no hash is shared, and the test shows nothing");
        let mesh = Mesh::new(positions, Vec::new()).unwrap();
        let places = find(mesh.positions(), &super::super::begin(&NoProgress, &mesh)).unwrap();
        assert_eq!(places.duplicates, 1000);
        let expected = |i: usize| (i % count) as u32;
        assert!(places.of_vertex.iter().enumerate().all(|(i, &place)| place == expected(i)));
    }
}
