//! Rows put together to the whole picture, and what can only be added then.

use std::ops::Range;

use halfline::error::{Error, Result};
use rayon::prelude::*;

use crate::image::Rendering;
use crate::integrator::{press_highlights, spread_depth, spread_steps};
use crate::rows::{Rows, blank, settings_fingerprint};
use crate::settings::{RenderSettings, Shading};
use crate::sky::backdrop;

/// Makes the picture of all its rows, which may come in any order and from different machines. What
/// comes out is what [`render`](crate::render) gives at once, to the bit, statistics' ray counts
/// included; the seconds of tracing are the sum of those of the parts. Needs no scene.
///
/// # Errors
/// [`Error::Invalid`], naming the first rows at fault: if some are missing or came twice, if they are
/// of a picture of another size, were traced with other settings, or not all of the same scene.
pub fn assemble(
    settings: &RenderSettings,
    parts: impl IntoIterator<Item = Rows>,
) -> Result<Rendering> {
    settings.check()?;
    let mut picture = gather(settings, parts)?;
    match settings.shading {
        Shading::Clay => press_highlights(&mut picture),
        Shading::Depth => spread_depth(&mut picture),
        Shading::Steps => spread_steps(&mut picture),
        Shading::Whitted | Shading::Normal | Shading::Face => {}
    }
    add_backdrop(&mut picture, settings);
    Ok(picture)
}

fn gather(settings: &RenderSettings, parts: impl IntoIterator<Item = Rows>) -> Result<Rendering> {
    let fingerprint = settings_fingerprint(settings);
    let mut picture: Option<Rendering> = None;
    let mut origin = None;
    let mut is_there = vec![false; settings.height as usize];
    for part in parts {
        check_origin(settings, fingerprint, &part)?;
        if *origin.get_or_insert(part.origin) != part.origin {
            return Err(refused(&part.range(), "traced of another scene than those before"));
        }
        let range = part.first_row as usize..part.range().end as usize;
        if let Some(twice) = first_run(&is_there[range.clone()], true) {
            let first = part.first_row;
            return Err(refused(&(first + twice.start..first + twice.end), "there twice"));
        }
        is_there[range].fill(true);

        let is_whole = part.traced.height == settings.height;
        match &mut picture {
            // The usual case, one machine: nothing is copied.
            None if is_whole => picture = Some(part.traced),
            None => copy(&part, picture.insert(blank(settings, settings.height)?)),
            Some(picture) => copy(&part, picture),
        }
    }
    if let Some(missing) = first_run(&is_there, false) {
        return Err(refused(&missing, "missing"));
    }
    Ok(picture.expect("a picture has rows, and none is missing"))
}

/// Refuses rows of another picture.
fn check_origin(settings: &RenderSettings, fingerprint: u64, part: &Rows) -> Result<()> {
    let (width, height) = part.picture_size();
    if (width, height) != (settings.width, settings.height) {
        let wanted = format!("{} x {}", settings.width, settings.height);
        let reason = format!("of a picture of {width} x {height} pixels, not {wanted}");
        return Err(refused(&part.range(), &reason));
    }
    let counts_steps = settings.shading == Shading::Steps;
    if part.origin.settings != fingerprint || part.traced.steps.is_some() != counts_steps {
        let reason = "traced with other settings, or by another version of halfline";
        return Err(refused(&part.range(), reason));
    }
    Ok(())
}

/// The first run of rows that are all there, or that are all missing.
fn first_run(is_there: &[bool], wanted: bool) -> Option<Range<u32>> {
    let start = is_there.iter().position(|&there| there == wanted)?;
    let length = is_there[start..].iter().take_while(|&&there| there == wanted).count();
    Some(start as u32..(start + length) as u32)
}

fn refused(rows: &Range<u32>, reason: &str) -> Error {
    let (first, last) = (rows.start, rows.end - 1);
    let which = match first == last {
        true => format!("row {first}"),
        false => format!("rows {first} to {last}"),
    };
    Error::invalid(which, reason)
}

/// Puts `part` into its place.
fn copy(part: &Rows, picture: &mut Rendering) {
    let rows = &part.traced;
    let first = part.first_row as usize * rows.width as usize;
    let place = first..first + rows.pixel_count();
    picture.color[place.clone()].copy_from_slice(&rows.color);
    picture.depth[place.clone()].copy_from_slice(&rows.depth);
    picture.normal[place.clone()].copy_from_slice(&rows.normal);
    picture.face[place.clone()].copy_from_slice(&rows.face);
    if let (Some(steps), Some(of_rows)) = (&mut picture.steps, &rows.steps) {
        steps[place].copy_from_slice(of_rows);
    }
    picture.statistics.rays += rows.statistics.rays;
    picture.statistics.trace_seconds += rows.statistics.trace_seconds;
}

/// Puts the background behind what was drawn.
fn add_backdrop(picture: &mut Rendering, settings: &RenderSettings) {
    let (width, height) = (picture.width as usize, picture.height as usize);
    picture.color.par_chunks_mut(width).enumerate().for_each(|(row, pixels)| {
        let y = 1.0 - (2 * row + 1) as f64 / height as f64;
        for (column, pixel) in pixels.iter_mut().enumerate() {
            let alpha = pixel[3];
            if alpha == 1.0 {
                continue;
            }
            let x = (2 * column + 1) as f64 / width as f64 - 1.0;
            let (behind, behind_alpha) = backdrop(&settings.background, x, y);
            if behind_alpha == 0.0 {
                continue;
            }
            for (channel, behind) in behind.to_array().into_iter().enumerate() {
                pixel[channel] = pixel[channel] * alpha + behind as f32 * (1.0 - alpha);
            }
            pixel[3] = 1.0;
        }
    });
}
