//! Materials to start from.

use std::str::FromStr;

use halfline::error::{Error, Result};
use halfline::mesh::Material;

/// A material that has a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum StockMaterial {
    /// Rough and light grey.
    Plaster,
    /// Smooth and light grey.
    Plastic,
    /// Brushed metal.
    Metal,
    /// A perfect mirror.
    Mirror,
    /// Clear glass.
    Glass,
}

impl StockMaterial {
    /// Every one, in the order of the documentation.
    pub const ALL: [StockMaterial; 5] = [
        StockMaterial::Plaster,
        StockMaterial::Plastic,
        StockMaterial::Metal,
        StockMaterial::Mirror,
        StockMaterial::Glass,
    ];

    /// The name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            StockMaterial::Plaster => "plaster",
            StockMaterial::Plastic => "plastic",
            StockMaterial::Metal => "metal",
            StockMaterial::Mirror => "mirror",
            StockMaterial::Glass => "glass",
        }
    }

    /// What it is like, in a line for a help text.
    pub const fn description(self) -> &'static str {
        match self {
            StockMaterial::Plaster => "Rough and light grey",
            StockMaterial::Plastic => "Smooth and light grey",
            StockMaterial::Metal => "Brushed metal",
            StockMaterial::Mirror => "A perfect mirror",
            StockMaterial::Glass => "Clear glass",
        }
    }
}

impl From<StockMaterial> for Material {
    fn from(stock: StockMaterial) -> Material {
        let plain = Material::default();
        let metal = |base_color, roughness| Material {
            base_color,
            metallic: 1.0,
            roughness,
            ..Material::default()
        };
        match stock {
            StockMaterial::Plaster => plain,
            StockMaterial::Plastic => Material { roughness: 0.0, ..plain },
            StockMaterial::Metal => metal([0.6, 0.6, 0.62, 1.0], 0.4),
            StockMaterial::Mirror => metal([0.95, 0.95, 0.95, 1.0], 0.0),
            StockMaterial::Glass => {
                let base_color = [1.0; 4];
                Material { base_color, roughness: 0.0, transmission: 1.0, ..plain }
            }
        }
    }
}

impl FromStr for StockMaterial {
    type Err = Error;
    fn from_str(name: &str) -> Result<StockMaterial> {
        let mut known = StockMaterial::ALL.into_iter();
        known.find(|material| material.name() == name).ok_or_else(|| {
            let names = StockMaterial::ALL.map(StockMaterial::name).join(", ");
            Error::invalid("material", format!("{name:?} is none of {names}"))
        })
    }
}
