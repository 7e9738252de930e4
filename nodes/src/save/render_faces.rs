//! `render_faces`: a contact sheet of a performance: what a solve looks like, frame by frame and from several sides.

use super::scene::{Pose, Scene, SceneError, moved};
use super::{frame_range, parts};
use face_math::data::{Attachment, Curves, Image, Markers, Rig};
use face_math::render::{Camera, Mark, Sheet, Style, draw_marks, render_rig};
use glam::Vec3;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use wire::FrameAxis;

const RIG: Port<Rig> = Port::new("rig", "the head that is drawn");
const CURVES: Port<Curves> =
    Port::new("curves", "a weight for each channel of the rig and each frame; other channels are passed over");
const MARKERS: Port<Markers> = Port::new(
    "markers",
    "captured markers at the place of the rig, in metres, with the frames of the curves; drawn as green dots",
);
const ATTACHMENT: Port<Attachment> =
    Port::new("attachment", "where markers sit on the rig; the rig's own markers are drawn there as red crosses");
const IMAGE: Port<Image> = Port::new("image", "the contact sheet");

/// Most pictures on a sheet.
const PICTURES: usize = 1000;
/// Most pixels on a sheet, which hold it to half a gigabyte.
const SHEET_PX: usize = 150_000_000;
/// Most samples along the side of a picture, which hold the rasteriser to a quarter of a gigabyte.
const SIDE_SAMPLES: usize = 4096;

/// Draws chosen frames of a performance into one picture.
///
/// Each frame is drawn once for each angle of `yaw_deg`, with its number below. Where markers and attachment are both
/// given, the caption tells the root mean square of the distances between captured markers and the rig's own.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RenderFaces {
    /// Frames to draw, numbered as the curves number them: `1001-1100x10,1200`. Where empty, `count` frames are drawn,
    /// spread evenly over the whole performance.
    frames: String,
    /// How many frames are drawn where `frames` is empty.
    #[schemars(range(min = 1, max = 1000))]
    count: usize,
    /// Turns of the camera around the head: 0 is the front, above 0 it moves towards the performer's left.
    #[schemars(length(min = 1, max = 24), inner(range(min = -180.0, max = 180.0)))]
    yaw_deg: Vec<f64>,
    /// Lift of the camera above the horizontal.
    #[schemars(range(min = -85.0, max = 85.0))]
    pitch_deg: f64,
    /// Width and height of one picture.
    #[schemars(range(min = 32, max = 2048))]
    size_px: usize,
    /// How much nearer the camera is: 2 shows half the width.
    #[schemars(range(min = 0.1, max = 20.0))]
    zoom: f64,
    /// Parts that fill the picture, such as `face`. Where empty, it is filled by what the shapes move.
    frame_parts: Vec<String>,
    /// Parts that are not drawn.
    without_parts: Vec<String>,
    /// Pictures beside each other. Where not given, as many as make the sheet about as wide as high, the angles of one
    /// frame side by side.
    #[schemars(range(min = 1, max = 1000))]
    columns: Option<usize>,
    /// Whether frame numbers and distances are written below the pictures.
    captions: bool,
    /// Half the width of a marker's dot.
    #[schemars(range(min = 0.5, max = 50.0))]
    marker_px: f64,
    /// Samples along each side of a pixel: 1 is quick and jagged, 3 is slow and fine.
    #[schemars(range(min = 1, max = 4))]
    supersampling: usize,
}

impl Default for RenderFaces {
    fn default() -> Self {
        Self {
            frames: String::new(),
            count: 8,
            yaw_deg: vec![0.0, 35.0],
            pitch_deg: 0.0,
            size_px: 320,
            zoom: 1.0,
            frame_parts: Vec::new(),
            without_parts: Vec::new(),
            columns: None,
            captions: true,
            marker_px: 2.0,
            supersampling: 2,
        }
    }
}

graph_core::register!(RenderFaces);

