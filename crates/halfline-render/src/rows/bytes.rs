//! Rows as bytes, to be sent from one machine to another.
//!
//! All numbers are little-endian, nothing is padded:
//!
//! | bytes | what |
//! |---|---|
//! | 8 | `HALFROWS` |
//! | 4, 4 | version of this layout; 1 if steps were counted, else 0 |
//! | 4, 4 | width and height of the whole picture |
//! | 4, 4 | the first row, and how many there are |
//! | 8, 8 | fingerprints of the settings and of the scene |
//! | 5 x 8 | rays: primary, occlusion, shadow, reflection, refraction |
//! | 8 | seconds of tracing, as a double |
//! | 16 a pixel | red, green, blue, alpha, in single precision as all that follows |
//! | 4 a pixel | depth |
//! | 12 a pixel | normal |
//! | 4 a pixel | face, as an unsigned number |
//! | 8 a pixel | nodes and triangles, if steps were counted |
//! | 8 | checksum of all bytes before it |

use halfline::error::{Error, Result};

use super::{Origin, Rows};
use crate::checksum::checksum;
use crate::image::Rendering;
use crate::settings::MAX_PIXELS;
use crate::statistics::{RayCounts, RenderStatistics};

const MAGIC: &[u8; 8] = b"HALFROWS";
const VERSION: u32 = 1;
const HEADER_BYTES: usize = 96;
const CHECKSUM_BYTES: usize = 8;
const PIXEL_BYTES: usize = 36;
const STEPS_BYTES: usize = 8;

impl Rows {
    /// The rows as bytes, the same on every machine.
    pub fn to_bytes(&self) -> Vec<u8> {
        let rows = &self.traced;
        let (width, height) = self.picture_size();
        let mut bytes = Vec::with_capacity(encoded_bytes(rows.pixel_count(), rows.steps.is_some()));
        bytes.extend(MAGIC);
        let range = [self.first_row, rows.height];
        for number in [VERSION, rows.steps.is_some().into(), width, height].iter().chain(&range) {
            bytes.extend(number.to_le_bytes());
        }
        let RayCounts { primary, occlusion, shadow, reflection, refraction } = rows.statistics.rays;
        let counts = [primary, occlusion, shadow, reflection, refraction];
        for number in [self.origin.settings, self.origin.scene].iter().chain(&counts) {
            bytes.extend(number.to_le_bytes());
        }
        bytes.extend(rows.statistics.trace_seconds.to_le_bytes());
        put(&mut bytes, rows.color.as_flattened());
        put(&mut bytes, &rows.depth);
        put(&mut bytes, rows.normal.as_flattened());
        bytes.extend(rows.face.iter().flat_map(|face| face.to_le_bytes()));
        if let Some(steps) = &rows.steps {
            put(&mut bytes, steps.as_flattened());
        }
        bytes.extend(checksum(&bytes).to_le_bytes());
        bytes
    }

    /// The rows that [`Rows::to_bytes`] made `bytes` of. Takes no more memory than they do.
    ///
    /// # Errors
    /// [`Error::Invalid`] if `bytes` are something else, or were cut short or damaged.
    pub fn from_bytes(bytes: &[u8]) -> Result<Rows> {
        // Find out how long the bytes must be, and that they are so long, before anything is made.
        if !bytes.starts_with(MAGIC) {
            return Err(refused("they do not begin as rows of a picture do"));
        }
        let cut_short =
            || refused(&format!("{} bytes are too few: they were cut short", bytes.len()));
        let mut left =
            Reader { bytes: bytes.get(MAGIC.len()..HEADER_BYTES).ok_or_else(cut_short)? };
        let [version, counts_steps, width, height, first_row, row_count] = left.numbers();
        if version != VERSION {
            return Err(refused(&format!(
                "they have version {version} of their layout, and this is version {VERSION}"
            )));
        }
        let is_sound = counts_steps <= 1
            && width > 0
            && row_count > 0
            && u64::from(width) * u64::from(height) <= MAX_PIXELS
            && u64::from(first_row) + u64::from(row_count) <= u64::from(height);
        if !is_sound {
            return Err(damaged());
        }
        let counts_steps = counts_steps == 1;
        let pixels = width as usize * row_count as usize;
        let expected = encoded_bytes(pixels, counts_steps);
        if bytes.len() < expected {
            return Err(cut_short());
        }
        if bytes.len() > expected {
            return Err(refused(&format!("{} bytes are more than they should be", bytes.len())));
        }
        let (content, sum) = bytes.split_at(expected - CHECKSUM_BYTES);
        if *sum != checksum(content).to_le_bytes() {
            return Err(damaged());
        }

        let origin = Origin { settings: left.number(), scene: left.number() };
        let rays = RayCounts {
            primary: left.number(),
            occlusion: left.number(),
            shadow: left.number(),
            reflection: left.number(),
            refraction: left.number(),
        };
        let trace_seconds = f64::from_bits(left.number());
        let mut left = Reader { bytes: &content[HEADER_BYTES..] };
        let traced = Rendering {
            width,
            height: row_count,
            color: left.pixels(pixels),
            depth: left.pixels::<1>(pixels).into_flattened(),
            normal: left.pixels(pixels),
            face: left.faces(pixels),
            steps: counts_steps.then(|| left.pixels(pixels)),
            statistics: RenderStatistics { rays, trace_seconds },
        };
        // The scale of a heat map is made of these: a whole checksum is no proof of sense.
        let counts = traced.steps.iter().flatten().flatten().map(|&count| f64::from(count));
        if !counts.chain([trace_seconds]).all(|number| number.is_finite() && number >= 0.0) {
            return Err(damaged());
        }
        Ok(Rows { origin, first_row, picture_height: height, traced })
    }
}

