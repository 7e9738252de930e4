//! `marker_error`: how far the puppet's markers are from the captured ones, frame by frame; to be looked at, or plotted.

use crate::patterns::Patterns;
use face_math::data::{Attachment, Curves, Markers, Regions, Rig};
use face_math::rig::MarkerRig;
use glam::Vec3;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const CURVES: Port<Curves> = Port::new("curves", "a solve: weights of every channel of the rig");
const MARKERS: Port<Markers> = Port::new("markers", "the markers that it should meet, in metres");
const RIG: Port<Rig> = Port::new("rig", "the puppet");
const ATTACHMENT: Port<Attachment> = Port::new("attachment", "where the markers sit on it");
const REGIONS: Port<Regions> = Port::new("regions", "regions to tell apart, each with its markers");
const ERROR: Port<Curves> = Port::new(
    "error",
    "distances in millimetres: `rms_mm` and `worst_mm` over the markers of a frame, and the root mean square of each region as \
     `<region>_mm`; NaN where no marker is seen",
);

/// Measures the distance between the puppet's markers and the captured ones in every frame.
///
/// A distance is that of two points in space. Markers that are missing in a frame, or that the rig or the take lacks, are
/// passed over. Some of it no solve can mend: the noise of the markers, and what separates the actor from the puppet.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MarkerErrors {
    /// Markers to measure, as patterns: `lip_*`. All that are both captured and on the rig where empty.
    markers: Vec<String>,
    /// Markers not to measure, as patterns: `head_*`.
    exclude: Vec<String>,
}

graph_core::register!(MarkerErrors);

#[typetag::serde(name = "marker_error")]
impl Node for MarkerErrors {
    fn card(&self) -> Card {
        Card::new("solve")
            .takes(&CURVES)
            .takes(&MARKERS)
            .takes(&RIG)
            .takes(&ATTACHMENT)
            .may_take(&REGIONS)
            .gives(&ERROR)
            .per_frame(0)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let (curves, captured) = (inputs.get(&CURVES)?, inputs.get(&MARKERS)?);
        let axis = captured.frame_axis();
        curves.frame_axis().matches(&axis).map_err(|error| NodeError::input(MARKERS.name(), error))?;
        let puppet = MarkerRig::attached(inputs.get(&RIG)?, inputs.get(&ATTACHMENT)?)
            .map_err(|error| NodeError::input(ATTACHMENT.name(), error))?;
        let posed = puppet.drive(curves).map_err(|error| NodeError::input(CURVES.name(), error))?;
        let pairs = self.pairs(&posed, captured)?;
        let mut channels = vec!["rms_mm".to_owned(), "worst_mm".to_owned()];
        let mut groups = Vec::new();
        for region in inputs.may_get(&REGIONS)?.into_iter().flat_map(|regions| &regions.regions) {
            channels.push(format!("{}_mm", region.name));
            let inside = |(own, _): &&(usize, usize)| region.markers.contains(&posed.names()[*own]);
            groups.push(pairs.iter().filter(inside).copied().collect::<Vec<_>>());
        }
        let mut values = Vec::with_capacity(axis.count * channels.len());
        for frame in 0..axis.count {
            let (own, other) = (posed.frame(frame), captured.frame(frame));
            let all = Distances::of(own, other, &pairs);
            values.extend([all.root_mean_square_mm(), all.worst_mm()]);
            values.extend(groups.iter().map(|group| Distances::of(own, other, group).root_mean_square_mm()));
        }
        let error = Curves::new(axis, channels, values).map_err(|error| NodeError::input(REGIONS.name(), error))?;
        Ok(Outputs::default().with(&ERROR, error))
    }
}

impl MarkerErrors {
    /// Columns of the markers to measure: on the puppet, and among the captured ones.
    fn pairs(&self, posed: &Markers, captured: &Markers) -> Result<Vec<(usize, usize)>, NodeError> {
        let patterns = |parameter| Patterns { parameter, what: "marker", names: posed.names() };
        let chosen = patterns("markers").chosen(&self.markers)?;
        let out = patterns("exclude").fits(&self.exclude)?;
        let own = posed.names().iter().zip(out).enumerate();
        let pair = own.filter_map(|(column, (name, out))| {
            (!out && chosen.contains(name)).then_some((column, captured.index(name)?))
        });
        let pairs: Vec<_> = pair.collect();
        if pairs.is_empty() {
            let problem = "none of the markers to measure is both captured and on the rig";
            return Err(NodeError::input(MARKERS.name(), problem));
        }
        Ok(pairs)
    }
}