#[typetag::serde(name = "render_faces")]
impl Node for RenderFaces {
    fn card(&self) -> Card {
        Card::new("save").takes(&RIG).takes(&CURVES).may_take(&MARKERS).may_take(&ATTACHMENT).gives(&IMAGE)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        let (rig, curves) = (inputs.get(&RIG)?, inputs.get(&CURVES)?);
        let scene = Scene::new(rig, curves, inputs.may_get(&MARKERS)?, inputs.may_get(&ATTACHMENT)?)?;
        let positions = self.positions(&scene.axis())?;
        let columns = self.layout(positions.len())?;
        let camera = self.camera(rig)?;
        parts::named(rig, "without_parts", &self.without_parts)?;
        let style = Style {
            supersampling: self.supersampling,
            hidden: self.without_parts.clone(),
            ..Style::sized(self.size_px, self.size_px)
        };
        let pictures = positions.len() * self.yaw_deg.len();
        context.claim("count", (pictures * self.size_px * self.size_px).saturating_mul(size_of::<[f32; 4]>()))?;
        let mut sheet = Sheet::new(columns);
        for (done, position) in positions.iter().enumerate() {
            let pose = scene.pose(*position)?;
            for yaw_deg in &self.yaw_deg {
                context.go_on()?;
                let camera = camera.turned(yaw_deg.to_radians() as f32, self.pitch_deg.to_radians() as f32);
                let mut image = render_rig(rig, &pose.vertices, &camera, &style).map_err(NodeError::failed)?;
                self.mark(&mut image, &camera, &pose);
                sheet.add(if self.captions { self.caption(&pose, *yaw_deg) } else { String::new() }, image);
            }
            context.progress((done + 1) as f64 / positions.len() as f64, &[]);
        }
        Ok(Outputs::default().with(&IMAGE, sheet.compose()))
    }
}

impl RenderFaces {
    /// Positions of the drawn frames, counted from 0.
    fn positions(&self, axis: &FrameAxis) -> Result<Vec<usize>, NodeError> {
        if self.frames.trim().is_empty() {
            let count = self.count.min(axis.count);
            return Ok((0..count).map(|index| (2 * index + 1) * axis.count / (2 * count)).collect());
        }
        let wrong = |problem: String| NodeError::parameter("frames", problem);
        let last = axis.slice(&(axis.count - 1..axis.count)).first;
        let place = |frame: i64| {
            if (axis.first..=last).contains(&frame) {
                Ok((frame - axis.first) as usize)
            } else {
                Err(wrong(format!("there is no frame {frame}; the curves hold frames {} to {last}", axis.first)))
            }
        };
        frame_range::frames(&self.frames, PICTURES).map_err(wrong)?.into_iter().map(place).collect()
    }

    /// Columns of the sheet, where it is not too large.
    fn layout(&self, frames: usize) -> Result<usize, NodeError> {
        let views = self.yaw_deg.len();
        if views == 0 {
            return Err(NodeError::parameter("yaw_deg", "at least one angle is needed, such as [0.0]"));
        }
        let pictures = frames * views;
        let pixels = pictures * self.size_px * self.size_px;
        if pictures > PICTURES || pixels > SHEET_PX {
            let problem = format!(
                "{pictures} pictures of {0} x {0} pixels are too much for one sheet; draw fewer frames or angles, or \
                 smaller pictures",
                self.size_px
            );
            return Err(NodeError::parameter("size_px", problem));
        }
        if self.size_px * self.supersampling > SIDE_SAMPLES {
            let problem = format!(
                "{} samples along each side of a pixel are too much for pictures of {} pixels; take {} or fewer",
                self.supersampling,
                self.size_px,
                (SIDE_SAMPLES / self.size_px).max(1)
            );
            return Err(NodeError::parameter("supersampling", problem));
        }
        let square = (pictures as f64).sqrt().ceil() as usize;
        Ok(self.columns.unwrap_or(square.div_ceil(views) * views))
    }

    /// The camera at the front, the same for all frames.
    fn camera(&self, rig: &Rig) -> Result<Camera, NodeError> {
        let mut points: Vec<Vec3> = Vec::new();
        for part in parts::named(rig, "frame_parts", &self.frame_parts)? {
            points.extend(&rig.neutral[part.vertices.start as usize..part.vertices.end as usize]);
        }
        if self.frame_parts.is_empty() {
            points = moved(rig);
        }
        Ok(Camera::framing(&points).closer(self.zoom as f32))
    }

