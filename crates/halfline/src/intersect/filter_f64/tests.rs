//! What double precision is certain of is true.

use super::*;
use crate::geometry::{Ray, Vec3};
use crate::numeric::{PreparedRay, Touched};
use crate::rays::RaySource;
use crate::simd::{Job, Level};

/// Numbers at random (SplitMix64), the same each time.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    fn point(&mut self) -> Vec3 {
        Vec3::from([0; 3].map(|_| self.unit() * 2.0 - 1.0))
    }

    /// 2^-first to 2^-last.
    fn small(&mut self, first: usize, last: usize) -> f64 {
        2f64.powi(-((first + self.below(last - first)) as i32))
    }
}

/// A ray and a triangle.
type Pair = (Ray, [Vec3; 3]);

struct Look<'a>(&'a [Pair; LANES]);

impl Job for Look<'_> {
    type Output = Refined;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Refined {
        let wide = simd.doubles();
        let mut corners = [[wide.splat(0.0); 3]; 3];
        for corner in 0..3 {
            for axis in 0..3 {
                let mut lanes = [0.0; LANES];
                for lane in 0..LANES {
                    lanes[lane] = self.0[lane].1[corner][axis];
                }
                corners[corner][axis] = wide.set(lanes);
            }
        }
        let rays = self.0.map(|pair| pair.0);
        refine(simd, &RaySource::Rows(&rays).load8(simd, 0..LANES), &corners, 255)
    }
}

/// What was seen of pairs of ray and triangle.
#[derive(Debug, Default)]
struct Counts {
    pairs: u32,
    met: u32,
    hit: u32,
    missed: u32,
}

/// Looks at pairs by every instruction set, and fails if exact arithmetic says something else.
fn check(pairs: &[Pair]) -> Counts {
    let mut counts = Counts::default();
    for eight in pairs.as_chunks::<LANES>().0 {
        for level in Level::available() {
            let look = level.run(Look(eight));
            for (lane, (ray, corners)) in eight.iter().enumerate() {
                let exact = PreparedRay::new(ray).and_then(|ray| ray.meet(*corners));
                let is_hit = look.hit >> lane & 1 == 1;
                let is_missed = look.missed >> lane & 1 == 1;
                let [low, high] = [look.low[lane], look.high[lane]];
                let name = level.name();
                let all = || format!("{name}: {low} {high} {exact:?} {ray:?} {corners:?}");
                assert!(!(is_hit && is_missed), "both: {}", all());
                if is_missed {
                    assert!(exact.is_none(), "missed for certain, but hit: {}", all());
                }
                if is_hit {
                    let Some(exact) = exact else {
                        panic!("hit for certain, but missed: {}", all())
                    };
                    assert!(exact.touched == Touched::Inside, "not in the inside: {}", all());
                    assert!(low <= exact.t && exact.t <= high, "somewhere else: {}", all());
                }
                counts.pairs += 1;
                counts.met += u32::from(exact.is_some());
                counts.hit += u32::from(is_hit);
                counts.missed += u32::from(is_missed);
            }
        }
    }
    counts
}

/// The part of a line that begins, or ends, or both, where it meets a triangle, or nearly so.
fn cut(line: Ray, corners: [Vec3; 3], random: &mut Random) -> Ray {
    let contact = PreparedRay::new(&line).and_then(|line| line.meet(corners));
    let Some(contact) = contact else { return line };
    let mut t = contact.t;
    match random.below(3) {
        0 => t = t.next_up(),
        1 => t = t.next_down(),
        _ => {}
    }
    match random.below(3) {
        0 => Ray { t_min: t, ..line },
        1 => Ray { t_max: t, ..line },
        _ => Ray { t_min: t, t_max: t, ..line },
    }
}

