//! `stabilize_head`: takes the head's motion out of a take, so that markers move as the face does; before features and
//! fine-tuning.

use crate::patterns::Patterns;
use face_math::clean::{StabilizeError, StabilizeOptions, calm_reach, find_rigid, stabilize};
use face_math::data::{Curves, Markers};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const MARKERS: Port<Markers> = Port::new("markers", "a take's markers, in metres, moving with the head");
const NEUTRAL: Port<Markers> =
    Port::new("neutral", "one frame: the markers' places on the face at rest, in metres; the head is held there");
const POSED: Port<Markers> = Port::new(
    "posed",
    "the same markers and frames as a solve of the take moves them (`synthesize_markers`), in metres: places that take those \
     at rest, so that markers that move with the face tell of the head too",
);
const STILL: Port<Markers> = Port::new(
    "markers",
    "the same markers and frames, the head at rest; all missing in frames whose motion could not be told",
);
const MOTION: Port<Curves> = Port::new(
    "motion",
    "the motion that was removed: `tx`, `ty`, `tz` in metres, `rx`, `ry`, `rz` in radians (turned about x, then y, then z \
     of the world); NaN where it could not be told",
);
const FIT: Port<Curves> = Port::new(
    "fit",
    "`residual_mm`: how far the rigid markers are from the motion, root mean square; `used`: how many of them it rests on",
);

/// Holds the head still by markers that move with the skull alone.
///
/// In each frame the rigid markers say how the head has moved from rest, and every marker goes back by that motion. A
/// rigid marker that is missing, has slipped or is mixed up with another does not count: as long as three agree, the
/// others change nothing.
///
/// Where `rigid` names none, they are found: those whose distances from one another vary least over the take. That needs
/// the whole take at once; naming them keeps the work to the frames that change.
///
/// Real skin slides over the skull nearly everywhere. Once a take is solved, a second pass can hold the head by every marker
/// that the puppet meets: `posed` then says where each belongs in each frame.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct StabilizeHead {
    /// The rigid markers, as patterns: `head_*`. Found where empty.
    rigid: Vec<String>,
    /// How many rigid markers are found at most, where none are named.
    #[schemars(range(min = 3, max = 100))]
    most_found: usize,
    /// A rigid marker farther than this from where the head's motion takes it does not count, in millimetres. More than
    /// the noise, and than the marks were painted off their places.
    #[schemars(range(min = 0.001, max = 1000.0))]
    tolerance_mm: f64,
    /// How far the head's motion is calmed over time: standard deviation of a Gaussian, in frames. The noise of few rigid
    /// markers otherwise shakes the whole face; 8 leaves a quarter of it, and slow motion as it is. 0 takes each frame
    /// as it comes.
    #[schemars(range(min = 0.0, max = 100.0))]
    smoothing_frames: f64,
    /// Motions of the head below this count as none, and of others n² / r² is left out, where n is this and r how far the
    /// rigid markers move (root mean square): in millimetres, a little above the noise of the calmed motion. A take whose
    /// head is still then stays as it is, bit for bit. 0 takes all motion out.
    #[schemars(range(min = 0.0, max = 1000.0))]
    least_motion_mm: f64,
}

impl Default for StabilizeHead {
    fn default() -> Self {
        Self { rigid: Vec::new(), most_found: 6, tolerance_mm: 2.0, smoothing_frames: 0.0, least_motion_mm: 0.0 }
    }
}

graph_core::register!(StabilizeHead);

