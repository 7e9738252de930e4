//! `project_eye_markers`: pupils that one camera tracks, cast onto the puppet (section 8 of FDLS); after the markers are
//! triangulated, before features.

use crate::patterns::Patterns;
use face_math::clean::{MOTION_CHANNELS, motion_of};
use face_math::data::{Attachment, CalibratedCamera, Cameras, Curves, Markers, Rig, SurfacePoint, Views};
use face_math::rig::{Puppet, Rigid};
use face_math::views::{Hit, Ray, cast_ray, meetings, ray_through};
use glam::{DVec3, Vec3};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const VIEWS: Port<Views> = Port::new("views", "where cameras saw the eye markers, in pixels of the distorted picture");
const CAMERAS: Port<Cameras> = Port::new("cameras", "the calibrated cameras that the views name");
const RIG: Port<Rig> = Port::new("rig", "the puppet whose surface the markers are cast onto");
const ATTACHMENT: Port<Attachment> = Port::new(
    "attachment",
    "where the eye markers sit on the puppet; of the surfaces that a ray meets, the one nearest to that counts",
);
const CURVES: Port<Curves> =
    Port::new("curves", "a solve, to cast onto the posed puppet; onto the puppet at rest where left open");
const MOTION: Port<Curves> = Port::new(
    "motion",
    "how the head moved before the cameras, as `stabilize_head` gives it; where left open, the head stands as the rig does",
);
const OTHERS: Port<Markers> =
    Port::new("markers", "other markers of the same frames, in metres, which the eye markers join or replace");
const EYES: Port<Markers> = Port::new(
    "markers",
    "the eye markers in the frame of the rig, in metres, behind the other markers; missing where not seen, or where the \
     ray meets nothing",
);

/// Casts 2D eye markers from the camera through its picture onto the puppet: where the ray meets its surface, there the
/// marker is in space.
///
/// Without `attachment` the first surface counts. Eyeballs are often modelled with a cornea before the iris, which rays
/// meet first; with the pupils' attachment connected, rays go through to the surface that the marker sits on.
///
/// Where a solve is connected, the puppet is posed by it first; where the head's motion is, it is taken out.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ProjectEyeMarkers {
    /// Markers to cast, as patterns.
    eyes: Vec<String>,
    /// Cameras to cast from, as patterns: `upper`. Of those, in the order of the calibration, the first that saw a marker
    /// casts it. All cameras where empty.
    from: Vec<String>,
    /// Parts of the rig to cast onto, as patterns: `eyeball_*`. All where empty, lids and brows too.
    parts: Vec<String>,
}

impl Default for ProjectEyeMarkers {
    fn default() -> Self {
        Self { eyes: vec!["pupil_*".to_owned()], from: Vec::new(), parts: Vec::new() }
    }
}

graph_core::register!(ProjectEyeMarkers);