/// A ray past a corner, an edge or the inside of a triangle, at distances around what double precision can
/// tell; and past a triangle that it nearly lies in, so that the weights are little more than errors.
fn hard_pair(random: &mut Random) -> Pair {
    let mut corners = [0; 3].map(|_| random.point());
    let mut along = random.point();
    match random.below(4) {
        // A long sliver.
        0 => {
            let share = random.unit();
            let beside = random.point() * random.small(20, 54);
            corners[2] = corners[0] * share + corners[1] * (1.0 - share) + beside;
        }
        // A blade along the ray.
        1 => {
            let middle = random.point();
            for corner in &mut corners {
                let place = middle + along * (random.unit() * 2.0 - 1.0);
                *corner = place + *corner * random.small(40, 60);
            }
        }
        // A triangle across an axis, whose corners are all equally deep.
        2 => {
            let (axis, depth) = (random.below(3), random.unit());
            for corner in &mut corners {
                corner[axis] = depth;
            }
            along[axis] += if along[axis] < 0.0 { -1.0 } else { 1.0 };
        }
        _ => {}
    }
    let [a, b, c] = corners;
    let share = random.unit();
    let aim = match random.below(4) {
        0 => a,
        1 => a * share + b * (1.0 - share),
        2 => (a + b + c) * (1.0 / 3.0),
        _ => a * share + b * (1.0 - share) + random.point() * random.small(40, 54),
    };
    // From the triangle itself, from near and from far.
    let way = [0.0, 1.0, random.small(1, 50), 2f64.powi(random.below(40) as i32)][random.below(4)];
    let origin = aim - along * way;
    let line = Ray::with_range(origin, along, f64::NEG_INFINITY, f64::INFINITY);
    match random.below(4) {
        0 => (line, corners),
        1 => (Ray { t_min: 0.0, ..line }, corners),
        _ => (cut(line, corners, random), corners),
    }
}

/// The same, elsewhere: so much larger, and moved by so much.
fn moved((ray, corners): Pair, size: f64, offset: Vec3, speed: f64) -> Pair {
    let at = |point: Vec3| (point + offset) * size;
    let direction = ray.direction * speed;
    (Ray { origin: at(ray.origin), direction, ..ray }, corners.map(at))
}

#[test]
fn what_double_precision_is_certain_of_is_true() {
    let mut random = Random(31);
    let pairs: Vec<Pair> = (0..160_000).map(|_| hard_pair(&mut random)).collect();
    let Counts { pairs, met, hit, missed } = check(&pairs);
    // Neither side of an edge may go by without a trial.
    assert!(
        met * 4 > pairs && hit * 20 > pairs && missed * 20 > pairs,
        "{hit} {missed} of {pairs}"
    );
}

#[test]
fn it_is_true_at_any_size_and_distance() {
    let mut random = Random(32);
    let sizes = [1e-300, 1e-150, 1e-100, 1e-46, 1e-44, 1.0, 1e44, 1e46, 1e100, 1e150];
    let mut total = Counts::default();
    for size in sizes {
        for offset in [0.0, 1e4, 1e12] {
            let offset = Vec3::from([0.7, -0.9, 0.3]) * offset;
            let mut pair = || {
                let speed = [size, 1.0, 1e-100, 1e-46, 1e44, 1e100][random.below(6)];
                let (ray, corners) = moved(hard_pair(&mut random), size, offset, speed);
                let line = Ray { t_min: f64::NEG_INFINITY, t_max: f64::INFINITY, ..ray };
                let ray = if random.below(2) == 0 { line } else { cut(line, corners, &mut random) };
                (ray, corners)
            };
            let pairs: Vec<Pair> = (0..2400).map(|_| pair()).collect();
            let counts = check(&pairs);
            total.hit += counts.hit;
            total.missed += counts.missed;
        }
    }
    assert!(total.hit > 2000 && total.missed > 5000, "{total:?}");
}

#[test]
fn it_is_certain_of_what_is_plain() {
    let mut random = Random(33);
    for size in [1e-30, 1.0, 1e30] {
        let mut plain = || {
            let corners = [0; 3].map(|_| random.point());
            let [from, to] = [0; 2].map(|_| random.point() * 2.0);
            moved((Ray::new(from, to - from), corners), size, Vec3::ZERO, size)
        };
        let pairs: Vec<Pair> = (0..16_000).map(|_| plain()).collect();
        let Counts { pairs, met, hit, missed } = check(&pairs);
        assert!(met * 30 > pairs && hit * 1000 >= met * 999, "{size}: {hit} of {met}");
        assert!((hit + missed) * 1000 >= pairs * 999, "{size}: {hit}, {missed} of {pairs}");
    }
}
