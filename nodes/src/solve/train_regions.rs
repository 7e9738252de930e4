//! `train_regions`: one residual network a region, from features to channel weights (section 4.4 of FDLS). The networks then
//! solve every take of the actor.

use super::training::{Job, RegionSettings, Settled, checks, train_all};
use crate::patterns::Patterns;
use crate::values::Networks;
use face_math::data::{Curves, Features, Region, Regions, nearest_name};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use learn::{Activation, Loss, Schedule, TargetScale, Training};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::time::Duration;

const FEATURES: Port<Features> = Port::new("features", "the features of the training motion");
const CURVES: Port<Curves> = Port::new("curves", "the weights of the same frames: what the networks shall give");
const REGIONS: Port<Regions> = Port::new("regions", "the regions, each with its markers and channels");
const NETWORKS: Port<Networks> = Port::new("networks", "a trained network for each region");

/// Trains a fully-connected residual network for each region of the face, from its features to its channels.
///
/// The networks of lower face, lips and cheek are conditioned on the jaw: the true weights of the jaw join them in training,
/// the solved or corrected ones later. Left alone, every number is that of the FDLS supplement for the region's name; a
/// short schedule such as `epochs: 24`, `schedule: one_cycle()` and a larger `learning_rate` reaches the same in minutes on
/// a processor.
///
/// What is asked for in `by_region` goes before what is asked for all regions, and that before the paper. The same inputs
/// and `seed` give the same networks, however many regions are trained at once. A cook that was cut short goes on where
/// the last checkpoint was.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TrainRegions {
    /// How often every sample is seen, in all regions. The paper: 250 to 450.
    #[schemars(range(min = 1, max = 1_000_000))]
    epochs: Option<usize>,
    /// Steps of Adam in all regions, above 0 in place of `epochs`: as many whole epochs as come nearest to them. Motions of
    /// different length are then trained on for the same time.
    #[schemars(range(max = 1_000_000_000))]
    #[serde(skip_serializing_if = "unasked")]
    steps: usize,
    /// How the step size changes: `constant` as in the paper, `one_cycle()` or `cosine()`.
    schedule: Schedule,
    /// Step size of Adam (its peak, with a schedule), in all regions. The paper: 0.0001 to 0.0005.
    #[schemars(range(min = 1e-12, max = 10.0))]
    learning_rate: Option<f64>,
    /// Samples a step, in all regions. The paper: 64.
    #[schemars(range(min = 1, max = 1_000_000))]
    batch: Option<usize>,
    /// L2 coefficient of weights and biases, in all regions. The paper: 0.00001.
    #[schemars(range(min = 0.0, max = 1.0))]
    weight_decay: Option<f64>,
    /// Chance of a hidden node to be silenced in training, in all regions. The paper: 0.01, and none for the eyes.
    #[schemars(range(min = 0.0, max = 0.99))]
    dropout: Option<f32>,
    /// Nodes of every hidden layer, in all regions. The paper: 150 to 800.
    #[schemars(range(min = 1, max = 100_000))]
    width: Option<usize>,
    /// Residual blocks, in all regions. The paper: 2 or 3.
    #[schemars(range(max = 1000))]
    blocks: Option<usize>,
    /// Settings of certain regions, by the region's name.
    by_region: BTreeMap<String, RegionSettings>,
    /// Settings of regions whose names the paper does not know. They are otherwise like its cheek, without the jaw.
    other: RegionSettings,
    /// Whether regions are conditioned on the jaw at all. `false` shows what that is good for.
    jaw_conditioning: bool,
    /// Name of the region that solves the jaw.
    jaw_region: String,
    /// The channels that regions are conditioned on, as patterns. Where empty, those of the jaw's region.
    jaw_channels: Vec<String>,
    /// What to do where the curves have channels that no region solves.
    unsolved: Unsolved,
    /// What is made small.
    loss: Loss,
    /// How channels weigh against each other in the loss.
    target_scale: TargetScale,
    /// The smallest scale of a feature, as a share of the root mean square of all features' standard deviations in the
    /// region: features that vary less are not blown up.
    #[schemars(range(min = 0.0, max = 1.0))]
    input_floor: f32,
    /// The non-linear function of hidden nodes.
    activation: Activation,
    /// Where the random numbers come from: first weights, order of samples, dropout.
    #[schemars(range(max = 1_000_000_000))]
    seed: u64,
    /// Seconds between checkpoints of a region. They change nothing but what is lost when a cook is cut short.
    #[schemars(range(min = 0.0, max = 1_000_000.0))]
    checkpoint_s: f64,
}