#[typetag::serde(name = "project_eye_markers")]
impl Node for ProjectEyeMarkers {
    fn card(&self) -> Card {
        let card = Card::new("clean").takes(&VIEWS).takes(&CAMERAS).takes(&RIG).may_take(&ATTACHMENT);
        card.may_take(&CURVES).may_take(&MOTION).may_take(&OTHERS).gives(&EYES).per_frame(0)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        let (views, rig) = (inputs.get(&VIEWS)?, inputs.get(&RIG)?);
        let axis = views.frame_axis();
        let others = inputs.may_get(&OTHERS)?;
        let (curves, motion) = (inputs.may_get(&CURVES)?, inputs.may_get(&MOTION)?);
        let axes = [
            (OTHERS.name(), others.map(Markers::frame_axis)),
            (CURVES.name(), curves.map(Curves::frame_axis)),
            (MOTION.name(), motion.map(Curves::frame_axis)),
        ];
        for (port, other) in axes.into_iter().filter_map(|(port, other)| Some((port, other?))) {
            axis.matches(&other).map_err(|error| NodeError::input(port, error))?;
        }
        let eyes = Patterns { parameter: "eyes", what: "marker", names: views.markers() }.fits(&self.eyes)?;
        let eyes: Vec<usize> = (0..eyes.len()).filter(|marker| eyes[*marker]).collect();
        let cameras = self.cameras(views, inputs.get(&CAMERAS)?)?;
        let triangles = self.triangles(rig)?;
        let puppet = Puppet::new(rig).map_err(|error| NodeError::input(RIG.name(), error))?;
        let weights = curves.map(|curves| curves.arrange(&rig.channels, None)).transpose();
        let weights = weights.map_err(|error| NodeError::input(CURVES.name(), error))?;
        if let Some(weights) = &weights {
            crate::rig::check_finite(CURVES.name(), weights)?;
        }
        let motion = motion.map(|motion| motion.arrange(&MOTION_CHANNELS.map(str::to_owned), None)).transpose();
        let motion = motion.map_err(|error| NodeError::input(MOTION.name(), error))?;

        let attachment = inputs.may_get(&ATTACHMENT)?;
        let anchors = eyes.iter().map(|marker| anchor(attachment, &views.markers()[*marker], rig));
        let anchors = anchors.collect::<Result<Vec<_>, _>>()?;
        let names: Vec<String> = eyes.iter().map(|marker| views.markers()[*marker].clone()).collect();
        let kept = others.map_or(Vec::new(), |others| {
            (0..others.names().len()).filter(|column| !names.contains(&others.names()[*column])).collect()
        });
        let mut all: Vec<String> = Vec::new();
        all.extend(others.iter().flat_map(|others| kept.iter().map(|column| others.names()[*column].clone())));
        all.extend(names);
        let mut positions = Vec::with_capacity(axis.count * all.len());
        let mut posed = rig.neutral.clone();
        for frame in 0..axis.count {
            context.go_on()?;
            if let Some(weights) = &weights {
                let wrong = |error| NodeError::input(CURVES.name(), error);
                puppet.vertices_into(weights.frame(frame), &mut posed).map_err(wrong)?;
            }
            let head = motion.as_ref().map(|motion| {
                motion_of(std::array::from_fn(|channel| f64::from(motion.frame(frame)[channel]))).inverse()
            });
            positions.extend(others.iter().flat_map(|others| kept.iter().map(|column| others.frame(frame)[*column])));
            for (marker, anchor) in eyes.iter().zip(&anchors) {
                let seen = cameras
                    .iter()
                    .find_map(|(index, camera)| ray_through(camera, views.at(frame, *index, *marker)?.as_dvec2()));
                let ray =
                    seen.map(|ray| head.map_or(ray, |head| moved(ray, &head))).filter(|ray| ray.direction.is_finite());
                let hit = ray.and_then(|ray| match anchor {
                    None => cast_ray(&ray, &posed, triangles.iter().copied()),
                    Some(anchor) => nearest(meetings(&ray, &posed, triangles.iter().copied()), place(anchor, &posed)),
                });
                positions.push(hit.map_or(Vec3::NAN, |hit| hit.place_m.as_vec3()));
            }
        }
        let markers = Markers::new(axis, all, positions).map_err(NodeError::failed)?;
        Ok(Outputs::default().with(&EYES, markers))
    }
}

impl ProjectEyeMarkers {
    /// The cameras to cast from, each with its place in the views, in the order of the calibration.
    fn cameras<'c>(
        &self,
        views: &Views,
        cameras: &'c Cameras,
    ) -> Result<Vec<(usize, &'c CalibratedCamera)>, NodeError> {
        let chosen = Patterns { parameter: "from", what: "camera", names: &cameras.names() }.chosen(&self.from)?;
        let place = |name: &String| views.cameras().iter().position(|own| own == name);
        let used = cameras.cameras().iter().filter(|camera| chosen.contains(&camera.name));
        let used: Vec<_> = used.filter_map(|camera| Some((place(&camera.name)?, camera))).collect();
        if used.is_empty() {
            let problem =
                format!("none of the views' cameras is calibrated and chosen; the views have {:?}", views.cameras());
            return Err(NodeError::input(CAMERAS.name(), problem));
        }
        Ok(used)
    }

    fn triangles<'r>(&self, rig: &'r Rig) -> Result<Vec<&'r [u32; 3]>, NodeError> {
        let names: Vec<String> = rig.parts.iter().map(|part| part.name.clone()).collect();
        let chosen = Patterns { parameter: "parts", what: "part", names: &names }.chosen(&self.parts)?;
        Ok(rig.parts.iter().filter(|part| chosen.contains(&part.name)).flat_map(|part| &part.triangles).collect())
    }
}

