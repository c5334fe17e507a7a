//! Batches of columns must answer as batches of rows do, to the bit, whatever form the columns have.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::common::{Random, nasty_ray, sphere};
use halfline::columns::{Column, HitColumns, RayColumns, Scalars, Vectors};
use halfline::progress::{NoProgress, Observer, Stage};
use halfline::{Error, Hit, Level, Ray, Scene, Vec3};

/// Around the number of rays that a thread takes at a time.
const COUNTS: [usize; 6] = [0, 1, 4095, 4096, 4097, 10_000];

/// The columns of some rays, in both precisions.
#[derive(Default)]
struct Table {
    origins: Vec<[f64; 3]>,
    directions: Vec<[f64; 3]>,
    t_min: Vec<f64>,
    t_max: Vec<f64>,
    single_origins: Vec<[f32; 3]>,
    single_directions: Vec<[f32; 3]>,
    single_t_min: Vec<f32>,
    single_t_max: Vec<f32>,
}

impl Table {
    fn new(scene: &Scene, count: usize, seed: u64) -> Table {
        let mut random = Random(seed);
        let mut table = Table::default();
        for _ in 0..count {
            let mut ray = nasty_ray(scene.mesh(), &[], &mut random);
            if random.below(3) == 0 {
                (ray.t_min, ray.t_max) = (random.unit(), 1.0 + 2.0 * random.unit());
            }
            table.single_origins.push(ray.origin.to_array().map(|x| x as f32));
            table.single_directions.push(ray.direction.to_array().map(|x| x as f32));
            table.single_t_min.push(ray.t_min as f32);
            table.single_t_max.push(ray.t_max as f32);
            table.origins.push(ray.origin.to_array());
            table.directions.push(ray.direction.to_array());
            table.t_min.push(ray.t_min);
            table.t_max.push(ray.t_max);
        }
        table
    }

    /// Columns in every form: the same for all, single precision, double precision, and mixed.
    fn forms(&self) -> Vec<RayColumns<'_>> {
        let origin = Column::Same([0.1, 0.25, 3.0]);
        let single_origin = Column::Same([0.5, 0.25, 3.0]);
        let direction = Column::Same([-0.1, 0.0, -1.0]);
        let origins: [Vectors; 4] =
            [origin, single_origin, Column::F32(&self.single_origins), Column::F64(&self.origins)];
        let directions: [Vectors; 3] =
            [direction, Column::F32(&self.single_directions), Column::F64(&self.directions)];
        let ranges: [(Scalars, Scalars); 4] = [
            (Column::Same(0.0), Column::Same(f64::INFINITY)),
            (Column::Same(0.1), Column::Same(2.7)),
            (Column::F32(&self.single_t_min), Column::F32(&self.single_t_max)),
            (Column::F64(&self.t_min), Column::Same(f64::INFINITY)),
        ];
        let mut forms = Vec::new();
        for origins in origins {
            for directions in directions {
                for (t_min, t_max) in ranges {
                    let count = self.origins.len();
                    let columns = RayColumns::new(count, origins, directions, t_min, t_max);
                    forms.push(columns.expect("they are as long as each other"));
                }
            }
        }
        forms
    }
}

/// The rays of columns, one by one.
fn rows(columns: &RayColumns) -> Vec<Ray> {
    fn vector(column: Vectors, i: usize) -> Vec3 {
        match column {
            Column::Same(v) => v.into(),
            Column::F32(all) => all[i].into(),
            Column::F64(all) => all[i].into(),
        }
    }
    fn number(column: Scalars, i: usize) -> f64 {
        match column {
            Column::Same(x) => x,
            Column::F32(all) => all[i].into(),
            Column::F64(all) => all[i],
        }
    }
    let (origins, directions) = (columns.origins(), columns.directions());
    let (t_min, t_max) = (columns.t_min(), columns.t_max());
    (0..columns.len())
        .map(|i| Ray {
            origin: vector(origins, i),
            direction: vector(directions, i),
            t_min: number(t_min, i),
            t_max: number(t_max, i),
        })
        .collect()
}

fn face(hit: &Hit) -> i64 {
    if hit.is_hit() { hit.face.into() } else { -1 }
}

fn bits(numbers: impl IntoIterator<Item = f64>) -> Vec<u64> {
    numbers.into_iter().map(f64::to_bits).collect()
}

