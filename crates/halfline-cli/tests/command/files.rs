//! NumPy files, written and read by others than the command itself.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use npyz::{DType, NpyFile, Order, WriteOptions, WriterBuilder};

/// A `.npy` file of any content, sense or nonsense.
pub fn npy(dtype: &str, fortran_order: bool, shape: &str, data: &[u8]) -> Vec<u8> {
    let order = if fortran_order { "True" } else { "False" };
    let header = format!("{{'descr': '{dtype}', 'fortran_order': {order}, 'shape': {shape}, }}\n");
    let length = (header.len() as u16).to_le_bytes();
    [b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), data].concat()
}

/// Writes rays of `columns` numbers each as the given type and order.
pub fn write_rays(path: &Path, numbers: &[f64], columns: usize, dtype: &str, order: Order) {
    let rows = numbers.len() / columns;
    let stored: Vec<f64> = match order {
        Order::C => numbers.to_vec(),
        Order::Fortran => {
            (0..columns).flat_map(|c| (0..rows).map(move |r| numbers[r * columns + c])).collect()
        }
    };
    let shape = [rows as u64, columns as u64];
    let mut file = Vec::new();
    let plain = DType::Plain(dtype.parse().unwrap());
    match dtype.ends_with('4') {
        true => {
            let options = WriteOptions::new().dtype(plain).shape(&shape).order(order);
            let mut writer = options.writer(&mut file).begin_nd().unwrap();
            writer.extend(stored.into_iter().map(|x| x as f32)).unwrap();
            writer.finish().unwrap();
        }
        false => {
            let options = WriteOptions::new().dtype(plain).shape(&shape).order(order);
            let mut writer = options.writer(&mut file).begin_nd().unwrap();
            writer.extend(stored).unwrap();
            writer.finish().unwrap();
        }
    }
    std::fs::write(path, file).unwrap();
}

/// What `halfline query` wrote.
#[derive(Debug, PartialEq)]
pub enum Array {
    Float(Vec<f64>),
    Int(Vec<i64>),
    Bool(Vec<bool>),
}

impl Array {
    pub fn floats(&self) -> &[f64] {
        match self {
            Array::Float(values) => values,
            other => panic!("{other:?} instead of floats"),
        }
    }

    pub fn ints(&self) -> &[i64] {
        match self {
            Array::Int(values) => values,
            other => panic!("{other:?} instead of integers"),
        }
    }

    pub fn bools(&self) -> &[bool] {
        match self {
            Array::Bool(values) => values,
            other => panic!("{other:?} instead of booleans"),
        }
    }
}

/// Arrays of an archive by name, with their shapes.
pub type Arrays = BTreeMap<String, (Vec<u64>, Array)>;

/// Reads an `.npz` file.
pub fn read_npz(path: &Path) -> Arrays {
    let mut archive = zip::ZipArchive::new(File::open(path).unwrap()).unwrap();
    let mut arrays = Arrays::new();
    for i in 0..archive.len() {
        let mut entry = archive.by_index(i).unwrap();
        let name = entry.name().unwrap().strip_suffix(".npy").unwrap().to_string();
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes).unwrap();
        let npy = NpyFile::new(&bytes[..]).unwrap();
        assert_eq!(npy.order(), Order::C);
        let shape = npy.shape().to_vec();
        let array = match npy.dtype().descr().as_str() {
            "'<f8'" => Array::Float(npy.into_vec().unwrap()),
            "'<i8'" => Array::Int(npy.into_vec().unwrap()),
            "'|b1'" => Array::Bool(npy.into_vec().unwrap()),
            other => panic!("{name} has dtype {other}"),
        };
        arrays.insert(name, (shape, array));
    }
    arrays
}
