//! Meshes and rays out of the fuzzer's bytes: coordinates that repeat, lie on grids, beside each
//! other by units in the last place, are tiny, huge or not finite; rays aimed at corners, edges and
//! faces, and cut where they hit.

use std::fmt::Write;

use arbitrary::{Arbitrary, Result, Unstructured};
use halfline::mesh::Positions;
use halfline::{Mesh, Ray, Vec3, brute_force};

/// Answers count for coordinates of at most 2^99 and, if they are no single-precision number, at
/// least 2^-99: within a factor of 1e30 of one, as the library promises.
const LARGEST_EXPONENT: i32 = 99;

const MOST_VERTICES: usize = 16;
const MOST_TRIANGLES: usize = 16;
const MOST_COPIES: usize = 5;
const MOST_RAYS: usize = 4;

/// Which coordinates there may be, besides those that are not finite.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Range {
    /// Those for which answers count.
    Promised,
    /// All numbers.
    Whole,
}

/// Everything that is asked.
pub struct QueryInput {
    /// The triangles.
    pub mesh: Mesh,
    /// The rays, one at least.
    pub rays: Vec<Ray>,
    /// Which trees to build.
    pub choice: u8,
}

impl QueryInput {
    /// Understands the bytes of the fuzzer.
    pub fn new(bytes: &[u8], range: Range) -> Result<QueryInput> {
        let u = &mut Unstructured::new(bytes);
        let style = Style::arbitrary(u, range)?;
        let choice = u8::arbitrary(u)?;
        let mesh = mesh(u, &style)?;
        let count = 1 + usize::from(u8::arbitrary(u)?) % MOST_RAYS;
        let rays = (0..count).map(|_| ray(u, &style, &mesh)).collect::<Result<_>>()?;
        Ok(QueryInput { mesh, rays, choice })
    }

    /// Rust that asks about ray `index`.
    pub fn as_snippet(&self, index: usize) -> String {
        let list = |x: Vec3| format!("{:?}", x.to_array()).replace("NaN", "f64::NAN");
        let list = |x: Vec3| list(x).replace("inf", "f64::INFINITY");
        let mut text = String::new();
        let kind = match self.mesh.positions() {
            Positions::F32(_) => "F32, each",
            Positions::F64(_) => "F64",
        };
        let _ = writeln!(text, "// {kind}\nlet vertices = [");
        for i in 0..self.mesh.positions().len() {
            let _ = writeln!(text, "    {},", list(self.mesh.positions().get(i)));
        }
        let _ = writeln!(text, "];\nlet triangles = {:?};", self.mesh.triangles());
        let Ray { origin, direction, t_min, t_max } = self.rays[index];
        let (origin, direction) = (list(origin), list(direction));
        let _ = write!(
            text,
            "let ray = Ray::with_range({origin}.into(), {direction}.into(), {t_min:?}, {t_max:?});"
        );
        text
    }
}

/// What coordinates of an input are like.
struct Style {
    /// They are multiplied by this power of two.
    scale: f64,
    /// They are rounded to single precision.
    single: bool,
    range: Range,
    /// Added to those on the grid, before they are scaled: far from the origin, as on maps.
    offset: f64,
}

impl Style {
    fn arbitrary(u: &mut Unstructured, range: Range) -> Result<Style> {
        let flags = u8::arbitrary(u)?;
        let exponent = i32::from(i8::arbitrary(u)?).clamp(-90, 90);
        let offset = if flags & 8 == 0 { 0.0 } else { f64::from(u16::arbitrary(u)?) * 256.0 };
        Ok(Style {
            scale: if flags & 4 == 0 { 1.0 } else { 2_f64.powi(exponent) },
            single: flags & 1 != 0,
            range,
            offset,
        })
    }

