//! How settings are written as text, on the command line and in Python: vectors, colours, grounds,
//! lights. Each function gives the reason, in one line, why a text is none.

use halfline::geometry::{Vec3, vec3};

use crate::settings::{GroundSurface, Light};

/// A point or a vector, `X,Y,Z`.
pub fn vector(text: &str) -> Result<Vec3, String> {
    let [x, y, z] = numbers(text, "X,Y,Z")?;
    Ok(vec3(x, y, z))
}

/// A direction, `X,Y,Z` other than zero.
pub fn direction(text: &str) -> Result<Vec3, String> {
    match vector(text)? {
        Vec3::ZERO => Err("a direction cannot be zero".into()),
        direction => Ok(direction),
    }
}

/// A finite number.
pub fn finite(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err("expected a number".into()),
    }
}

/// An sRGB-encoded colour, `R,G,B` between 0 and 1, or `#RRGGBB`.
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

/// What the ground looks like: `shadow`, `checker`, or a colour.
pub fn ground_surface(text: &str) -> Result<GroundSurface, String> {
    match text {
        "shadow" => Ok(GroundSurface::Shadow),
        "checker" => Ok(GroundSurface::CHECKER),
        text => color(text)
            .map(GroundSurface::Matte)
            .map_err(|_| "expected shadow, checker, R,G,B in 0..1 or #RRGGBB".into()),
    }
}

/// A light, of the form `kind:name=value:name=value`. One of
/// - `point:position=X,Y,Z:intensity=I[:radius=R]`,
/// - `directional:direction=X,Y,Z[:irradiance=I][:angular-radius=DEGREES]`,
/// - `area:corner=X,Y,Z:edge-u=X,Y,Z:edge-v=X,Y,Z:radiance=I`,
///
/// where I is a number or `R,G,B`, linear.
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

/// The power of a light, `I` or `R,G,B`: linear, not negative.
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

    /// Fails if a field is left that the light does not have.
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
    fn vectors() {
        assert_eq!(vector("-1, 2.5,3e2"), Ok(vec3(-1.0, 2.5, 300.0)));
        for wrong in ["", "1,2", "1,2,3,4", "1,2,x", "1,2,inf", "1,2,nan"] {
            assert_eq!(vector(wrong), Err("expected X,Y,Z".into()), "{wrong}");
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
