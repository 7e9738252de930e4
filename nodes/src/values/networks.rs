//! Networks: the trained regressors of all regions. `train_regions` makes them, `solve_jaw` and `solve_regions` use them.

use face_math::data::FeatureSet;
use learn::Network;
use serde::{Deserialize, Serialize};
use wire::{Data, DecodeError, Decoder, Encoder, Rows, Table, Tolerance, Value, ValueKind};

/// The trained networks of all regions of a face (section 4.4 of FDLS).
#[derive(Debug, Clone, PartialEq)]
pub struct Networks {
    /// All channels of the training curves, in their order: the channels of a solve.
    pub channels: Vec<String>,
    /// The channels that no region solves; a solve leaves them at 0.
    pub unsolved: Vec<String>,
    /// Name of the region that solves the jaw.
    pub jaw: String,
    /// The regions, in the order of the regions' file.
    pub regions: Vec<RegionNetwork>,
}

/// The network of one region, and what it must be fed with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RegionNetwork {
    /// Name of the region.
    pub region: String,
    /// The markers whose features it sees, in their order.
    pub markers: Vec<String>,
    /// The feature sets it sees, in their order.
    pub sets: Vec<FeatureSet>,
    /// The channels it gives, in their order.
    pub channels: Vec<String>,
    /// The jaw channels it is conditioned on, in their order; none where it is not.
    pub conditions: Vec<String>,
    /// The network itself.
    pub network: Network,
    /// How its training went.
    pub training: TrainingRecord,
}

/// How the training of one network went, for people.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrainingRecord {
    /// Samples it saw in an epoch.
    pub samples: usize,
    /// The mean loss of each epoch; 1 is what a network that always gives the mean would have.
    pub losses: Vec<f64>,
}

impl Networks {
    /// The network of the region `name`.
    pub fn region(&self, name: &str) -> Option<&RegionNetwork> {
        self.regions.iter().find(|region| region.region == name)
    }
}

impl RegionNetwork {
    /// Whether the network takes and gives as many numbers as the names beside it say.
    fn fits(&self) -> bool {
        let architecture = self.network.architecture();
        architecture.outputs == self.channels.len() && architecture.conditions == self.conditions.len()
    }
}

impl Value for Networks {
    fn kind(&self) -> ValueKind {
        ValueKind::of::<Self>()
    }

    fn encode(&self, out: &mut Encoder) {
        out.record(&(&self.channels, &self.unsolved, &self.jaw));
        out.count(self.regions.len());
        for region in &self.regions {
            out.record(region);
        }
    }

    fn summary(&self) -> String {
        let parameters: usize = self.regions.iter().map(|region| region.network.architecture().parameter_count()).sum();
        let each = self.regions.iter().map(|region| {
            let losses = &region.training.losses;
            let last = losses.last().map_or(String::new(), |loss| format!(", loss {loss:.5}"));
            format!("{} ({} channels, {} epochs{last})", region.region, region.channels.len(), losses.len())
        });
        let each: Vec<_> = each.collect();
        format!("{} networks, {:.1} million parameters: {}", each.len(), parameters as f64 / 1e6, each.join(", "))
    }

    fn size(&self) -> usize {
        // A network keeps its numbers twice: as trained, and packed for evaluation.
        self.regions.iter().map(|region| region.network.architecture().parameter_count() * 8).sum()
    }

    /// How well they were trained: their weights mean nothing one by one, and drift apart on different machines.
    fn tables(&self) -> Vec<Table<'_>> {
        let epochs = self.regions.iter().map(|region| region.training.losses.len()).max().unwrap_or(0);
        vec![Table {
            what: "losses",
            unit: "",
            tolerance: Tolerance::relative(0.1),
            rows: Rows::Counted("epoch", epochs),
            columns: self.regions.iter().map(|region| region.region.clone()).collect(),
            number: Box::new(|epoch, region| {
                self.regions[region].training.losses.get(epoch).copied().unwrap_or(f64::NAN)
            }),
        }]
    }
}

impl Data for Networks {
    const NAME: &'static str = "Networks";
    const VERSION: u32 = 1;
    const FRAMED: bool = false;

    fn decode(input: &mut Decoder<'_>) -> Result<Self, DecodeError> {
        let (channels, unsolved, jaw) = input.record()?;
        let count = input.count()?;
        let mut regions = Vec::new();
        for _ in 0..count {
            let region: RegionNetwork = input.record()?;
            if !region.fits() {
                return Err(DecodeError::Invalid { what: format!("network of the region {}", region.region) });
            }
            regions.push(region);
        }
        Ok(Self { channels, unsolved, jaw, regions })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use learn::{Architecture, Matrix, Samples, Training};

    fn networks() -> Networks {
        let inputs = Matrix::from_fn(16, 3, |row, column| (row * (column + 1)) as f32 / 16.0);
        let targets = Matrix::from_fn(16, 2, |row, column| (row + column) as f32 / 16.0);
        let training = Training { epochs: 2, ..Training::default() };
        let network =
            learn::train(&Architecture::new(3, 2, 4, 1), &training, &Samples::new(&inputs, &targets), &()).unwrap();
        let region = RegionNetwork {
            region: "jaw".into(),
            markers: vec!["chin".into()],
            sets: vec![FeatureSet::Delta],
            channels: vec!["jawOpen".into(), "jawLeft".into()],
            conditions: Vec::new(),
            network,
            training: TrainingRecord { samples: 16, losses: vec![0.5, 0.25] },
        };
        Networks { channels: region.channels.clone(), unsolved: Vec::new(), jaw: "jaw".into(), regions: vec![region] }
    }

    #[test]
    fn networks_round_trip_bit_for_bit() {
        let networks = networks();
        let encoded = (&networks as &dyn Value).encoded();
        let decoded = (ValueKind::of::<Networks>().decode)(&encoded).unwrap();
        assert_eq!(decoded.downcast_ref::<Networks>(), Some(&networks));
        assert_eq!(decoded.encoded(), encoded);
        let summary = networks.summary();
        assert!(summary.contains("jaw (2 channels, 2 epochs, loss 0.25000)"), "{summary}");
    }

    #[test]
    fn a_network_that_does_not_fit_its_names_is_refused() {
        let mut networks = networks();
        networks.regions[0].conditions = vec!["jawOpen".into()];
        let encoded = (&networks as &dyn Value).encoded();
        assert!((ValueKind::of::<Networks>().decode)(&encoded).is_err());
    }
}
