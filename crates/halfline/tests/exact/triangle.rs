//! The triangle test against exact rational arithmetic that shares no code with it.

use crate::common::contact::WEIGHT_TOLERANCE;
use crate::common::exact::{
    cross, crosses, exact, exact_double, is_front, meeting, minus, nearest_double,
};
use crate::common::nudge;
use halfline::numeric::{Interval, Orientation, PreparedRay, is_zero_area};
use halfline::{Ray, Vec3};
use num_traits::Zero;
use proptest::prelude::*;

/// Fails unless the test under trial agrees: the same verdict, t to the bit, u and v to 2^-40, the
/// same side, and the same answer to whether it is a crossing.
fn check(ray: Ray, corners: [Vec3; 3]) -> Result<(), TestCaseError> {
    let prepared = PreparedRay::new(&ray);
    check_bounds(&ray, corners)?;
    let found = prepared.and_then(|r| r.meet(corners).map(|contact| (contact, r.hit(0, corners))));
    let expected = meeting(&ray, corners).filter(|[t, ..]| {
        // t is compared with the range after rounding, as documented.
        let t = nearest_double(t);
        ray.t_min <= t && t <= ray.t_max && t.is_finite()
    });
    match (found, expected) {
        (None, None) => {}
        (Some((contact, hit)), Some([t, u, v])) => {
            // To the bit, so that a zero is no negative one.
            let (got, want) = (hit.t.to_bits(), nearest_double(&t).to_bits());
            prop_assert_eq!(got, want, "t of {:?} {:?}: {:?}", ray, corners, hit);
            prop_assert_eq!(
                contact.t.to_bits(),
                want,
                "t of {:?} {:?}, the long way",
                ray,
                corners
            );
            let crossing = contact.is_crossing;
            prop_assert_eq!(crossing, crosses(&ray, corners), "{:?} {:?}", ray, corners);
            let front = contact.orientation == Orientation::Front;
            prop_assert_eq!(front, is_front(&ray, corners), "{:?} {:?}", ray, corners);
            for (got, want) in [(hit.u, u), (hit.v, v)] {
                let want = nearest_double(&want);
                prop_assert!((got - want).abs() <= WEIGHT_TOLERANCE, "{} for {}", got, want);
                prop_assert!((0.0..=1.0).contains(&got), "{} is no weight", got);
            }
        }
        (found, expected) => prop_assert!(
            false,
            "{:?} {:?}: found {:?}, but exactly it is {:?}",
            ray,
            corners,
            found.map(|(_, hit)| hit),
            expected.map(|e| e.map(|x| nearest_double(&x)))
        ),
    }
    Ok(())
}

/// Fails unless the exact t, if the line meets the triangle, lies within the bounds of the meeting.
fn check_bounds(ray: &Ray, corners: [Vec3; 3]) -> Result<(), TestCaseError> {
    let Some(prepared) = PreparedRay::new(ray) else { return Ok(()) };
    let (found, expected) = (prepared.meet_line(corners), meeting(ray, corners));
    prop_assert_eq!(found.is_some(), expected.is_some(), "{:?} {:?}", ray, corners);
    if let (Some(meeting), Some([t, ..])) = (found, expected) {
        let Interval { low, high } = meeting.bounds(&prepared);
        let is_above = low == f64::NEG_INFINITY || exact_double(low) <= t;
        let is_below = high == f64::INFINITY || t <= exact_double(high);
        prop_assert!(is_above && is_below, "{} is not in {}..{}", nearest_double(&t), low, high);
    }
    Ok(())
}

fn grid_point(range: i32) -> impl Strategy<Value = Vec3> {
    (-range..=range, -range..=range, -range..=range)
        .prop_map(|(x, y, z)| Vec3::from([f64::from(x), f64::from(y), f64::from(z)]))
}

fn any_point() -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(-1.0..1.0).prop_map(Vec3::from)
}