fn scene() -> Scene {
    Scene::new(sphere(4, Vec3::ZERO, 1.0)).expect("builds")
}

#[test]
fn columns_answer_as_rows_do() {
    let scene = scene();
    let mut hit_rays = 0;
    for count in COUNTS {
        let table = Table::new(&scene, count, 7 + count as u64);
        for columns in table.forms() {
            let rays = rows(&columns);

            let (mut t, mut faces) = (vec![-7.0; count], vec![-7; count]);
            let mut uv = vec![[-7.0; 2]; count];
            let hits = HitColumns { t: &mut t, face: &mut faces, uv: &mut uv };
            scene
                .observed(&NoProgress)
                .intersect_columns(&columns, hits)
                .expect("nobody interrupts");
            let expected = scene.intersect(&rays);
            assert_eq!(bits(t), bits(expected.iter().map(|hit| hit.t)));
            assert_eq!(faces, expected.iter().map(face).collect::<Vec<_>>());
            let expected_uv = expected.iter().flat_map(|hit| [hit.u, hit.v]);
            assert_eq!(bits(uv.into_iter().flatten()), bits(expected_uv));
            hit_rays += faces.iter().filter(|&&face| face >= 0).count();

            for before in [false, true] {
                let mut flags = vec![before; count];
                scene
                    .observed(&NoProgress)
                    .occluded_columns(&columns, &mut flags)
                    .expect("nobody interrupts");
                assert_eq!(flags, scene.occluded(&rays));
            }

            let expected = scene.intersect_all(&rays);
            let all = scene
                .observed(&NoProgress)
                .intersect_all_columns(&columns)
                .expect("nobody interrupts");
            let splits: Vec<i64> = expected.splits.iter().map(|&split| split as i64).collect();
            assert_eq!(all.splits, splits);
            assert_eq!(bits(all.t), bits(expected.hits.iter().map(|hit| hit.t)));
            assert_eq!(all.face, expected.hits.iter().map(face).collect::<Vec<_>>());
            let expected_uv = expected.hits.iter().flat_map(|hit| [hit.u, hit.v]);
            assert_eq!(bits(all.uv.into_iter().flatten()), bits(expected_uv));

            let mut counts = vec![-7; count];
            let done =
                scene.observed(&NoProgress).count_intersections_columns(&columns, &mut counts);
            done.expect("nobody interrupts");
            let lengths: Vec<i64> = splits.windows(2).map(|pair| pair[1] - pair[0]).collect();
            assert_eq!(counts, lengths);
        }
    }
    assert!(hit_rays > 100_000, "too few rays hit to show anything: {hit_rays}");
}

#[test]
fn a_range_that_single_precision_lacks_is_not_rounded() {
    // Straight down on a square at z = 0 from 0.1, which no float is: t is 0.1 rounded to single
    // precision, and so beyond a t_max of 0.1, or of any other double between the two.
    let corners = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    let positions = halfline::mesh::Positions::F32(corners.into());
    let mesh = halfline::Mesh::new(positions, vec![[0, 1, 2], [0, 2, 3]]).expect("a mesh");
    let scene = Scene::new(mesh).expect("builds");
    let height = 0.1f32;
    assert!(f64::from(height) > 0.1 && 0.1f64 as f32 == height);
    let origins = [[0.25, 0.5, height]; 2];
    for (t_max, is_hit) in [(0.1, false), (f64::from(height), true)] {
        let columns = RayColumns::new(
            2,
            Column::F32(&origins),
            Column::Same([0.0, 0.0, -1.0]),
            Column::Same(0.0),
            Column::Same(t_max),
        );
        let mut flags = [!is_hit; 2];
        let columns = columns.expect("two rays");
        scene
            .observed(&NoProgress)
            .occluded_columns(&columns, &mut flags)
            .expect("nobody interrupts");
        assert_eq!(flags, [is_hit; 2]);
    }
}

#[test]
fn a_column_of_another_length_is_refused_by_name() {
    let zero = Column::Same([0.0; 3]);
    let (three, two) = ([[0.0; 3]; 3], [0.0f32; 2]);
    let same = Column::Same(0.0);
    let error = RayColumns::new(4, zero, Column::F64(&three), same, same).unwrap_err();
    assert_eq!(error.to_string(), "directions: expected one or 4 entries, found 3");
    let error = RayColumns::new(4, zero, zero, same, Column::F32(&two)).unwrap_err();
    assert_eq!(error.to_string(), "t_max: expected one or 4 entries, found 2");
}

