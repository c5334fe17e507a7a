//! The same bits on every instruction set, on any number of threads, and in batches of any size.

use halfline::columns::Column;
use halfline::progress::NoProgress;
use halfline::{Level, Scene, Vec3};

use crate::cases::{self, direction, point, triangles};
use crate::random::Random;
use crate::shapes::{soup, sphere};

fn bits(scene: &Scene, points: &[Vec3]) -> (Vec<u64>, Vec<bool>) {
    let numbers = scene.winding_numbers(points);
    (numbers.into_iter().map(f64::to_bits).collect(), scene.contains(points))
}

#[test]
fn bits_depend_on_nothing_but_the_question() {
    let mut random = Random(41);
    let mut meshes = cases::open(&mut random);
    meshes.extend(cases::closed(&mut random));
    let half = triangles(&sphere(5, Vec3::ZERO, 3.0)).into_iter().filter(|t| t[0].z > 0.2);
    meshes.push(soup(half));
    let along = direction();
    let count = cases::points(0.04) / meshes.len();
    let pools = [1, 2].map(|n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap());
    for mesh in meshes {
        let mut scene = Scene::new(mesh).unwrap();
        let corners = triangles(scene.mesh());
        let finite = |corners: &[Vec3; 3]| corners.iter().all(|corner| corner.is_finite());
        let corners: Vec<_> = corners.into_iter().filter(finite).collect();
        let points: Vec<Vec3> = (0..count).map(|_| point(&mut random, &corners, along)).collect();
        let expected = bits(&scene, &points);
        for level in Level::available() {
            scene.set_simd_level(level);
            for pool in &pools {
                assert!(pool.install(|| bits(&scene, &points)) == expected, "{level:?}");
            }
        }
        for (i, point) in points.iter().enumerate().step_by(37) {
            let (number, flag) = bits(&scene, &[*point]);
            assert_eq!((number[0], flag[0]), (expected.0[i], expected.1[i]));
        }
        // In single precision points are others, but rows and columns are the same.
        let single: Vec<[f32; 3]> = points.iter().map(|p| p.to_array().map(|x| x as f32)).collect();
        let rows: Vec<Vec3> = single.iter().map(|p| Vec3::from(*p)).collect();
        let mut numbers = vec![0.0; rows.len()];
        let observed = scene.observed(&NoProgress);
        observed.winding_numbers_columns(Column::F32(&single), &mut numbers).unwrap();
        let numbers: Vec<u64> = numbers.into_iter().map(f64::to_bits).collect();
        assert_eq!(numbers, bits(&scene, &rows).0);
    }
}
