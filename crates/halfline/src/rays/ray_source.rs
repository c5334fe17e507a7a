//! Where rays come from: rows in either precision, or columns, as NumPy has them.
//!
//! The engine takes rays eight at a time, and asks for single ones again by their numbers. Nothing else of it
//! depends on how they lie in memory, so it is compiled once for all forms.

use std::ops::Range;

use crate::error::{Error, Result};
use crate::geometry::{Ray, RayF32};
use crate::simd::{F64x8, LANES, Simd, SimdF64};

/// Rays by number.
#[derive(Clone, Copy, Debug)]
pub enum RaySource<'a> {
    /// Rows in double precision.
    Rows(&'a [Ray]),
    /// Rows in single precision.
    RowsF32(&'a [RayF32]),
    /// Columns.
    Columns(RayColumns<'a>),
}

/// Eight rays as they were given, by lane.
pub struct RayLanes<S: Simd> {
    /// By axis.
    pub origin: [F64x8<S>; 3],
    /// By axis.
    pub direction: [F64x8<S>; 3],
    /// Where the ranges begin.
    pub t_min: F64x8<S>,
    /// Where the ranges end.
    pub t_max: F64x8<S>,
}

/// What each ray has of one kind: the same for all, or an entry of an array in single precision or in
/// double.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Column<'a, S, D> {
    /// All rays have this.
    Same(D),
    /// Each ray has its own, in single precision.
    F32(&'a [S]),
    /// Each ray has its own, in double precision.
    F64(&'a [D]),
}

/// Origins or directions.
pub type Vectors<'a> = Column<'a, [f32; 3], [f64; 3]>;

/// Ends of ranges.
pub type Scalars<'a> = Column<'a, f32, f64>;

/// Rays as columns. No number is ever rounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayColumns<'a> {
    count: usize,
    origins: Vectors<'a>,
    directions: Vectors<'a>,
    t_min: Scalars<'a>,
    t_max: Scalars<'a>,
}

impl<S, D> Column<'_, S, D> {
    /// A message if there are not `count` entries.
    fn check(&self, what: &str, count: usize) -> Result<()> {
        let found = match self {
            Column::Same(_) => return Ok(()),
            Column::F32(entries) => entries.len(),
            Column::F64(entries) => entries.len(),
        };
        if found == count {
            return Ok(());
        }
        Err(Error::invalid(what, format!("expected one or {count} entries, found {found}")))
    }

    /// The entries of some rays.
    fn slice(&self, numbers: Range<usize>) -> Self
    where
        D: Copy,
    {
        match self {
            Column::Same(entry) => Column::Same(*entry),
            Column::F32(entries) => Column::F32(&entries[numbers]),
            Column::F64(entries) => Column::F64(&entries[numbers]),
        }
    }
}

impl Vectors<'_> {
    #[inline(always)]
    fn at(&self, number: usize) -> [f64; 3] {
        match self {
            Column::Same(entry) => *entry,
            Column::F32(entries) => {
                let [x, y, z] = entries[number];
                [f64::from(x), f64::from(y), f64::from(z)]
            }
            Column::F64(entries) => entries[number],
        }
    }

    /// Up to eight entries, by axis and lane.
    #[inline(always)]
    fn lanes(&self, numbers: &[usize]) -> [[f64; LANES]; 3] {
        let mut lanes = [[0.0; LANES]; 3];
        for (lane, &number) in numbers.iter().enumerate().take(LANES) {
            let entry = self.at(number);
            for axis in 0..3 {
                lanes[axis][lane] = entry[axis];
            }
        }
        lanes
    }
}

impl Scalars<'_> {
    #[inline(always)]
    fn at(&self, number: usize) -> f64 {
        match self {
            Column::Same(entry) => *entry,
            Column::F32(entries) => f64::from(entries[number]),
            Column::F64(entries) => entries[number],
        }
    }

    /// Up to eight entries.
    #[inline(always)]
    fn lanes(&self, numbers: &[usize]) -> [f64; LANES] {
        let mut lanes = [0.0; LANES];
        for (lane, &number) in numbers.iter().enumerate().take(LANES) {
            lanes[lane] = self.at(number);
        }
        lanes
    }
}

