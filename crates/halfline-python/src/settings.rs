//! `halfline._native.RenderSettings`: keyword arguments of `Scene.render` as settings of a picture.

use std::str::FromStr;

use halfline::Error;
use halfline::geometry::Vec3;
use halfline::mesh::{Material, linear_from_srgb};
use halfline_render::{
    Background, Ground, GroundSurface, Light, Projection, RenderSettings, Shading, StockMaterial,
    Up, text,
};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyString};

use crate::error::exception;

/// What a picture is like. As JSON it travels to where rows are traced.
#[pyclass(frozen, module = "halfline._native", name = "RenderSettings")]
pub struct Settings(pub RenderSettings);

#[pymethods]
impl Settings {
    /// Of arguments that `Scene.render` knows; None and what is left out are as usual.
    #[new]
    #[pyo3(signature = (**keywords))]
    fn new(py: Python, keywords: Option<&Bound<PyDict>>) -> PyResult<Settings> {
        let settings = match keywords {
            Some(keywords) => Keywords(keywords.copy()?).settings()?,
            None => RenderSettings::default(),
        };
        settings.check().map_err(|error| renamed(py, error))?;
        Ok(Settings(settings))
    }

    #[staticmethod]
    #[pyo3(signature = (json, /))]
    fn from_json(json: &str) -> PyResult<Settings> {
        let settings = serde_json::from_str(json);
        settings.map(Settings).map_err(|error| PyValueError::new_err(format!("settings: {error}")))
    }

    fn to_json(&self) -> String {
        serde_json::to_string(&self.0).expect("settings are plain data")
    }

    #[getter]
    fn size(&self) -> (u32, u32) {
        (self.0.width, self.0.height)
    }

    #[getter]
    fn samples(&self) -> u32 {
        self.0.samples
    }
}

/// The exception that tells of a setting, by the name of its argument.
pub fn renamed(py: Python, error: Error) -> PyErr {
    let Error::Invalid { what, reason } = error else { return exception(py, error) };
    let (name, reason) = match what.as_str() {
        "resolution" => ("width, height", reason),
        "background color" => ("background", reason),
        "ground color" => ("ground", reason),
        "material color" => ("color", reason),
        "material metallic" => ("metallic", reason),
        "material roughness" => ("roughness", reason),
        "material ior" => ("base_ior", reason),
        what => match what.strip_prefix("light ") {
            Some(part) => ("lights", format!("{part}: {reason}")),
            None => (&*what.replace(' ', "_"), reason),
        },
    };
    PyValueError::new_err(format!("{name}: {reason}"))
}

/// Keyword arguments that have not been read yet.
struct Keywords<'py>(Bound<'py, PyDict>);

/// Makes something of the value of an argument, which it knows by name.
type Reader<'py, T> = fn(&str, &Bound<'py, PyAny>) -> PyResult<T>;

impl<'py> Keywords<'py> {
    fn settings(&self) -> PyResult<RenderSettings> {
        let mut settings = RenderSettings::default();
        self.set("width", &mut settings.width, whole)?;
        self.set("height", &mut settings.height, whole)?;
        self.set("samples", &mut settings.samples, whole)?;
        self.set("seed", &mut settings.seed, whole)?;
        self.set("shading", &mut settings.shading, named::<Shading>)?;
        self.set_camera(&mut settings)?;
        self.set("background", &mut settings.background, background)?;
        settings.ground = self.ground()?;
        settings.material = self.material()?;
        settings.smooth_angle = self.take("smooth_angle", number)?;
        self.set("lights", &mut settings.lights, lights)?;
        self.set("max_depth", &mut settings.max_depth, whole)?;
        self.set("occlusion_rays", &mut settings.occlusion_rays, whole)?;
        self.set("occlusion_reach", &mut settings.occlusion_reach, number)?;
        self.refuse_unknown()?;
        Ok(settings)
    }

    fn set_camera(&self, settings: &mut RenderSettings) -> PyResult<()> {
        let camera = &mut settings.camera;
        self.set("up", &mut camera.up, named::<Up>)?;
        camera.position = self.take("camera_position", vector)?;
        camera.focal_point = self.take("camera_focal_point", vector)?;
        camera.view_up = self.take("camera_view_up", vector)?;
        self.set("camera_view_angle", &mut camera.view_angle, number)?;
        for (name, angle) in [
            ("camera_azimuth_angle", &mut camera.azimuth),
            ("camera_elevation_angle", &mut camera.elevation),
        ] {
            if let Some(value) = self.take(name, number)? {
                *angle = value;
                if camera.position.is_some() {
                    let message = format!("{name}: expected none beside camera_position");
                    return Err(PyValueError::new_err(message));
                }
            }
        }
        self.set("camera_orthographic", &mut camera.projection, projection)
    }