    /// A coordinate: most on a coarse grid, some beside it, some of any size.
    fn coordinate(&self, u: &mut Unstructured) -> Result<f64> {
        let kind = u8::arbitrary(u)?;
        let grid = f64::from(i8::arbitrary(u)?) * 0.25 + self.offset;
        let x = match kind {
            0..0x60 => grid.round() * self.scale,
            0x60..0x90 => grid * self.scale,
            0x90..0xb0 => step(grid * self.scale, i8::arbitrary(u)?, self.single),
            0xb0..0xc0 => f64::from(i32::arbitrary(u)?) * 2_f64.powi(-31) * self.scale,
            0xc0..0xd0 => 0.0_f64.copysign(grid),
            0xd0..0xe0 => {
                f64::from(f32::from_bits(u16::arbitrary(u)?.into()).copysign(grid as f32))
            }
            0xe0..0xf8 => f64::from_bits(u64::arbitrary(u)?),
            0xf8..0xfd => f64::from(i16::arbitrary(u)?) * 2_f64.powi((grid * 3.0) as i32),
            0xfd => f64::NAN,
            0xfe => f64::INFINITY,
            0xff => f64::NEG_INFINITY,
        };
        Ok(self.limit(x))
    }

    /// The nearest to `x` that the style allows, in range unless any number is.
    fn limit(&self, x: f64) -> f64 {
        if self.range == Range::Whole {
            return if self.single { f64::from(x as f32) } else { x };
        }
        let x = if x.is_finite() { into_range(x) } else { x };
        if self.single { f64::from(x as f32) } else { x }
    }

    fn vector(&self, u: &mut Unstructured) -> Result<Vec3> {
        Ok(Vec3::from([self.coordinate(u)?, self.coordinate(u)?, self.coordinate(u)?]))
    }

    fn limit_vector(&self, x: Vec3) -> Vec3 {
        Vec3::from(x.to_array().map(|x| self.limit(x)))
    }
}

/// `x` with its exponent brought into the range in which answers count; single-precision numbers
/// below it, denormal ones too, are left as they are.
fn into_range(x: f64) -> f64 {
    let is_small_single = x.abs() < 1.0 && f64::from(x as f32) == x;
    if x == 0.0 || is_small_single {
        return x;
    }
    let exponent = ((x.to_bits() >> 52) & 0x7ff) as i32 - 1023;
    let wrapped = if exponent.abs() <= LARGEST_EXPONENT - 1 {
        exponent
    } else {
        exponent.rem_euclid(2 * LARGEST_EXPONENT - 1) - (LARGEST_EXPONENT - 1)
    };
    f64::from_bits(x.to_bits() & !(0x7ff << 52) | ((wrapped + 1023) as u64) << 52)
}

/// The number `steps` units in the last place away from `x`.
fn step(x: f64, steps: i8, single: bool) -> f64 {
    if !x.is_finite() || x == 0.0 {
        return x;
    }
    let steps = steps / 16;
    if single {
        let bits = (x as f32).to_bits() as i32;
        return f64::from(f32::from_bits(bits.wrapping_add(i32::from(steps)) as u32));
    }
    f64::from_bits((x.to_bits() as i64).wrapping_add(i64::from(steps)) as u64)
}

/// A vertex: a new one, one between two earlier ones, or one beside an earlier one.
fn vertex(u: &mut Unstructured, style: &Style, earlier: &[Vec3]) -> Result<Vec3> {
    let kind = u8::arbitrary(u)?;
    if earlier.is_empty() || kind < 0xa0 {
        return style.vector(u);
    }
    let a = *u.choose(earlier)?;
    let vertex = match kind {
        0xa0..0xc8 => point_between(a, *u.choose(earlier)?, u)?,
        0xc8..0xe8 => {
            let steps = i8::arbitrary(u)?;
            let axis = usize::from(steps.unsigned_abs()) % 3;
            let mut b = a;
            b[axis] = step(b[axis], steps, style.single);
            b
        }
        _ => {
            let axis = usize::from(kind) % 3;
            let mut b = a;
            b[axis] = style.coordinate(u)?;
            b
        }
    };
    Ok(style.limit_vector(vertex))
}

/// A point on the line through two points, most often between them.
fn point_between(a: Vec3, b: Vec3, u: &mut Unstructured) -> Result<Vec3> {
    let share = f64::from(u8::arbitrary(u)?) / 128.0;
    Ok(a * (1.0 - share) + b * share)
}