impl<'a> RayColumns<'a> {
    /// `count` rays.
    ///
    /// # Errors
    /// [`Error::Invalid`] if a column that is not the same for all has not `count` entries.
    pub fn new(
        count: usize,
        origins: Vectors<'a>,
        directions: Vectors<'a>,
        t_min: Scalars<'a>,
        t_max: Scalars<'a>,
    ) -> Result<RayColumns<'a>> {
        origins.check("origins", count)?;
        directions.check("directions", count)?;
        t_min.check("t_min", count)?;
        t_max.check("t_max", count)?;
        Ok(RayColumns { count, origins, directions, t_min, t_max })
    }

    /// Number of rays.
    pub fn len(&self) -> usize {
        self.count
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Where the rays begin.
    pub fn origins(&self) -> Vectors<'a> {
        self.origins
    }

    /// How far one unit of t reaches.
    pub fn directions(&self) -> Vectors<'a> {
        self.directions
    }

    /// The smallest t that count.
    pub fn t_min(&self) -> Scalars<'a> {
        self.t_min
    }

    /// The largest t that count.
    pub fn t_max(&self) -> Scalars<'a> {
        self.t_max
    }

    /// Some of the rays, numbered from zero.
    pub fn slice(&self, numbers: Range<usize>) -> RayColumns<'a> {
        RayColumns {
            count: numbers.len(),
            origins: self.origins.slice(numbers.clone()),
            directions: self.directions.slice(numbers.clone()),
            t_min: self.t_min.slice(numbers.clone()),
            t_max: self.t_max.slice(numbers),
        }
    }

    fn ray(&self, number: usize) -> Ray {
        Ray {
            origin: self.origins.at(number).into(),
            direction: self.directions.at(number).into(),
            t_min: self.t_min.at(number),
            t_max: self.t_max.at(number),
        }
    }

    #[inline(always)]
    fn lanes<S: Simd>(&self, simd: S, numbers: &[usize]) -> RayLanes<S> {
        let double = simd.doubles();
        let [a, b, c] = self.origins.lanes(numbers);
        let [x, y, z] = self.directions.lanes(numbers);
        RayLanes {
            origin: [double.load(&a), double.load(&b), double.load(&c)],
            direction: [double.load(&x), double.load(&y), double.load(&z)],
            t_min: double.load(&self.t_min.lanes(numbers)),
            t_max: double.load(&self.t_max.lanes(numbers)),
        }
    }
}

impl<'a> RaySource<'a> {
    /// How many rays there are.
    pub fn len(&self) -> usize {
        match self {
            RaySource::Rows(rays) => rays.len(),
            RaySource::RowsF32(rays) => rays.len(),
            RaySource::Columns(columns) => columns.len(),
        }
    }

    /// Some of the rays, numbered from zero.
    pub fn slice(&self, numbers: Range<usize>) -> RaySource<'a> {
        match self {
            RaySource::Rows(rays) => RaySource::Rows(&rays[numbers]),
            RaySource::RowsF32(rays) => RaySource::RowsF32(&rays[numbers]),
            RaySource::Columns(columns) => RaySource::Columns(columns.slice(numbers)),
        }
    }

    /// One ray.
    pub fn ray(&self, number: usize) -> Ray {
        match self {
            RaySource::Rows(rays) => rays[number],
            RaySource::RowsF32(rays) => rays[number].into(),
            RaySource::Columns(columns) => columns.ray(number),
        }
    }

    /// Up to eight rays in a row; what the other lanes hold does not matter.
    #[inline(always)]
    pub fn load8<S: Simd>(&self, simd: S, numbers: Range<usize>) -> RayLanes<S> {
        match self {
            RaySource::Rows(rays) => of_rays(simd, rays[numbers].iter().take(LANES)),
            RaySource::RowsF32(rays) => {
                let mut rows = [simd.splat(0.0); LANES];
                for (row, ray) in rows.iter_mut().zip(&rays[numbers]) {
                    *row = simd.load(bytemuck::cast_ref(ray));
                }
                of_rows(simd, rows)
            }
            RaySource::Columns(columns) => {
                let mut all = [numbers.start; LANES];
                for lane in 0..LANES {
                    all[lane] += lane;
                }
                columns.lanes(simd, &all[..numbers.len().min(LANES)])
            }
        }
    }

    /// The rays of eight numbers.
    #[inline(always)]
    pub fn gather8<S: Simd>(&self, simd: S, numbers: &[usize; LANES]) -> RayLanes<S> {
        match self {
            RaySource::Rows(rays) => of_rays(simd, numbers.iter().map(|&number| &rays[number])),
            RaySource::RowsF32(rays) => {
                let mut rows = [simd.splat(0.0); LANES];
                for lane in 0..LANES {
                    rows[lane] = simd.load(bytemuck::cast_ref(&rays[numbers[lane]]));
                }
                of_rows(simd, rows)
            }
            RaySource::Columns(columns) => columns.lanes(simd, numbers),
        }
    }
}

/// Up to eight rays in double precision.
#[inline(always)]
fn of_rays<'a, S: Simd>(simd: S, rays: impl Iterator<Item = &'a Ray>) -> RayLanes<S> {
    let mut lanes = [[0.0; LANES]; 8];
    for (lane, ray) in rays.enumerate() {
        for axis in 0..3 {
            lanes[axis][lane] = ray.origin[axis];
            lanes[3 + axis][lane] = ray.direction[axis];
        }
        (lanes[6][lane], lanes[7][lane]) = (ray.t_min, ray.t_max);
    }
    let double = simd.doubles();
    RayLanes {
        origin: [double.load(&lanes[0]), double.load(&lanes[1]), double.load(&lanes[2])],
        direction: [double.load(&lanes[3]), double.load(&lanes[4]), double.load(&lanes[5])],
        t_min: double.load(&lanes[6]),
        t_max: double.load(&lanes[7]),
    }
}

/// Eight rays in single precision, as they lie in memory.
#[inline(always)]
fn of_rows<S: Simd>(simd: S, rows: [S::F32x8; LANES]) -> RayLanes<S> {
    let [a, b, c, t_min, x, y, z, t_max] = simd.transpose(rows);
    RayLanes {
        origin: [simd.widen(a), simd.widen(b), simd.widen(c)],
        direction: [simd.widen(x), simd.widen(y), simd.widen(z)],
        t_min: simd.widen(t_min),
        t_max: simd.widen(t_max),
    }
}
