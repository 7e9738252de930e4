//! Animations of morph-target weights as curves: the way back from [`super::write_animation`], and in from other tools.
//!
//! Keys become frames: [`rate`] finds how many pass a second, [`sampler`] says what a track is worth at each.

mod rate;
mod sampler;

use super::GltfError;
use super::container::File;
use super::primitive::target_names;
use super::scene::Scene;
use crate::{ReadError, Sibling};
use face_math::data::{Curves, Driver, nearest_name};
use face_math::rig::shape_drivers;
use gltf_json::animation::Property;
use gltf_json::validation::Checked;
use rate::Clock;
use sampler::Track;
use std::collections::{BTreeMap, BTreeSet};
use wire::FrameAxis;

/// More numbers than this come of damaged times, not of a performance.
const MOST_VALUES: f64 = 2e8;

/// The weights in an animation, and what else it moves.
#[derive(Debug, Clone, PartialEq)]
pub struct Animation {
    /// Its name; empty where it has none.
    pub name: String,
    /// Weights of channels. Those of correctives (`a+b`) and in-betweens (`a@0.5`) are left out: rigs compute them.
    pub curves: Curves,
    /// Nodes that turn, move or are scaled over time, by name; curves cannot hold that.
    pub moving_nodes: Vec<String>,
    /// Whether the joints that move follow the channels, because this program wrote the file.
    pub joints_follow: bool,
    /// Correctives and in-betweens whose weights are not what the channels make of them.
    pub free_correctives: Vec<String>,
}

/// The animations of a file in a word: their names.
///
/// # Errors
/// Where the file is damaged.
pub fn animation_names(bytes: &[u8], sibling: &mut Sibling<'_>) -> Result<Vec<String>, ReadError> {
    Ok(names(&File::read(bytes, sibling)?))
}

/// Names of the animations, or numbers where they have none.
pub(super) fn names(file: &File) -> Vec<String> {
    let label = |(index, animation): (usize, &gltf_json::Animation)| {
        animation.name.clone().filter(|name| !name.is_empty()).unwrap_or_else(|| format!("animation_{index}"))
    };
    file.root.animations.iter().enumerate().map(label).collect()
}

/// Reads the weights in the animation called `name`, or in the only one, as curves.
///
/// Between keys, tracks are sampled as they say: in straight lines, steps or cubic splines (appendix C of glTF 2.0).
/// Frame `n` is the time `n / rate`; a file that this program wrote keeps the frame numbers it was written with.
/// Without `rate_hz` it is the one that the keys show: their own where they are even, or else the lowest usual rate
/// that has a frame at every key.
///
/// # Errors
/// Where there is no animation of weights, there are several and no name says which, the keys show no rate, two
/// meshes move a channel differently, or the file is damaged.
pub fn read_animation(
    bytes: &[u8],
    name: Option<&str>,
    rate_hz: Option<f64>,
    sibling: &mut Sibling<'_>,
) -> Result<Animation, ReadError> {
    let file = File::read(bytes, sibling)?;
    let names = names(&file);
    let wrong = |problem: String| GltfError::Animation { name: name.unwrap_or_default().to_owned(), problem };
    let index = match name {
        Some(name) => names.iter().position(|own| own == name).ok_or_else(|| {
            let near = nearest_name(name, names.iter().map(String::as_str));
            let near = near.map_or_else(
                || format!("; there are {}", names.join(", ")),
                |near| format!("; did you mean `{near}`?"),
            );
            wrong(format!("there is no such animation in the file{near}"))
        })?,
        None if names.len() == 1 => 0,
        None if names.is_empty() => {
            return Err(wrong("the file holds no animation; export it with its shape keys animated".into()).into());
        }
        None => return Err(wrong(format!("the file holds several: {}; say which", names.join(", "))).into()),
    };
    Ok(read(&file, index, &names[index], rate_hz)?)
}

/// What a weights track moves: the node's label, the names of its targets, and the track.
struct Moving {
    node: String,
    targets: Vec<String>,
    track: Track,
}

