//! The space of meshes that a face takes: their mean and principal components, learned from training meshes.

use super::{DataError, check_size};
use glam::Vec3;
use wire::{Data, DecodeError, Decoder, Encoder, Rows, Table, Tolerance, Value, ValueKind};

/// A mean mesh and its modes, the greatest first.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshSpace {
    mean: Vec<Vec3>,
    modes: Vec<Vec3>,
    spreads_m: Vec<f64>,
}

impl MeshSpace {
    /// A space from its mean (metres), modes (unit vectors over all coordinates, mode after mode) and the standard
    /// deviation along each.
    ///
    /// # Errors
    /// Where sizes do not fit or a spread is not a positive number.
    pub fn new(mean: Vec<Vec3>, modes: Vec<Vec3>, spreads_m: Vec<f64>) -> Result<Self, DataError> {
        check_size("modes of a mesh space", mean.len() * spreads_m.len(), modes.len())?;
        if let Some(spread) = spreads_m.iter().find(|spread| !(spread.is_finite() && **spread > 0.0)) {
            let what = "a spread of the mesh space in metres".to_owned();
            return Err(DataError::Number { what, value: *spread, wanted: "a positive number" });
        }
        Ok(Self { mean, modes, spreads_m })
    }

    /// Mean positions, in metres.
    pub fn mean(&self) -> &[Vec3] {
        &self.mean
    }

    /// What each vertex does in a mode of length 1.
    pub fn mode(&self, mode: usize) -> &[Vec3] {
        &self.modes[mode * self.mean.len()..(mode + 1) * self.mean.len()]
    }

    /// Standard deviation along each mode, in metres, the greatest first.
    pub fn spreads_m(&self) -> &[f64] {
        &self.spreads_m
    }
}

impl Value for MeshSpace {
    fn kind(&self) -> ValueKind {
        ValueKind::of::<Self>()
    }

    fn encode(&self, out: &mut Encoder) {
        out.points(&self.mean);
        out.points(&self.modes);
        out.f64s(&self.spreads_m);
    }

    fn summary(&self) -> String {
        let spread = |place: Option<&f64>| place.map_or(0.0, |spread| 1000.0 * spread);
        format!(
            "{} modes of {} vertices, {:.1} mm to {:.4} mm over all coordinates",
            self.spreads_m.len(),
            self.mean.len(),
            spread(self.spreads_m.first()),
            spread(self.spreads_m.last())
        )
    }

    fn size(&self) -> usize {
        self.modes.len() * 12 + self.mean.len() * 12
    }

    fn tables(&self) -> Vec<Table<'_>> {
        vec![Table {
            what: "spreads",
            unit: "mm",
            tolerance: Tolerance { absolute: 1e-3, relative: 1e-3 },
            rows: Rows::Counted("mode", self.spreads_m.len()),
            columns: vec!["spread".to_owned()],
            number: Box::new(|mode, _| 1000.0 * self.spreads_m[mode]),
        }]
    }
}

impl Data for MeshSpace {
    const NAME: &'static str = "MeshSpace";
    const VERSION: u32 = 1;
    const FRAMED: bool = false;

    fn decode(input: &mut Decoder<'_>) -> Result<Self, DecodeError> {
        Self::new(input.points()?, input.points()?, input.f64s()?)
            .map_err(|error| DecodeError::Invalid { what: error.to_string() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spaces_round_trip_and_misfits_are_refused() {
        let space = MeshSpace::new(vec![Vec3::ZERO; 2], vec![Vec3::X; 4], vec![2e-3, 1e-3]).unwrap();
        let encoded = (&space as &dyn Value).encoded();
        let decoded = (ValueKind::of::<MeshSpace>().decode)(&encoded).unwrap();
        assert_eq!(decoded.downcast_ref::<MeshSpace>(), Some(&space));
        assert!(MeshSpace::new(vec![Vec3::ZERO; 2], vec![Vec3::X; 3], vec![1.0]).is_err());
        assert!(MeshSpace::new(vec![Vec3::ZERO; 2], vec![Vec3::X; 2], vec![0.0]).is_err());
    }
}
