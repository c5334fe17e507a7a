//! Images of textures: decoding with limits, and bilinear sampling.

use std::io::Cursor;

use zune_jpeg::errors::DecodeErrors;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use super::buffers::{Buffers, Bytes, Refusal};
use super::one_line;
use halfline::error::{Error, Result};
use halfline::mesh::linear_from_srgb;

/// The most pixels of an image, whatever the size of its file: 4096 x 4096 ...
const PIXELS_ALWAYS_ALLOWED: u64 = 1 << 24;
/// ... or, if that is more, this many for each byte of the file.
const MOST_PIXELS_PER_BYTE: u64 = 16;

/// Eight bits each of red, green, blue and alpha, sRGB-encoded, from the top left.
pub(super) struct Image {
    width: usize,
    height: usize,
    pixels: Vec<[u8; 4]>,
    linear: [f32; 256],
}

/// What lies beyond the borders of a texture.
#[derive(Clone, Copy)]
pub(super) enum Wrap {
    Clamp,
    Mirror,
    Repeat,
}

impl Wrap {
    /// From a sampler's `wrapS` or `wrapT`.
    pub fn new(code: Option<u32>) -> Wrap {
        match code {
            Some(33071) => Wrap::Clamp,
            Some(33648) => Wrap::Mirror,
            _ => Wrap::Repeat,
        }
    }

    /// The pixel of an axis of `count` pixels.
    fn pixel(self, position: f64, count: usize) -> usize {
        // Beyond 2^53 a coordinate has no pixels any more, and NaN has none: all are some pixel.
        let (n, count) = (position as i64, count as i64);
        let wrapped = match self {
            Wrap::Clamp => n.clamp(0, count - 1),
            Wrap::Repeat => n.rem_euclid(count),
            Wrap::Mirror => {
                let n = n.rem_euclid(2 * count);
                n.min(2 * count - 1 - n)
            }
        };
        wrapped as usize
    }
}

impl Image {
    /// Reads an image of the document; `None` if it is missing, or in no format that is read.
    /// Takes its pixels from `pixels_left`.
    pub fn load(buffers: &Buffers, index: u32, pixels_left: &mut u64) -> Result<Option<Image>> {
        let error = |reason: String| Error::format(buffers.path, format!("image {index}"), reason);
        let image = &buffers.document.images[index as usize];
        let bytes = match (&image.uri, image.buffer_view) {
            (Some(uri), _) => match buffers.resolve(uri) {
                Ok(Some(bytes)) => bytes,
                Ok(None) => return Ok(None),
                Err(Refusal::Reason(reason)) => return Err(error(reason)),
                Err(Refusal::Error(error)) => return Err(error),
            },
            (None, Some(view)) => Bytes::Borrowed(buffers.view(view)?.bytes),
            (None, None) => return Ok(None),
        };
        let most = (bytes.len() as u64 * MOST_PIXELS_PER_BYTE).max(PIXELS_ALWAYS_ALLOWED);
        let most = most.min(*pixels_left);
        let decoded = if bytes.starts_with(b"\x89PNG") {
            decode_png(&bytes, most)
        } else if bytes.starts_with(b"\xff\xd8\xff") {
            decode_jpeg(&bytes, most)
        } else {
            return Ok(None);
        };
        let (width, height, pixels) = decoded.map_err(error)?;
        *pixels_left -= pixels.len() as u64;
        if pixels.is_empty() {
            return Ok(None);
        }
        let linear = std::array::from_fn(|encoded| linear_from_srgb(encoded as f32 / 255.0));
        Ok(Some(Image { width, height, pixels, linear }))
    }

