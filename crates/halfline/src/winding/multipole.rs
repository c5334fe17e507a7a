//! The solid angle of a surface that is far away, by the moments of its area.
//!
//! The solid angle of a surface S seen from p is the flux of `(x - p) / |x - p|^3` through it. With x = c + y,
//! R = c - p and the expansion of 1/|R + y| in powers of y (E. W. Hobson, "The Theory of Spherical and
//! Ellipsoidal Harmonics", 1931), it is the sum over n >= 1 of
//!
//! ```text
//! (-1)^(n+1) (2n-1)!! / (n-1)!  H[ integral over S of (dA . R) (y . R)^(n-1) ]  /  |R|^(2n+1)
//! ```
//!
//! where H takes the harmonic part of a polynomial in R. For a triangle with area vector N and corners y0, y1, y2 the
//! integral is `(N . R) 2 (n-1)! / (n+1)!` times the sum of all monomials of degree n - 1 in the numbers yi . R.
//! The gradient of the term of degree n of 1/|R + y| is at most n |y|^(n-1) / |R|^(n+1) long, so with area A within r
//! of c, and rho = r / |R|, all terms beyond the [`DEGREE`]-th, K, amount to no more than
//!
//! ```text
//! A / |R|^2  sum over n > K of n rho^(n-1)  =  A / |R|^2  ((K + 1) - K rho) rho^K / (1 - rho)^2.
//! ```

use crate::geometry::Vec3;

/// The degree of the last term that is taken.
pub const DEGREE: usize = 6;

/// Monomials of the largest degree.
const WIDTH: usize = (DEGREE + 1) * (DEGREE + 2) / 2;

/// Monomials of the degrees 0 to [`DEGREE`].
pub const COEFFICIENTS: usize = (DEGREE + 1) * (DEGREE + 2) * (DEGREE + 3) / 6;

/// A homogeneous polynomial in three variables, of a degree that its user knows; monomials by [`place`].
type Polynomial = [f64; WIDTH];

const ZERO: Polynomial = [0.0; WIDTH];

/// The place of x^i y^j z^(degree - i - j) among the monomials of a degree: the larger i first, then the larger j.
const fn place(degree: usize, i: usize, j: usize) -> usize {
    let rest = degree - i;
    rest * (rest + 1) / 2 + rest - j
}

/// The moments of a surface within a ball, in units of its radius.
#[derive(Clone, Debug)]
pub struct Moments {
    sums: [Polynomial; DEGREE],
    /// The area of all triangles together.
    pub area: f64,
}

impl Moments {
    /// Of no surface.
    pub fn none() -> Moments {
        Moments { sums: [ZERO; DEGREE], area: 0.0 }
    }

    /// Takes a triangle, given from the ball's centre.
    pub fn add(&mut self, [a, b, c]: [Vec3; 3]) {
        let normal = (b - a).cross(c - a) * 0.5;
        self.area += normal.length();
        // For each degree all monomials in the first corner alone, in the first two, in all three.
        let mut of_corners = [ZERO; 3];
        of_corners.iter_mut().for_each(|sum| sum[0] = 1.0);
        let mut factor = 1.0;
        for degree in 1..=DEGREE {
            if degree > 1 {
                let mut previous = ZERO;
                for (sum, corner) in of_corners.iter_mut().zip([a, b, c]) {
                    let more = times(sum, degree - 2, corner);
                    *sum = std::array::from_fn(|i| previous[i] + more[i]);
                    previous = *sum;
                }
            }
            // 2 (2n-1)!! / (n+1)!, with the sign.
            if degree > 1 {
                factor *= -((2 * degree - 1) as f64) / (degree + 1) as f64;
            }
            let flux = times(&of_corners[2], degree - 1, normal);
            let sum = &mut self.sums[degree - 1];
            for i in 0..WIDTH {
                sum[i] += factor * flux[i];
            }
        }
    }