/// A point of a face, or near to it.
fn target(u: &mut Unstructured, style: &Style, mesh: &Mesh) -> Result<Vec3> {
    if mesh.triangle_count() == 0 {
        return style.vector(u);
    }
    let face = usize::from(u8::arbitrary(u)?) % mesh.triangle_count();
    let [a, b, c] = mesh.corners(face as u32);
    let target = match u8::arbitrary(u)? % 5 {
        0 => a,
        1 => a * 0.5 + b * 0.5,
        2 => point_between(b, c, u)?,
        3 => {
            let p = point_between(a, b, u)?;
            point_between(p, c, u)?
        }
        _ => {
            let steps = i8::arbitrary(u)?;
            let axis = usize::from(steps.unsigned_abs()) % 3;
            let mut p = a;
            p[axis] = step(p[axis], steps, false);
            p
        }
    };
    Ok(target)
}

fn mesh(u: &mut Unstructured, style: &Style) -> Result<Mesh> {
    // Make vertices, and triangles that share them.
    let mut vertices = Vec::new();
    for _ in 0..usize::from(u8::arbitrary(u)?) % (MOST_VERTICES + 1) {
        vertices.push(vertex(u, style, &vertices)?);
    }
    let mut triangles = Vec::new();
    if !vertices.is_empty() {
        for _ in 0..usize::from(u8::arbitrary(u)?) % (MOST_TRIANGLES + 1) {
            let corners = <[u8; 3]>::arbitrary(u)?;
            triangles.push(corners.map(|i| u32::from(i) % vertices.len() as u32));
        }
    }

    // Copy all of it a few times, each a step further.
    let copies = usize::from(u8::arbitrary(u)?) % (MOST_COPIES + 1);
    let (vertex_count, triangle_count) = (vertices.len(), triangles.len());
    if copies > 0 {
        let offset = style.vector(u)?;
        for copy in 1..=copies {
            for i in 0..vertex_count {
                vertices.push(style.limit_vector(vertices[i] + offset * copy as f64));
            }
            for i in 0..triangle_count {
                let first = (copy * vertex_count) as u32;
                triangles.push(triangles[i].map(|corner| corner + first));
            }
        }
    }
    let positions = if style.single {
        let single = |p: &Vec3| p.to_array().map(|x| x as f32);
        Positions::F32(vertices.iter().map(single).collect())
    } else {
        Positions::F64(vertices.iter().map(|p| p.to_array()).collect())
    };
    Mesh::new(positions, triangles).map_err(|_| arbitrary::Error::IncorrectFormat)
}

fn ray(u: &mut Unstructured, style: &Style, mesh: &Mesh) -> Result<Ray> {
    let wide = Style { single: false, ..*style };
    let kind = u8::arbitrary(u)?;
    let origin = if kind & 1 == 0 { wide.vector(u)? } else { target(u, &wide, mesh)? };
    let origin = wide.limit_vector(origin);
    let direction = match kind >> 1 & 3 {
        0 => wide.vector(u)?,
        1 => {
            let axis = usize::from(kind >> 3) % 3;
            let mut direction = Vec3::ZERO;
            direction[axis] = if kind & 0x80 == 0 { style.scale } else { -style.scale };
            direction
        }
        _ => target(u, &wide, mesh)? - origin,
    };
    let line = Ray {
        origin,
        direction: wide.limit_vector(direction),
        t_min: f64::NEG_INFINITY,
        t_max: f64::INFINITY,
    };
    Ok(match u8::arbitrary(u)? % 8 {
        0 => line,
        1 => Ray { t_min: -1.0, t_max: 1.0, ..line },
        2 => Ray { t_min: f64::arbitrary(u)?, t_max: f64::arbitrary(u)?, ..line },
        // Cut where it hits.
        3 => {
            let t = brute_force::closest(mesh, &line).t;
            match u8::arbitrary(u)? % 3 {
                0 => Ray { t_max: t, ..line },
                1 => Ray { t_min: t, ..line },
                _ => Ray { t_min: t, t_max: t, ..line },
            }
        }
        _ => Ray { t_min: 0.0, ..line },
    })
}