    /// The linear colour at texture coordinates, between the four nearest pixels.
    pub fn sample(&self, [u, v]: [f32; 2], [wrap_u, wrap_v]: [Wrap; 2]) -> [f32; 4] {
        let x = f64::from(u) * self.width as f64 - 0.5;
        let y = f64::from(v) * self.height as f64 - 0.5;
        let (left, top) = (x.floor(), y.floor());
        let share = |position: f64| if position.is_finite() { position as f32 } else { 0.0 };
        let (across, down) = (share(x - left), share(y - top));
        let columns = [left, left + 1.0].map(|position| wrap_u.pixel(position, self.width));
        let rows = [top, top + 1.0].map(|position| wrap_v.pixel(position, self.height));
        let mut color = [0.0; 4];
        for (row, row_weight) in rows.into_iter().zip([1.0 - down, down]) {
            for (column, column_weight) in columns.into_iter().zip([1.0 - across, across]) {
                let weight = row_weight * column_weight;
                let [red, green, blue, alpha] = self.pixels[row * self.width + column];
                color[0] += weight * self.linear[usize::from(red)];
                color[1] += weight * self.linear[usize::from(green)];
                color[2] += weight * self.linear[usize::from(blue)];
                color[3] += weight * (f32::from(alpha) / 255.0);
            }
        }
        color
    }
}

type Pixels = (usize, usize, Vec<[u8; 4]>);

fn check_size(width: usize, height: usize, most: u64) -> std::result::Result<(), String> {
    if width as u64 * height as u64 > most {
        return Err(format!("{width} x {height} pixels are more than the {most} allowed"));
    }
    Ok(())
}

fn decode_png(bytes: &[u8], most: u64) -> std::result::Result<Pixels, String> {
    let broken =
        |error: png::DecodingError| format!("broken PNG: {}", one_line(&error.to_string()));
    // The decoder's own buffers: two rows, at most sixteen bits in four channels, and its window.
    let limits = png::Limits { bytes: 1 << 26 };
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), limits);
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(broken)?;
    let (width, height) = (reader.info().width as usize, reader.info().height as usize);
    check_size(width, height, most)?;
    let size = reader.output_buffer_size().ok_or("broken PNG: too large")?;
    let mut data = vec![0; size];
    let frame = reader.next_frame(&mut data).map_err(broken)?;
    data.truncate(frame.buffer_size());
    let pixels = match frame.color_type {
        png::ColorType::Grayscale => data.iter().map(|&grey| [grey, grey, grey, 255]).collect(),
        png::ColorType::GrayscaleAlpha => {
            data.as_chunks().0.iter().map(|&[grey, alpha]| [grey, grey, grey, alpha]).collect()
        }
        png::ColorType::Rgb => {
            data.as_chunks().0.iter().map(|&[red, green, blue]| [red, green, blue, 255]).collect()
        }
        png::ColorType::Rgba => data.as_chunks().0.to_vec(),
        png::ColorType::Indexed => return Err("broken PNG: its palette was not used".to_owned()),
    };
    checked((width, height, pixels))
}

fn decode_jpeg(bytes: &[u8], most: u64) -> std::result::Result<Pixels, String> {
    let broken = |error: DecodeErrors| format!("broken JPEG: {}", one_line(&error.to_string()));
    let options = DecoderOptions::default().jpeg_set_out_colorspace(ColorSpace::RGB);
    let mut decoder = zune_jpeg::JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(broken)?;
    let (width, height) = decoder.dimensions().ok_or("broken JPEG: it has no size")?;
    check_size(width, height, most)?;
    let data = decoder.decode().map_err(broken)?;
    let to_pixel = |&[red, green, blue]: &[u8; 3]| [red, green, blue, 255];
    checked((width, height, data.as_chunks().0.iter().map(to_pixel).collect()))
}

/// A decoder must have delivered all pixels: `Image::sample` counts on it.
fn checked((width, height, pixels): Pixels) -> std::result::Result<Pixels, String> {
    match pixels.len() == width * height {
        true => Ok((width, height, pixels)),
        false => Err(format!("{} pixels, not {width} x {height}", pixels.len())),
    }
}
