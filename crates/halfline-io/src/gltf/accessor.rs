//! Accessors: typed, strided, perhaps sparse arrays in buffers.
//!
//! Not the readers of the crate gltf: they overflow on a count of zero or a huge offset, and
//! panic on a short sparse accessor. Here every element is checked to lie in its view before the
//! first is read, and nothing is allocated for elements that the file does not hold.

use std::path::Path;

use super::buffers::{Buffers, View};
use super::document::{self, Shape};
use halfline::error::{Error, Result};

/// An accessor all of whose elements lie within their buffers.
pub(super) struct Accessor<'b> {
    path: &'b Path,
    index: u32,
    pub count: usize,
    pub shape: Shape,
    pub component: Component,
    normalized: bool,
    /// None: all elements are zero.
    base: Option<Elements<'b>>,
    sparse: Option<(Elements<'b>, Component, Elements<'b>)>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

/// `count` elements, the first at the start of `bytes`, the last wholly inside.
struct Elements<'b> {
    bytes: &'b [u8],
    stride: usize,
    count: usize,
}

impl<'b> Accessor<'b> {
    pub fn new(buffers: &'b Buffers<'_>, index: u32) -> Result<Accessor<'b>> {
        let error =
            |reason: String| Error::format(buffers.path, format!("accessor {index}"), reason);
        let accessors = &buffers.document.accessors;
        let Some(accessor) = accessors.get(index as usize) else {
            return Err(error(format!("the file has {} accessors", accessors.len())));
        };
        let component = Component::new(accessor.component_type).map_err(error)?;
        let size = component.size() * component_count(accessor.shape);
        let base = match accessor.buffer_view {
            Some(view) => {
                let view = buffers.view(view)?;
                Some(elements(view, accessor.byte_offset, accessor.count, size).map_err(error)?)
            }
            None => None,
        };
        // Elements that are in no buffer cost the file nothing: bound them by its size.
        let most = buffers.bytes_read();
        if base.is_none() && accessor.count > most {
            let count = accessor.count;
            return Err(error(format!("{count} elements without a buffer view, in {most} bytes")));
        }
        let sparse = match &accessor.sparse {
            Some(sparse) => Some(sparse_elements(buffers, sparse, size, &error)?),
            None => None,
        };
        Ok(Accessor {
            path: buffers.path,
            index,
            count: accessor.count as usize,
            shape: accessor.shape,
            component,
            normalized: accessor.normalized,
            base,
            sparse,
        })
    }

    /// True if all elements are zero for want of any data.
    pub fn has_no_data(&self) -> bool {
        self.base.is_none() && self.sparse.is_none()
    }

    /// An error about this accessor.
    pub fn error(&self, reason: impl Into<String>) -> Error {
        Error::format(self.path, format!("accessor {}", self.index), reason)
    }

    /// The elements as `N` floats each: components past the shape's are `fill`, integers that are
    /// `normalized` become fractions.
    pub fn floats<const N: usize>(&self, normalized: bool, fill: f32) -> Result<Vec<[f32; N]>> {
        let width = component_count(self.shape).min(N);
        let size = self.component.size();
        let normalized = normalized && self.component != Component::F32;
        let scale = if normalized { self.component.largest() } else { 1.0 };
        let decode = |bytes: &[u8]| {
            let mut element = [fill; N];
            for (value, bytes) in element.iter_mut().zip(bytes.chunks_exact(size)).take(width) {
                let decoded = self.component.decode(bytes);
                *value = if normalized { (decoded / scale).max(-1.0) } else { decoded };
            }
            element
        };
        let element_size = size * component_count(self.shape);
        let mut elements = match &self.base {
            Some(base) => base.iter(element_size).map(decode).collect(),
            None => {
                let mut zero = [fill; N];
                zero[..width].fill(0.0);
                vec![zero; self.count]
            }
        };
        if let Some((indices, component, values)) = &self.sparse {
            let indices = indices.iter(component.size()).map(|bytes| component.decode_index(bytes));
            for (index, value) in indices.zip(values.iter(element_size)) {
                match elements.get_mut(index as usize) {
                    Some(element) => *element = decode(value),
                    None => {
                        let count = self.count;
                        return Err(self.error(format!("sparse index {index} of {count} elements")));
                    }
                }
            }
        }
        Ok(elements)
    }

    /// The elements as said by the accessor itself to be normalized or not.
    pub fn floats_as_declared<const N: usize>(&self, fill: f32) -> Result<Vec<[f32; N]>> {
        self.floats(self.normalized, fill)
    }

    /// The elements as vertex indices.
    pub fn indices(&self) -> Result<Vec<u32>> {
        let integers = matches!(self.component, Component::U8 | Component::U16 | Component::U32);
        if self.shape != Shape::Scalar || !integers {
            return Err(self.error("indices must be unsigned scalars"));
        }
        let size = self.component.size();
        let mut elements = match &self.base {
            Some(base) => base.iter(size).map(|b| self.component.decode_index(b)).collect(),
            None => vec![0; self.count],
        };
        if let Some((indices, component, values)) = &self.sparse {
            let indices = indices.iter(component.size()).map(|bytes| component.decode_index(bytes));
            for (index, value) in indices.zip(values.iter(size)) {
                match elements.get_mut(index as usize) {
                    Some(element) => *element = self.component.decode_index(value),
                    None => {
                        let count = self.count;
                        return Err(self.error(format!("sparse index {index} of {count} elements")));
                    }
                }
            }
        }
        let restart = self.component.largest() as u32;
        match elements.iter().position(|&index| index == restart) {
            Some(n) => Err(self.error(format!("index {n} is {restart}, a primitive restart"))),
            None => Ok(elements),
        }
    }
}

