//! Marker noise: how much each marker shakes, as it is measured on takes and handed to training and fine-tuning.

use super::{DataError, check_unique};
use serde::{Deserialize, Serialize};
use wire::{Data, DecodeError, Decoder, Encoder, Table, Value, ValueKind};

/// The noise of one marker.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NoiseOfMarker {
    /// The marker.
    pub marker: String,
    /// Standard deviation of a coordinate, in millimetres; positive or 0.
    pub sigma_mm: f64,
}

/// The noise of markers, each named once.
#[derive(Debug, Clone, PartialEq)]
pub struct MarkerNoise {
    markers: Vec<NoiseOfMarker>,
}

impl MarkerNoise {
    /// Noise of markers, in the order in which it is to be kept.
    ///
    /// # Errors
    /// Where a marker stands twice, or a noise is no number of 0 or more.
    pub fn new(markers: Vec<NoiseOfMarker>) -> Result<Self, DataError> {
        check_unique("marker", &markers.iter().map(|one| one.marker.clone()).collect::<Vec<_>>())?;
        match markers.iter().find(|one| !(one.sigma_mm.is_finite() && one.sigma_mm >= 0.0)) {
            Some(one) => Err(DataError::Number {
                what: format!("noise of marker `{}` in millimetres", one.marker),
                value: one.sigma_mm,
                wanted: "0 or more",
            }),
            None => Ok(Self { markers }),
        }
    }

    /// The markers and their noise.
    pub fn markers(&self) -> &[NoiseOfMarker] {
        &self.markers
    }

    /// Noise of the marker `name`, where it is known: standard deviation of a coordinate in millimetres.
    pub fn sigma_mm(&self, name: &str) -> Option<f64> {
        self.markers.iter().find(|one| one.marker == name).map(|one| one.sigma_mm)
    }
}

impl Value for MarkerNoise {
    fn kind(&self) -> ValueKind {
        ValueKind::of::<Self>()
    }

    fn encode(&self, out: &mut Encoder) {
        out.record(&self.markers);
    }

    fn summary(&self) -> String {
        let by_size = |a: &&NoiseOfMarker, b: &&NoiseOfMarker| a.sigma_mm.total_cmp(&b.sigma_mm);
        let ends = (self.markers.iter().min_by(by_size), self.markers.iter().max_by(by_size));
        let (Some(least), Some(most)) = ends else { return "noise of no marker".to_owned() };
        format!(
            "noise of {} markers, {:.3} mm ({}) to {:.3} mm ({})",
            self.markers.len(),
            least.sigma_mm,
            least.marker,
            most.sigma_mm,
            most.marker
        )
    }

    fn size(&self) -> usize {
        self.markers.iter().map(|one| one.marker.len() + 32).sum()
    }

    fn tables(&self) -> Vec<Table<'_>> {
        super::tables::noise(self)
    }
}

impl Data for MarkerNoise {
    const NAME: &'static str = "MarkerNoise";
    const VERSION: u32 = 1;
    const FRAMED: bool = false;

    fn decode(input: &mut Decoder<'_>) -> Result<Self, DecodeError> {
        Self::new(input.record()?).map_err(|error| DecodeError::Invalid { what: error.to_string() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(markers: &[(&str, f64)]) -> Result<MarkerNoise, DataError> {
        let one = |(name, sigma_mm): &(&str, f64)| NoiseOfMarker { marker: (*name).to_owned(), sigma_mm: *sigma_mm };
        MarkerNoise::new(markers.iter().map(one).collect())
    }

    #[test]
    fn noise_is_found_by_name_and_round_trips() {
        let noise = noise(&[("chin", 0.2), ("brow", 0.05)]).unwrap();
        assert_eq!((noise.sigma_mm("brow"), noise.sigma_mm("lip")), (Some(0.05), None));
        assert_eq!(noise.summary(), "noise of 2 markers, 0.050 mm (brow) to 0.200 mm (chin)");
        let encoded = (&noise as &dyn Value).encoded();
        let decoded = (ValueKind::of::<MarkerNoise>().decode)(&encoded).unwrap();
        assert_eq!(decoded.downcast_ref::<MarkerNoise>(), Some(&noise));
    }

    #[test]
    fn bad_numbers_and_names_are_refused() {
        assert!(matches!(noise(&[("a", 1.0), ("a", 1.0)]), Err(DataError::Twice { .. })));
        for bad in [-0.1, f64::NAN, f64::INFINITY] {
            assert!(noise(&[("a", bad)]).unwrap_err().to_string().contains("marker `a`"));
        }
    }
}
