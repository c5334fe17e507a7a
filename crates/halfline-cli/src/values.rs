//! How values are written on the command line: vectors, colours, sizes, lights.

use halfline::geometry::{Ray, Vec3, vec3};
use halfline_render::{Light, MAX_PIXELS};

/// `X,Y,Z`
pub fn vector(text: &str) -> Result<Vec3, String> {
    let [x, y, z] = numbers(text, "X,Y,Z")?;
    Ok(vec3(x, y, z))
}

/// `X,Y,Z` other than zero.
pub fn direction(text: &str) -> Result<Vec3, String> {
    match vector(text)? {
        Vec3::ZERO => Err("a direction cannot be zero".into()),
        direction => Ok(direction),
    }
}

/// `OX,OY,OZ,DX,DY,DZ`, and if wanted the range of t.
pub fn ray(text: &str) -> Result<Ray, String> {
    const EXPECTED: &str = "expected OX,OY,OZ,DX,DY,DZ, and if wanted ,T_MIN,T_MAX";
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|n| n.trim().parse()).collect();
    let ray = match numbers.map_err(|_| EXPECTED)?[..] {
        [a, b, c, x, y, z] => Ray::new(vec3(a, b, c), vec3(x, y, z)),
        [a, b, c, x, y, z, t_min, t_max] => {
            Ray::with_range(vec3(a, b, c), vec3(x, y, z), t_min, t_max)
        }
        _ => return Err(EXPECTED.into()),
    };
    halfline::explain::check(&ray).map_err(|error| error.to_string())?;
    Ok(ray)
}

/// `COLUMN,ROW` of a pixel.
pub fn pixel(text: &str) -> Result<(u32, u32), String> {
    let numbers: Vec<_> = text.split(',').map(|number| number.trim().parse()).collect();
    match numbers[..] {
        [Ok(column), Ok(row)] => Ok((column, row)),
        _ => Err("expected COLUMN,ROW, counted from 0 at the top left".into()),
    }
}

/// `WIDTH,HEIGHT` in pixels.
pub fn resolution(text: &str) -> Result<(u32, u32), String> {
    let sides: Vec<_> = text.split([',', 'x']).map(|side| side.trim().parse::<u32>()).collect();
    match sides[..] {
        [Ok(width @ 1..), Ok(height @ 1..)] => {
            if u64::from(width) * u64::from(height) > MAX_PIXELS {
                Err(format!("more than {MAX_PIXELS} pixels"))
            } else {
                Ok((width, height))
            }
        }
        _ => Err("expected WIDTH,HEIGHT in pixels, as in 1280,720".into()),
    }
}

/// `R,G,B` between 0 and 1, or `#RRGGBB`: sRGB-encoded.
pub fn color(text: &str) -> Result<[f32; 3], String> {
    const EXPECTED: &str = "expected R,G,B between 0 and 1, or #RRGGBB";
    if let Some(digits) = text.strip_prefix('#') {
        if digits.len() != 6 || !digits.bytes().all(|b| b.is_ascii_hexdigit()) {
            return Err(EXPECTED.into());
        }
        let value = u32::from_str_radix(digits, 16).map_err(|_| EXPECTED)?;
        return Ok([16, 8, 0].map(|shift| (value >> shift & 255) as f32 / 255.0));
    }
    let [r, g, b] = numbers(text, "").map_err(|_| EXPECTED)?;
    if [r, g, b].iter().all(|c| (0.0..=1.0).contains(c)) {
        Ok([r as f32, g as f32, b as f32])
    } else {
        Err(EXPECTED.into())
    }
}

/// A whole number, which may end in k or M.
pub fn count(text: &str) -> Result<usize, String> {
    const EXPECTED: &str = "expected a whole number of at least 1, as in 250000, 250k or 5.5M";
    let (digits, factor) = match text.char_indices().next_back() {
        Some((at, 'k' | 'K')) => (&text[..at], 1e3),
        Some((at, 'M')) => (&text[..at], 1e6),
        _ => return text.parse().ok().filter(|&count| count > 0).ok_or(EXPECTED.into()),
    };
    let count = finite(digits).map_err(|_| EXPECTED)? * factor;
    // Rounding forgives that 5.5 or 0.1 are no binary fractions.
    let whole = count.round();
    let exact = (count - whole).abs() <= f64::EPSILON * whole;
    match exact && (1.0..1e15).contains(&whole) {
        true => Ok(whole as usize),
        false => Err(EXPECTED.into()),
    }
}