#[typetag::serde(name = "stabilize_head")]
impl Node for StabilizeHead {
    fn card(&self) -> Card {
        let card = Card::new("clean").takes(&MARKERS).takes(&NEUTRAL).still().may_take(&POSED);
        let card = card.gives(&STILL).gives(&MOTION).gives(&FIT);
        if self.rigid.is_empty() { card } else { card.per_frame(calm_reach(self.smoothing_frames)) }
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let (take, neutral) = (inputs.get(&MARKERS)?, inputs.get(&NEUTRAL)?);
        let rigid = if self.rigid.is_empty() {
            // Only markers that have a place at rest can say where the head went.
            let placed = |name: &&String| neutral.index(name).is_some();
            let names: Vec<String> = take.names().iter().filter(placed).cloned().collect();
            let placed = take.pick(&names).map_err(NodeError::failed)?;
            find_rigid(&placed, self.most_found).map_err(|error| NodeError::input(MARKERS.name(), error))?.names
        } else {
            Patterns { parameter: "rigid", what: "marker", names: take.names() }.chosen(&self.rigid)?
        };
        context.go_on()?;
        let options = StabilizeOptions {
            tolerance_m: self.tolerance_mm / 1000.0,
            smoothing_frames: self.smoothing_frames,
            least_motion_m: self.least_motion_mm / 1000.0,
        };
        let found = stabilize(take, neutral, inputs.may_get(&POSED)?, &rigid, &options).map_err(told)?;
        context.progress(1.0, &[("rigid markers", rigid.len() as f64), ("lost frames", found.lost_frames as f64)]);
        Ok(Outputs::default().with(&STILL, found.markers).with(&MOTION, found.motion).with(&FIT, found.fit))
    }
}