/// What to do with channels that no region solves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Unsolved {
    /// Stop, and name them.
    Error,
    /// Leave them at 0 in every solve.
    Zero,
}

impl Default for TrainRegions {
    fn default() -> Self {
        let usual = Training::default();
        Self {
            epochs: None,
            steps: 0,
            schedule: usual.schedule,
            learning_rate: None,
            batch: None,
            weight_decay: None,
            dropout: None,
            width: None,
            blocks: None,
            by_region: BTreeMap::new(),
            other: RegionSettings::default(),
            jaw_conditioning: true,
            jaw_region: "jaw".to_owned(),
            jaw_channels: Vec::new(),
            unsolved: Unsolved::Error,
            loss: usual.loss,
            target_scale: usual.target_scale,
            input_floor: usual.input_floor,
            activation: Activation::default(),
            seed: 0,
            checkpoint_s: 30.0,
        }
    }
}

graph_core::register!(TrainRegions);

#[typetag::serde(name = "train_regions")]
impl Node for TrainRegions {
    fn card(&self) -> Card {
        Card::new("solve").takes(&FEATURES).takes(&CURVES).takes(&REGIONS).gives(&NETWORKS).version(2)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        let (features, curves, regions) = (inputs.get(&FEATURES)?, inputs.get(&CURVES)?, inputs.get(&REGIONS)?);
        let axis = features.frame_axis();
        axis.matches(&curves.frame_axis()).map_err(|error| NodeError::input(CURVES.name(), error))?;
        crate::rig::check_finite(CURVES.name(), curves)?;
        self.by_region.keys().try_for_each(|name| checks::known_region("by_region", name, regions))?;
        checks::each_solved_once(regions)?;
        let unsolved = checks::unsolved(regions, curves)?;
        if self.unsolved == Unsolved::Error && !unsolved.is_empty() {
            let problem = format!(
                "no region solves `{}`; add them to a region, or set `unsolved` to `zero`",
                unsolved.join("`, `")
            );
            return Err(NodeError::input(REGIONS.name(), problem));
        }
        let jobs = regions.regions.iter().map(|region| self.job(region, features, curves, regions));
        let jobs = jobs.collect::<Result<Vec<_>, _>>()?;
        let every = Duration::from_secs_f64(self.checkpoint_s.clamp(0.0, 1e6));
        let networks = Networks {
            channels: curves.channels().to_vec(),
            unsolved,
            jaw: self.jaw_region.clone(),
            regions: train_all(context, curves, &jobs, every)?,
        };
        Ok(Outputs::default().with(&NETWORKS, networks))
    }
}

/// Where steps are not asked for, the key stays what it was before they could be.
#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
fn unasked(steps: &usize) -> bool {
    *steps == 0
}

/// The whole epochs that come nearest to so many steps; at least one.
fn epochs_of(steps: usize, samples: usize, batch: usize) -> usize {
    let epoch = samples.div_ceil(batch.max(1)).max(1);
    ((steps + epoch / 2) / epoch).max(1)
}