/// A number within a range, for messages that name the range.
pub fn within(
    low: f64,
    high: f64,
    ends_count: bool,
) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    move |text| match text.trim().parse::<f64>() {
        Ok(value) if low < value && value < high => Ok(value),
        Ok(value) if ends_count && (value == low || value == high) && value.is_finite() => {
            Ok(value)
        }
        _ if high == f64::INFINITY && low == 0.0 => Err("expected a number above 0".into()),
        _ if high == f64::INFINITY => Err(format!("expected a number of at least {low}")),
        _ if ends_count => Err(format!("expected a number from {low} to {high}")),
        _ => Err(format!("expected a number between {low} and {high}")),
    }
}

/// A finite number.
pub fn finite(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err("expected a number".into()),
    }
}

/// The grammar of [`light`], for the help text.
pub const LIGHT_GRAMMAR: &str = "\
A light of --shading whitted; may be given several times. One of
  point:position=X,Y,Z:intensity=I[:radius=R]
  directional:direction=X,Y,Z[:irradiance=I][:angular-radius=DEGREES]
  area:corner=X,Y,Z:edge-u=X,Y,Z:edge-v=X,Y,Z:radiance=I
where I is a number or R,G,B, linear, and may exceed 1. A point at distance d receives I / d²";

/// A light, in the grammar of [`LIGHT_GRAMMAR`].
pub fn light(text: &str) -> Result<Light, String> {
    let (kind, rest) = text.split_once(':').unwrap_or((text, ""));
    let mut fields = Fields::parse(rest)?;
    let light = match kind {
        "point" => Light::Point {
            position: fields.required("position", vector)?,
            intensity: fields.required("intensity", power)?,
            radius: fields.optional("radius", finite)?.unwrap_or(0.0),
        },
        "directional" => Light::Directional {
            direction: fields.required("direction", direction)?,
            // A white surface that faces the light is then seen white.
            irradiance: fields.optional("irradiance", power)?.unwrap_or([std::f32::consts::PI; 3]),
            angular_radius: fields.optional("angular-radius", finite)?.unwrap_or(0.0),
        },
        "area" => Light::Area {
            corner: fields.required("corner", vector)?,
            edge_u: fields.required("edge-u", direction)?,
            edge_v: fields.required("edge-v", direction)?,
            radiance: fields.required("radiance", power)?,
        },
        other => return Err(format!("`{other}` is none of point, directional, area")),
    };
    fields.finish()?;
    Ok(light)
}

/// `I` or `R,G,B`: linear, not negative.
fn power(text: &str) -> Result<[f32; 3], String> {
    let power = match text.contains(',') {
        true => numbers(text, "R,G,B")?,
        false => [finite(text)?; 3],
    };
    match power.iter().all(|c| *c >= 0.0) {
        true => Ok(power.map(|c| c as f32)),
        false => Err("light cannot be negative".into()),
    }
}

fn numbers<const N: usize>(text: &str, form: &str) -> Result<[f64; N], String> {
    let numbers: Vec<f64> =
        text.split(',').map(finite).collect::<Result<_, _>>().map_err(|_| expected(form))?;
    numbers.try_into().map_err(|_| expected(form))
}

fn expected(form: &str) -> String {
    format!("expected {form}")
}

/// `name=value` fields, separated by colons.
struct Fields<'a> {
    fields: Vec<(&'a str, &'a str)>,
}