/// Where a marker is attached, where that is connected.
fn anchor<'a>(
    attachment: Option<&'a Attachment>,
    name: &str,
    rig: &Rig,
) -> Result<Option<&'a SurfacePoint>, NodeError> {
    let Some(attachment) = attachment else { return Ok(None) };
    let found = attachment.points.iter().find(|point| point.name == name);
    let found = found.filter(|point| point.vertices.iter().all(|vertex| (*vertex as usize) < rig.neutral.len()));
    let problem = || format!("`{name}` sits nowhere on rig `{}`; attach it, or leave `attachment` open", rig.name);
    found.map(Some).ok_or_else(|| NodeError::input(ATTACHMENT.name(), problem()))
}

/// Where an attached point is on the posed vertices, in metres.
fn place(point: &SurfacePoint, posed: &[Vec3]) -> DVec3 {
    let corners = point.vertices.iter().zip(point.weights);
    corners.map(|(vertex, weight)| f64::from(weight) * posed[*vertex as usize].as_dvec3()).sum()
}

/// The meeting nearest to `place` (metres).
fn nearest(meetings: impl Iterator<Item = Hit>, place: DVec3) -> Option<Hit> {
    let apart = |hit: &Hit| hit.place_m.distance_squared(place);
    meetings.min_by(|a, b| apart(a).total_cmp(&apart(b)))
}