impl TrainRegions {
    fn job<'a>(
        &self,
        region: &'a Region,
        features: &'a Features,
        curves: &Curves,
        regions: &Regions,
    ) -> Result<Job<'a>, NodeError> {
        let asked = self.asked(&region.name);
        let mut settled = Settled::new(&region.name, &asked);
        if self.steps > 0 {
            settled.epochs = epochs_of(self.steps, features.frame_axis().count, settled.batch);
        }
        let conditioned = self.jaw_conditioning && settled.jaw_conditioned && region.name != self.jaw_region;
        let conditions = if conditioned { self.jaw_channels(&region.name, regions, curves)? } else { Vec::new() };
        let shared = Training {
            schedule: self.schedule,
            loss: self.loss,
            target_scale: self.target_scale,
            input_floor: self.input_floor,
            seed: self.seed,
            ..Training::default()
        };
        let own = checks::features_of(region, features)?;
        let job = Job::new(region, own, conditions, &settled, (&shared, self.activation));
        job.architecture
            .check()
            .and_then(|()| job.training.check())
            .map_err(|error| NodeError::failed(format!("region `{}`: {error}", region.name)))?;
        Ok(job)
    }

    /// What the graph asks for the region `name`.
    fn asked(&self, name: &str) -> RegionSettings {
        let all = RegionSettings {
            width: self.width,
            blocks: self.blocks,
            jaw_conditioned: None,
            dropout: self.dropout,
            learning_rate: self.learning_rate,
            weight_decay: self.weight_decay,
            batch: self.batch,
            epochs: self.epochs,
        };
        let own = self.by_region.get(name).cloned().unwrap_or_default();
        let strange = if Settled::is_known(name) { RegionSettings::default() } else { self.other.clone() };
        own.before(&strange).before(&all)
    }

    /// The channels that a region is conditioned on.
    fn jaw_channels(&self, region: &str, regions: &Regions, curves: &Curves) -> Result<Vec<String>, NodeError> {
        if !self.jaw_channels.is_empty() {
            let names = curves.channels();
            return Patterns { parameter: "jaw_channels", what: "channel", names }.chosen(&self.jaw_channels);
        }
        regions.get(&self.jaw_region).map(|jaw| jaw.channels.clone()).ok_or_else(|| {
            let near = nearest_name(&self.jaw_region, regions.regions.iter().map(|own| own.name.as_str()));
            let near = near.map(|near| format!(" (did you mean `{near}`?)")).unwrap_or_default();
            let problem = format!(
                "region `{region}` is conditioned on the jaw, but there is no region `{}`{near}; name the jaw's, or set \
                 `jaw_conditioning` to false",
                self.jaw_region
            );
            NodeError::parameter("jaw_region", problem)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy;
    use crate::solve::training::toy::{small, training};
    use crate::testing::{Bench, compute, made};
    use serde_json::json;

    #[test]
    fn steps_are_the_nearest_whole_epochs() {
        // 100 samples in batches of 64 are 2 steps an epoch.
        assert_eq!([1, 2, 3, 40, 41].map(|steps| epochs_of(steps, 100, 64)), [1, 1, 2, 20, 21]);
        assert_eq!(epochs_of(5, 1_000_000, 64), 1);
        let inputs = training(&toy::curves(70, 1));
        let trained_by = |count| trained(&compute(&merged(&count), &inputs).unwrap()).clone();
        assert!(trained_by(json!({"steps": 6})) == trained_by(json!({"epochs": 3})));
    }

    fn trained(outputs: &Outputs) -> &Networks {
        outputs.get(&NETWORKS).unwrap()
    }

    fn fault(node: &TrainRegions, inputs: &Inputs) -> String {
        compute(node, inputs).err().unwrap().to_string()
    }

    fn merged(extra: &serde_json::Value) -> TrainRegions {
        let mut all = json!({"width": 8, "blocks": 1, "epochs": 2});
        all.as_object_mut().unwrap().extend(extra.as_object().unwrap().clone());
        made(all)
    }

    #[test]
    fn each_region_gets_its_network_and_the_jaw_conditions_those_that_ask_for_it() {
        let inputs = training(&toy::curves(70, 1));
        let outputs = compute(&merged(&json!({})), &inputs).unwrap();
        let networks = trained(&outputs);
        assert_eq!(networks.channels, toy::rig().channels);
        let names: Vec<_> = networks.regions.iter().map(|region| region.region.as_str()).collect();
        assert_eq!(names, ["lips", "jaw", "brow"]);
        let conditions: Vec<_> = networks.regions.iter().map(|region| region.conditions.len()).collect();
        assert_eq!(conditions, [1, 0, 0]);
        let record = &networks.regions[0].training;
        assert!(record.samples == 70 && record.losses.len() == 2 && record.losses[1] < record.losses[0]);
        let without = compute(&merged(&json!({"jaw_conditioning": false})), &inputs).unwrap();
        assert!(trained(&without).regions.iter().all(|region| region.conditions.is_empty()));
        let own =
            json!({"by_region": {"brow": {"jaw_conditioned": true, "width": 5}}, "jaw_channels": ["jaw*", "browUp"]});
        let own = compute(&merged(&own), &inputs).unwrap();
        let brow = trained(&own).region("brow").unwrap();
        assert_eq!((brow.conditions.len(), brow.network.architecture().width), (2, 5));
    }

    #[test]
    fn the_same_bits_come_whatever_the_number_of_threads() {
        let inputs = training(&toy::curves(70, 1));
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| trained(&compute(&merged(&json!({})), &inputs).unwrap()).clone())
        };
        assert_eq!(run(1), run(3));
        let other = compute(&merged(&json!({"seed": 1})), &inputs).unwrap();
        assert_ne!(trained(&other).regions[0].network, run(1).regions[0].network);
    }

    #[test]
    fn progress_rises_to_one() {
        let bench = Bench::default();
        bench.compute(&merged(&json!({})), &training(&toy::curves(70, 1))).unwrap();
        let fractions = bench.fractions();
        assert_eq!(fractions.len(), 6);
        assert!(fractions.is_sorted() && (fractions[5] - 1.0).abs() < 1e-9, "{fractions:?}");
    }

    #[test]
    fn a_cook_that_was_cut_short_goes_on_to_the_same_bits() {
        let inputs = training(&toy::curves(70, 1));
        let node = merged(&json!({"epochs": 6, "checkpoint_s": 0.0}));
        let whole = compute(&node, &inputs).unwrap();
        let bench = Bench::default().cancelled_after(8);
        assert!(matches!(bench.compute(&node, &inputs), Err(NodeError::Cancelled)));
        let second = bench.resumed();
        let resumed = second.compute(&node, &inputs).unwrap();
        assert_eq!(trained(&resumed), trained(&whole));
        assert!(second.fractions().len() < 18, "{:?}", second.fractions());
        let bench = second.resumed();
        let other = bench.compute(&merged(&json!({"epochs": 6, "seed": 3})), &inputs).unwrap();
        assert_ne!(trained(&other), trained(&whole), "a checkpoint of other settings is not used");
    }

    #[test]
    fn cancelling_stops_at_once() {
        let bench = Bench::default().cancelled_after(0);
        let outcome = bench.compute(&small(1000), &training(&toy::curves(70, 1)));
        assert!(matches!(outcome, Err(NodeError::Cancelled)));
    }

    #[test]
    fn what_does_not_fit_is_named() {
        let curves = toy::curves(10, 1);
        let inputs = training(&curves);
        let with_regions = |change: &dyn Fn(&mut Regions)| {
            let mut regions = toy::regions();
            change(&mut regions);
            inputs.clone().with(&REGIONS, regions)
        };
        let node = merged(&json!({}));
        assert!(fault(&merged(&json!({"by_region": {"lip": {}}})), &inputs).contains("did you mean `lips`?"));
        assert!(fault(&merged(&json!({"jaw_region": "jow"})), &inputs).contains("did you mean `jaw`?"));
        let twice = with_regions(&|regions| regions.regions[2].channels.push("smile_L".into()));
        assert!(fault(&node, &twice).contains("solved by `lips` and by `brow`"));
        let none = with_regions(&|regions| regions.regions[2].channels.clear());
        assert!(fault(&node, &none).contains("`brow` has no channels"));
        let fewer = with_regions(&|regions| drop(regions.regions[0].channels.pop()));
        assert!(fault(&node, &fewer).contains("no region solves `smile_R`"));
        let zero = compute(&merged(&json!({"unsolved": "zero"})), &fewer).unwrap();
        assert_eq!(trained(&zero).unsolved, ["smile_R"]);
        let strange = with_regions(&|regions| regions.regions[2].channels[0] = "browUpp".into());
        assert!(fault(&node, &strange).contains("did you mean `browUp`?"));
        let other = with_regions(&|regions| regions.regions[2].markers.reverse());
        assert!(fault(&node, &other).contains("in another order"));
        let short = inputs.clone().with(&CURVES, toy::cut(&curves, 0..9));
        assert!(fault(&node, &short).contains("10 frames beside 9 frames"));
        let wild = fault(&merged(&json!({"learning_rate": 1e30})), &inputs);
        assert!(wild.contains("region `") && wild.contains("lower the learning rate"), "{wild}");
    }
}