fn sparse_elements<'b>(
    buffers: &'b Buffers<'_>,
    sparse: &document::Sparse,
    size: usize,
    error: &impl Fn(String) -> Error,
) -> Result<(Elements<'b>, Component, Elements<'b>)> {
    let component = Component::new(sparse.indices.component_type).map_err(error)?;
    if !matches!(component, Component::U8 | Component::U16 | Component::U32) {
        return Err(error("sparse indices must be unsigned".to_owned()));
    }
    let view = buffers.view(sparse.indices.buffer_view)?;
    let indices = elements(view, sparse.indices.byte_offset, sparse.count, component.size())
        .map_err(|reason| error(format!("sparse indices: {reason}")))?;
    let view = buffers.view(sparse.values.buffer_view)?;
    let values = elements(view, sparse.values.byte_offset, sparse.count, size)
        .map_err(|reason| error(format!("sparse values: {reason}")))?;
    Ok((indices, component, values))
}

/// `count` elements of `size` bytes from byte `offset` of the view.
fn elements(
    view: View<'_>,
    offset: u64,
    count: u64,
    size: usize,
) -> std::result::Result<Elements<'_>, String> {
    let stride = view.stride.unwrap_or(size as u64);
    // Elements may be interleaved, but an element does not reach into the next one: so the number
    // of elements is bounded by that of bytes.
    if stride < size as u64 {
        return Err(format!("elements of {size} bytes are {stride} bytes apart"));
    }
    let end = match count.checked_sub(1) {
        Some(before) => {
            before.checked_mul(stride).and_then(|n| n.checked_add(size as u64)?.checked_add(offset))
        }
        None => Some(offset),
    };
    match end {
        Some(end) if end <= view.bytes.len() as u64 => Ok(Elements {
            bytes: &view.bytes[offset as usize..end as usize],
            stride: stride as usize,
            count: count as usize,
        }),
        _ => Err(format!(
            "{count} elements of {size} bytes, {stride} apart, from byte {offset} \
             reach past the {} bytes of the view",
            view.bytes.len()
        )),
    }
}

impl<'b> Elements<'b> {
    fn iter(&self, size: usize) -> impl ExactSizeIterator<Item = &'b [u8]> {
        let (bytes, stride) = (self.bytes, self.stride);
        (0..self.count).map(move |n| &bytes[n * stride..n * stride + size])
    }
}

impl Component {
    fn new(code: u32) -> std::result::Result<Component, String> {
        Ok(match code {
            5120 => Component::I8,
            5121 => Component::U8,
            5122 => Component::I16,
            5123 => Component::U16,
            5125 => Component::U32,
            5126 => Component::F32,
            _ => return Err(format!("unknown component type {code}")),
        })
    }

    fn size(self) -> usize {
        match self {
            Component::I8 | Component::U8 => 1,
            Component::I16 | Component::U16 => 2,
            Component::U32 | Component::F32 => 4,
        }
    }

    /// The largest integer; 1 for floats, which are never normalized.
    fn largest(self) -> f32 {
        match self {
            Component::I8 => i8::MAX.into(),
            Component::U8 => u8::MAX.into(),
            Component::I16 => i16::MAX.into(),
            Component::U16 => u16::MAX.into(),
            // Rounds up to 2^32, and converts back to the largest by saturation.
            Component::U32 => u32::MAX as f32,
            Component::F32 => 1.0,
        }
    }

    /// A component from exactly its bytes.
    #[inline]
    fn decode(self, bytes: &[u8]) -> f32 {
        match (self, bytes) {
            (Component::I8, &[a]) => f32::from(a as i8),
            (Component::I16, &[a, b]) => f32::from(i16::from_le_bytes([a, b])),
            (Component::F32, &[a, b, c, d]) => f32::from_le_bytes([a, b, c, d]),
            _ => self.decode_index(bytes) as f32,
        }
    }

    /// An unsigned component from exactly its bytes.
    #[inline]
    fn decode_index(self, bytes: &[u8]) -> u32 {
        match *bytes {
            [a] => a.into(),
            [a, b] => u16::from_le_bytes([a, b]).into(),
            [a, b, c, d] => u32::from_le_bytes([a, b, c, d]),
            _ => unreachable!("components have 1, 2 or 4 bytes"),
        }
    }
}

fn component_count(shape: Shape) -> usize {
    match shape {
        Shape::Scalar => 1,
        Shape::Vec2 => 2,
        Shape::Vec3 => 3,
        Shape::Vec4 | Shape::Mat2 => 4,
        Shape::Mat3 => 9,
        Shape::Mat4 => 16,
    }
}
