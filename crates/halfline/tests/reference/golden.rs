//! The same bits on every machine: hashes of answers, written down once. A machine may differ from the
//! one where they were written in its instruction sets, its compiler and its mathematical library.

use halfline::progress::NoProgress;
use halfline::{Mesh, Ray, Scene};
use halfline_io::models::{Kind, generate};
use twox_hash::XxHash3_64;

use super::common::engines::{bits, by_batch};
use super::common::{Random, meshes, nasty_ray};

/// By name of the mesh.
const GOLDEN: &[(&str, u64)] = &[
    ("grid cube", 0x06a5_cf26_45f9_73e7),
    ("stairs", 0xf458_9138_eb61_e4a9),
    ("sphere", 0xc3ef_505b_7fb3_916b),
    ("sphere in single precision", 0xd64e_2a23_aa79_59be),
    ("stairs in single precision", 0xf458_9138_eb61_e4a9),
    ("sphere in map coordinates", 0xb255_9747_aad6_0efd),
    ("tiny sphere", 0xad2b_a0eb_e227_4ec0),
    ("huge sphere", 0x5770_d98a_758f_a636),
    ("random soup", 0xc7c2_8299_21b8_4cd6),
    ("slivers", 0xf33f_4513_e018_8f23),
    ("beams", 0x4404_ed43_3c44_7fd9),
    ("coplanar copies", 0xcc14_a656_65cc_22db),
    ("plane", 0xc8c7_f17c_3cc7_beda),
    ("sheets", 0x9c40_8841_ed35_ddfc),
    ("broken faces", 0xd7d8_e884_f0da_3261),
    ("one triangle", 0xdeb4_e1e5_c171_0ed4),
    ("nothing", 0x011a_d744_d582_92fe),
    ("scan", 0x5d00_dc83_ecd5_dafc),
    ("layers", 0xa3d2_0dc1_ecbc_1df8),
    ("sticks", 0x7296_cf6f_366c_b514),
    ("terrain", 0x6f88_710c_bf38_dddd),
];

/// Meshes whose coordinates are the same everywhere: sine and cosine, of which the fan is made, are not.
fn golden_meshes() -> Vec<(&'static str, Mesh)> {
    let mut all = meshes();
    all.retain(|(name, _)| *name != "fan");
    let kinds = [
        ("scan", Kind::Scan),
        ("layers", Kind::Layers),
        ("sticks", Kind::Sticks),
        ("terrain", Kind::Terrain),
    ];
    all.extend(
        kinds.map(|(name, kind)| (name, generate(kind, 2000, 0, &NoProgress).expect("generates"))),
    );
    all
}

/// Rays that are made to hurt, then such as a camera has, which go as packets.
fn golden_rays(mesh: &Mesh) -> Vec<Ray> {
    let mut random = Random(16);
    let mut rays: Vec<Ray> = (0..256).map(|_| nasty_ray(mesh, &[], &mut random)).collect();
    let bounds = mesh.bounds();
    if bounds.is_empty() {
        return rays;
    }
    let (center, size) = (bounds.center(), bounds.extent().max_element());
    let eye = center + random.point() * size;
    for pixel in 0..256 {
        let mut target = center;
        target.x += (f64::from(pixel % 16) / 16.0 - 0.5) * size;
        target.y += (f64::from(pixel / 16) / 16.0 - 0.5) * size;
        rays.push(Ray::new(eye, target - eye));
    }
    rays
}

#[test]
fn every_machine_gives_the_same_bits() {
    let mut found = Vec::new();
    for (name, mesh) in golden_meshes() {
        let rays = golden_rays(&mesh);
        let mut scene = Scene::new(mesh).expect("builds");
        let mut bytes = Vec::new();
        for answers in by_batch(&mut scene, &rays) {
            let (any, hits) = bits(&answers);
            bytes.push(u8::from(any));
            bytes.extend((hits.len() as u64).to_le_bytes());
            bytes.extend(hits.into_iter().flatten().flat_map(u64::to_le_bytes));
        }
        found.push((name, XxHash3_64::oneshot(&bytes)));
    }
    assert!(found == GOLDEN, "not as written down: {found:#x?}");
}