    fn ground(&self) -> PyResult<Option<Ground>> {
        let surface = self.take("ground", ground_surface)?.flatten();
        let height = self.take("ground_height", number)?;
        let reflectivity = self.take("ground_reflectivity", number)?;
        let Some(surface) = surface else {
            let given = [("ground_height", height), ("ground_reflectivity", reflectivity)];
            let lonely = given.into_iter().find(|(_, value)| value.is_some());
            return lonely.map_or(Ok(None), |(name, _)| {
                Err(PyValueError::new_err(format!("{name}: expected none without ground")))
            });
        };
        let plane = Ground::new(surface).mirroring(reflectivity.unwrap_or(0.0) as f32);
        Ok(Some(height.map_or(plane, |height| plane.at_height(height))))
    }

    /// The material that the arguments describe; None if they say nothing.
    fn material(&self) -> PyResult<Option<Material>> {
        let stock = self.take("material", named::<StockMaterial>)?;
        let color = self.take("color", color)?;
        let metallic = self.take("metallic", number)?;
        let roughness = self.take("roughness", number)?;
        let ior = self.take("base_ior", number)?;
        if let Some(ior) = ior.filter(|ior| !(1.0..=4.0).contains(ior)) {
            return Err(PyValueError::new_err(format!("base_ior: {ior} is not between 1 and 4")));
        }
        let is_silent = color.is_none() && [metallic, roughness, ior] == [None; 3];
        if stock.is_none() && is_silent {
            return Ok(None);
        }
        let mut material = stock.map_or_else(Material::default, Material::from);
        if let Some(color) = color {
            let [r, g, b] = color.map(linear_from_srgb);
            material.base_color = [r, g, b, 1.0];
        }
        for (value, field) in [
            (metallic, &mut material.metallic),
            (roughness, &mut material.roughness),
            (ior, &mut material.ior),
        ] {
            *field = value.map_or(*field, |value| value as f32);
        }
        Ok(Some(material))
    }

    /// What `read` makes of an argument, unless that is None or not there.
    fn take<T>(&self, name: &str, read: Reader<'py, T>) -> PyResult<Option<T>> {
        let Some(value) = self.0.get_item(name)? else { return Ok(None) };
        self.0.del_item(name)?;
        if value.is_none() {
            return Ok(None);
        }
        read(name, &value).map(Some)
    }

    /// Sets a field to what [`Keywords::take`] gives, if anything.
    fn set<T>(&self, name: &str, field: &mut T, read: Reader<'py, T>) -> PyResult<()> {
        if let Some(value) = self.take(name, read)? {
            *field = value;
        }
        Ok(())
    }

    /// Refuses what is left, as Python does.
    fn refuse_unknown(&self) -> PyResult<()> {
        let Some(name) = self.0.keys().iter().next() else { return Ok(()) };
        Err(PyTypeError::new_err(format!(
            "render() got an unexpected keyword argument '{}'",
            name.extract::<String>()?
        )))
    }
}

/// The error about a value of a type which it cannot have.
fn wrong_type(name: &str, expected: &str, value: &Bound<PyAny>) -> PyErr {
    let found = value.get_type().name().map_or_else(|_| "?".into(), |name| name.to_string());
    PyTypeError::new_err(format!("{name}: expected {expected}, found {found}"))
}

/// The error about a value that makes no sense.
fn wrong_value(name: &str, expected: &str, value: &Bound<PyAny>) -> PyErr {
    let found = value.repr().map_or_else(|_| "?".into(), |text| text.to_string());
    PyValueError::new_err(format!("{name}: {expected}, found {found}"))
}

fn is_bool(value: &Bound<PyAny>) -> bool {
    value.is_instance_of::<PyBool>()
}

/// Text, if that is what it is.
fn text_of(value: &Bound<PyAny>) -> PyResult<Option<String>> {
    value.is_instance_of::<PyString>().then(|| value.extract()).transpose()
}

