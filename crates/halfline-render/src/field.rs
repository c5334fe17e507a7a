//! Pictures of a mesh on whose surface numbers lie, such as distances to another one.

use halfline::Scene;
use halfline::error::{Error, Result};
use halfline::mesh::Mesh;
use halfline::progress::Observer;

use crate::assemble::assemble;
use crate::color_bar::{ColorBar, Markings};
use crate::color_scale::ColorScale;
use crate::image::Rendering;
use crate::plan::Plan;
use crate::settings::RenderSettings;
use crate::world::Surface;

/// Encoded grey of lines and letters, before the bright backdrop.
const INK: f32 = 0.15;

/// Numbers on one side of zero.
const INTERVALS: i32 = 4;

/// A number for each vertex of a mesh, with the colours that show it.
///
/// Between vertices the numbers are interpolated and not the colours, so that a limit runs through a
/// triangle as a line, and no colour is seen that the scale does not have.
pub struct VertexField {
    /// One for each vertex; NaN where there is none.
    pub values: Vec<f64>,
    /// Their colours.
    pub scale: ColorScale,
    /// What the numbers are, in lower-case letters: it stands beside the scale.
    pub caption: &'static str,
}

impl VertexField {
    /// Where the scale goes in a picture.
    pub(crate) fn color_bar(&self, width: u32, height: u32) -> ColorBar {
        let longest = self.ticks().iter().map(|(_, number)| number.len()).max();
        ColorBar::new(width, height, longest.unwrap_or(0))
    }

    /// The sRGB-encoded colour of a place on the mesh.
    pub(crate) fn color(&self, mesh: &Mesh, surface: &Surface) -> [f32; 3] {
        let [u, v] = surface.uv;
        let corners = mesh.triangles()[surface.face as usize];
        let weights = [1.0 - u - v, u, v];
        let value: f64 = corners
            .iter()
            .zip(weights)
            .map(|(&vertex, weight)| weight * self.values[vertex as usize])
            .sum();
        self.scale.color(value)
    }

    /// Draws the scale over a picture.
    fn draw_scale(&self, picture: &mut Rendering) {
        let (lowest, range) = (self.scale.lowest(), self.scale.range());
        let color = |share: f32| self.scale.color(lowest + f64::from(share) * (range - lowest));
        let (ticks, caption) = (self.ticks(), self.caption);
        let markings = Markings { color: &color, ticks: &ticks, caption, ink: INK };
        self.color_bar(picture.width, picture.height).draw(&mut picture.color, &markings);
    }

    /// The numbers on the scale, the most important first, each with its share of it.
    fn ticks(&self) -> Vec<(f64, String)> {
        let (lowest, range) = (self.scale.lowest(), self.scale.range());
        let side = |size: f64| match lowest < 0.0 {
            true => vec![-size, size],
            false => vec![size],
        };
        let mut numbers: Vec<f64> = self.scale.tolerance().map_or(Vec::new(), side);
        numbers.push(0.0);
        for i in (1..=INTERVALS).rev() {
            numbers.append(&mut side(range * f64::from(i) / f64::from(INTERVALS)));
        }
        let beyond = |value: f64| {
            let is_end = value == range || value == lowest && lowest < 0.0;
            let is_beyond = |other: &f64| match value > 0.0 {
                true => *other > range,
                false => *other < lowest,
            };
            if is_end && self.values.iter().any(is_beyond) { "+" } else { "" }
        };
        let tick = |value: f64| ((value - lowest) / (range - lowest), short(value) + beyond(value));
        numbers.into_iter().map(tick).collect()
    }
}

/// A number in at most some seven characters.
fn short(value: f64) -> String {
    // Fractions of a round number are decimals of few digits, but for what they are rounded by.
    let rounded: f64 = format!("{value:.3e}").parse().unwrap_or(value);
    match rounded.abs() {
        size if size == 0.0 || (1e-4..1e6).contains(&size) => format!("{rounded}"),
        _ => format!("{rounded:e}"),
    }
}

