//! glTF 2.0: JSON documents with their buffers, and GLB.
//!
//! Read are triangles, strips and fans of all meshes in the default scene, placed by their nodes;
//! vertex colours, base colour textures sampled at the vertices, and the materials' base colour,
//! metalness, roughness, transmission and index of refraction. Points, lines, skins, morph
//! targets, animations, cameras and lights are passed over. Triangles come in the order of nodes
//! and primitives; the file has no other faces.
//!
//! Transforms are carried out in double precision, and coordinates stay in it unless every one of
//! them fits single precision without loss.

mod accessor;
mod assemble;
mod buffers;
mod container;
mod document;
mod image;
mod material;
mod scene_graph;
mod vertex_colors;

use std::path::Path;

use self::buffers::{Buffers, unsupported_extension};
use self::document::{Document, Preamble};
use crate::lines::quoted;
use halfline::error::{Error, Result};
use halfline::mesh::Mesh;
use halfline::progress::{Observer, Stage};

/// Extensions that a document may require: those that are read, and those that change neither the
/// shape nor what is read of the materials.
const KNOWN_EXTENSIONS: [&str; 19] = [
    "KHR_mesh_quantization",
    "KHR_texture_transform",
    "KHR_materials_transmission",
    "KHR_materials_ior",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_iridescence",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_lights_punctual",
    "KHR_texture_basisu",
    "KHR_xmp_json_ld",
    "EXT_texture_webp",
    "MSFT_texture_dds",
];

/// Reads the content `bytes` of the file `path`, a glTF document or a GLB container. Buffers and
/// images are read where they lie in the file's folder or below. An image that is missing, or
/// neither PNG nor JPEG, leaves its material without a texture.
///
/// # Errors
/// [`Error::Format`] with the place in the document, [`Error::Io`] for a buffer or an image that
/// is there and cannot be read, or [`Error::Interrupted`].
pub fn read(path: &Path, bytes: &[u8], observer: &dyn Observer) -> Result<Mesh> {
    observer.report(Stage::Load, 0, bytes.len() as u64);
    observer.check()?;
    let (json, binary_chunk) = container::split(path, bytes)?;
    let document = parse(path, json)?;
    observer.check()?;
    let buffers = Buffers::new(path, bytes.len(), &document, binary_chunk);
    buffers.check_uris()?;
    let mesh = assemble::assemble(&buffers, bytes.len() as u64, observer)?;
    observer.report(Stage::Load, bytes.len() as u64, bytes.len() as u64);
    Ok(mesh)
}

fn parse(path: &Path, json: &[u8]) -> Result<Document> {
    let syntax = |error: serde_json::Error| {
        let place = format!("JSON line {} column {}", error.line(), error.column());
        let mut reason = error.to_string();
        // The message repeats the place at its end.
        if let Some(end) = reason.rfind(" at line ") {
            reason.truncate(end);
        }
        Error::format(path, place, one_line(&reason))
    };
    let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);

    // The version first: a document of another version may differ in everything else.
    let asset = serde_json::from_slice::<Preamble>(json).map_err(syntax)?.asset;
    if !asset.version.starts_with("2.") {
        let version = quoted(asset.version.as_bytes());
        let reason = format!("version {version} is not supported, only 2.x");
        return Err(Error::format(path, "asset", reason));
    }
    if let Some(version) = asset.min_version.filter(|version| version != "2.0") {
        let version = quoted(version.as_bytes());
        let reason = format!("needs a reader of version {version}; this one has 2.0");
        return Err(Error::format(path, "asset", reason));
    }
    let document = serde_json::from_slice::<Document>(json).map_err(syntax)?;
    match document.extensions_required.iter().find(|e| !KNOWN_EXTENSIONS.contains(&e.as_str())) {
        Some(name) => {
            let name = quoted(name.as_bytes());
            Err(unsupported_extension(path, "extensionsRequired", &name))
        }
        None => Ok(document),
    }
}

/// Another library's message as it can stand in ours: on one line, and not long.
fn one_line(message: &str) -> String {
    const MOST_CHARACTERS: usize = 200;
    let plain = |c: char| if c.is_control() { ' ' } else { c };
    message.trim().chars().take(MOST_CHARACTERS).map(plain).collect()
}
