//! `fill_gaps`: points that the cameras lost; between loading a take and its features, which want every marker.

use face_math::clean::{Filled, GapError, GapOptions, Source, fill_gaps};
use face_math::data::{Curves, Markers, ShapeSpace};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const MARKERS: Port<Markers> = Port::new("markers", "a take's markers, in metres; missing points are NaN");
const NEUTRAL: Port<Markers> = Port::new(
    "neutral",
    "one frame: the markers' places on the face at rest, in metres, by the same names; long gaps are filled only with it",
);
const SHAPES: Port<ShapeSpace> = Port::new(
    "shapes",
    "the shapes that the face takes (`learn_shape_space`); long gaps of markers that it knows are filled by these",
);
const WHOLE: Port<Markers> =
    Port::new("markers", "the same markers and frames; seen points as they were, gaps filled as far as they can be");
const FILLED: Port<Curves> = Port::new("filled", "one channel, `filled`: how many points were filled in each frame");
const SOURCES: Port<Curves> = Port::new(
    "sources",
    "a channel a marker: 0 where it was seen, 1 bridged in time, 2 from its neighbours, 3 from the shapes, -1 still missing",
);

/// Fills gaps in markers: short ones from the frames around them, long ones from the other markers.
///
/// A gap of up to `max_gap_frames` that is seen at both ends is bridged by a smooth path through the frames around it.
///
/// A longer gap, or one that reaches the start or end of the take, is told from the markers that are seen in the same
/// frame, corrected by how far the marker was off that when it was last seen and is seen again: by the shapes that the
/// whole face takes where `shapes` are connected, else by the seen markers nearest to it on the face at rest (moving least
/// squares), which needs `neutral`. Where neither has the marker, long gaps stay missing, as do frames in which too few
/// markers are seen.
///
/// Seen points are never changed; `filled` counts what was made up, frame by frame, and `sources` says of every point where
/// it comes from.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct FillGaps {
    /// Longest gap, in frames, that is bridged in time; 12 are a fifth of a second at 60 Hz, 0 bridges none.
    #[schemars(range(min = 0, max = 1000))]
    max_gap_frames: usize,
    /// For how many frames a longer gap keeps, ever less, the difference from its neighbours that was seen at its ends.
    /// More follows the marker better; a change to one frame then recomputes as many frames around it.
    #[schemars(range(min = 0, max = 1000))]
    carry_frames: usize,
    /// How many of the nearest seen markers a longer gap follows.
    #[schemars(range(min = 3, max = 100))]
    neighbours: usize,
}

impl Default for FillGaps {
    fn default() -> Self {
        let GapOptions { max_gap_frames, carry_frames, neighbours } = GapOptions::default();
        Self { max_gap_frames, carry_frames, neighbours }
    }
}

graph_core::register!(FillGaps);

#[typetag::serde(name = "fill_gaps")]
impl Node for FillGaps {
    fn card(&self) -> Card {
        let card = Card::new("clean").takes(&MARKERS).may_take(&NEUTRAL).still().may_take(&SHAPES);
        let card = card.gives(&WHOLE).gives(&FILLED).gives(&SOURCES);
        card.version(2).per_frame(self.options().halo_frames())
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let (take, neutral, shapes) = (inputs.get(&MARKERS)?, inputs.may_get(&NEUTRAL)?, inputs.may_get(&SHAPES)?);
        let Filled { markers, filled, sources } = fill_gaps(take, neutral, shapes, &self.options()).map_err(told)?;
        let counts = filled.iter().map(|count| *count as f32).collect();
        let counts = Curves::new(take.frame_axis(), vec![FILLED.name().to_owned()], counts);
        let counts = counts.map_err(NodeError::failed)?;
        let sources = sources.into_iter().map(number).collect();
        let sources = Curves::new(take.frame_axis(), take.names().to_vec(), sources).map_err(NodeError::failed)?;
        Ok(Outputs::default().with(&WHOLE, markers).with(&FILLED, counts).with(&SOURCES, sources))
    }
}

impl FillGaps {
    fn options(&self) -> GapOptions {
        let Self { max_gap_frames, carry_frames, neighbours } = *self;
        GapOptions { max_gap_frames, carry_frames, neighbours }
    }
}

/// The number that stands for a source on the port `sources`.
fn number(source: Source) -> f32 {
    match source {
        Source::Missing => -1.0,
        Source::Seen => 0.0,
        Source::Time => 1.0,
        Source::Neighbours => 2.0,
        Source::Shapes => 3.0,
    }
}

