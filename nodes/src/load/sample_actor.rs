//! `sample_actor`: a procedural head with performances, so that graphs run where there are no files.

use face_math::data::{Attachment, Curves, Markers, Regions, Rig};
use face_math::rig::{MarkerRig, SkinJawOptions, skin_jaw};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use sample_head::{Options, SampleHead, SampleHeadError, Take};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const RIG: Port<Rig> = Port::new("rig", "the head: 53 channels, combination correctives and in-betweens, in metres");
const NEUTRAL: Port<Markers> =
    Port::new("neutral", "the markers of the face at rest, one frame: 98 on the face, 4 `head_*`, in metres");
const LANDMARKS: Port<Attachment> =
    Port::new("landmarks", "the 68 landmarks of Multi-PIE on the head, as `landmark_00` to `landmark_67`");
const REGIONS: Port<Regions> = Port::new("regions", "seven regions, each with its markers and its channels");
const ROM: Port<Curves> = Port::new("rom", "a range of motion at 60 Hz: every channel, then expressions, then speech");
const TAKES: Port<Markers> = Port::new("takes", "captured markers of each take at 60 Hz, in metres");
const TRUTH: Port<Curves> = Port::new("truth", "the weights that drove each take, to measure against");

/// Makes an actor to try graphs on: a head, its painted markers, a range of motion, and takes with the weights that
/// drove them.
///
/// In the takes the jaw turns as a joint, as real jaws do, so that solving them on the plain rig leaves an error:
/// `skin_jaw` mends that. The takes are called `take_00`, `take_01` and so on, counted from `seed`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SampleActor {
    /// Who the actor is: 0 is the average head, every other number another person.
    identity: u64,
    /// How far actors differ from the average head: 0 not at all, 1 as people do, 3 as caricatures do.
    #[schemars(range(min = 0.0, max = 3.0))]
    variation: f64,
    /// Fineness of the mesh along each side: 1 gives about 30,000 vertices, 0.7 about half as many.
    #[schemars(range(min = 0.5, max = 2.0))]
    density: f64,
    /// Length of the range of motion at 60 Hz.
    #[schemars(range(min = 600, max = 100_000))]
    rom_frames: usize,
    /// Number of takes.
    #[schemars(range(min = 1, max = 1000))]
    takes: usize,
    /// Length of each take at 60 Hz.
    #[schemars(range(min = 60, max = 100_000))]
    frames: usize,
    /// Seed of the first take; the next one has the next seed. The same seed performs the same on every head.
    #[schemars(range(max = 1_000_000_000))]
    seed: u64,
    /// Noise of the captured markers: 1 is that of a good camera set (0.05 mm at the brow, 0.15 mm at the chin), 0 is
    /// none.
    #[schemars(range(min = 0.0, max = 100.0))]
    noise: f64,
}

impl Default for SampleActor {
    fn default() -> Self {
        let head = Options::default();
        Self {
            identity: head.identity,
            variation: f64::from(head.variation),
            density: f64::from(head.density),
            rom_frames: head.motion_frames,
            takes: 3,
            frames: 600,
            seed: 0,
            noise: 1.0,
        }
    }
}

graph_core::register!(SampleActor);

#[typetag::serde(name = "sample_actor")]
impl Node for SampleActor {
    fn card(&self) -> Card {
        Card::new("load")
            .gives(&RIG)
            .gives(&NEUTRAL)
            .gives(&REGIONS)
            .gives(&ROM)
            .gives(&LANDMARKS)
            .gives_list(&TAKES)
            .gives_list(&TRUTH)
            .version(2)
    }

    fn compute(&self, context: &Context<'_>, _: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let head = sample_head::build(&Options {
            identity: self.identity,
            variation: self.variation as f32,
            density: self.density as f32,
            motion_frames: self.rom_frames,
        });
        let head = head.map_err(NodeError::failed)?;
        let frame_bytes = size_of_val(head.neutral_markers.positions()) + head.rig.channels.len() * size_of::<f32>();
        context.claim("takes", (self.takes * self.frames).saturating_mul(frame_bytes))?;
        context.progress(0.5, &[]);
        context.go_on()?;
        let exact = self.exact_markers(&head)?;
        let (mut takes, mut truth) = (Vec::new(), Vec::new());
        for index in 0..self.takes {
            context.go_on()?;
            let performed = sample_head::takes(&head, 1, self.frames, self.seed + index as u64);
            for take in performed.map_err(NodeError::failed)? {
                takes.push((take.name.clone(), self.captured(exact.as_ref(), &take)?));
                truth.push((take.name, take.truth));
            }
            context.progress(0.5 + 0.5 * (index + 1) as f64 / self.takes as f64, &[]);
        }
        Ok(Outputs::default()
            .with(&LANDMARKS, super::landmarks_on(&head.rig, &head.landmarks))
            .with(&RIG, head.rig)
            .with(&NEUTRAL, head.neutral_markers)
            .with(&REGIONS, head.regions)
            .with(&ROM, head.range_of_motion)
            .with_list(&TAKES, takes)
            .with_list(&TRUTH, truth))
    }
}

