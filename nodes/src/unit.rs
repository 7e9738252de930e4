//! Units of length as parameters of nodes that load and save positions; inside, all positions are metres.

use face_io::LengthUnit;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A unit of length, by its symbol.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub(crate) enum Unit {
    /// Micrometres.
    #[serde(rename = "um")]
    Micrometres,
    /// Millimetres.
    #[serde(rename = "mm")]
    Millimetres,
    /// Centimetres.
    #[serde(rename = "cm")]
    Centimetres,
    /// Decimetres.
    #[serde(rename = "dm")]
    Decimetres,
    /// Metres.
    #[serde(rename = "m")]
    Metres,
    /// Inches of 25.4 mm.
    #[serde(rename = "in")]
    Inches,
    /// Feet of 12 inches.
    #[serde(rename = "ft")]
    Feet,
}

impl From<Unit> for LengthUnit {
    fn from(unit: Unit) -> Self {
        match unit {
            Unit::Micrometres => Self::Micrometre,
            Unit::Millimetres => Self::Millimetre,
            Unit::Centimetres => Self::Centimetre,
            Unit::Decimetres => Self::Decimetre,
            Unit::Metres => Self::Metre,
            Unit::Inches => Self::Inch,
            Unit::Feet => Self::Foot,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_name_units_as_files_do() {
        for symbol in LengthUnit::KNOWN.split(", ") {
            let unit: Unit = serde_json::from_value(symbol.into()).unwrap();
            assert_eq!(LengthUnit::from(unit).symbol(), symbol);
        }
    }
}
