//! Material libraries of Wavefront OBJ.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use super::lines::{Fields, Lines, name_without_comment, number, without_comment};
use super::sibling;
use halfline::error::Result;
use halfline::mesh::Material;

/// The materials of all libraries that a file names.
#[derive(Default)]
pub(super) struct MaterialLibrary {
    pub materials: Vec<Material>,
    by_name: HashMap<Vec<u8>, u32>,
    /// By the part of the name before what may be a comment.
    by_short_name: HashMap<Vec<u8>, u32>,
    loaded: HashSet<PathBuf>,
}

impl MaterialLibrary {
    /// The index of the material with this name, or else of the one whose name it is but for a comment
    /// behind either.
    pub fn find(&self, name: &[u8]) -> Option<u32> {
        let short = name_without_comment(name);
        let found = self.by_name.get(name).or_else(|| self.by_name.get(short));
        found.or_else(|| self.by_short_name.get(short)).copied()
    }

    /// Adds the materials of a file. False if there is no such file.
    pub fn load(&mut self, place: &Path) -> Result<bool> {
        if self.loaded.contains(place) {
            return Ok(true);
        }
        let Some(bytes) = sibling::read(place)? else { return Ok(false) };
        self.loaded.insert(place.to_owned());
        let mut lines = Lines::new(&bytes);
        let mut current = None;
        while let Some(line) = lines.next_continued() {
            let mut fields = Fields::of(line);
            let Some(keyword) = fields.next() else { continue };
            if keyword == b"newmtl" {
                self.add(current.take());
                current = Some((fields.rest().to_owned(), Statements::default()));
            } else if let Some((_, statements)) = &mut current
                && let Err(reason) =
                    statements.apply(keyword, Fields::of(without_comment(fields.rest())))
            {
                return Err(lines.error(place, reason));
            }
        }
        self.add(current);
        Ok(true)
    }

    fn add(&mut self, named: Option<(Vec<u8>, Statements)>) {
        if let Some((name, statements)) = named {
            let index = self.materials.len() as u32;
            let short = name_without_comment(&name);
            if short.len() < name.len() {
                self.by_short_name.insert(short.to_owned(), index);
            }
            self.by_name.insert(name, index);
            self.materials.push(statements.material());
        }
    }
}

/// What one material says.
struct Statements {
    diffuse: [f32; 3],
    specular: [f32; 3],
    /// Exponent of the highlight (`Ns`).
    exponent: Option<f32>,
    /// `d`, or 1 - `Tr`.
    opacity: f32,
    ior: Option<f32>,
    illumination: u32,
    roughness: Option<f32>,
    metallic: Option<f32>,
}

impl Default for Statements {
    fn default() -> Statements {
        Statements {
            diffuse: [0.8; 3],
            specular: [0.0; 3],
            exponent: None,
            opacity: 1.0,
            ior: None,
            illumination: 2,
            roughness: None,
            metallic: None,
        }
    }
}

impl Statements {
    fn apply(&mut self, keyword: &[u8], mut fields: Fields) -> std::result::Result<(), String> {
        let name = String::from_utf8_lossy(keyword);
        let mut value = || match fields.next() {
            Some(field) => number(field).map(|value| value as f32),
            None => Err(format!("{name} needs a value")),
        };
        match keyword {
            b"Kd" | b"Ks" => {
                // The other two forms of a colour name a file or the CIE system.
                let Ok(red) = value() else { return Ok(()) };
                // One value stands for all three.
                let green = value().unwrap_or(red);
                let color = [red, green, value().unwrap_or(red)];
                match keyword {
                    b"Kd" => self.diffuse = color,
                    _ => self.specular = color,
                }
            }
            b"Ns" => self.exponent = Some(value()?),
            // `d -halo factor` makes the opacity depend on the view; its factor is ignored.
            b"d" => self.opacity = value().unwrap_or(1.0),
            b"Tr" => self.opacity = 1.0 - value()?,
            b"Ni" => self.ior = Some(value()?),
            b"illum" => self.illumination = value()? as u32,
            b"Pr" => self.roughness = Some(value()?),
            b"Pm" => self.metallic = Some(value()?),
            _ => {}
        }
        Ok(())
    }

    /// The nearest material of glTF's model. Mirrors (illumination models 3 and 5) become metals
    /// of the specular colour, glass (4, 6, 7 and 9) a transmitting dielectric.
    fn material(&self) -> Material {
        let mirror = matches!(self.illumination, 3 | 5) && self.specular != [0.0; 3];
        let glass = matches!(self.illumination, 4 | 6 | 7 | 9) && self.opacity < 1.0
            || matches!(self.illumination, 6 | 7);
        let highlight = self.illumination >= 2 && self.specular != [0.0; 3];
        let roughness = match (self.roughness, self.exponent) {
            (Some(roughness), _) => roughness,
            // Blinn and Phong's exponent to Beckmann's width, alpha^2 = 2 / (n + 2) (Walter et
            // al. 2007), and alpha is the square of glTF's roughness.
            (None, Some(exponent)) if highlight || glass => {
                (2.0 / (exponent.max(0.0) + 2.0)).powf(0.25)
            }
            (None, None) if mirror || glass => 0.0,
            _ => 1.0,
        };
        let transmission = match glass {
            true if self.opacity < 1.0 => 1.0 - self.opacity,
            true => 1.0,
            false => 0.0,
        };
        let [red, green, blue] = if mirror { self.specular } else { self.diffuse };
        let alpha = if glass { 1.0 } else { self.opacity };
        let unit = |value: f32| if value.is_nan() { 0.0 } else { value.clamp(0.0, 1.0) };
        Material {
            base_color: [red, green, blue, alpha].map(unit),
            metallic: unit(self.metallic.unwrap_or(f32::from(mirror))),
            roughness: unit(roughness),
            transmission: unit(transmission),
            ior: self.ior.filter(|ior| ior.is_finite() && *ior >= 1.0).unwrap_or(1.5),
        }
    }
}