/// The error with the port or parameter that it is about.
fn told(error: GapError) -> NodeError {
    match error {
        GapError::NeutralFrames { .. } | GapError::NeutralMarkers { .. } => NodeError::input(NEUTRAL.name(), error),
        GapError::Shapes { .. } => NodeError::input(SHAPES.name(), error),
        GapError::Neighbours { .. } => NodeError::parameter("neighbours", error),
        GapError::Infinite { .. } | GapError::Data(_) => NodeError::input(MARKERS.name(), error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy;
    use crate::testing::{compute, made, test_data};
    use face_io::{c3d, marker_csv};
    use face_math::clean::learn_shapes;
    use glam::Vec3;
    use graph_core::node::Time;
    use serde_json::json;
    use std::fs;
    use wire::FrameAxis;

    fn fill(parameters: serde_json::Value, take: &Markers, neutral: Option<&Markers>) -> Result<Outputs, String> {
        let node: FillGaps = made(parameters);
        let mut inputs = Inputs::default().with(&MARKERS, take.clone());
        if let Some(neutral) = neutral {
            inputs = inputs.with(&NEUTRAL, neutral.clone());
        }
        compute(&node, &inputs).map_err(|error| error.to_string())
    }

    /// The toy's markers at rest, rising 1 mm a frame, with a short gap of `m2` and a long one of `m5`.
    fn take() -> Markers {
        let neutral = toy::neutral();
        let rise = |frame: usize| Vec3::Y * (frame as f32 * 1e-3);
        let point = |frame: usize, column: usize| match (column, frame) {
            (2, 20..24) | (5, 30..60) => Vec3::NAN,
            _ => neutral.frame(0)[column] + rise(frame),
        };
        let count = neutral.names().len();
        let positions = (0..80).flat_map(|frame| (0..count).map(move |column| point(frame, column)));
        Markers::new(FrameAxis::new(80, 60.0), neutral.names().to_vec(), positions.collect()).unwrap()
    }

    #[test]
    fn the_halo_follows_from_the_parameters() {
        let halo = |parameters| made::<FillGaps>(parameters).card().time;
        assert_eq!(halo(json!({})), Time::PerFrame { halo: 32 });
        assert_eq!(halo(json!({"carry_frames": 0})), Time::PerFrame { halo: 14 });
        assert_eq!(halo(json!({"max_gap_frames": 50})), Time::PerFrame { halo: 52 });
        let card = made::<FillGaps>(json!({})).card();
        let neutral = card.input("neutral").unwrap();
        assert!(neutral.still && neutral.optional);
    }

    #[test]
    fn gaps_are_filled_and_counted() {
        let outputs = fill(json!({}), &take(), Some(&toy::neutral())).unwrap();
        let (markers, filled) = (outputs.get(&WHOLE).unwrap(), outputs.get(&FILLED).unwrap());
        for frame in 0..80 {
            for (found, rest) in markers.frame(frame).iter().zip(toy::neutral().frame(0)) {
                assert!(found.abs_diff_eq(*rest + Vec3::Y * (frame as f32 * 1e-3), 1e-6), "{frame}");
            }
            let count = f32::from(u8::from((20..24).contains(&frame)) + u8::from((30..60).contains(&frame)));
            assert_eq!(filled.frame(frame).iter().map(|value| value.to_bits()).collect::<Vec<_>>(), [count.to_bits()]);
        }
        assert_eq!(filled.channels(), ["filled"]);
        let sources = outputs.get(&SOURCES).unwrap();
        let at = |frame: usize, column: usize| sources.frame(frame)[column] as i32;
        assert_eq!([at(19, 2), at(20, 2), at(29, 5), at(30, 5)], [0, 1, 0, 2]);
        let alone = fill(json!({}), &take(), None).unwrap();
        assert_eq!(alone.get(&WHOLE).unwrap().missing(), 30);
        assert_eq!(alone.get(&SOURCES).unwrap().frame(40)[5] as i32, -1);
    }

    #[test]
    fn errors_name_the_port_or_the_parameter() {
        let error = fill(json!({}), &take(), Some(&take())).unwrap_err();
        assert!(error.starts_with("input `neutral`: ") && error.contains("80 frames"), "{error}");
        let error = fill(json!({"neighbours": 1}), &take(), None).unwrap_err();
        assert!(error.starts_with("parameter `neighbours`: "), "{error}");
        let positions = vec![Vec3::splat(f32::INFINITY); take().positions().len()];
        let error = fill(json!({}), &take().with_positions(positions).unwrap(), None).unwrap_err();
        assert!(error.starts_with("input `markers`: ") && error.contains("`m0`"), "{error}");
    }

    /// A real take and its face at rest.
    fn real(name: &str) -> Option<(Markers, Markers)> {
        let path = test_data(&format!("actors/ict_actor_a/takes/{name}.c3d"))?;
        let neutral = path.parent()?.with_file_name("neutral_markers.csv");
        let neutral = marker_csv::open(&fs::read(neutral).unwrap()).unwrap();
        let neutral = neutral.into_markers(Some(1.0)).unwrap();
        Some((c3d::read_take(&fs::read(path).unwrap()).unwrap().markers, neutral))
    }

    #[test]
    fn blocks_of_a_real_take_are_the_whole_bit_for_bit() {
        let Some((take, neutral)) = real("day2_167") else { return };
        let whole = fill(json!({}), &take, Some(&neutral)).unwrap();
        let (markers, filled) = (whole.get(&WHOLE).unwrap(), whole.get(&FILLED).unwrap());
        assert_eq!(markers.missing(), 0, "every marker of this take has a place on the face at rest");
        assert_eq!(filled.values().iter().sum::<f32>() as usize, take.missing());
        for start in (0..take.frames()).step_by(32 * 7) {
            let (end, halo) = ((start + 32).min(take.frames()), 32);
            let from = start.saturating_sub(halo);
            let block = toy::cut(&take, from..(end + halo).min(take.frames()));
            let block = fill(json!({}), &block, Some(&neutral)).unwrap();
            let own = start - from..end - from;
            let (points, counts) = (block.get(&WHOLE).unwrap(), block.get(&FILLED).unwrap());
            assert!(toy::same_bits(markers, start..end, &toy::cut(points, own.clone())), "{start} to {end}");
            assert!(toy::same_bits(filled, start..end, &toy::cut(counts, own)), "{start} to {end}");
        }
    }

    /// Takes known points of the face out of a real take, `length` frames of one marker after the other, and gives the
    /// root mean square distance (mm) at which they come back.
    fn rms_mm(take: &Markers, neutral: &Markers, shapes: Option<&ShapeSpace>, length: usize) -> f64 {
        let width = take.names().len();
        let face: Vec<usize> = (0..width).filter(|column| !take.names()[*column].starts_with("head_")).collect();
        let (mut squares, mut count) = (0.0, 0.0);
        for round in 0..3 {
            let mut positions = take.positions().to_vec();
            let mut taken = Vec::new();
            for (order, column) in face.iter().enumerate() {
                let first = 40 + (order * 37 + round * 577) % (take.frames() - 80 - length);
                let near = first - 3..first + length + 3;
                if near.clone().any(|frame| take.frame(frame)[*column].is_nan()) {
                    continue;
                }
                for frame in first..first + length {
                    positions[frame * width + column] = Vec3::NAN;
                    taken.push(frame * width + column);
                }
            }
            let gappy = take.with_positions(positions).unwrap();
            let filled = fill_gaps(&gappy, Some(neutral), shapes, &GapOptions::default()).unwrap();
            let found = filled.markers.positions();
            for index in taken {
                squares += f64::from(found[index].distance(take.positions()[index])).powi(2);
                count += 1.0;
            }
        }
        1000.0 * (squares / count).sqrt()
    }

    /// The tracker's own noise in these takes is 0.25 to 0.4 mm: a straight line over one lost frame is as far off.
    #[test]
    fn known_points_of_real_takes_come_back() {
        let limits = [
            ("day1_164", [(1, 0.33), (4, 0.42), (12, 0.49), (20, 0.72), (40, 1.18)]),
            ("day2_167", [(1, 0.49), (4, 0.51), (12, 0.57), (20, 0.54), (40, 0.69)]),
        ];
        for (name, limits) in limits {
            let Some((take, neutral)) = real(name) else { return };
            for (length, limit_mm) in limits {
                let found_mm = rms_mm(&take, &neutral, None, length);
                assert!(found_mm < limit_mm, "{name}, {length} frames: {found_mm:.3} mm");
            }
        }
    }

    /// Shapes learned from one take fill the gaps of another, painted on the same day, better than neighbours do.
    #[test]
    fn shapes_of_another_take_fill_long_gaps_better_than_neighbours() {
        let Some((other, _)) = real("day1_161") else { return };
        let Some((take, neutral)) = real("day1_164") else { return };
        let shapes = learn_shapes(&[&other], other.names(), 12).unwrap();
        for (length, share) in [(20, 0.75), (40, 0.75)] {
            let by_neighbours_mm = rms_mm(&take, &neutral, None, length);
            let by_shapes_mm = rms_mm(&take, &neutral, Some(&shapes), length);
            assert!(by_shapes_mm < share * by_neighbours_mm, "{length} frames: {by_neighbours_mm} {by_shapes_mm} mm");
        }
    }
}