    /// The coefficients of the harmonic parts: those with the highest power of x first, and for each power by
    /// the place of their rest.
    pub fn harmonic(&self) -> [f64; COEFFICIENTS] {
        let mut parts = [ZERO; DEGREE + 1];
        for degree in 1..=DEGREE {
            parts[degree] = harmonic_part(&self.sums[degree - 1], degree);
        }
        let (mut all, mut at) = ([0.0; COEFFICIENTS], 0);
        for power in (0..=DEGREE).rev() {
            for rest in 0..=DEGREE - power {
                for place in rest * (rest + 1) / 2..(rest + 1) * (rest + 2) / 2 {
                    all[at] = parts[power + rest][place];
                    at += 1;
                }
            }
        }
        all
    }
}

/// A polynomial times a linear one.
fn times(polynomial: &Polynomial, degree: usize, by: Vec3) -> Polynomial {
    let mut product = ZERO;
    for i in 0..=degree {
        for j in 0..=degree - i {
            let coefficient = polynomial[place(degree, i, j)];
            product[place(degree + 1, i + 1, j)] += coefficient * by.x;
            product[place(degree + 1, i, j + 1)] += coefficient * by.y;
            product[place(degree + 1, i, j)] += coefficient * by.z;
        }
    }
    product
}

/// What is left of a polynomial without its multiples of x^2 + y^2 + z^2.
fn harmonic_part(polynomial: &Polynomial, degree: usize) -> Polynomial {
    // Q - r^2 L Q / (2 (2n-1)) + r^4 L^2 Q / (2 4 (2n-1) (2n-3)) - ..., where L is the Laplacian.
    let (mut part, mut derived, mut factor) = (*polynomial, *polynomial, 1.0);
    for step in 1..=degree / 2 {
        derived = laplacian(&derived, degree - 2 * (step - 1));
        factor *= -1.0 / ((2 * step) as f64 * (2 * degree + 1 - 2 * step) as f64);
        let mut term = derived;
        for i in 0..step {
            term = times_square(&term, degree - 2 * step + 2 * i);
        }
        for i in 0..WIDTH {
            part[i] += factor * term[i];
        }
    }
    part
}

fn laplacian(polynomial: &Polynomial, degree: usize) -> Polynomial {
    let mut derived = ZERO;
    for i in 0..=degree {
        for j in 0..=degree - i {
            let (coefficient, k) = (polynomial[place(degree, i, j)], degree - i - j);
            let twice = |power: usize| coefficient * (power * power.saturating_sub(1)) as f64;
            if i >= 2 {
                derived[place(degree - 2, i - 2, j)] += twice(i);
            }
            if j >= 2 {
                derived[place(degree - 2, i, j - 2)] += twice(j);
            }
            if k >= 2 {
                derived[place(degree - 2, i, j)] += twice(k);
            }
        }
    }
    derived
}

fn times_square(polynomial: &Polynomial, degree: usize) -> Polynomial {
    let mut product = ZERO;
    for i in 0..=degree {
        for j in 0..=degree - i {
            let coefficient = polynomial[place(degree, i, j)];
            product[place(degree + 2, i + 2, j)] += coefficient;
            product[place(degree + 2, i, j + 2)] += coefficient;
            product[place(degree + 2, i, j)] += coefficient;
        }
    }
    product
}