/// The distances of one frame.
#[derive(Default)]
struct Distances {
    squares: f64,
    worst: f64,
    seen: usize,
}

impl Distances {
    fn of(own: &[Vec3], other: &[Vec3], pairs: &[(usize, usize)]) -> Self {
        let mut distances = Self::default();
        for (a, b) in pairs {
            let square = (own[*a].as_dvec3() - other[*b].as_dvec3()).length_squared();
            if square.is_finite() {
                distances.squares += square;
                distances.worst = distances.worst.max(square);
                distances.seen += 1;
            }
        }
        distances
    }

    fn root_mean_square_mm(&self) -> f32 {
        // 0 / 0 where none is seen: NaN.
        ((self.squares / self.seen as f64).sqrt() * 1000.0) as f32
    }

    fn worst_mm(&self) -> f32 {
        if self.seen == 0 { f32::NAN } else { (self.worst.sqrt() * 1000.0) as f32 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy;
    use crate::testing::{compute, made};
    use serde_json::json;

    fn captured(curves: &Curves) -> Markers {
        MarkerRig::attached(&toy::rig(), &toy::attachment()).unwrap().drive(curves).unwrap()
    }

    fn measure(parameters: serde_json::Value, curves: &Curves, markers: Markers) -> Result<Curves, String> {
        let node: MarkerErrors = made(parameters);
        let mut regions = toy::regions();
        regions.regions.truncate(1);
        regions.regions[0].markers = vec!["m0".into(), "m1".into()];
        let inputs = Inputs::default()
            .with(&CURVES, curves.clone())
            .with(&MARKERS, markers)
            .with(&RIG, toy::rig())
            .with(&ATTACHMENT, toy::attachment())
            .with(&REGIONS, regions);
        let outputs = compute(&node, &inputs);
        outputs.map(|outputs| outputs.get(&ERROR).unwrap().clone()).map_err(|error| error.to_string())
    }

    #[test]
    fn distances_are_in_millimetres_and_missing_markers_passed_over() {
        let curves = toy::curves(3, 1);
        let exact = captured(&curves);
        let mut positions = exact.positions().to_vec();
        positions[0] += Vec3::new(0.001, 0.002, 0.002);
        positions[1] = Vec3::NAN;
        positions[24..36].fill(Vec3::NAN);
        let error = measure(json!({}), &curves, exact.with_positions(positions).unwrap()).unwrap();
        assert_eq!(error.channels(), ["rms_mm", "worst_mm", "lips_mm"]);
        let first = error.frame(0);
        assert!((first[0] - (9.0_f32 / 11.0).sqrt()).abs() < 1e-3, "{first:?}");
        assert!((first[1] - 3.0).abs() < 1e-3 && (first[2] - 3.0).abs() < 1e-3, "{first:?}");
        assert!(error.frame(1).iter().all(|distance| *distance < 1e-3));
        assert!(error.frame(2).iter().all(|distance| distance.is_nan()));
        assert_eq!(error.frame_axis(), curves.frame_axis());
    }

    #[test]
    fn markers_can_be_chosen() {
        let curves = toy::curves(2, 2);
        let exact = captured(&curves);
        let mut positions = exact.positions().to_vec();
        positions[3] += Vec3::X * 0.01;
        let moved = exact.with_positions(positions).unwrap();
        assert!(measure(json!({"exclude": ["m3"]}), &curves, moved.clone()).unwrap().frame(0)[1] < 1e-3);
        assert!(measure(json!({"markers": ["m3", "m4"]}), &curves, moved.clone()).unwrap().frame(0)[0] > 7.0);
        assert!(measure(json!({"markers": ["chin"]}), &curves, moved.clone()).unwrap_err().contains("`markers`"));
        assert!(measure(json!({"exclude": ["m*"]}), &curves, moved).unwrap_err().contains("none of the markers"));
    }

    #[test]
    fn blocks_equal_the_whole() {
        let curves = toy::curves(8, 3);
        let exact = captured(&toy::curves(8, 4));
        let block = measure(json!({}), &toy::cut(&curves, 3..6), toy::cut(&exact, 3..6)).unwrap();
        assert!(toy::same_bits(&measure(json!({}), &curves, exact).unwrap(), 3..6, &block));
    }
}