impl<'a> Fields<'a> {
    fn parse(text: &'a str) -> Result<Fields<'a>, String> {
        let fields = text.split(':').filter(|field| !field.is_empty()).map(|field| {
            field.split_once('=').ok_or_else(|| format!("`{field}` is not of the form name=value"))
        });
        Ok(Fields { fields: fields.collect::<Result<_, _>>()? })
    }

    fn optional<T>(
        &mut self,
        name: &str,
        parse: impl Fn(&str) -> Result<T, String>,
    ) -> Result<Option<T>, String> {
        let Some(at) = self.fields.iter().position(|(n, _)| *n == name) else { return Ok(None) };
        let (_, value) = self.fields.remove(at);
        parse(value).map(Some).map_err(|reason| format!("{name}: {reason}"))
    }

    fn required<T>(
        &mut self,
        name: &str,
        parse: impl Fn(&str) -> Result<T, String>,
    ) -> Result<T, String> {
        self.optional(name, parse)?.ok_or_else(|| format!("{name}= is missing"))
    }

    /// Fails if a field is left that nobody asked for.
    fn finish(self) -> Result<(), String> {
        match self.fields.first() {
            Some((name, _)) => Err(format!("`{name}` is unknown here, or given twice")),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_and_resolutions() {
        assert_eq!(vector("-1, 2.5,3e2"), Ok(vec3(-1.0, 2.5, 300.0)));
        for wrong in ["", "1,2", "1,2,3,4", "1,2,x", "1,2,inf", "1,2,nan"] {
            assert_eq!(vector(wrong), Err("expected X,Y,Z".into()), "{wrong}");
        }
        assert_eq!(resolution("640,480"), Ok((640, 480)));
        assert_eq!(resolution("640x480"), Ok((640, 480)));
        for wrong in ["640", "0,480", "-1,5", "1,2,3", "99999,99999", "4294967296,1"] {
            assert!(resolution(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn counts() {
        let texts = ["1", "250000", "250k", "5.5M", "0.1k", "1.1k"];
        let counts = [1, 250_000, 250_000, 5_500_000, 100, 1100];
        assert_eq!(texts.map(count), counts.map(Ok));
        for wrong in ["", "k", "0", "0M", "-1", "-1k", "1.5", "0.0001k", "1e3000M", "nanM", "7é"] {
            assert!(count(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn colors() {
        assert_eq!(color("0,0.5,1"), Ok([0.0, 0.5, 1.0]));
        assert_eq!(color("#ff8000"), Ok([1.0, 128.0 / 255.0, 0.0]));
        for wrong in ["", "#ff80", "#ff80zz", "#+f8000", "0,0,1.1", "-0.1,0,0", "red", "#ff80é"] {
            assert!(color(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn ranges() {
        let angle = within(0.0, 180.0, false);
        assert_eq!(angle("30"), Ok(30.0));
        for wrong in ["0", "180", "-1", "nan", "x"] {
            assert_eq!(angle(wrong), Err("expected a number between 0 and 180".into()));
        }
        let share = within(0.0, 1.0, true);
        assert_eq!((share("0"), share("1")), (Ok(0.0), Ok(1.0)));
        assert!(share("1.01").is_err() && share("-0.01").is_err());
        assert!(within(1.0, f64::INFINITY, true)("inf").is_err());
    }

    #[test]
    fn lights() {
        assert_eq!(
            light("point:position=1,2,3:intensity=10:radius=0.5"),
            Ok(Light::Point { position: vec3(1.0, 2.0, 3.0), intensity: [10.0; 3], radius: 0.5 })
        );
        assert_eq!(
            light("directional:irradiance=1,2,3:direction=0,-1,0"),
            Ok(Light::Directional {
                direction: vec3(0.0, -1.0, 0.0),
                irradiance: [1.0, 2.0, 3.0],
                angular_radius: 0.0
            })
        );
        for (wrong, reason) in [
            ("lamp", "`lamp` is none of point, directional, area"),
            ("point", "position= is missing"),
            ("point:1,2,3", "`1,2,3` is not of the form name=value"),
            ("point:position=1,2", "position: expected X,Y,Z"),
            ("point:position=1,2,3:intensity=-1", "intensity: light cannot be negative"),
            ("directional:direction=0,0,0", "direction: a direction cannot be zero"),
            ("directional:direction=0,0,1:radius=2", "`radius` is unknown here, or given twice"),
        ] {
            assert_eq!(light(wrong), Err(reason.into()), "{wrong}");
        }
    }
}
