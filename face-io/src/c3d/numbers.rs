//! Numbers of a C3D file: the three processors that wrote them and the three ways they lay out bytes.

use super::C3dError;

/// The make of processor whose number formats a file uses (the byte at the start of its parameters).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Processor {
    /// Little-endian, IEEE floats: PCs.
    Intel,
    /// Little-endian, VAX F floats: DEC machines.
    Dec,
    /// Big-endian, IEEE floats: SGI and other MIPS machines.
    Mips,
}

impl Processor {
    /// From the processor byte (84, 85 or 86).
    pub(super) fn from_byte(byte: u8) -> Option<Self> {
        match byte {
            84 => Some(Self::Intel),
            85 => Some(Self::Dec),
            86 => Some(Self::Mips),
            _ => None,
        }
    }

    /// Its name for people.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Intel => "Intel",
            Self::Dec => "DEC",
            Self::Mips => "SGI/MIPS",
        }
    }

    pub(super) const fn byte(self) -> u8 {
        match self {
            Self::Intel => 84,
            Self::Dec => 85,
            Self::Mips => 86,
        }
    }

    pub(super) fn u16(self, bytes: [u8; 2]) -> u16 {
        match self {
            Self::Intel | Self::Dec => u16::from_le_bytes(bytes),
            Self::Mips => u16::from_be_bytes(bytes),
        }
    }

    pub(super) fn f32(self, bytes: [u8; 4]) -> f32 {
        match self {
            Self::Intel => f32::from_le_bytes(bytes),
            Self::Mips => f32::from_be_bytes(bytes),
            Self::Dec => vax_float(bytes),
        }
    }

    pub(super) fn u16_bytes(self, number: u16) -> [u8; 2] {
        match self {
            Self::Intel | Self::Dec => number.to_le_bytes(),
            Self::Mips => number.to_be_bytes(),
        }
    }

    /// `None` for what the format cannot hold.
    pub(super) fn f32_bytes(self, number: f32) -> Option<[u8; 4]> {
        match self {
            Self::Intel => Some(number.to_le_bytes()),
            Self::Mips => Some(number.to_be_bytes()),
            Self::Dec => vax_bytes(number),
        }
    }
}

/// A VAX F float: two little-endian words, high word first, holding sign s, exponent e and fraction f.
///
/// value = (-1)^s · (2²³ + f) · 2^(e - 152), with 8 bits of e and 23 of f; e = 0 is zero where s = 0, and the
/// reserved operand (here NaN) where s = 1. Source: VAX Architecture Reference Manual, `F_floating`.
pub(super) fn vax_float(bytes: [u8; 4]) -> f32 {
    let high = u32::from(u16::from_le_bytes([bytes[0], bytes[1]]));
    let low = u32::from(u16::from_le_bytes([bytes[2], bytes[3]]));
    let bits = high << 16 | low;
    let negative = bits >> 31 == 1;
    let exponent = (bits >> 23 & 0xff).cast_signed();
    if exponent == 0 {
        return if negative { f32::NAN } else { 0.0 };
    }
    let mantissa = f64::from(bits & 0x007f_ffff | 0x0080_0000);
    let magnitude = (mantissa * f64::from(exponent - 152).exp2()) as f32;
    if negative { -magnitude } else { magnitude }
}

/// A number as VAX F float (see [`vax_float`]). What lies below its range, 2^-128, is zero; `None` for what lies above it, from
/// 2^127 on, and for what is no number.
fn vax_bytes(number: f32) -> Option<[u8; 4]> {
    // Double precision holds every single-precision number in its normal form: ±(2^52 + f) · 2^(e - 1075).
    let bits = f64::from(number).to_bits();
    let exponent = (bits >> 52 & 0x7ff).cast_signed() - 1023 + 129;
    let bits = match exponent {
        ..1 => 0,
        1..256 => (bits >> 63 << 31) as u32 | (exponent as u32) << 23 | (bits >> 29 & 0x007f_ffff) as u32,
        _ => return None,
    };
    // The high word comes first.
    Some(bits.rotate_left(16).to_le_bytes())
}

/// The bytes of a file together with the way to read numbers from them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Source<'a> {
    pub bytes: &'a [u8],
    pub processor: Processor,
}

impl<'a> Source<'a> {
    pub fn slice(&self, at: usize, length: usize, what: &str) -> Result<&'a [u8], C3dError> {
        let short = || C3dError::Short { what: what.to_owned(), begins: at, length, have: self.bytes.len() };
        let end = at.checked_add(length).ok_or_else(short)?;
        self.bytes.get(at..end).ok_or_else(short)
    }

    fn array<const N: usize>(&self, at: usize, what: &str) -> Result<[u8; N], C3dError> {
        let mut array = [0; N];
        array.copy_from_slice(self.slice(at, N, what)?);
        Ok(array)
    }

    pub fn u8(&self, at: usize, what: &str) -> Result<u8, C3dError> {
        Ok(self.array::<1>(at, what)?[0])
    }

    pub fn u16(&self, at: usize, what: &str) -> Result<u16, C3dError> {
        Ok(self.processor.u16(self.array(at, what)?))
    }

    pub fn f32(&self, at: usize, what: &str) -> Result<f32, C3dError> {
        Ok(self.processor.f32(self.array(at, what)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vax_floats_of_the_reference_manual_decode() {
        // 1.0 is 0x00004080, 3.5 is 0x00004160, -3.5 is 0x0000C160 (as little-endian 32-bit numbers).
        assert_eq!(vax_float(0x0000_4080_u32.to_le_bytes()).to_bits(), 1.0_f32.to_bits());
        assert_eq!(vax_float(0x0000_4160_u32.to_le_bytes()).to_bits(), 3.5_f32.to_bits());
        assert_eq!(vax_float(0x0000_C160_u32.to_le_bytes()).to_bits(), (-3.5_f32).to_bits());
        // Pi is 0x0FD04149, its words the other way round from the bits of IEEE.
        assert!((vax_float(0x0FDB_4149_u32.to_le_bytes()) - std::f32::consts::PI).abs() < 1e-6);
        assert_eq!(vax_float([0; 4]).to_bits(), 0);
        assert!(vax_float(0x0000_8000_u32.to_le_bytes()).is_nan());
    }

    proptest::proptest! {
        #[test]
        fn vax_floats_keep_every_bit_within_their_range(bits: u32) {
            let number = f32::from_bits(bits);
            match vax_bytes(number) {
                Some(bytes) if number.abs() >= (-128.0_f32).exp2() => {
                    proptest::prop_assert_eq!(vax_float(bytes).to_bits(), bits);
                }
                Some(bytes) => {
                    proptest::prop_assert!(number.abs() < (-128.0_f32).exp2());
                    proptest::prop_assert_eq!(bytes, [0; 4]);
                }
                None => proptest::prop_assert!(!number.is_finite() || number.abs() >= 127.0_f32.exp2()),
            }
        }
    }
}