/// Draws `scene` as `settings` ask, coloured by the numbers of `field`, with a scale at the picture's
/// right, reporting as [`render`](crate::render) does.
///
/// # Errors
/// Those of [`render`](crate::render), and [`Error::Invalid`] unless there is a number for each vertex.
pub fn render_field(
    scene: &Scene,
    field: VertexField,
    settings: &RenderSettings,
    observer: &dyn Observer,
) -> Result<Rendering> {
    observer.check()?;
    let (expected, found) = (scene.mesh().positions().len(), field.values.len());
    if found != expected {
        let reason = format!("expected a value for each of {expected} vertices, found {found}");
        return Err(Error::invalid("field", reason));
    }
    let plan = Plan::of_field(scene, settings, field)?;
    let rows = plan.trace_rows(0..settings.height, observer)?;
    let mut picture = assemble(settings, [rows])?;
    if let Some(field) = plan.field() {
        field.draw_scale(&mut picture);
    }
    Ok(picture)
}

#[cfg(test)]
mod tests {
    use super::*;
    use halfline::geometry::NO_FACE;
    use halfline::progress::NoProgress;
    use halfline::vec3;

    fn field(values: Vec<f64>, tolerance: Option<f64>) -> VertexField {
        let scale = ColorScale::new(true, 1.0, tolerance).unwrap();
        VertexField { values, scale, caption: "signed distance" }
    }

    #[test]
    fn the_scale_tells_its_ends_its_middle_and_the_tolerance() {
        let field = field(vec![-0.2, 3.0], Some(0.3));
        let texts: Vec<String> = field.ticks().into_iter().map(|(_, text)| text).collect();
        let expected =
            ["-0.3", "0.3", "0", "-1", "1+", "-0.75", "0.75", "-0.5", "0.5", "-0.25", "0.25"];
        assert_eq!(texts, expected);
    }

    #[test]
    fn numbers_are_short() {
        let numbers = [0.1 + 0.2, -2.5e-5, 1.25e7, 0.0005, 750_000.0];
        assert_eq!(numbers.map(short), ["0.3", "-2.5e-5", "1.25e7", "0.0005", "750000"]);
    }

    /// A square that goes from -1 at its left edge to 1 at its right one: left of the middle it is blue,
    /// right of it red, and within the tolerance green.
    #[test]
    fn numbers_are_interpolated_not_colours() {
        let corners = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
        let mesh = Mesh::new(corners, [[0, 1, 2], [0, 2, 3]]).unwrap();
        let scene = Scene::new(mesh).unwrap();
        let field = field(vec![-1.0, 1.0, 1.0, -1.0], Some(0.25));
        let settings = RenderSettings::new(120, 60).with(|settings| {
            settings.samples = 1;
            settings.camera.position = Some(vec3(0.0, 0.0, 5.0));
            settings.camera.focal_point = Some(vec3(0.0, 0.0, 0.0));
        });
        let picture = render_field(&scene, field, &settings, &NoProgress).unwrap();
        let row = 30 * 120..31 * 120;
        let seen: Vec<usize> = row.filter(|&i| picture.face[i] != NO_FACE).collect();
        let at = |share: f64| picture.color[seen[(share * seen.len() as f64) as usize]];
        let (left, middle, right) = (at(0.1), at(0.5), at(0.9));
        assert!(left[2] > 1.5 * left[0], "{left:?}");
        assert!(right[0] > 1.5 * right[2], "{right:?}");
        assert!(middle[1] > middle[0] && middle[1] > middle[2], "{middle:?}");
        // Five eighths of the way, the number is the tolerance.
        assert!(at(0.61)[1] > at(0.61)[0] && at(0.64)[0] > at(0.64)[1]);
    }

    #[test]
    fn a_value_for_each_vertex_is_needed() {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let scene = Scene::new(Mesh::new(corners, [[0, 1, 2]]).unwrap()).unwrap();
        let settings = RenderSettings::new(8, 8);
        let outcome = render_field(&scene, field(vec![0.0; 2], None), &settings, &NoProgress);
        assert!(outcome.unwrap_err().to_string().contains("each of 3 vertices, found 2"));
    }
}