/// A weight for corners: often zero, so that aimed rays pass through edges and vertices.
fn weight() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), Just(0.5), Just(1.0), 0.0..1.0]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4000, ..ProptestConfig::default() })]

    #[test]
    fn coarse_grid(o in grid_point(2), d in grid_point(2), a in grid_point(2), b in grid_point(2), c in grid_point(2), t_min in -2..1i32) {
        prop_assume!(d != Vec3::ZERO);
        check(Ray::with_range(o, d, f64::from(t_min), 3.0), [a, b, c])?;
    }

    #[test]
    fn aimed_at_edges_and_vertices(
        o in any_point(), a in any_point(), b in any_point(), c in any_point(),
        wa in weight(), wb in weight(), wc in weight(), steps in prop::array::uniform3(-4..=4i32),
        offset in prop_oneof![Just(0.0), Just(500_000.0), Just(1e7)],
    ) {
        let sum = wa + wb + wc;
        prop_assume!(sum > 0.0);
        let shift = Vec3::splat(offset);
        let [o, a, b, c] = [o + shift, a + shift, b + shift, c + shift];
        let target = a * (wa / sum) + b * (wb / sum) + c * (wc / sum);
        let d = target - o;
        let d = Vec3::from([nudge(d.x, steps[0]), nudge(d.y, steps[1]), nudge(d.z, steps[2])]);
        prop_assume!(d != Vec3::ZERO);
        check(Ray::new(o, d), [a, b, c])?;
    }

    #[test]
    fn slivers_and_grazing_rays(
        o in any_point(), a in any_point(), b in any_point(), along in 0.0..1.0f64, off in any_point(),
        thinness in prop_oneof![Just(0.0), Just(1e-6), Just(1e-12), Just(1e-16)],
        aim in 0.0..1.0f64, tilt in any_point(), tilt_size in prop_oneof![Just(1e-3), Just(1e-9), Just(1e-15)],
    ) {
        let c = a * (1.0 - along) + b * along + off * thinness;
        let d = a * (1.0 - aim) + b * aim - o;
        check(Ray::new(o, d), [a, b, c])?;
        check(Ray::new(a + tilt * tilt_size, b - a), [a, b, c])?;
    }

    #[test]
    fn powers_of_two_change_nothing(
        o in any_point(), a in any_point(), b in any_point(), c in any_point(), d in any_point(),
        size in -100..=100i32, speed in -900..=900i32,
    ) {
        prop_assume!(d != Vec3::ZERO);
        let scale = 2f64.powi(size);
        let corners = [a * scale, b * scale, c * scale];
        let hit = |ray: Ray, corners| {
            let prepared = PreparedRay::new(&ray)?;
            prepared.meet(corners).map(|_| prepared.hit(0, corners))
        };
        let plain = hit(Ray::new(o, d), [a, b, c]);
        let scaled = hit(Ray::new(o * scale, d * 2f64.powi(speed)), corners);
        prop_assert_eq!(plain.is_some(), scaled.is_some());
        if let (Some(p), Some(s)) = (plain, scaled) {
            prop_assert_eq!((p.t, p.u, p.v), (s.t * 2f64.powi(speed - size), s.u, s.v));
        }
    }
}

/// A coordinate of few digits, of a size that several coordinates share: so that they coincide and
/// cancel, anywhere in the range of doubles.
fn few_digits(exponents: [i32; 2], digits: i32, which: usize) -> f64 {
    f64::from(digits)
        * 2f64.powi(exponents[which] / 2)
        * 2f64.powi(exponents[which] - exponents[which] / 2)
}

fn wide_point(exponents: [i32; 2]) -> impl Strategy<Value = Vec3> {
    prop::array::uniform3((-3..=3i32, 0..2usize))
        .prop_map(move |p| p.map(|(digits, which)| few_digits(exponents, digits, which)).into())
}

