//! What each face is by itself, which ones are there twice, and the volume between them.

use std::sync::atomic::{AtomicBool, Ordering};

use foldhash::fast::FixedState;
use rayon::prelude::*;
use std::hash::BuildHasher;

use super::CHUNK;
use super::Found;
use super::for_each_surface_face;
use halfline::error::Result;
use halfline::geometry::Vec3;
use halfline::mesh::Mesh;
use halfline::numeric::{UNIT_ROUNDOFF, is_zero_area};
use halfline::progress::SharedProgress;

/// What a face is by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaceKind {
    /// The face has an area.
    Sound,
    /// The corners of the face are apart and on one line.
    OnLine,
    /// Two corners of the face are in one place.
    Collapsed,
    /// A corner of the face is infinite or NaN.
    NonFinite,
}

impl FaceKind {
    /// True if the face's edges are edges of the surface.
    pub fn takes_part(self) -> bool {
        matches!(self, FaceKind::Sound | FaceKind::OnLine)
    }
}

/// What all faces are.
pub struct Faces {
    pub kinds: Vec<FaceKind>,
    pub non_finite: Found,
    pub degenerate: Found,
    pub unreferenced_vertices: usize,
    pub signed_volume: f64,
    pub signed_volume_error: f64,
}

/// What a chunk of faces comes to.
#[derive(Default)]
struct Tally {
    non_finite: Found,
    degenerate: Found,
    /// Six times the volume, and the sum of the absolute values that were added up for it.
    volume: f64,
    permanent: f64,
}

/// Tells what each face is, and the volume that all of them enclose.
pub fn examine(mesh: &Mesh, place_of_vertex: &[u32], progress: &SharedProgress) -> Result<Faces> {
    let bounds = mesh.bounds();
    let center = if bounds.is_empty() { Vec3::ZERO } else { bounds.center() };
    let used: Vec<AtomicBool> =
        place_of_vertex.par_iter().map(|_| AtomicBool::new(false)).collect();
    let mut kinds = vec![FaceKind::Sound; mesh.triangle_count()];
    let tallies: Vec<Tally> = kinds
        .par_chunks_mut(CHUNK)
        .enumerate()
        .map(|(chunk, kinds)| {
            let mut tally = Tally::default();
            for (offset, kind) in kinds.iter_mut().enumerate() {
                let face = chunk * CHUNK + offset;
                let triangle = mesh.triangles()[face];
                triangle.iter().for_each(|&v| used[v as usize].store(true, Ordering::Relaxed));
                let [a, b, c] = triangle.map(|v| place_of_vertex[v as usize]);
                let corners = mesh.corners(face as u32);
                *kind = if !corners.iter().all(|p| p.is_finite()) {
                    tally.non_finite.add(face as u32);
                    FaceKind::NonFinite
                } else if a == b || b == c || c == a {
                    tally.degenerate.add(face as u32);
                    FaceKind::Collapsed
                } else if is_zero_area(corners) {
                    tally.degenerate.add(face as u32);
                    FaceKind::OnLine
                } else {
                    let [a, b, c] = corners.map(|p| p - center);
                    tally.volume += a.dot(b.cross(c));
                    let (a, b, c) = (a.abs(), b.abs(), c.abs());
                    tally.permanent += a.x * (b.y * c.z + b.z * c.y)
                        + a.y * (b.z * c.x + b.x * c.z)
                        + a.z * (b.x * c.y + b.y * c.x);
                    FaceKind::Sound
                };
            }
            progress.advance(kinds.len())?;
            Ok(tally)
        })
        .collect::<Result<_>>()?;

    // Add up in the order of the chunks: the sum is the same for any number of threads.
    let mut total = Tally::default();
    for tally in tallies {
        total.non_finite = total.non_finite.and(tally.non_finite);
        total.degenerate = total.degenerate.and(tally.degenerate);
        total.volume += tally.volume;
        total.permanent += tally.permanent;
    }
    let unreferenced_vertices =
        used.par_iter().filter(|used| !used.load(Ordering::Relaxed)).count();
    Ok(Faces {
        unreferenced_vertices,
        non_finite: total.non_finite,
        degenerate: total.degenerate,
        signed_volume: total.volume / 6.0,
        signed_volume_error: volume_error(kinds.len()) * total.permanent / 6.0,
        kinds,
    })
}

/// By how much the computed volume of `faces` faces may err, relative to the sum of the absolute
/// values of all products.
///
/// A product of three differences passes at most nine roundings: three of differences, and two
/// products, one subtraction, two sums within the determinant, and the division by six; of the
/// sums over faces none adds more than one for each face. Twelve more are for the permanent's own
/// rounding and for the terms of higher order.
fn volume_error(faces: usize) -> f64 {
    (faces as f64 + 21.0) * UNIT_ROUNDOFF
}

/// The faces that have the same corners as a face before them.
pub fn duplicates(
    mesh: &Mesh,
    place_of_vertex: &[u32],
    kinds: &[FaceKind],
    progress: &SharedProgress,
) -> Result<Found> {
    let sorted = |mut places: [u32; 3]| {
        places.sort_unstable();
        places
    };
    // As with places, sort by a hash, and compare what has the same one.
    let state = FixedState::default();
    let chunks: Vec<Vec<u64>> = mesh
        .triangles()
        .par_chunks(CHUNK)
        .enumerate()
        .map(|(chunk, triangles)| {
            let mut keys = Vec::with_capacity(triangles.len());
            let first = chunk * CHUNK;
            for_each_surface_face(first, triangles, kinds, place_of_vertex, |face, places| {
                let hash = state.hash_one(sorted(places));
                keys.push(hash & 0xffff_ffff_0000_0000 | u64::from(face));
            });
            progress.advance(triangles.len())?;
            Ok(keys)
        })
        .collect::<Result<_>>()?;
    let mut keys = chunks.concat();
    drop(chunks);
    keys.par_sort_unstable();
    progress.advance(mesh.triangle_count())?;

    let mut found = Found::default();
    let mut sharers: Vec<([u32; 3], u32)> = Vec::new();
    for keys in keys.chunk_by(|a, b| a >> 32 == b >> 32).filter(|keys| keys.len() > 1) {
        let corners = |face: u32| {
            sorted(mesh.triangles()[face as usize].map(|v| place_of_vertex[v as usize]))
        };
        sharers.clear();
        sharers.extend(keys.iter().map(|&key| (corners(key as u32), key as u32)));
        sharers.sort_unstable();
        for group in sharers.chunk_by(|a, b| a.0 == b.0) {
            group[1..].iter().for_each(|&(_, face)| found.add(face));
        }
    }
    Ok(found)
}
