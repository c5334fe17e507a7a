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
    /// Rays of a row if they are the pixels of an image, else 0.
    image_width: usize,
    origins: Vectors<'a>,
    directions: Vectors<'a>,
    t_min: Scalars<'a>,
    t_max: Scalars<'a>,
}

impl<S, D> Column<'_, S, D> {
    /// A message if there are not `count` entries.
    pub(crate) fn check(&self, what: &str, count: usize) -> Result<()> {
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
    pub(crate) fn slice(&self, numbers: Range<usize>) -> Self
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
    /// One entry.
    #[inline(always)]
    pub(crate) fn at(&self, number: usize) -> [f64; 3] {
        match self {
            Column::Same(entry) => *entry,
            Column::F32(entries) => {
                let [x, y, z] = entries[number];
                [f64::from(x), f64::from(y), f64::from(z)]
            }
            Column::F64(entries) => entries[number],
        }
    }

    /// Eight entries, by axis.
    #[inline(always)]
    fn lanes<S: Simd>(&self, simd: S, numbers: &[usize; LANES]) -> [F64x8<S>; 3] {
        let mut entries = [[0.0; 3]; LANES];
        for lane in 0..LANES {
            entries[lane] = self.at(numbers[lane]);
        }
        let mut axes = [simd.doubles().splat(0.0); 3];
        for axis in 0..3 {
            let mut lanes = [0.0; LANES];
            for lane in 0..LANES {
                lanes[lane] = entries[lane][axis];
            }
            axes[axis] = simd.doubles().set(lanes);
        }
        axes
    }
}

impl Scalars<'_> {
    /// One entry.
    #[inline(always)]
    pub(crate) fn at(&self, number: usize) -> f64 {
        match self {
            Column::Same(entry) => *entry,
            Column::F32(entries) => f64::from(entries[number]),
            Column::F64(entries) => entries[number],
        }
    }

    /// Eight entries.
    #[inline(always)]
    fn lanes<S: Simd>(&self, simd: S, numbers: &[usize; LANES]) -> F64x8<S> {
        let mut lanes = [0.0; LANES];
        for lane in 0..LANES {
            lanes[lane] = self.at(numbers[lane]);
        }
        simd.doubles().set(lanes)
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
        Ok(RayColumns { count, image_width: 0, origins, directions, t_min, t_max })
    }

    /// The same rays as pixels of an image, row by row, `width` in each row: they are cast tile by tile, which is
    /// quicker where neighbours are alike. The answers are the same in any case, and in the same places.
    #[must_use]
    pub fn with_image_width(self, width: usize) -> RayColumns<'a> {
        RayColumns { image_width: width, ..self }
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
            image_width: self.image_width,
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
    fn lanes<S: Simd>(&self, simd: S, numbers: &[usize; LANES]) -> RayLanes<S> {
        RayLanes {
            origin: self.origins.lanes(simd, numbers),
            direction: self.directions.lanes(simd, numbers),
            t_min: self.t_min.lanes(simd, numbers),
            t_max: self.t_max.lanes(simd, numbers),
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

    /// Rays of a row if they are the pixels of an image, else 0.
    pub fn image_width(&self) -> usize {
        match self {
            RaySource::Rows(_) | RaySource::RowsF32(_) => 0,
            RaySource::Columns(columns) => columns.image_width,
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

    /// Up to eight rays in a row; the other lanes repeat the last.
    #[inline(always)]
    pub fn load8<S: Simd>(&self, simd: S, numbers: Range<usize>) -> RayLanes<S> {
        let mut all = [numbers.start; LANES];
        for lane in 0..LANES {
            all[lane] = (numbers.start + lane).min(numbers.end - 1);
        }
        self.gather8(simd, &all)
    }

    /// The rays of eight numbers.
    #[inline(always)]
    pub fn gather8<S: Simd>(&self, simd: S, numbers: &[usize; LANES]) -> RayLanes<S> {
        match self {
            RaySource::Rows(rays) => {
                let mut eight = [&rays[numbers[0]]; LANES];
                for lane in 0..LANES {
                    eight[lane] = &rays[numbers[lane]];
                }
                of_rays(simd, &eight)
            }
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

/// Eight rays in double precision.
#[inline(always)]
fn of_rays<S: Simd>(simd: S, rays: &[&Ray; LANES]) -> RayLanes<S> {
    let double = simd.doubles();
    let (mut origin, mut direction) = ([double.splat(0.0); 3], [double.splat(0.0); 3]);
    let (mut t_min, mut t_max) = ([0.0; LANES], [0.0; LANES]);
    for axis in 0..3 {
        let (mut from, mut along) = ([0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            (from[lane], along[lane]) = (rays[lane].origin[axis], rays[lane].direction[axis]);
        }
        (origin[axis], direction[axis]) = (double.set(from), double.set(along));
    }
    for lane in 0..LANES {
        (t_min[lane], t_max[lane]) = (rays[lane].t_min, rays[lane].t_max);
    }
    RayLanes { origin, direction, t_min: double.set(t_min), t_max: double.set(t_max) }
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
