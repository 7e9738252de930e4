//! The shapes that a face's markers take: their mean and the ways in which they vary together. Learned from frames in which
//! all are seen, used to tell those that are not.

use super::{DataError, check_size, check_unique};
use glam::Vec3;
use wire::{Data, DecodeError, Decoder, Encoder, Value, ValueKind};

/// Principal components of marker positions, the head's motion taken out.
#[derive(Debug, Clone, PartialEq)]
pub struct ShapeSpace {
    markers: Vec<String>,
    mean: Vec<Vec3>,
    modes: Vec<Vec3>,
    spreads_m: Vec<f64>,
    remainder_m: f64,
}

impl ShapeSpace {
    /// A space of `spreads_m.len()` modes over the named markers: mean places (metres), modes (each of length 1 over all
    /// its coordinates, mode after mode), the standard deviation of each mode, and that of what no mode holds, a
    /// coordinate (metres).
    ///
    /// # Errors
    /// Where sizes do not fit, a name stands twice, or a spread is not positive.
    pub fn new(
        markers: Vec<String>,
        mean: Vec<Vec3>,
        modes: Vec<Vec3>,
        spreads_m: Vec<f64>,
        remainder_m: f64,
    ) -> Result<Self, DataError> {
        check_unique("marker", &markers)?;
        check_size("mean positions", markers.len(), mean.len())?;
        check_size("positions of modes", markers.len() * spreads_m.len(), modes.len())?;
        let wrong = spreads_m.iter().chain([&remainder_m]).find(|spread| !(spread.is_finite() && **spread > 0.0));
        if let Some(spread) = wrong {
            return Err(DataError::Number {
                what: "a spread of the shape space in metres".to_owned(),
                value: *spread,
                wanted: "a positive number",
            });
        }
        Ok(Self { markers, mean, modes, spreads_m, remainder_m })
    }

    /// Marker names.
    pub fn markers(&self) -> &[String] {
        &self.markers
    }

    /// Mean places, in metres.
    pub fn mean(&self) -> &[Vec3] {
        &self.mean
    }

    /// What each marker does in a mode of length 1.
    pub fn mode(&self, mode: usize) -> &[Vec3] {
        &self.modes[mode * self.markers.len()..(mode + 1) * self.markers.len()]
    }

    /// Standard deviation of each mode, in metres, the greatest first.
    pub fn spreads_m(&self) -> &[f64] {
        &self.spreads_m
    }

    /// Standard deviation of a coordinate that no mode explains, in metres.
    pub fn remainder_m(&self) -> f64 {
        self.remainder_m
    }
}

impl Value for ShapeSpace {
    fn kind(&self) -> ValueKind {
        ValueKind::of::<Self>()
    }

    fn encode(&self, out: &mut Encoder) {
        out.record(&(&self.markers, &self.spreads_m, self.remainder_m));
        out.points(&self.mean);
        out.points(&self.modes);
    }

    fn summary(&self) -> String {
        let largest = self.spreads_m.first().map_or(0.0, |spread| 1000.0 * spread);
        format!(
            "{} modes of {} markers, the largest {largest:.2} mm; {:.3} mm a coordinate left over",
            self.spreads_m.len(),
            self.markers.len(),
            1000.0 * self.remainder_m
        )
    }

    fn size(&self) -> usize {
        self.modes.len() * 12 + self.markers.iter().map(|name| name.len() + 36).sum::<usize>()
    }
}

impl Data for ShapeSpace {
    const NAME: &'static str = "ShapeSpace";
    const VERSION: u32 = 1;
    const FRAMED: bool = false;

    fn decode(input: &mut Decoder<'_>) -> Result<Self, DecodeError> {
        let (markers, spreads_m, remainder_m) = input.record()?;
        let (mean, modes) = (input.points()?, input.points()?);
        Self::new(markers, mean, modes, spreads_m, remainder_m)
            .map_err(|error| DecodeError::Invalid { what: error.to_string() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spaces_round_trip_and_misfits_are_refused() {
        let names = || vec!["a".to_owned(), "b".to_owned()];
        let space = ShapeSpace::new(names(), vec![Vec3::ZERO; 2], vec![Vec3::X; 4], vec![2e-3, 1e-3], 1e-4).unwrap();
        assert_eq!(space.mode(1), [Vec3::X; 2]);
        let encoded = (&space as &dyn Value).encoded();
        let decoded = (ValueKind::of::<ShapeSpace>().decode)(&encoded).unwrap();
        assert_eq!(decoded.downcast_ref::<ShapeSpace>(), Some(&space));
        assert!(ShapeSpace::new(names(), vec![Vec3::ZERO; 2], vec![Vec3::X; 3], vec![1.0], 1.0).is_err());
        assert!(ShapeSpace::new(names(), vec![Vec3::ZERO; 2], vec![Vec3::X; 2], vec![0.0], 1.0).is_err());
    }
}
