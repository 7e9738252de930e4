//! The manifold of plausible strains: an autoencoder with the names of what goes in. `train_strain_autoencoder` makes it,
//! `solve_strains` uses it.

use face_math::data::{DataError, Rig, nearest_name};
use face_math::strain::{Manifold, StrainError, pose_channels, strain_channels};
use learn::Autoencoder;
use wire::{Data, DecodeError, Decoder, Encoder, Rows, Table, Tolerance, Value, ValueKind};

/// An autoencoder of strains under the jaw's pose (section A.4 of Animatomy). Rest stays exactly at rest.
#[derive(Debug, Clone, PartialEq)]
pub struct StrainAutoencoder {
    /// The strains, in the order in which they go in.
    pub strains: Vec<String>,
    /// The pose channels that go in beside them.
    pub poses: Vec<String>,
    /// The network.
    pub network: Autoencoder,
    /// The loss of each epoch; 1 is what giving 0 for everything would have.
    pub losses: Vec<f64>,
}

impl StrainAutoencoder {
    /// The manifold for the channels of a rig.
    ///
    /// # Errors
    /// Where the rig lacks a strain or a pose channel, or has a strain that the autoencoder does not know.
    pub(crate) fn on(&self, rig: &Rig) -> Result<RigManifold<'_>, StrainError> {
        let places = |own: &[String], all: &[String]| -> Result<Vec<usize>, DataError> {
            let place = |name: &String| {
                all.iter().position(|other| other == name).ok_or_else(|| DataError::Missing {
                    what: "channel",
                    name: name.clone(),
                    near: nearest_name(name, all.iter().map(String::as_str)),
                })
            };
            own.iter().map(place).collect()
        };
        let (strains, poses) = (strain_channels(rig)?, pose_channels(rig)?);
        // Each strain of the rig must be known, and the other way round.
        places(&strains, &self.strains)?;
        Ok(RigManifold {
            network: &self.network,
            strains: places(&self.strains, &strains)?,
            poses: places(&self.poses, &poses)?,
            widths: [strains.len(), poses.len()],
        })
    }
}

/// The manifold with its values in the order of a rig's channels.
pub(crate) struct RigManifold<'a> {
    network: &'a Autoencoder,
    strains: Vec<usize>,
    poses: Vec<usize>,
    widths: [usize; 2],
}

impl RigManifold<'_> {
    fn pick(rows: &[f64], places: &[usize], width: usize) -> Vec<f64> {
        rows.chunks_exact(width).flat_map(|row| places.iter().map(|place| row[*place])).collect()
    }

    fn put_back(&self, rows: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; rows.len()];
        let width = self.strains.len();
        for (own, row) in out.chunks_exact_mut(width).zip(rows.chunks_exact(width)) {
            self.strains.iter().zip(row).for_each(|(place, value)| own[*place] = *value);
        }
        out
    }
}

impl Manifold for RigManifold<'_> {
    fn residual(&self, strains: &[f64], poses: &[f64]) -> Vec<f64> {
        let own = Self::pick(strains, &self.strains, self.widths[0]);
        let out = self.put_back(&self.network.reconstruct(&own, &Self::pick(poses, &self.poses, self.widths[1])));
        out.iter().zip(strains).map(|(out, strain)| out - strain).collect()
    }

    fn pull_back(&self, strains: &[f64], poses: &[f64], by: &[f64]) -> Vec<f64> {
        let [own, moved] = [strains, by].map(|rows| Self::pick(rows, &self.strains, self.widths[0]));
        let pulled = self.network.pull_back(&own, &Self::pick(poses, &self.poses, self.widths[1]), &moved);
        self.put_back(&pulled).iter().zip(by).map(|(pulled, by)| pulled - by).collect()
    }
}

impl Value for StrainAutoencoder {
    fn kind(&self) -> ValueKind {
        ValueKind::of::<Self>()
    }

    fn encode(&self, out: &mut Encoder) {
        out.record(&(&self.strains, &self.poses, &self.network, &self.losses));
    }

    fn summary(&self) -> String {
        let last = self.losses.last().map_or(String::new(), |loss| format!(", loss {loss:.5}"));
        format!(
            "autoencoder of {} strains under {} pose channels, {} epochs{last}",
            self.strains.len(),
            self.poses.len(),
            self.losses.len()
        )
    }

    fn size(&self) -> usize {
        self.network.parameter_count() * 8
    }

    fn tables(&self) -> Vec<Table<'_>> {
        vec![Table {
            what: "losses",
            unit: "",
            tolerance: Tolerance::relative(0.1),
            rows: Rows::Counted("epoch", self.losses.len()),
            columns: vec!["loss".to_owned()],
            number: Box::new(|epoch, _| self.losses[epoch]),
        }]
    }
}

impl Data for StrainAutoencoder {
    const NAME: &'static str = "StrainAutoencoder";
    const VERSION: u32 = 1;
    const FRAMED: bool = false;

    fn decode(input: &mut Decoder<'_>) -> Result<Self, DecodeError> {
        let (strains, poses, network, losses): (Vec<String>, Vec<String>, Autoencoder, Vec<f64>) = input.record()?;
        if network.values() != strains.len() || network.conditions() != poses.len() {
            return Err(DecodeError::Invalid { what: "autoencoder of strains".to_owned() });
        }
        Ok(Self { strains, poses, network, losses })
    }
}
