//! Units of length that files state their positions in; inside, all positions are metres.

use serde::{Deserialize, Serialize};
use std::fmt;

/// A unit of length.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum LengthUnit {
    /// 10⁻⁶ m.
    #[serde(rename = "um")]
    Micrometre,
    /// 10⁻³ m.
    #[serde(rename = "mm")]
    Millimetre,
    /// 10⁻² m.
    #[serde(rename = "cm")]
    Centimetre,
    /// 10⁻¹ m.
    #[serde(rename = "dm")]
    Decimetre,
    /// 1 m.
    #[serde(rename = "m")]
    Metre,
    /// 25.4 mm.
    #[serde(rename = "in")]
    Inch,
    /// 12 inches.
    #[serde(rename = "ft")]
    Foot,
}

impl LengthUnit {
    /// What [`LengthUnit::from_text`] understands, for messages.
    pub const KNOWN: &str = "um, mm, cm, dm, m, in, ft";

    /// Reads a unit as files spell it: symbol or word, any case, with blanks or brackets around it.
    pub fn from_text(text: &str) -> Option<Self> {
        let text = text.trim_matches(|c: char| c.is_whitespace() || "\0[]().".contains(c)).to_lowercase();
        Some(match text.as_str() {
            "um" | "µm" | "μm" | "micron" | "microns" | "micrometre" | "micrometer" | "micrometres" | "micrometers" => {
                Self::Micrometre
            }
            "mm" | "mms" | "millimetre" | "millimeter" | "millimetres" | "millimeters" => Self::Millimetre,
            "cm" | "cms" | "centimetre" | "centimeter" | "centimetres" | "centimeters" => Self::Centimetre,
            "dm" | "decimetre" | "decimeter" | "decimetres" | "decimeters" => Self::Decimetre,
            "m" | "metre" | "meter" | "metres" | "meters" | "mtr" => Self::Metre,
            "in" | "inch" | "inches" | "\"" => Self::Inch,
            "ft" | "foot" | "feet" | "'" => Self::Foot,
            _ => return None,
        })
    }

    /// Its symbol.
    pub const fn symbol(self) -> &'static str {
        match self {
            Self::Micrometre => "um",
            Self::Millimetre => "mm",
            Self::Centimetre => "cm",
            Self::Decimetre => "dm",
            Self::Metre => "m",
            Self::Inch => "in",
            Self::Foot => "ft",
        }
    }

    /// How many metres one of it is.
    pub const fn metres(self) -> f64 {
        match self {
            Self::Micrometre => 1e-6,
            Self::Millimetre => 1e-3,
            Self::Centimetre => 1e-2,
            Self::Decimetre => 1e-1,
            Self::Metre => 1.0,
            Self::Inch => 0.0254,
            Self::Foot => 0.3048,
        }
    }

    /// A length in this unit as metres, rounded once.
    pub fn to_metres(self, length: f64) -> f32 {
        (length * self.metres()) as f32
    }

    /// The length in this unit that [`LengthUnit::to_metres`] turns into exactly `metres`, where a 32-bit float can
    /// hold one; otherwise the nearest.
    ///
    /// Values that were read from a file in this unit therefore write back the same, and read again the same.
    pub fn from_metres(self, metres: f32) -> f32 {
        let nearest = (f64::from(metres) / self.metres()) as f32;
        let exact = |length: &f32| self.to_metres(f64::from(*length)).to_bits() == metres.to_bits();
        [nearest, nearest.next_up(), nearest.next_down()].into_iter().find(exact).unwrap_or(nearest)
    }
}

impl fmt::Display for LengthUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.symbol())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn lengths_that_came_from_a_unit_go_back_and_come_again_the_same(length in -3000.0_f32..3000.0) {
            for unit in [LengthUnit::Millimetre, LengthUnit::Centimetre, LengthUnit::Metre, LengthUnit::Inch] {
                let metres = unit.to_metres(f64::from(length));
                prop_assert_eq!(unit.to_metres(f64::from(unit.from_metres(metres))).to_bits(), metres.to_bits());
            }
        }
    }

    #[test]
    fn units_are_read_as_files_spell_them() {
        assert_eq!(LengthUnit::from_text("mm  "), Some(LengthUnit::Millimetre));
        assert_eq!(LengthUnit::from_text("Meters\0"), Some(LengthUnit::Metre));
        assert_eq!(LengthUnit::from_text("IN"), Some(LengthUnit::Inch));
        assert_eq!(LengthUnit::from_text("[mm]"), Some(LengthUnit::Millimetre));
        assert_eq!(LengthUnit::from_text("deg"), None);
        for unit in [LengthUnit::Micrometre, LengthUnit::Decimetre, LengthUnit::Foot, LengthUnit::Inch] {
            assert_eq!(LengthUnit::from_text(unit.symbol()), Some(unit));
        }
    }
}