fn moved(ray: Ray, motion: &Rigid) -> Ray {
    Ray { origin_m: motion.apply(ray.origin_m), direction: motion.rotation * ray.direction }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{compute, made, test_data};
    use face_io::{camera_json, gltf, marker_csv, no_sibling, view_csv};
    use face_math::rig::{AttachOptions, attach_markers};
    use face_math::views::project;
    use serde_json::json;
    use std::fs;

    struct Actor {
        rig: Rig,
        cameras: Cameras,
        views: Views,
        neutral: Markers,
    }

    fn actor() -> Option<Actor> {
        let folder = test_data("actors/ict_actor_a")?;
        let read = |name: &str| fs::read(folder.join(name)).unwrap();
        Some(Actor {
            rig: gltf::read(&read("ict_actor_a.glb"), "ict_actor_a", &mut no_sibling).unwrap(),
            cameras: camera_json::read(&read("cameras.json")).unwrap(),
            views: view_csv::open(&read("neutral_views.csv")).unwrap().into_views(None).unwrap(),
            neutral: marker_csv::read(&read("neutral_markers.csv"), Some(1.0)).unwrap(),
        })
    }

    fn inputs(actor: &Actor) -> Inputs {
        Inputs::default()
            .with(&VIEWS, actor.views.clone())
            .with(&CAMERAS, actor.cameras.clone())
            .with(&RIG, actor.rig.clone())
    }

    fn run(parameters: serde_json::Value, inputs: &Inputs) -> Result<Markers, String> {
        let node: ProjectEyeMarkers = made(parameters);
        let outputs = compute(&node, inputs);
        outputs.map(|outputs| outputs.get(&EYES).unwrap().clone()).map_err(|error| error.to_string())
    }

    #[test]
    fn real_pupils_land_on_their_places() {
        let Some(actor) = actor() else { return };
        let attached = attach_markers(&actor.rig, &actor.neutral, &AttachOptions::default()).unwrap().attachment;
        for camera in ["cam1", "cam2"] {
            let first = run(json!({"from": [camera]}), &inputs(&actor)).unwrap();
            let known = actor.neutral.frame(0)[actor.neutral.index("pupil_L").unwrap()];
            let depth = 1000.0 * first.frame(0)[0].distance(known);
            assert!((0.5..1.5).contains(&depth), "the cornea stands {depth} mm before the pupil");
            let inputs = inputs(&actor).with(&ATTACHMENT, attached.clone());
            let eyes = run(json!({"from": [camera]}), &inputs).unwrap();
            assert_eq!(eyes.names(), ["pupil_L", "pupil_R"]);
            for (name, place) in eyes.names().iter().zip(eyes.frame(0)) {
                let known = actor.neutral.frame(0)[actor.neutral.index(name).unwrap()];
                // A pixel is 0.3 mm there, and tracking is good to 0.15 of one; the markers lie 0.1 mm off the surface.
                assert!(place.distance(known) < 3e-4, "{camera} {name}: {} mm", 1000.0 * place.distance(known));
            }
        }
    }

    #[test]
    fn a_turned_eye_and_a_moved_head_are_followed() {
        let Some(actor) = actor() else { return };
        let channels = actor.rig.channels.clone();
        let mut weights = vec![0.0; channels.len()];
        let look = channels.iter().position(|channel| channel.starts_with("eyeLook")).unwrap();
        weights[look] = 0.6;
        let puppet = Puppet::new(&actor.rig).unwrap();
        let posed = puppet.vertices(&weights).unwrap();
        // The vertex of the left eyeball that looks forward the most.
        let ball = &actor.rig.part("eyeball_L").unwrap().vertices;
        let front = ball.clone().max_by(|a, b| posed[*a as usize].z.total_cmp(&posed[*b as usize].z)).unwrap();
        let place = posed[front as usize].as_dvec3();
        let motion = [0.01, 0.02, -0.03, 0.05, -0.1, 0.02];
        let camera = actor.cameras.camera("cam2").unwrap();
        let seen = project(camera, motion_of(motion).apply(place)).unwrap().point_px.as_vec2();
        let axis = wire::FrameAxis { first: 9, count: 1, rate_hz: 60.0 };
        let views = Views::new(axis, vec!["cam2".into()], vec!["pupil_L".into()], vec![seen]).unwrap();
        let values = motion.map(|value| value as f32).to_vec();
        let motion = Curves::new(axis, MOTION_CHANNELS.map(str::to_owned).to_vec(), values).unwrap();
        let others = Markers::new(axis, vec!["pupil_L".into(), "chin".into()], vec![Vec3::ZERO, Vec3::ONE]).unwrap();
        let inputs = Inputs::default()
            .with(&VIEWS, views)
            .with(&CAMERAS, actor.cameras.clone())
            .with(&RIG, actor.rig.clone())
            .with(&CURVES, Curves::new(axis, channels, weights).unwrap())
            .with(&MOTION, motion)
            .with(&OTHERS, others);
        let found = run(json!({"parts": ["eyeball_*"]}), &inputs).unwrap();
        assert_eq!((found.names(), found.frame(0)[0]), (&["chin".to_owned(), "pupil_L".to_owned()][..], Vec3::ONE));
        let off = 1000.0 * found.frame(0)[1].as_dvec3().distance(place);
        assert!(off < 0.02, "{off} mm");
    }

    #[test]
    fn unseen_markers_are_missing_and_mistakes_named() {
        let Some(actor) = actor() else { return };
        let none = vec![glam::Vec2::NAN; actor.views.points_px().len()];
        let blind = Actor { views: actor.views.with_points(none).unwrap(), ..actor };
        assert_eq!(run(json!({}), &inputs(&blind)).unwrap().missing(), 2);
        assert!(run(json!({"eyes": ["iris_*"]}), &inputs(&blind)).unwrap_err().contains("`eyes`"));
        assert!(run(json!({"from": ["upper"]}), &inputs(&blind)).unwrap_err().contains("`from`"));
        assert!(run(json!({"parts": ["eyes"]}), &inputs(&blind)).unwrap_err().contains("`parts`"));
    }
}
