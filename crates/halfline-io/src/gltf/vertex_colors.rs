//! Colours of vertices: `COLOR_0`, times the base colour texture sampled at the vertex.

use std::collections::HashMap;

use super::accessor::{Accessor, Component};
use super::buffers::Buffers;
use super::document::{self, Shape, TextureInfo, TextureTransform};
use super::image::{Image, Wrap};
use super::material::is_opaque;
use halfline::error::{Error, Result};
use halfline::mesh::srgb_from_linear;
use halfline::progress::Observer;

/// Decoding all images may cost this much work, in pixels for each byte read ...
const MOST_PIXELS_PER_BYTE: u64 = 64;
/// ... or this many pixels, whichever is more: sixty-four images of 4096 x 4096.
const PIXELS_ALWAYS_ALLOWED: u64 = 1 << 30;

/// Where the colours of a block of vertices come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Coloring {
    count: usize,
    color: Option<u32>,
    texture: Option<Sampling>,
    opaque: bool,
}

/// The texture of a material at the coordinates of an accessor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Sampling {
    image: u32,
    coordinates: u32,
    material: u32,
}

impl Coloring {
    /// The colours of a primitive of `count` vertices; `None` if it has none.
    pub fn of(
        buffers: &Buffers,
        primitive: &document::Primitive,
        count: usize,
    ) -> Result<Option<Coloring>> {
        let document = buffers.document;
        let error = |place: String, reason: String| Err(Error::format(buffers.path, place, reason));
        let color = primitive.attributes.get("COLOR_0").copied();
        let material = primitive.material.map(|material| &document.materials[material as usize]);
        let mut texture = None;
        if let (Some(info), Some(index)) = (material.and_then(texture_info), primitive.material) {
            let set = transform(info).and_then(|t| t.tex_coord).unwrap_or(info.tex_coord);
            let coordinates = primitive.attributes.get(&format!("TEXCOORD_{set}")).copied();
            let Some(entry) = document.textures.get(info.index as usize) else {
                let reason = format!("the file has {} textures", document.textures.len());
                return error(format!("texture {}", info.index), reason);
            };
            if let Some(image) = entry.source.filter(|&i| i as usize >= document.images.len()) {
                let reason = format!("image {image}, but the file has {}", document.images.len());
                return error(format!("texture {}", info.index), reason);
            }
            if let Some(s) = entry.sampler.filter(|&s| s as usize >= document.samplers.len()) {
                let reason = format!("sampler {s}, but the file has {}", document.samplers.len());
                return error(format!("texture {}", info.index), reason);
            }
            if let (Some(image), Some(coordinates)) = (entry.source, coordinates) {
                texture = Some(Sampling { image, coordinates, material: index });
            }
        }

        let same_count = |name: &str, index: u32, shapes: &[Shape]| -> Result<()> {
            let accessor = Accessor::new(buffers, index)?;
            let of_floats = matches!(
                accessor.component,
                Component::F32 | Component::U8 | Component::U16 | Component::I8 | Component::I16
            );
            if !shapes.contains(&accessor.shape) || !of_floats {
                return Err(accessor.error(format!("not of a type that {name} may have")));
            }
            if accessor.count != count {
                let found = accessor.count;
                return Err(accessor.error(format!("{found} of {name} for {count} vertices")));
            }
            Ok(())
        };
        if let Some(color) = color {
            same_count("COLOR_0", color, &[Shape::Vec3, Shape::Vec4])?;
        }
        if let Some(texture) = texture {
            same_count("TEXCOORD", texture.coordinates, &[Shape::Vec2])?;
        }
        let opaque = material.is_none_or(is_opaque);
        let coloring = Coloring { count, color, texture, opaque };
        Ok((color.is_some() || texture.is_some()).then_some(coloring))
    }
}

/// The colours of each coloring, sRGB-encoded.
pub(super) fn compute(
    buffers: &Buffers,
    mut colorings: Vec<Coloring>,
    observer: &dyn Observer,
) -> Result<HashMap<Coloring, Vec<[u8; 4]>>> {
    // Image by image, so that only one is in memory.
    colorings.sort_by_key(|coloring| coloring.texture.map(|texture| texture.image));
    let mut pixels_left =
        buffers.bytes_read().saturating_mul(MOST_PIXELS_PER_BYTE).max(PIXELS_ALWAYS_ALLOWED);
    let mut latest: Option<(u32, Option<Image>)> = None;
    let mut all = HashMap::new();
    for coloring in colorings {
        if all.contains_key(&coloring) {
            continue;
        }
        observer.check()?;
        let mut colors = match coloring.color {
            // Floats are never normalized, and integers always are.
            Some(color) => Accessor::new(buffers, color)?.floats::<4>(true, 1.0)?,
            None => vec![[1.0; 4]; coloring.count],
        };
        if let Some(texture) = coloring.texture {
            if latest.as_ref().is_none_or(|&(image, _)| image != texture.image) {
                drop(latest.take());
                let image = Image::load(buffers, texture.image, &mut pixels_left)?;
                latest = Some((texture.image, image));
            }
            if let Some((_, Some(image))) = &latest {
                multiply(buffers, texture, image, &mut colors)?;
            }
        }
        let to_byte = |part: f32| (part.clamp(0.0, 1.0) * 255.0).round() as u8;
        let encode = |[red, green, blue, alpha]: [f32; 4]| {
            let alpha = if coloring.opaque { 1.0 } else { alpha };
            let [red, green, blue] = [red, green, blue].map(|part| to_byte(srgb_from_linear(part)));
            [red, green, blue, to_byte(alpha)]
        };
        all.insert(coloring, colors.into_iter().map(encode).collect());
    }
    Ok(all)
}

/// Multiplies each colour by the texture at its vertex.
fn multiply(
    buffers: &Buffers,
    texture: Sampling,
    image: &Image,
    colors: &mut [[f32; 4]],
) -> Result<()> {
    let document = buffers.document;
    let Some(info) = texture_info(&document.materials[texture.material as usize]) else {
        return Ok(());
    };
    let sampler = document.textures[info.index as usize].sampler;
    let sampler = sampler.map(|sampler| &document.samplers[sampler as usize]);
    let wrap = [sampler.and_then(|s| s.wrap_s), sampler.and_then(|s| s.wrap_t)].map(Wrap::new);
    let transform = transform(info);
    let coordinates = Accessor::new(buffers, texture.coordinates)?.floats_as_declared::<2>(0.0)?;
    for (color, mut at) in colors.iter_mut().zip(coordinates) {
        if let Some(transform) = transform {
            at = transformed(at, transform);
        }
        let sample = image.sample(at, wrap);
        for part in 0..4 {
            color[part] *= sample[part];
        }
    }
    Ok(())
}

fn texture_info(material: &document::Material) -> Option<&TextureInfo> {
    material.pbr_metallic_roughness.as_ref()?.base_color_texture.as_ref()
}

fn transform(info: &TextureInfo) -> Option<&TextureTransform> {
    info.extensions.as_ref()?.transform.as_ref()
}

/// Scaled, then turned, then moved, as KHR_texture_transform has it.
fn transformed([u, v]: [f32; 2], transform: &TextureTransform) -> [f32; 2] {
    let [scale_u, scale_v] = transform.scale.unwrap_or([1.0; 2]);
    let (sine, cosine) = transform.rotation.sin_cos();
    let (u, v) = (u * scale_u, v * scale_v);
    [u * cosine + v * sine + transform.offset[0], v * cosine - u * sine + transform.offset[1]]
}