/// A number without a fraction, of as many bits as `T` has and without a sign.
fn whole<T: TryFrom<u64>>(name: &str, value: &Bound<PyAny>) -> PyResult<T> {
    if is_bool(value) || !value.hasattr("__index__")? {
        return Err(wrong_type(name, "an integer", value));
    }
    let number = value.extract::<u64>().ok().and_then(|number| T::try_from(number).ok());
    let largest = u64::MAX >> (64 - 8 * size_of::<T>());
    let expected = format!("expected a number from 0 to {largest}");
    number.ok_or_else(|| wrong_value(name, &expected, value))
}

fn number(name: &str, value: &Bound<PyAny>) -> PyResult<f64> {
    let number = if is_bool(value) { None } else { value.extract::<f64>().ok() };
    let number = number.ok_or_else(|| wrong_type(name, "a number", value))?;
    match number.is_finite() {
        true => Ok(number),
        false => Err(wrong_value(name, "expected a finite number", value)),
    }
}

fn three(name: &str, expected: &str, value: &Bound<PyAny>) -> PyResult<[f64; 3]> {
    if value.is_instance_of::<PyString>() || value.try_iter().is_err() {
        return Err(wrong_type(name, expected, value));
    }
    let numbers: Vec<f64> =
        value.try_iter()?.map(|item| number(name, &item?)).collect::<PyResult<_>>()?;
    numbers.try_into().map_err(|_| wrong_value(name, &format!("expected {expected}"), value))
}

fn vector(name: &str, value: &Bound<PyAny>) -> PyResult<Vec3> {
    three(name, "three numbers", value).map(Vec3::from)
}

fn color(name: &str, value: &Bound<PyAny>) -> PyResult<[f32; 3]> {
    if let Some(text) = text_of(value)? {
        return text::color(&text).map_err(|expected| wrong_value(name, &expected, value));
    }
    let color = three(name, "#RRGGBB or three numbers", value)?;
    match color.iter().all(|channel| (0.0..=1.0).contains(channel)) {
        true => Ok(color.map(|channel| channel as f32)),
        false => Err(wrong_value(name, "expected #RRGGBB or three numbers in 0..1", value)),
    }
}

fn background(name: &str, value: &Bound<PyAny>) -> PyResult<Background> {
    match text_of(value)?.as_deref() {
        Some("studio") => Ok(Background::Studio),
        Some("none") => Ok(Background::Transparent),
        Some(text) => text::color(text).map(Background::Color).map_err(|_| {
            wrong_value(name, "expected studio, none, #RRGGBB or R,G,B between 0 and 1", value)
        }),
        None => color(name, value).map(Background::Color),
    }
}

/// A plane's look; None for False.
fn ground_surface(name: &str, value: &Bound<PyAny>) -> PyResult<Option<GroundSurface>> {
    if is_bool(value) {
        return Ok(value.extract::<bool>()?.then(GroundSurface::default));
    }
    match text_of(value)? {
        Some(text) => text::ground_surface(&text)
            .map_err(|expected| wrong_value(name, &expected, value))
            .map(Some),
        None => color(name, value).map(|color| Some(GroundSurface::Matte(color))),
    }
}

fn projection(name: &str, value: &Bound<PyAny>) -> PyResult<Projection> {
    if !is_bool(value) {
        return Ok(Projection::Orthographic { height: Some(number(name, value)?) });
    }
    Ok(match value.extract()? {
        true => Projection::Orthographic { height: None },
        false => Projection::Perspective,
    })
}

fn lights(name: &str, value: &Bound<PyAny>) -> PyResult<Vec<Light>> {
    const EXPECTED: &str = "strings, as --light of the command has them";
    if value.is_instance_of::<PyString>() || value.try_iter().is_err() {
        return Err(wrong_type(name, EXPECTED, value));
    }
    let light = |item: PyResult<Bound<PyAny>>| {
        let item = item?;
        let text = text_of(&item)?.ok_or_else(|| wrong_type(name, EXPECTED, &item))?;
        text::light(&text).map_err(|reason| wrong_value(name, &reason, &item))
    };
    value.try_iter()?.map(light).collect()
}

/// A value that has a name.
fn named<T: FromStr<Err = Error>>(name: &str, value: &Bound<PyAny>) -> PyResult<T> {
    let text = text_of(value)?.ok_or_else(|| wrong_type(name, "a name", value))?;
    text.parse().map_err(|error| match error {
        Error::Invalid { reason, .. } => PyValueError::new_err(format!("{name}: {reason}")),
        error => exception(value.py(), error),
    })
}