/// The animation at `index`, called `name`.
pub(super) fn read(file: &File, index: usize, name: &str, rate_hz: Option<f64>) -> Result<Animation, GltfError> {
    let wrong = |problem: String| GltfError::Animation { name: name.to_owned(), problem };
    Scene::read(file)?;
    let (moving, moving_nodes) = tracks(file, index, name)?;
    if moving.is_empty() {
        let moves =
            if moving_nodes.is_empty() { "nothing".to_owned() } else { format!("only {}", moving_nodes.join(", ")) };
        return Err(wrong(format!(
            "it moves no morph targets ({moves}); bake the face to its shape keys and export again"
        )));
    }
    let own = Own::of(file);
    let times: Vec<&[f32]> = moving.iter().map(|moving| moving.track.times()).collect();
    let clock = match (rate_hz, &own) {
        (None, Some(own)) if own.fits(&times) => Clock { rate_hz: own.rate_hz },
        _ => Clock::of(&times, rate_hz).map_err(&wrong)?,
    };
    let width: usize = moving.iter().map(|moving| moving.targets.len()).sum();
    let span = clock.frames(&times).filter(|(_, count)| *count as f64 * width as f64 <= MOST_VALUES);
    let (first, count) = span.ok_or_else(|| {
        wrong(format!(
            "between its keys are too many frames of {} Hz; give a lower rate or mend its times",
            clock.rate_hz
        ))
    })?;
    let all = merged(&moving, name, clock, first, count)?;
    // Names keep the order in which the file has them.
    let mut order: Vec<String> = Vec::new();
    let mut seen = BTreeSet::new();
    order.extend(moving.iter().flat_map(|moving| &moving.targets).filter(|name| seen.insert(name.as_str())).cloned());
    let (channels, drivers) = shape_drivers(&order)?;
    let column = |name: &String| all[name].as_slice();
    let columns: Vec<&[f32]> = channels.iter().map(column).collect();
    let free_correctives = order
        .iter()
        .zip(&drivers)
        .filter(|(shape, driver)| !follows(driver, column(shape), &columns, &drivers))
        .map(|(shape, _)| shape.clone())
        .collect();
    let values = (0..count).flat_map(|frame| columns.iter().map(move |column| column[frame])).collect();
    let numbered = own.as_ref().filter(|own| own.frames == count && first == 0).map(|own| own.first_frame);
    let axis = FrameAxis { first: numbered.unwrap_or(first), count, rate_hz: clock.rate_hz };
    let curves = Curves::new(axis, channels, values).map_err(|error| wrong(error.to_string()))?;
    Ok(Animation { name: name.to_owned(), curves, moving_nodes, joints_follow: own.is_some(), free_correctives })
}

/// The tracks of weights in an animation, and the names of nodes that it moves otherwise.
fn tracks(file: &File, index: usize, name: &str) -> Result<(Vec<Moving>, Vec<String>), GltfError> {
    let animation = &file.root.animations[index];
    let wrong = |problem: String| GltfError::Animation { name: name.to_owned(), problem };
    let nodes = &file.root.nodes;
    let (mut moving, mut others) = (Vec::new(), BTreeSet::new());
    for (at, channel) in animation.channels.iter().enumerate() {
        let place = format!("animation `{name}`, channel {at}");
        let missing = |kind, index, count| GltfError::Reference { from: place.clone(), kind, index, count };
        let node_index = channel.target.node.value();
        let node = nodes.get(node_index).ok_or_else(|| missing("node", node_index, nodes.len()))?;
        let label = node.name.clone().unwrap_or_else(|| format!("node {node_index}"));
        match channel.target.path {
            Checked::Valid(Property::MorphTargetWeights) => {}
            Checked::Valid(_) => {
                others.insert(label);
                continue;
            }
            Checked::Invalid => return Err(wrong(format!("channel {at} moves something unknown"))),
        }
        let mesh_index = node
            .mesh
            .ok_or_else(|| wrong(format!("channel {at} moves weights of `{label}`, which has no mesh")))?
            .value();
        let mesh =
            file.root.meshes.get(mesh_index).ok_or_else(|| missing("mesh", mesh_index, file.root.meshes.len()))?;
        let targets = target_names(mesh, mesh_index)?;
        if targets.is_empty() {
            return Err(wrong(format!("channel {at} moves weights of `{label}`, whose mesh has no morph targets")));
        }
        let sampler_index = channel.sampler.value();
        let sampler = animation
            .samplers
            .get(sampler_index)
            .ok_or_else(|| missing("sampler", sampler_index, animation.samplers.len()))?;
        let track = Track::read(file, sampler, targets.len(), &place)?;
        moving.push(Moving { node: label, targets, track });
    }
    Ok((moving, others.into_iter().collect()))
}

