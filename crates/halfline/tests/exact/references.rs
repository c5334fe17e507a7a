//! The exact judges against each other: integers, rationals, and rays that are really moved.

use crate::common::contact::ExactContact;
use crate::common::exact as rational;
use crate::common::exact::{Q, crosses, exact, meeting_of_points, nearest_double};
use crate::common::grid::{aimed_at, fans, needles, plates, soups, stacks};
use crate::common::integer::nearest_quotient;
use num_rational::BigRational;
use num_traits::Signed;
use proptest::prelude::*;

fn any_faces() -> impl Strategy<Value = Vec<[crate::common::integer::Point; 3]>> {
    let few = |faces: Vec<[crate::common::integer::Point; 3]>| faces.into_iter().take(12).collect();
    prop_oneof![soups(), plates(), fans(), stacks(), needles()].prop_map(few)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]

    #[test]
    fn integers_and_rationals_agree((grid, aims) in aimed_at(any_faces())) {
        let mesh = grid.to_mesh();
        for aim in aims.iter().take(8) {
            let line = aim.line(&grid.faces);
            let by_rationals = rational::contacts(&mesh, &grid.to_ray(&line));
            prop_assert_eq!(grid.contacts(&line), by_rationals, "{:?}", line);
        }
    }

    /// The infinitesimal in person: e = 2^-300 is small enough for numbers as coarse as these.
    #[test]
    fn crossings_are_those_of_rays_that_are_moved((mut grid, aims) in aimed_at(any_faces())) {
        grid.unit = 0;
        let mesh = grid.to_mesh();
        for aim in aims.iter().take(4) {
            let line = aim.line(&grid.faces);
            let ray = grid.to_ray(&crate::common::integer::GridLine { speed: 0, ..line });
            let e = Q::from_float(2f64.powi(-300)).expect("finite");
            let [x, y, z] = exact(ray.origin);
            let origin = [x + &e, y + &e * &e, z + &e * &e * &e];
            for face in 0..mesh.triangle_count() as u32 {
                let corners = mesh.corners(face);
                let moved = meeting_of_points(&origin, &exact(ray.direction), &corners.map(exact));
                // A moved line meets no edge at all.
                if let Some([_, u, v]) = &moved {
                    prop_assert!(u.is_positive() && v.is_positive() && u + v < Q::new(1.into(), 1.into()));
                }
                prop_assert_eq!(crosses(&ray, corners), moved.is_some(), "{:?} {:?}", ray, corners);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 20_000, ..ProptestConfig::default() })]

    #[test]
    fn integer_quotients_are_rounded_as_rationals(
        n in -(1i128 << 66)..=1 << 66, d in 1..=1i128 << 66, cut in prop::array::uniform2(0..66u32),
    ) {
        let (n, d) = (n >> cut[0], (d >> cut[1]).max(1));
        let exact = BigRational::new(n.into(), d.into());
        prop_assert_eq!(nearest_quotient(n, d), nearest_double(&exact), "{} / {}", n, d);
        prop_assert_eq!(nearest_quotient(n, -d), nearest_double(&-exact), "{} / {}", n, -d);
    }
}

#[test]
fn quotients_halfway_between_two_doubles_go_to_the_even_one() {
    let whole = 1i128 << 53;
    for (n, d, expected) in [
        (whole + 1, 1, 2f64.powi(53)),
        (whole + 3, 1, 2f64.powi(53) + 4.0),
        (2 * whole + 2, 1 << 60, 2f64.powi(-6)),
        (3 * (whole + 1), 3, 2f64.powi(53)),
        (3 * (whole + 1) + 1, 3, 2f64.powi(53) + 2.0),
    ] {
        assert_eq!(nearest_quotient(n, d), expected, "{n} / {d}");
        assert_eq!(nearest_quotient(-n, d), -expected, "-{n} / {d}");
    }
    assert_eq!(nearest_quotient(0, -1).to_bits(), 0);
}

/// A case worked out by hand: a ray straight down on a square's diagonal, and along its side.
#[test]
fn a_ray_on_a_diagonal_touches_both_triangles_and_crosses_one() {
    let corner = |x: i128, y: i128| [4 * x, 4 * y, 0];
    let grid = crate::common::integer::GridMesh {
        faces: vec![
            [corner(0, 0), corner(1, 0), corner(1, 1)],
            [corner(0, 0), corner(1, 1), corner(0, 1)],
        ],
        unit: -2,
    };
    let down = crate::common::integer::GridLine {
        origin: [1, 1, 8],
        direction: [0, 0, -1],
        speed: 1,
        has_negative_zeros: false,
    };
    // The origin is moved by e along x before all else: into the triangle on the right.
    let touch = |face, is_crossing, u, v| {
        let is_on_border = false;
        ExactContact { face, t: 1.0, u, v, is_crossing, is_on_border }
    };
    let expected = vec![touch(0, true, 0.0, 0.25), touch(1, false, 0.25, 0.0)];
    assert_eq!(grid.contacts(&down), expected);
    let along =
        crate::common::integer::GridLine { origin: [-4, 0, 0], direction: [1, 0, 0], ..down };
    assert_eq!(grid.contacts(&along), Vec::new());
    // In the middle of the open side on the right, and at the corner where the sides on the right
    // and at the front meet, the ray is moved off the square.
    for (origin, u, v) in [([4, 2, 8], 0.5, 0.5), ([4, 0, 8], 1.0, 0.0)] {
        let found = grid.contacts(&crate::common::integer::GridLine { origin, ..down });
        assert_eq!(found, [ExactContact { is_on_border: true, ..touch(0, false, u, v) }]);
        let ray = grid.to_ray(&crate::common::integer::GridLine { origin, ..down });
        assert_eq!(rational::contacts(&grid.to_mesh(), &ray), found);
    }
}
