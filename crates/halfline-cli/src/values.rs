//! How values are written on the command line: rays, pixels, sizes, numbers, names. Those of settings
//! alone are in [`halfline_render::text`].

use std::str::FromStr;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use halfline::Error;
use halfline::geometry::{Ray, vec3};
use halfline_render::MAX_PIXELS;
use halfline_render::text::finite;

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
        _ if high == f64::INFINITY && low == 0.0 && !ends_count => {
            Err("expected a number above 0".into())
        }
        _ if high == f64::INFINITY => Err(format!("expected a number of at least {low}")),
        _ if ends_count => Err(format!("expected a number from {low} to {high}")),
        _ => Err(format!("expected a number between {low} and {high}")),
    }
}

/// A value that has a name: any of `known`, of which `described` gives the name and a line for the help.
pub fn named<T, const N: usize>(
    known: [T; N],
    described: fn(T) -> (&'static str, &'static str),
) -> impl TypedValueParser<Value = T>
where
    T: FromStr<Err = Error> + Clone + Send + Sync + 'static,
{
    let values = known.map(|value| {
        let (name, line) = described(value);
        PossibleValue::new(name).help(line)
    });
    PossibleValuesParser::new(values).try_map(|name| name.parse())
}

/// The grammar of [`halfline_render::text::light`], for the help text.
pub const LIGHT_GRAMMAR: &str = "\
A light of --shading whitted; may be given several times. One of
  point:position=X,Y,Z:intensity=I[:radius=R]
  directional:direction=X,Y,Z[:irradiance=I][:angular-radius=DEGREES]
  area:corner=X,Y,Z:edge-u=X,Y,Z:edge-v=X,Y,Z:radiance=I
where I is a number or R,G,B, linear, and may exceed 1. A point at distance d receives I / d²";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn resolutions() {
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
}