/// The solid angle of a surface whose centre is at `from_point` from the point, within `radius`.
#[inline(always)]
pub fn far_solid_angle(coefficients: &[f64; COEFFICIENTS], from_point: Vec3, radius: f64) -> f64 {
    let inverse = 1.0 / from_point.dot(from_point);
    let rho = radius * inverse.sqrt();
    let Vec3 { x, y, z } = from_point * (radius * inverse);
    // For each monomial in y and z a polynomial in x: all of them at once, by Horner's rule.
    let (mut sums, mut rest) = (ZERO, &coefficients[..]);
    horner_step::<1>(&mut sums, &mut rest, x);
    horner_step::<3>(&mut sums, &mut rest, x);
    horner_step::<6>(&mut sums, &mut rest, x);
    horner_step::<10>(&mut sums, &mut rest, x);
    horner_step::<15>(&mut sums, &mut rest, x);
    horner_step::<21>(&mut sums, &mut rest, x);
    horner_step::<28>(&mut sums, &mut rest, x);
    // Times y^m, y^(m-1) z, ..., z^m.
    let (y2, z2) = (y * y, z * z);
    let (y3, z3) = (y2 * y, z2 * z);
    let (y4, z4) = (y2 * y2, z2 * z2);
    let (y5, z5, y6, z6) = (y4 * y, z4 * z, y3 * y3, z3 * z3);
    let s = &sums;
    let low = (s[0] + (s[1] * y + s[2] * z)) + ((s[3] * y2 + s[5] * z2) + s[4] * (y * z));
    let third = (s[6] * y3 + s[9] * z3) + (s[7] * (y2 * z) + s[8] * (y * z2));
    let fourth =
        (s[10] * y4 + s[14] * z4) + ((s[11] * (y3 * z) + s[13] * (y * z3)) + s[12] * (y2 * z2));
    let fifth = ((s[15] * y5 + s[20] * z5) + (s[16] * (y4 * z) + s[19] * (y * z4)))
        + (s[17] * (y3 * z2) + s[18] * (y2 * z3));
    let sixth = ((s[21] * y6 + s[27] * z6) + (s[22] * (y5 * z) + s[26] * (y * z5)))
        + ((s[23] * (y4 * z2) + s[25] * (y2 * z4)) + s[24] * (y3 * z3));
    rho * ((low + third) + (fourth + (fifth + sixth)))
}

/// `sums * x + coefficients` for the first `N`, whose coefficients are dropped then.
#[inline(always)]
fn horner_step<const N: usize>(sums: &mut Polynomial, coefficients: &mut &[f64], x: f64) {
    let (these, rest) = coefficients.split_at(N);
    for i in 0..N {
        sums[i] = sums[i] * x + these[i];
    }
    *coefficients = rest;
}

/// For a surface of some area, in units of its radius squared: the largest radius over distance for which the solid
/// angle is off by no more than `tolerance`; at most [`LARGEST_RATIO`].
pub fn largest_ratio(area: f64, tolerance: f64) -> f64 {
    let (mut low, mut high) = (0.0, LARGEST_RATIO);
    if remainder(area, high) <= tolerance {
        return high;
    }
    for _ in 0..RATIO_STEPS {
        let middle = 0.5 * (low + high);
        if remainder(area, middle) <= tolerance {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// A point that is so near, in terms of the radius, is well outside of the ball.
pub const LARGEST_RATIO: f64 = 0.8;

/// Bisections until a ratio is good to a few digits; below, it is on the safe side.
const RATIO_STEPS: usize = 24;

/// What the terms that are left out amount to, and the roundings of those that are taken.
fn remainder(area: f64, ratio: f64) -> f64 {
    let last = DEGREE as f64;
    let tail = (last + 1.0 - last * ratio) * ratio.powi(DEGREE as i32) / (1.0 - ratio).powi(2);
    area * ratio * ratio * (tail + ROUNDING)
}

/// Surfaces of more triangles are not seen from afar.
pub const MOST_TRIANGLES: usize = 1 << 16;

/// What is wrong with the terms that are taken, in terms of the area over the distance squared. Sums over up to
/// [`MOST_TRIANGLES`] are off by 2^-37 of their permanents, and what is computed before and after by some ten
/// roundings. At the largest ratio the terms, by the bound of their gradients, sum to no more than 25, the sum
/// of n 0.8^(n-1).
const ROUNDING: f64 = 1.0 / (1_u64 << 34) as f64;