impl SampleActor {
    /// The markers without noise, where the noise is not the usual one.
    fn exact_markers(&self, head: &SampleHead) -> Result<Option<MarkerRig>, NodeError> {
        if self.noise.to_bits() == 1.0_f64.to_bits() {
            return Ok(None);
        }
        let jawed = skin_jaw(&head.rig, &SkinJawOptions::default()).map_err(NodeError::failed)?;
        MarkerRig::of_vertices(&jawed.rig, &head.marker_vertices).map(Some).map_err(NodeError::failed)
    }

    /// The markers of `take` with `noise` times their noise: x = e + n (c − e), e exact and c captured positions.
    fn captured(&self, exact: Option<&MarkerRig>, take: &Take) -> Result<Markers, NodeError> {
        let Some(exact) = exact else { return Ok(take.markers.clone()) };
        let exact = exact.drive(&take.truth).map_err(SampleHeadError::from).map_err(NodeError::failed)?;
        let noise = self.noise as f32;
        let pairs = exact.positions().iter().zip(take.markers.positions());
        let positions = pairs.map(|(exact, captured)| *exact + noise * (*captured - *exact)).collect();
        take.markers.with_positions(positions).map_err(NodeError::failed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Bench, compute, made};
    use serde_json::json;

    fn actor(noise: f64) -> Outputs {
        let node: SampleActor =
            made(json!({"density": 0.5, "rom_frames": 600, "takes": 2, "frames": 90, "seed": 5, "noise": noise}));
        compute(&node, &Inputs::default()).unwrap()
    }

    #[test]
    fn it_gives_all_that_a_solve_needs() {
        let outputs = actor(1.0);
        let (rig, neutral) = (outputs.get(&RIG).unwrap(), outputs.get(&NEUTRAL).unwrap());
        assert_eq!((rig.channels.len(), neutral.names().len(), neutral.frames()), (53, 102, 1));
        assert_eq!(outputs.get(&REGIONS).unwrap().regions.len(), 7);
        assert_eq!(outputs.get(&ROM).unwrap().frames(), 600);
        let (takes, truth) = (outputs.items(&TAKES), outputs.items(&TRUTH));
        assert_eq!(takes.iter().map(|(name, _)| *name).collect::<Vec<_>>(), ["take_05", "take_06"]);
        for ((name, markers), (own, weights)) in takes.iter().zip(&truth) {
            assert_eq!(name, own);
            assert_eq!(markers.names(), neutral.names());
            assert_eq!(weights.channels(), rig.channels);
            markers.frame_axis().matches(&weights.frame_axis()).unwrap();
        }
    }

    #[test]
    fn takes_do_not_depend_on_how_many_there_are() {
        let node: SampleActor = made(json!({"density": 0.5, "rom_frames": 600, "takes": 1, "frames": 90, "seed": 6}));
        let alone = compute(&node, &Inputs::default()).unwrap();
        assert_eq!(alone.items(&TAKES)[0], actor(1.0).items(&TAKES)[1]);
    }

    #[test]
    fn noise_scales() {
        let [none, usual, double] = [0.0, 1.0, 2.0].map(actor);
        let positions = |outputs: &Outputs| outputs.items(&TAKES)[0].1.positions().to_vec();
        let [none, usual, double] = [&none, &usual, &double].map(positions);
        let rms = |a: &[glam::Vec3]| {
            let sum: f32 = a.iter().zip(&none).map(|(a, b)| a.distance_squared(*b)).sum();
            (sum / none.len() as f32).sqrt()
        };
        let (once, twice) = (rms(&usual), rms(&double));
        assert!((0.000_1..0.000_3).contains(&once), "{once} m");
        assert!((twice / once - 2.0).abs() < 1e-3);
    }

    #[test]
    fn it_stops_when_cancelled() {
        for reports in 0..2 {
            let bench = Bench::default().cancelled_after(reports);
            let node: SampleActor = made(json!({"density": 0.5, "rom_frames": 600, "frames": 60}));
            assert!(matches!(bench.compute(&node, &Inputs::default()), Err(NodeError::Cancelled)));
            assert!(bench.fractions().len() <= 1);
        }
    }

    #[test]
    fn options_out_of_bounds_are_named() {
        let node: SampleActor = made(json!({"density": 9.0}));
        assert!(compute(&node, &Inputs::default()).unwrap_err().to_string().contains("density"));
    }
}