/// Pairs of binary exponents, together or far apart.
fn two_exponents() -> impl Strategy<Value = [i32; 2]> {
    (-1074..=1020i32, -1074..=1020i32, any::<bool>())
        .prop_map(|(one, other, same)| if same { [one, one] } else { [one, other] })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, ..ProptestConfig::default() })]

    /// Where products overflow, underflow, or lose their last digits.
    #[test]
    fn the_whole_range_of_doubles(
        (corners, o) in two_exponents().prop_flat_map(|e| (prop::array::uniform3(wide_point(e)), wide_point(e))),
        d in two_exponents().prop_flat_map(wide_point),
        steps in prop::array::uniform3(-1..=1i32),
        aim in any::<bool>(),
    ) {
        let [a, b, c] = corners;
        let d = if aim { a * 0.5 + b * 0.25 + c * 0.25 - o } else { d };
        let d = if d.is_finite() { d } else { Vec3::from([0.0, 5e-324, 1e300]) };
        prop_assume!(d != Vec3::ZERO);
        let line = |o| Ray::with_range(o, d, f64::NEG_INFINITY, f64::INFINITY);
        check(line(o), corners)?;
        let o = Vec3::from([nudge(o.x, steps[0]), nudge(o.y, steps[1]), nudge(o.z, steps[2])]);
        check(line(o), corners)?;
        let zero_area = [0, 1, 2].map(|i| exact(corners[i]));
        let normal = cross(&minus(&zero_area[1], &zero_area[0]), &minus(&zero_area[2], &zero_area[0]));
        prop_assert_eq!(is_zero_area(corners), normal.iter().all(Zero::is_zero));
    }

    /// Any coordinates whatever.
    #[test]
    fn any_finite_doubles(bits in prop::array::uniform5(prop::array::uniform3(any::<u64>()))) {
        let points = bits.map(|point| Vec3::from(point.map(f64::from_bits)));
        prop_assume!(points.into_iter().all(Vec3::is_finite));
        let [a, b, c, o, d] = points;
        check(Ray::with_range(o, d, f64::NEG_INFINITY, f64::INFINITY), [a, b, c])?;
        check(Ray::with_range(o, a, f64::NEG_INFINITY, f64::INFINITY), [a, b, c])?;
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4000, ..ProptestConfig::default() })]

    /// Corners on one line, nearly on one line, and not: in map coordinates differences round.
    #[test]
    fn triangles_without_area_are_told_from_thin_ones(
        a in grid_point(2), b in grid_point(2), times in -3..=3i32,
        unit in prop_oneof![Just(1.0), Just(0.1), Just(1e-9)],
        offset in prop_oneof![Just(0.0), Just(0.3), Just(1e7)],
        steps in prop::array::uniform3(-1..=1i32),
    ) {
        let shift = Vec3::splat(offset);
        let c = a + (b - a) * f64::from(times);
        let [a, b, c] = [a, b, c].map(|corner| corner * unit + shift);
        let nudged = [0, 1, 2].map(|axis| nudge(c[axis], steps[axis]));
        for corners in [[a, b, c], [a, b, Vec3::from(nudged)]] {
            let [p, q, r] = corners.map(exact);
            let normal = cross(&minus(&q, &p), &minus(&r, &p));
            prop_assert_eq!(is_zero_area(corners), normal.iter().all(Zero::is_zero), "{:?}", corners);
        }
    }
}

/// t halfway between two doubles goes to the even one, from wherever the ray comes.
#[test]
fn ties_of_t_are_rounded_to_even() {
    for k in 0..64 {
        // The distance from -1 to the plane takes 54 bits if k is odd.
        let z = 1.0 + f64::from(k) * f64::EPSILON;
        let corners = [[-1.0, -1.0, z], [1.0, -1.0, z], [0.0, 1.0, z]].map(Vec3::from);
        let [down, up] = [-1.0, 1.0].map(|z| Vec3::from([0.0, 0.0, z]));
        check(Ray::new(down, up), corners).expect("agrees with the judge");
        let flipped = corners.map(|corner| corner * -1.0);
        check(Ray::new(up, down), flipped).expect("agrees with the judge");
        let range = (f64::NEG_INFINITY, f64::INFINITY);
        check(Ray::with_range(down, down, range.0, range.1), corners).expect("agrees");
    }
}

