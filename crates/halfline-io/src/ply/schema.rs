//! Which parts of a PLY file make up the mesh.

use std::path::Path;

use super::header::{Element, Header, Kind};
use super::scalar::Scalar;
use halfline::error::{Error, Result};

/// Where in the header a mesh's parts are, as indices of elements and of their properties.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Schema {
    pub vertex: usize,
    /// The properties x, y and z.
    pub position: [usize; 3],
    /// True if single precision does not hold the coordinates.
    pub double: bool,
    /// The properties red, green, blue and perhaps alpha.
    pub color: Option<([usize; 3], Option<usize>)>,
    /// The element `face` and its list of vertices.
    pub face: Option<(usize, usize)>,
    /// The element `tristrips` and its list of vertices.
    pub strips: Option<(usize, usize)>,
}

/// More records than this cannot be named by the 32-bit indices of a mesh.
const MOST_RECORDS: u64 = u32::MAX as u64 - 1;

impl Schema {
    /// The parts of the mesh that `header` describes.
    pub fn of(path: &Path, header: &Header) -> Result<Schema> {
        let wrong = |reason: &str| Error::format(path, "header", reason);
        let elements = &header.elements;
        let vertex = elements
            .iter()
            .position(|e| e.name == "vertex")
            .ok_or_else(|| wrong("there is no element vertex"))?;
        let (vertex_element, mut position) = (&elements[vertex], [0; 3]);
        let mut double = false;
        for (place, name) in position.iter_mut().zip(["x", "y", "z"]) {
            let (index, scalar) = scalar(vertex_element, &[name]).ok_or_else(|| {
                wrong(&format!("element vertex has no property {name} that is one number"))
            })?;
            *place = index;
            double |= !scalar.fits_f32();
        }
        let component = |names: &[&str]| scalar(vertex_element, names).map(|(index, _)| index);
        let color = match (
            component(&["red", "diffuse_red"]),
            component(&["green", "diffuse_green"]),
            component(&["blue", "diffuse_blue"]),
        ) {
            (Some(red), Some(green), Some(blue)) => {
                Some(([red, green, blue], component(&["alpha", "diffuse_alpha"])))
            }
            _ => None,
        };
        let face = index_list(elements, "face").map_err(|e| wrong(&e))?;
        let strips = index_list(elements, "tristrips").map_err(|e| wrong(&e))?;
        let used = [Some(vertex), face.map(|f| f.0), strips.map(|s| s.0)];
        for element in used.into_iter().flatten().map(|index| &elements[index]) {
            if element.count > MOST_RECORDS {
                return Err(wrong(&format!(
                    "{} records of element {} are more than the {MOST_RECORDS} that are supported",
                    element.count, element.name
                )));
            }
        }
        Ok(Schema { vertex, position, double, color, face, strips })
    }
}

fn scalar(element: &Element, names: &[&str]) -> Option<(usize, Scalar)> {
    let index = element.properties.iter().position(|p| names.contains(&&*p.name))?;
    match element.properties[index].kind {
        Kind::Scalar(scalar) => Some((index, scalar)),
        Kind::List { .. } => None,
    }
}

/// The element `name` and its list of vertices; `None` if there is no such element or no record.
fn index_list(
    elements: &[Element],
    name: &str,
) -> std::result::Result<Option<(usize, usize)>, String> {
    let Some(index) = elements.iter().position(|e| e.name == name && e.count > 0) else {
        return Ok(None);
    };
    let list = elements[index]
        .properties
        .iter()
        .position(|p| p.name == "vertex_indices" || p.name == "vertex_index");
    match list.map(|list| (list, elements[index].properties[list].kind)) {
        Some((list, Kind::List { item, .. })) if item.is_integer() => Ok(Some((index, list))),
        Some(_) => Err(format!(
            "property {} of element {name} must be a list of an integer type",
            elements[index].properties[list.unwrap_or(0)].name
        )),
        None => Err(format!("element {name} has no property list vertex_indices")),
    }
}