/// The error with the port or parameter that it is about.
fn told(error: StabilizeError) -> NodeError {
    match error {
        StabilizeError::PosedFrames { .. } => NodeError::input(POSED.name(), error),
        StabilizeError::NeutralFrames { .. } => NodeError::input(NEUTRAL.name(), error),
        StabilizeError::Unplaced { .. } | StabilizeError::TooFew { .. } => NodeError::parameter("rigid", error),
        StabilizeError::Tolerance { .. } => NodeError::parameter("tolerance_mm", error),
        StabilizeError::Data(_) => NodeError::input(MARKERS.name(), error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy;
    use crate::testing::{compute, made, test_data};
    use face_io::{c3d, marker_csv};
    use face_math::clean::motion_of;
    use graph_core::node::Time;
    use serde_json::json;
    use std::fs;

    fn run(parameters: serde_json::Value, take: &Markers, neutral: &Markers) -> Result<Outputs, String> {
        let node: StabilizeHead = made(parameters);
        let inputs = Inputs::default().with(&MARKERS, take.clone()).with(&NEUTRAL, neutral.clone());
        compute(&node, &inputs).map_err(|error| error.to_string())
    }

    fn real(take: &str) -> Option<(Markers, Markers)> {
        let folder = test_data("actors/ict_actor_a")?;
        let take = fs::read(folder.join(format!("takes/{take}.c3d"))).unwrap();
        let neutral = marker_csv::read(&fs::read(folder.join("neutral_markers.csv")).unwrap(), Some(1.0)).unwrap();
        Some((c3d::read(&take).unwrap(), neutral))
    }

    /// The take, moved as a head moves.
    fn moved(take: &Markers) -> Markers {
        let width = take.names().len();
        let positions = take.positions().iter().enumerate().map(|(index, point)| {
            let time = (index / width) as f64 / 60.0;
            let motion =
                motion_of([0.1 * time.sin(), 1.5, 0.05 * time, 0.2 * time.sin(), 0.6 * (0.7 * time).sin(), 0.1]);
            motion.apply(point.as_dvec3()).as_vec3()
        });
        take.with_positions(positions.collect()).unwrap()
    }

    fn rms_mm(a: &Markers, b: &Markers) -> f64 {
        let squares = a.positions().iter().zip(b.positions()).map(|(a, b)| f64::from(a.distance_squared(*b)));
        let squares: Vec<f64> = squares.filter(|square| !square.is_nan()).collect();
        1000.0 * (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    }

    #[test]
    fn naming_the_markers_makes_it_work_per_frame() {
        assert_eq!(made::<StabilizeHead>(json!({})).card().time, Time::Whole);
        let card = made::<StabilizeHead>(json!({"rigid": ["head_*"]})).card();
        assert_eq!(card.time, Time::PerFrame { halo: 0 });
        assert!(card.input("neutral").unwrap().still);
        let card = made::<StabilizeHead>(json!({"rigid": ["head_*"], "smoothing_frames": 8.0})).card();
        assert_eq!(card.time, Time::PerFrame { halo: 24 });
    }

    #[test]
    fn a_real_face_on_a_moving_head_comes_back() {
        let Some((take, neutral)) = real("day1_161") else { return };
        let moved = moved(&take);
        let named = run(json!({"rigid": ["head_*"]}), &moved, &neutral).unwrap();
        // The four head markers shake by 0.05 mm a coordinate, and with them the head: most at the chin.
        let off = rms_mm(named.get(&STILL).unwrap(), &take);
        assert!(off < 0.16, "{off} mm");
        let calm = run(json!({"rigid": ["head_*"], "smoothing_frames": 8.0}), &moved, &neutral).unwrap();
        let calm_off = rms_mm(calm.get(&STILL).unwrap(), &take);
        assert!(calm_off < 0.8 * off, "{calm_off} beside {off} mm");
        let found = run(json!({}), &moved, &neutral).unwrap();
        let off = rms_mm(found.get(&STILL).unwrap(), &take);
        assert!(off < 0.16, "found markers: {off} mm");
        let block = run(json!({"rigid": ["head_*"]}), &toy::cut(&moved, 300..340), &neutral).unwrap();
        for port in [&MOTION, &FIT] {
            assert!(toy::same_bits(named.get(port).unwrap(), 300..340, block.get(port).unwrap()));
        }
        assert!(toy::same_bits(named.get(&STILL).unwrap(), 300..340, block.get(&STILL).unwrap()));
    }

    #[test]
    fn what_is_left_of_head_motion_in_real_takes_is_removed() {
        let Some((take, neutral)) = real("day2_167") else { return };
        let found = run(json!({"rigid": ["head_*"]}), &take, &neutral).unwrap();
        let fit = found.get(&FIT).unwrap();
        let residual_mm =
            (0..fit.frames()).map(|frame| f64::from(fit.frame(frame)[0])).sum::<f64>() / fit.frames() as f64;
        assert!(residual_mm < 0.5, "{residual_mm} mm");
        let spread = |markers: &Markers| {
            let column = markers.index("head_0").unwrap();
            let points: Vec<_> = (0..markers.frames()).map(|frame| markers.frame(frame)[column].as_dvec3()).collect();
            let points: Vec<_> = points.into_iter().filter(|point| point.is_finite()).collect();
            let middle = points.iter().sum::<glam::DVec3>() / points.len() as f64;
            let squares = points.iter().map(|point| point.distance_squared(middle)).sum::<f64>();
            1000.0 * (squares / points.len() as f64).sqrt()
        };
        let (before, after) = (spread(&take), spread(found.get(&STILL).unwrap()));
        assert!(before > 1.0 && after < 0.1 * before, "{before} to {after} mm");
    }

    #[test]
    fn unstabilised_takes_find_markers_on_the_skull() {
        for name in ["CheeksMoCap", "JawMoCap"] {
            let Some(path) = test_data(&format!("mocap/animface/{name}.c3d")) else { return };
            let take = c3d::read(&fs::read(path).unwrap()).unwrap();
            let rest = toy::cut(&take, 0..1);
            let found = find_rigid(&take, 6).unwrap();
            let soft = ["Mouth", "Chin", "cheek_Down"];
            assert!(!found.names.iter().any(|name| soft.iter().any(|soft| name.contains(soft))), "{found:?}");
            let outputs = run(json!({}), &take, &rest).unwrap();
            assert_eq!(outputs.get(&STILL).unwrap().missing(), 0, "{name}");
            let fit = outputs.get(&FIT).unwrap();
            let worst = (0..fit.frames()).map(|frame| fit.frame(frame)[0]).fold(0.0, f32::max);
            assert!(worst < 1.5, "{name}: {worst} mm");
        }
    }

    #[test]
    fn mistakes_are_named() {
        let (take, neutral) = (toy::neutral(), toy::neutral());
        assert!(run(json!({"rigid": ["skull_*"]}), &take, &neutral).unwrap_err().contains("`rigid`"));
        assert!(run(json!({"rigid": ["m0", "m1"]}), &take, &neutral).unwrap_err().contains("2 rigid markers"));
        assert!(run(json!({}), &take, &neutral).unwrap_err().starts_with("input `markers`: "));
    }
}