fn encoded_bytes(pixels: usize, counts_steps: bool) -> usize {
    let of_pixel = PIXEL_BYTES + if counts_steps { STEPS_BYTES } else { 0 };
    HEADER_BYTES + pixels * of_pixel + CHECKSUM_BYTES
}

fn put(bytes: &mut Vec<u8>, numbers: &[f32]) {
    bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
}

fn damaged() -> Error {
    refused("the bytes are damaged")
}

fn refused(reason: &str) -> Error {
    Error::invalid("rows", reason)
}

/// Takes numbers from the front of bytes that are known to be long enough.
struct Reader<'a> {
    bytes: &'a [u8],
}

impl Reader<'_> {
    fn take<const BYTES: usize>(&mut self) -> [u8; BYTES] {
        let (taken, left) = self.bytes.split_first_chunk().expect("the length was checked");
        self.bytes = left;
        *taken
    }

    fn number(&mut self) -> u64 {
        u64::from_le_bytes(self.take())
    }

    fn numbers<const COUNT: usize>(&mut self) -> [u32; COUNT] {
        std::array::from_fn(|_| u32::from_le_bytes(self.take()))
    }

    fn faces(&mut self, pixels: usize) -> Vec<u32> {
        (0..pixels).map(|_| u32::from_le_bytes(self.take())).collect()
    }

    fn pixels<const CHANNELS: usize>(&mut self, pixels: usize) -> Vec<[f32; CHANNELS]> {
        (0..pixels).map(|_| self.numbers().map(f32::from_bits)).collect()
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use halfline::Scene;
    use halfline::progress::NoProgress;
    use halfline_io::models::{Kind, generate};

    use super::*;
    use crate::{Plan, RenderSettings, Shading, assemble};

    /// A checksum is no signature: whoever writes it may write anything before it.
    #[test]
    fn senseless_bytes_with_a_right_checksum_do_no_harm() {
        let scene = Scene::new(generate(Kind::Sphere, 100, 0, &NoProgress).unwrap()).unwrap();
        for shading in [Shading::Clay, Shading::Depth, Shading::Steps] {
            let settings =
                RenderSettings { width: 9, height: 5, shading, ..RenderSettings::default() };
            let plan = Plan::new(&scene, &settings).unwrap();
            let bytes = plan.trace_rows(0..5, &NoProgress).unwrap().to_bytes();
            let end = bytes.len() - CHECKSUM_BYTES;
            let mut assembled = 0;
            for at in (0..end).step_by(4) {
                let nan = f32::NAN.to_bits();
                for word in
                    [0, 1, 2, u32::MAX, 1 << 31, nan, f32::INFINITY.to_bits(), 1e38_f32.to_bits()]
                {
                    let mut bytes = bytes.clone();
                    bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
                    let sum = checksum(&bytes[..end]);
                    bytes[end..].copy_from_slice(&sum.to_le_bytes());
                    let Ok(rows) = Rows::from_bytes(&bytes) else { continue };
                    let Ok(picture) = assemble(&settings, [rows]) else { continue };
                    assembled += 1;
                    picture.statistics.rays.total();
                    picture.write_png(Vec::new()).unwrap();
                    #[cfg(feature = "exr")]
                    if at % 64 == 0 {
                        picture.write_exr(Cursor::new(Vec::new())).unwrap();
                    }
                }
            }
            assert!(assembled > 1000, "{assembled}");
        }
    }
}