    fn mark(&self, image: &mut Image, camera: &Camera, pose: &Pose<'_>) {
        let radius_px = self.marker_px as f32;
        draw_marks(image, camera, pose.captured, &Mark { radius_px, ..Mark::CAPTURED });
        draw_marks(image, camera, &pose.own, &Mark { radius_px: radius_px * 1.2, ..Mark::PUPPET });
    }

    fn caption(&self, pose: &Pose<'_>, yaw_deg: f64) -> String {
        let mut words = vec![pose.frame.to_string()];
        if self.yaw_deg.len() > 1 {
            words.push(format!("{yaw_deg:.0} deg"));
        }
        if let Some(distance_m) = pose.distance_m {
            words.push(format!("{:.2} mm", distance_m * 1000.0));
        }
        words.join("  ")
    }
}

impl From<SceneError> for NodeError {
    fn from(error: SceneError) -> Self {
        match error {
            SceneError::Rig(problem) => Self::input(RIG.name(), problem),
            SceneError::Curves(problem) => Self::input(CURVES.name(), problem),
            SceneError::Markers(problem) => Self::input(MARKERS.name(), problem),
            SceneError::Attachment(problem) => Self::input(ATTACHMENT.name(), problem),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Bench, HEAD, compute, made};
    use face_math::data::SurfacePoint;
    use face_math::rig::{AttachOptions, MarkerRig, attach_markers};
    use serde_json::{Value, json};

    fn inputs() -> Inputs {
        Inputs::default().with(&RIG, HEAD.rig.clone()).with(&CURVES, HEAD.range_of_motion.clone())
    }

    /// Exact markers of the range of motion, and where they sit.
    fn marked() -> Inputs {
        let attached = attach_markers(&HEAD.rig, &HEAD.neutral_markers, &AttachOptions::default()).unwrap();
        let rig = MarkerRig::attached(&HEAD.rig, &attached.attachment).unwrap();
        inputs().with(&MARKERS, rig.drive(&HEAD.range_of_motion).unwrap()).with(&ATTACHMENT, attached.attachment)
    }

    fn small(mut more: Value) -> RenderFaces {
        let mut with = json!({"size_px": 64, "supersampling": 1, "count": 2});
        with.as_object_mut().unwrap().append(more.as_object_mut().unwrap());
        made(with)
    }

    fn drawn(node: &RenderFaces, inputs: &Inputs) -> Result<Image, String> {
        let outputs = compute(node, inputs).map_err(|error| error.to_string())?;
        Ok(outputs.get(&IMAGE).unwrap().clone())
    }

    #[test]
    fn every_frame_is_drawn_from_every_angle() {
        let node = small(json!({"yaw_deg": [-30.0, 0.0, 30.0]}));
        let image = drawn(&node, &inputs()).unwrap();
        assert_eq!((image.width_px(), image.height_px()), (3 * 68 + 4, 2 * (64 + 12 + 4) + 4));
        assert_eq!(drawn(&node, &inputs()).unwrap(), image);
        let row = drawn(&small(json!({"columns": 4})), &inputs()).unwrap();
        assert_eq!(row.width_px(), 4 * 68 + 4);
    }

    #[test]
    fn different_frames_look_different() {
        let one = |frames: &str| {
            drawn(&small(json!({"frames": frames, "yaw_deg": [0.0], "captions": false})), &inputs()).unwrap()
        };
        assert_eq!(one("0"), one(" 0 "));
        let open = HEAD.range_of_motion.index("jawOpen").unwrap();
        let frame = (0..600)
            .max_by(|a, b| HEAD.range_of_motion.frame(*a)[open].total_cmp(&HEAD.range_of_motion.frame(*b)[open]));
        assert_ne!(one("0"), one(&frame.unwrap().to_string()));
    }

    #[test]
    fn frames_are_spread_over_the_middles_of_equal_spans() {
        let axis = FrameAxis { first: 1001, count: 100, rate_hz: 60.0 };
        let positions = |more: Value| small(more).positions(&axis);
        assert_eq!(positions(json!({"count": 4})).unwrap(), [12, 37, 62, 87]);
        assert_eq!(positions(json!({"count": 1000})).unwrap(), (0..100).collect::<Vec<_>>());
        assert_eq!(positions(json!({"frames": "1001,1050-1052"})).unwrap(), [0, 49, 50, 51]);
        let error = positions(json!({"frames": "1101"})).unwrap_err().to_string();
        assert_eq!(error, "parameter `frames`: there is no frame 1101; the curves hold frames 1001 to 1100");
    }

    #[test]
    fn markers_and_captions_are_drawn() {
        let bare = small(json!({"yaw_deg": [0.0], "size_px": 160, "captions": false}));
        let bold = small(json!({"yaw_deg": [0.0], "size_px": 160, "captions": false, "marker_px": 4.0}));
        let face = drawn(&bare, &inputs()).unwrap();
        let changed = |node: &RenderFaces, inputs: &Inputs| {
            let image = drawn(node, inputs).unwrap();
            face.pixels().chunks(3).zip(image.pixels().chunks(3)).filter(|(a, b)| a != b).count()
        };
        let all = marked();
        let dots = inputs().with(&MARKERS, all.get(&MARKERS).unwrap().clone());
        let crosses = inputs().with(&ATTACHMENT, all.get(&ATTACHMENT).unwrap().clone());
        let missing = vec![glam::Vec3::NAN; all.get(&MARKERS).unwrap().positions().len()];
        let gone = inputs().with(&MARKERS, all.get(&MARKERS).unwrap().with_positions(missing).unwrap());
        assert_eq!(changed(&bold, &gone), 0);
        for with in [&dots, &crosses, &all] {
            let (fine, thick) = (changed(&bare, with), changed(&bold, with));
            assert!(fine > 500 && thick > fine, "{fine} {thick}");
        }
        let captioned = small(json!({"yaw_deg": [0.0], "size_px": 160}));
        assert_ne!(drawn(&captioned, &inputs()).unwrap(), face);
    }

    #[test]
    fn what_does_not_fit_is_named() {
        let error = |more: Value, inputs: &Inputs| drawn(&small(more), inputs).unwrap_err();
        let short = marked().with(&MARKERS, HEAD.neutral_markers.clone());
        assert!(error(json!({}), &short).starts_with("input `markers`: beside the curves: 600 frames"));
        let mut values = HEAD.range_of_motion.values().to_vec();
        values.fill(f32::NAN);
        let axis = HEAD.range_of_motion.frame_axis();
        let broken = Curves::new(axis, HEAD.rig.channels.clone(), values).unwrap();
        let broken = inputs().with(&CURVES, broken);
        assert!(error(json!({}), &broken).contains("channel `browDown_L` is NaN in frame 150"));
        assert!(error(json!({"frame_parts": ["fase"]}), &inputs()).contains("did you mean `face`?"));
        assert!(error(json!({"without_parts": ["hat"]}), &inputs()).contains("`without_parts`"));
        assert!(error(json!({"yaw_deg": []}), &inputs()).contains("`yaw_deg`"));
        assert!(error(json!({"count": 500, "size_px": 2048}), &inputs()).contains("`size_px`"));
        assert!(error(json!({"size_px": 2048, "supersampling": 4}), &inputs()).contains("take 2 or fewer"));
        let point =
            SurfacePoint { name: "a".into(), vertices: [0, 1, 9_000_000], weights: [1.0, 0.0, 0.0], distance_m: 0.0 };
        let foreign = inputs().with(&ATTACHMENT, Attachment { points: vec![point] });
        assert!(error(json!({}), &foreign).contains("attach the markers to this rig"));
    }

    #[test]
    fn it_stops_when_cancelled() {
        let bench = Bench::default().cancelled_after(1);
        let stopped = bench.compute(&small(json!({"count": 50})), &inputs());
        assert!(matches!(stopped, Err(NodeError::Cancelled)));
        assert_eq!(bench.fractions().len(), 1);
    }
}
