//! NumPy's arrays as the library's slices. What a caller may pass is for `_arrays.py` to check; here
//! arrive C-contiguous arrays of the machine's byte order, or plain numbers.

use halfline::columns::{Column, Scalars, Vectors};
use numpy::{
    Element, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyReadwriteArrayDyn,
    PyUntypedArrayMethods,
};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

/// What each ray has: one value for all of them, or an array.
pub enum ColumnArray<'py, Same> {
    Same(Same),
    Single(PyReadonlyArrayDyn<'py, f32>),
    Double(PyReadonlyArrayDyn<'py, f64>),
}

/// Origins or directions: three numbers, or an array of shape (..., 3).
pub type VectorArray<'py> = ColumnArray<'py, [f64; 3]>;

/// Ends of ranges: one number, or an array of any shape.
pub type NumberArray<'py> = ColumnArray<'py, f64>;

impl<'a, 'py, Same> FromPyObject<'a, 'py> for ColumnArray<'py, Same>
where
    Same: FromPyObject<'a, 'py, Error = PyErr>,
{
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(array) = object.cast::<PyArrayDyn<f32>>() {
            return Ok(ColumnArray::Single(array.try_readonly()?));
        }
        if let Ok(array) = object.cast::<PyArrayDyn<f64>>() {
            return Ok(ColumnArray::Double(array.try_readonly()?));
        }
        Ok(ColumnArray::Same(object.extract()?))
    }
}

impl VectorArray<'_> {
    /// The vectors.
    pub fn column(&self) -> PyResult<Vectors<'_>> {
        Ok(match self {
            ColumnArray::Same(vector) => Column::Same(*vector),
            ColumnArray::Single(array) => Column::F32(rows(array.as_slice()?)?),
            ColumnArray::Double(array) => Column::F64(rows(array.as_slice()?)?),
        })
    }
}

impl NumberArray<'_> {
    /// The numbers.
    pub fn column(&self) -> PyResult<Scalars<'_>> {
        Ok(match self {
            ColumnArray::Same(number) => Column::Same(*number),
            ColumnArray::Single(array) => Column::F32(array.as_slice()?),
            ColumnArray::Double(array) => Column::F64(array.as_slice()?),
        })
    }
}

/// Numbers by `N`.
pub fn rows<T, const N: usize>(numbers: &[T]) -> PyResult<&[[T; N]]> {
    match numbers.as_chunks() {
        (rows, []) => Ok(rows),
        _ => Err(wrong_length(numbers.len(), N)),
    }
}

/// Numbers by `N`, to be written.
pub fn rows_mut<T, const N: usize>(numbers: &mut [T]) -> PyResult<&mut [[T; N]]> {
    let count = numbers.len();
    match numbers.as_chunks_mut() {
        (rows, []) => Ok(rows),
        _ => Err(wrong_length(count, N)),
    }
}

fn wrong_length(count: usize, row: usize) -> PyErr {
    PyValueError::new_err(format!("expected rows of {row} numbers, found {count} numbers"))
}

/// There must be places for the answers of so many rays.
pub fn check_places(count: usize, found: &[usize]) -> PyResult<()> {
    match found.iter().all(|&found| found == count) {
        true => Ok(()),
        false => Err(PyValueError::new_err(format!("expected {count} places, found {found:?}"))),
    }
}

/// An array of answers.
pub type Places<'py, T> = PyReadwriteArrayDyn<'py, T>;

/// How many answers are in a row of an image, if the array has rows; 0 otherwise.
pub fn image_width<T: Element>(places: &Places<T>) -> usize {
    match places.shape() {
        [_, .., width] => *width,
        _ => 0,
    }
}

/// The vertex indices of triangles, in one of the types that they come in.
pub enum FaceArray<'py> {
    U32(PyReadonlyArrayDyn<'py, u32>),
    I32(PyReadonlyArrayDyn<'py, i32>),
    U64(PyReadonlyArrayDyn<'py, u64>),
    I64(PyReadonlyArrayDyn<'py, i64>),
}

impl<'a, 'py> FromPyObject<'a, 'py> for FaceArray<'py> {
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(array) = object.cast::<PyArrayDyn<i64>>() {
            return Ok(FaceArray::I64(array.try_readonly()?));
        }
        if let Ok(array) = object.cast::<PyArrayDyn<i32>>() {
            return Ok(FaceArray::I32(array.try_readonly()?));
        }
        if let Ok(array) = object.cast::<PyArrayDyn<u32>>() {
            return Ok(FaceArray::U32(array.try_readonly()?));
        }
        if let Ok(array) = object.cast::<PyArrayDyn<u64>>() {
            return Ok(FaceArray::U64(array.try_readonly()?));
        }
        Err(PyTypeError::new_err("faces: expected 32-bit or 64-bit integers"))
    }
}