#[test]
fn directions_with_denormal_components_are_ordinary() {
    let tiny = 5e-324;
    // The smallest direction reaches the nearer one at a t that a double can hold, and the farther
    // one beyond all doubles.
    for z in [1e-20, 1.0] {
        let corners = [[-1.0, -1.0, z], [1.0, -1.0, z], [0.0, 1.0, z]].map(Vec3::from);
        for direction in [
            [tiny, 0.0, 1.0],
            [0.0, -tiny, 1.0],
            [-0.0, 0.0, tiny],
            [tiny, tiny, tiny],
            [tiny, -tiny, 1e300],
            [0.0, tiny, f64::MAX],
        ] {
            check(Ray::new(Vec3::ZERO, direction.into()), corners).expect("agrees with the judge");
        }
    }
}

#[test]
fn invalid_rays_hit_nothing() {
    let up = Vec3::from([0.0, 0.0, 1.0]);
    let nan = Vec3::from([f64::NAN, 0.0, 0.0]);
    for ray in [
        Ray::new(nan, up),
        Ray::new(Vec3::ZERO, nan),
        Ray::new(Vec3::ZERO, Vec3::ZERO),
        Ray::new(Vec3::ZERO, Vec3::from([0.0, f64::INFINITY, 0.0])),
        Ray::with_range(Vec3::ZERO, up, 2.0, 1.0),
        Ray::with_range(Vec3::ZERO, up, f64::NAN, 1.0),
    ] {
        assert!(PreparedRay::new(&ray).is_none(), "{ray:?}");
    }
}

/// Every line through a closed surface crosses it an even number of times, and each shared edge
/// or vertex once: on a cube's surface cut into a grid, from the inside, along all directions of
/// a coarse grid, so that most rays pass through edges and vertices.
#[test]
fn crossings_of_a_closed_surface_have_the_right_parity() {
    // Each side of the cube [-2, 2]^3 as 4 x 4 squares, each cut in two.
    let mut triangles = Vec::new();
    for axis in 0..3 {
        for side in [-2.0, 2.0] {
            for i in -2..2 {
                for j in -2..2 {
                    let corner = |di: i32, dj: i32| {
                        let mut p = Vec3::ZERO;
                        p[axis] = side;
                        p[(axis + 1) % 3] = f64::from(i + di);
                        p[(axis + 2) % 3] = f64::from(j + dj);
                        p
                    };
                    triangles.push([corner(0, 0), corner(1, 0), corner(1, 1)]);
                    triangles.push([corner(0, 0), corner(1, 1), corner(0, 1)]);
                }
            }
        }
    }
    let range = -3..=3i32;
    let mut tried = 0;
    for (x, y, z) in range.clone().flat_map(|x| {
        let range = range.clone();
        range.clone().flat_map(move |y| range.clone().map(move |z| (x, y, z)))
    }) {
        let direction = Vec3::from([f64::from(x), f64::from(y), f64::from(z)]);
        for origin in [[0.0; 3], [1.0, 0.0, 0.0], [1.0, -1.0, 1.0], [0.5, 0.5, 0.0]].map(Vec3::from)
        {
            let Some(ray) = PreparedRay::new(&Ray::new(origin, direction)) else { continue };
            let crossings = triangles
                .iter()
                .filter(|corners| ray.meet(**corners).is_some_and(|c| c.is_crossing))
                .count();
            assert_eq!(crossings, 1, "from {origin:?} along {direction:?}");
            tried += 1;
        }
    }
    assert_eq!(tried, 342 * 4);
}
