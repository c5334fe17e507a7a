//! The number types of PLY: the eight of the format, under their old names and their new ones,
//! and the integers of 64 bits that writers in Python add to them.

/// A number type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Scalar {
    /// The type called `name` in a header.
    pub fn from_name(name: &[u8]) -> Option<Scalar> {
        Some(match name {
            b"char" | b"int8" => Scalar::I8,
            b"uchar" | b"uint8" => Scalar::U8,
            b"short" | b"int16" => Scalar::I16,
            b"ushort" | b"uint16" => Scalar::U16,
            b"int" | b"int32" => Scalar::I32,
            b"uint" | b"uint32" => Scalar::U32,
            b"int64" => Scalar::I64,
            b"uint64" => Scalar::U64,
            b"float" | b"float32" => Scalar::F32,
            b"double" | b"float64" => Scalar::F64,
            _ => return None,
        })
    }

    /// Bytes of one number in a binary file.
    pub fn size(self) -> usize {
        match self {
            Scalar::I8 | Scalar::U8 => 1,
            Scalar::I16 | Scalar::U16 => 2,
            Scalar::I32 | Scalar::U32 | Scalar::F32 => 4,
            Scalar::I64 | Scalar::U64 | Scalar::F64 => 8,
        }
    }

    /// True for the types that may count a list or name a vertex.
    pub fn is_integer(self) -> bool {
        !matches!(self, Scalar::F32 | Scalar::F64)
    }

    /// True if single precision holds every value of the type.
    pub fn fits_f32(self) -> bool {
        matches!(self, Scalar::I8 | Scalar::U8 | Scalar::I16 | Scalar::U16 | Scalar::F32)
    }

    /// The least and the largest value of an integer type, as far as `i64` holds them; of the
    /// others, all that `i64` holds.
    pub fn range(self) -> (i64, i64) {
        match self {
            Scalar::I8 => (i8::MIN.into(), i8::MAX.into()),
            Scalar::U8 => (0, u8::MAX.into()),
            Scalar::I16 => (i16::MIN.into(), i16::MAX.into()),
            Scalar::U16 => (0, u16::MAX.into()),
            Scalar::I32 => (i32::MIN.into(), i32::MAX.into()),
            Scalar::U32 => (0, u32::MAX.into()),
            Scalar::U64 => (0, i64::MAX),
            Scalar::I64 | Scalar::F32 | Scalar::F64 => (i64::MIN, i64::MAX),
        }
    }

    /// The number that `bytes` begin with, as an integer; floating-point ones are cut,
    /// and what is above `i64` becomes its largest value, too large to count or name anything.
    ///
    /// # Panics
    /// If there are fewer bytes than [`Scalar::size`].
    #[inline]
    pub fn integer<const BIG: bool>(self, bytes: &[u8]) -> i64 {
        match self {
            Scalar::I8 => i8::read::<BIG>(bytes).into(),
            Scalar::U8 => u8::read::<BIG>(bytes).into(),
            Scalar::I16 => i16::read::<BIG>(bytes).into(),
            Scalar::U16 => u16::read::<BIG>(bytes).into(),
            Scalar::I32 => i32::read::<BIG>(bytes).into(),
            Scalar::U32 => u32::read::<BIG>(bytes).into(),
            Scalar::I64 => i64::read::<BIG>(bytes),
            Scalar::U64 => i64::try_from(u64::read::<BIG>(bytes)).unwrap_or(i64::MAX),
            Scalar::F32 => f32::read::<BIG>(bytes) as i64,
            Scalar::F64 => f64::read::<BIG>(bytes) as i64,
        }
    }

    /// The number that `bytes` begin with: exactly, but for integers beyond 2^53, which are rounded.
    ///
    /// # Panics
    /// If there are fewer bytes than [`Scalar::size`].
    #[inline]
    pub fn real<const BIG: bool>(self, bytes: &[u8]) -> f64 {
        match self {
            Scalar::F32 => f32::read::<BIG>(bytes).into(),
            Scalar::F64 => f64::read::<BIG>(bytes),
            Scalar::U64 => u64::read::<BIG>(bytes) as f64,
            _ => self.integer::<BIG>(bytes) as f64,
        }
    }

    /// A colour component of this type on the scale of a byte: floating point from 0 to 1 and
    /// `ushort` from 0 to 65535 are scaled, other integers are taken for bytes already.
    #[inline]
    pub fn color_byte(self, value: f64) -> u8 {
        // The casts saturate, and take NaN to 0.
        match self {
            Scalar::F32 | Scalar::F64 => (value * 255.0).round() as u8,
            Scalar::U16 => (value * (255.0 / 65535.0)).round() as u8,
            _ => value as u8,
        }
    }
}

/// A type that can be read from the start of some bytes.
pub trait Number: Sized + Copy {
    /// Reads it, in big-endian order if `BIG`.
    fn read<const BIG: bool>(bytes: &[u8]) -> Self;
}

macro_rules! number {
    ($($type:ty),*) => {$(
        impl Number for $type {
            #[inline(always)]
            fn read<const BIG: bool>(bytes: &[u8]) -> $type {
                let mut raw = [0; size_of::<$type>()];
                raw.copy_from_slice(&bytes[..size_of::<$type>()]);
                if BIG { <$type>::from_be_bytes(raw) } else { <$type>::from_le_bytes(raw) }
            }
        }
    )*};
}
number!(i8, u8, i16, u16, i32, u32, i64, u64, f32, f64);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_byte_orders_are_read() {
        assert_eq!(Scalar::I16.integer::<false>(&[0xfe, 0xff]), -2);
        assert_eq!(Scalar::I16.integer::<true>(&[0xff, 0xfe]), -2);
        assert_eq!(Scalar::U32.real::<true>(&[0xff, 0xff, 0xff, 0xff]), 4_294_967_295.0);
        assert_eq!(Scalar::I64.integer::<true>(&(-5_i64).to_be_bytes()), -5);
        assert_eq!(Scalar::U64.integer::<false>(&u64::MAX.to_le_bytes()), i64::MAX);
        assert_eq!(Scalar::U64.real::<false>(&(1_u64 << 63).to_le_bytes()), 2.0_f64.powi(63));
        assert_eq!(Scalar::F64.real::<true>(&1.5_f64.to_be_bytes()), 1.5);
        assert_eq!(Scalar::F32.real::<false>(&1.5_f32.to_le_bytes()), 1.5);
    }

    #[test]
    fn colours_are_scaled_to_bytes_and_saturate() {
        assert_eq!(Scalar::F32.color_byte(0.5), 128);
        assert_eq!(Scalar::F32.color_byte(7.0), 255);
        assert_eq!(Scalar::F64.color_byte(f64::NAN), 0);
        assert_eq!(Scalar::U16.color_byte(65535.0), 255);
        assert_eq!(Scalar::U16.color_byte(257.0), 1);
        assert_eq!(Scalar::U16.color_byte(129.0), 1);
        assert_eq!(Scalar::U16.color_byte(128.0), 0);
        assert_eq!(Scalar::I32.color_byte(-3.0), 0);
        assert_eq!(Scalar::U8.color_byte(200.0), 200);
    }
}