#[test]
#[should_panic(expected = "a place for the answer of each ray")]
fn there_cannot_be_fewer_places_than_rays() {
    let (zero, same) = (Column::Same([0.0; 3]), Column::Same(0.0));
    let columns = RayColumns::new(3, zero, zero, same, same).expect("three rays");
    let _ = scene().observed(&NoProgress).occluded_columns(&columns, &mut [false; 2]);
}

/// Ends the work once a number of rays are done.
struct EndsAfter {
    rays: u64,
    done: AtomicU64,
}

impl Observer for EndsAfter {
    fn report(&self, stage: Stage, done: u64, total: u64) {
        assert_eq!(stage, Stage::Trace);
        assert!(done <= total);
        self.done.fetch_max(done, Ordering::Relaxed);
    }

    fn cancelled(&self) -> bool {
        self.done.load(Ordering::Relaxed) >= self.rays
    }
}

#[test]
fn the_observer_hears_of_all_rays_and_ends_the_work() {
    let scene = scene();
    for count in [1000, 200_000] {
        let origins = vec![[0.1f32, 0.2, 3.0]; count];
        let columns = RayColumns::new(
            count,
            Column::F32(&origins),
            Column::Same([0.0, 0.0, -1.0]),
            Column::Same(0.0),
            Column::Same(f64::INFINITY),
        );
        let columns = columns.expect("as many rays");
        let listener = EndsAfter { rays: u64::MAX, done: 0.into() };
        scene.observed(&listener).intersect_all_columns(&columns).expect("nobody interrupts");
        assert_eq!(listener.done.into_inner(), count as u64);

        let ends = EndsAfter { rays: count as u64 / 2, done: 0.into() };
        let error = scene.observed(&ends).intersect_all_columns(&columns).unwrap_err();
        assert!(matches!(error, Error::Interrupted));
        let done = ends.done.into_inner();
        assert!(count < 4096 || done < count as u64, "all {done} rays were cast");
    }
}

/// Images are cast tile by tile, and answered as rays one by one are, whatever their shape.
#[test]
fn images_are_answered_as_their_rays() {
    let mut scene = scene();
    let bounds = scene.mesh().bounds();
    let (center, size) = (bounds.center(), bounds.extent().length());
    for (width, height) in [(8, 8), (64, 20), (71, 19), (100, 8), (63, 16), (9, 9), (640, 3)] {
        let pixel = |i: usize| {
            let x = (i % width) as f64 / width as f64 - 0.5;
            let y = (i / width) as f64 / height as f64 - 0.5;
            [x * size * 0.3, y * size * 0.3, -size]
        };
        let directions: Vec<[f64; 3]> = (0..width * height).map(pixel).collect();
        let eye = (center + Vec3::from([0.0, 0.0, size])).to_array();
        let rays = RayColumns::new(
            directions.len(),
            Column::Same(eye),
            Column::F64(&directions),
            Column::Same(0.0),
            Column::Same(f64::INFINITY),
        );
        let plain = rays.expect("of one length");
        let image = plain.with_image_width(width);
        for level in Level::available() {
            scene.set_simd_level(level);
            let answers = [plain, image].map(|rays| {
                let (mut t, mut face) = (vec![0.0; rays.len()], vec![0; rays.len()]);
                let (mut uv, mut flags) = (vec![[0.0; 2]; rays.len()], vec![false; rays.len()]);
                let mut counts = vec![0; rays.len()];
                let hits = HitColumns { t: &mut t, face: &mut face, uv: &mut uv };
                let seen = scene.observed(&NoProgress);
                seen.intersect_columns(&rays, hits).expect("nobody interrupts");
                seen.occluded_columns(&rays, &mut flags).expect("nobody interrupts");
                seen.count_intersections_columns(&rays, &mut counts).expect("nobody interrupts");
                let all = seen.intersect_all_columns(&rays).expect("nobody interrupts");
                (bits(t), face, bits(uv.into_flattened()), flags, counts, all)
            });
            assert_eq!(answers[0], answers[1], "{width} x {height}, {}", level.name());
            assert!(answers[0].3.iter().any(|&flag| flag), "something is hit");
        }
    }
}