/// The weights of each target by name, a frame. Meshes that share a name must move it alike.
fn merged(
    moving: &[Moving],
    animation: &str,
    clock: Clock,
    first: i64,
    count: usize,
) -> Result<BTreeMap<String, Vec<f32>>, GltfError> {
    let mut all: BTreeMap<String, (Vec<f32>, &str)> = BTreeMap::new();
    for Moving { node, targets, track } in moving {
        let mut columns = vec![Vec::with_capacity(count); targets.len()];
        let mut weights = vec![0.0; targets.len()];
        for frame in 0..count {
            track.at(clock.time_s(first + frame as i64), clock.tolerance_s(), &mut weights);
            columns.iter_mut().zip(&weights).for_each(|(column, weight)| column.push(*weight));
        }
        for (name, column) in targets.iter().zip(columns) {
            let Some((known, other)) = all.get(name) else {
                all.insert(name.clone(), (column, node));
                continue;
            };
            let apart = known.iter().zip(&column).position(|(a, b)| (a - b).abs() > 1e-4);
            if let Some(frame) = apart {
                let (a, b) = (known[frame], column[frame]);
                let frame = first + frame as i64;
                return Err(GltfError::Animation {
                    name: animation.to_owned(),
                    problem: format!(
                        "`{name}` is {a} on `{other}` but {b} on `{node}` in frame {frame}; one channel cannot be both"
                    ),
                });
            }
        }
    }
    Ok(all.into_iter().map(|(name, (column, _))| (name, column)).collect())
}

/// Whether the weights of a shape are what its channels make of them, within what eight bits can hold.
fn follows(driver: &Driver, weights: &[f32], channels: &[&[f32]], drivers: &[Driver]) -> bool {
    let close = |frame: usize, expected: f32| (weights[frame] - expected).abs() < 0.005;
    (0..weights.len()).all(|frame| match driver {
        Driver::Channel(_) | Driver::Turn { .. } => true,
        Driver::Combination(parts) => close(frame, parts.iter().map(|part| channels[*part as usize][frame]).product()),
        Driver::InBetween { channel, peak } => {
            let (mut below, mut above) = (0.0_f32, 1.0_f32);
            for other in drivers {
                match other {
                    Driver::InBetween { channel: own, peak: other } if own == channel => {
                        below = if other < peak { below.max(*other) } else { below };
                        above = if other > peak { above.min(*other) } else { above };
                    }
                    _ => {}
                }
            }
            let weight = channels[*channel as usize][frame];
            close(frame, ((weight - below) / (peak - below)).min((above - weight) / (above - peak)).max(0.0))
        }
    })
}

/// What this program notes in `asset.extras` of the files that it writes.
struct Own {
    first_frame: i64,
    frames: usize,
    rate_hz: f64,
}

impl Own {
    fn of(file: &File) -> Option<Self> {
        let asset = &file.root.asset;
        if !asset.generator.as_deref()?.starts_with("grimace ") {
            return None;
        }
        let extras: serde_json::Value = serde_json::from_str(asset.extras.as_deref()?.get()).ok()?;
        let rate_hz = extras["rate_hz"].as_f64().filter(|rate| rate.is_finite() && *rate > 0.0)?;
        let frames = usize::try_from(extras["frames"].as_u64()?).ok()?;
        Some(Self { first_frame: extras["first_frame"].as_i64()?, frames, rate_hz })
    }

    /// Whether the keys are those of the noted frames still; another program may have changed them.
    fn fits(&self, tracks: &[&[f32]]) -> bool {
        let on_time = |(frame, time): (usize, &f32)| {
            let expected = frame as f64 / self.rate_hz;
            (f64::from(*time) - expected).abs() <= 1e-6 * expected.max(1.0)
        };
        tracks.iter().all(|times| times.len() == self.frames && times.iter().enumerate().all(on_time))
    }
}
