//! A procedural head that stands in for a scanned actor, so that everything runs with no data.
//!
//! [`build`] makes a rig of the kind that scans give: face, head, teeth, gums, tongue, eyeballs; 53 channels, combination
//! correctives and in-betweens; 98 painted markers, 68 landmarks, seven regions, a range of motion. [`takes()`] performs
//! it: markers with the weights that drove them. All of it is computed from a seed, the same on every run.
//!
//! The way from proportions to a rig, in order: `identity` (who), `skull` (the bare head), `features` (what
//! stands on it), `skin` (the mesh), pieces besides the skin (`eyes`, `mouth_inside`, `decals`, `ears`), `motion`
//! (what channels do, from `brushes`, `lids`, `lips`, `jaw`), `assemble` (the rig), `places` (markers, landmarks),
//! `performance` (curves), `takes`.

mod assemble;
mod brushes;
mod channels;
mod decals;
mod ears;
mod eyes;
mod features;
mod gestures;
mod identity;
mod jaw;
mod lids;
mod lips;
mod motion;
mod mouth_inside;
mod numbers;
mod performance;
mod piece;
mod places;
mod regions;
mod skin;
mod skull;
mod takes;

pub use channels::{CHANNELS, COMBINATIONS, IN_BETWEENS};
pub use performance::RATE_HZ;
pub use takes::{Take, takes};

use assemble::Assembly;
use face_math::data::{Curves, DataError, Markers, Regions, Rig};
use face_math::rig::RigError;
use glam::Vec3;
use wire::FrameAxis;

/// Which head to build.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Who: 0 is the average head, other seeds are other people.
    pub identity: u64,
    /// How far people differ from the average: 0 not at all, 1 as people do, 2 as caricatures do.
    pub variation: f32,
    /// Fineness of the mesh along each side: 1 gives about 20,000 vertices, 0.7 half as many. Between 0.5 and 2.
    pub density: f32,
    /// Length of the range of motion in frames of 1/60 s, at least 600.
    pub motion_frames: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self { identity: 0, variation: 1.0, density: 1.0, motion_frames: 1600 }
    }
}

/// A built head.
#[derive(Debug, Clone, PartialEq)]
pub struct SampleHead {
    /// The rig; its shapes hold the whole deformation, its `skin` the jaw's shares.
    pub rig: Rig,
    /// All markers at rest, one frame, in metres: face, pupils, head.
    pub neutral_markers: Markers,
    /// The rig's vertex of each marker, in the order of the neutral markers.
    pub marker_vertices: Vec<u32>,
    /// The seven regions.
    pub regions: Regions,
    /// The rig's vertex of each of the 68 landmarks, in Multi-PIE order.
    pub landmarks: [u32; 68],
    /// A range of motion.
    pub range_of_motion: Curves,
}

/// Why no head was built.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SampleHeadError {
    /// An option lies outside its bounds.
    #[error("option `{option}` is {value}: choose a value from {low} to {high}")]
    Option {
        /// Name of the option.
        option: &'static str,
        /// What was asked for.
        value: f64,
        /// Least value.
        low: f64,
        /// Greatest value.
        high: f64,
    },
    /// The head's parts do not fit together.
    #[error(transparent)]
    Data(#[from] DataError),
    /// The head cannot be posed.
    #[error(transparent)]
    Rig(#[from] RigError),
}

fn within(option: &'static str, value: f64, low: f64, high: f64) -> Result<(), SampleHeadError> {
    if (low..=high).contains(&value) { Ok(()) } else { Err(SampleHeadError::Option { option, value, low, high }) }
}

/// Builds the head.
///
/// # Errors
/// Where an option is outside its bounds.
pub fn build(options: &Options) -> Result<SampleHead, SampleHeadError> {
    within("variation", f64::from(options.variation), 0.0, 3.0)?;
    within("density", f64::from(options.density), 0.5, 2.0)?;
    within("motion_frames", options.motion_frames as f64, 600.0, 1e6)?;
    let features = features::Features::new(identity::Identity::new(options.identity, options.variation));
    let skin = skin::Skin::new(&features, options.density);
    let normals = normals(&skin);
    let mut pieces = mouth_inside::inside(&skin);
    pieces.extend(eyes::eyes(&features, options.density));
    pieces.extend(ears::ears(&features));
    pieces.push(decals::lips(&skin, &normals, &features));
    pieces.push(decals::lashes(&skin, &normals, &features));
    pieces.push(decals::brows(&skin, &normals, &features));
    pieces.push(decals::nostrils(&skin, &normals, &features));

    let name = format!("sample_head_{}", options.identity);
    let mut assembly = Assembly::new(&name, &features, &skin, &pieces);
    assembly.add_shapes(&motion::Mover::new(&features, &skin), &features, &pieces);
    let Assembly { rig, of_skin, .. } = assembly;
    let rig = rig.checked()?;

    let on_rig = |vertex: u32| of_skin[vertex as usize];
    let (face, head) = places::skin_markers(&skin, &features);
    let mut named: Vec<(String, u32)> = face.into_iter().map(|(name, vertex)| (name, on_rig(vertex))).collect();
    let after_lips = named.iter().position(|(name, _)| name.starts_with("skin_")).unwrap_or(named.len());
    for (place, name) in ["pupil_L", "pupil_R"].into_iter().enumerate() {
        let centre = rig.part(name).map_or(0, |part| part.vertices.start);
        named.insert(after_lips + place, (name.to_owned(), centre));
    }
    named.extend(head.into_iter().map(|(name, vertex)| (name, on_rig(vertex))));
    let (names, marker_vertices): (Vec<String>, Vec<u32>) = named.into_iter().unzip();
    let at_rest = marker_vertices.iter().map(|vertex| rig.neutral[*vertex as usize]).collect();
    Ok(SampleHead {
        regions: regions::regions(&names),
        neutral_markers: Markers::new(FrameAxis::new(1, RATE_HZ), names, at_rest)?,
        marker_vertices,
        landmarks: places::landmarks(&skin, &features).map(on_rig),
        range_of_motion: performance::range_of_motion(options.motion_frames, 1 + options.identity)?,
        rig,
    })
}

/// Unit normals of the skin, weighted by area.
fn normals(skin: &skin::Skin) -> Vec<Vec3> {
    let mut sums = vec![Vec3::ZERO; skin.points.len()];
    for corners in &skin.triangles {
        let [a, b, c] = corners.map(|vertex| skin.points[vertex as usize].at);
        let normal = (b - a).cross(c - a);
        for vertex in corners {
            sums[*vertex as usize] += normal;
        }
    }
    sums.iter().map(|sum| sum.normalize_or(Vec3::Z)).collect()
}
