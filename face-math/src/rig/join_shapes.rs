//! Rigs of one neutral face, each with some of the shapes, joined into one: how a folder of sculpts becomes a rig.
//!
//! A sculpt shows the whole face, while a rig adds its shapes up. With D the offsets of a shape, S what a file shows less
//! the neutral face (both metres, a vertex), the correctives are what their channels do not do already:
//!
//! ```text
//! D(a@p)   = S(a@p) − p D(a)                        in-between at the weight p
//! D(a+b)   = S(a+b) − D(a) − D(b)                   combination of two channels at weight 1
//! D(a+b+c) = S(a+b+c) − Σ D(one of them) − Σ D(combinations of some of them)
//! ```
//!
//! That is the sum of [`super::ShapeDrivers`] at those weights, solved for the last shape.

use super::{ShapeNameError, shape_drivers};
use crate::data::{DataError, Driver, Rig, Shape};
use glam::Vec3;
use std::collections::BTreeMap;

/// What files of combinations (`a+b`) and in-betweens (`a@0.5`) show.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Sculpts {
    /// The whole face at those weights, as it was sculpted.
    #[default]
    Whole,
    /// The neutral face plus the corrective alone, as programs extract it.
    Offsets,
}

/// Why rigs do not join.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum JoinShapesError {
    /// Nothing to join.
    #[error("there is no head to join; does the pattern of files fit any?")]
    Nothing,
    /// Two heads are not of one surface.
    #[error(
        "`{item}` has {found}, but `{first}` has {expected}; all heads must be of one neutral face, so load them with the \
         same `neutral`"
    )]
    Surface {
        /// The item that differs.
        item: String,
        /// What it has.
        found: String,
        /// The item it differs from.
        first: String,
        /// What that one has.
        expected: String,
    },
    /// Two heads hold a shape of one name.
    #[error("`{first}` and `{second}` both hold the shape `{shape}`; leave one of them out")]
    Twice {
        /// The shape.
        shape: String,
        /// The first item with it.
        first: String,
        /// The second.
        second: String,
    },
    /// A name that makes no sense.
    #[error(transparent)]
    Name(#[from] ShapeNameError),
    /// What was joined does not fit together.
    #[error(transparent)]
    Data(#[from] DataError),
}

/// Joins `heads`, given with the names of their items, into one rig called `name`.
///
/// Channels stand in the order of the items. What shapes mean is read off their names over all heads: a shape that its
/// own head had for a channel becomes a combination or in-between where the channels it names are there.
///
/// # Errors
/// See [`JoinShapesError`].
pub fn join_shapes(heads: &[(&str, &Rig)], name: &str, sculpts: Sculpts) -> Result<Rig, JoinShapesError> {
    let Some(((first, base), _)) = heads.split_first() else { return Err(JoinShapesError::Nothing) };
    let mut from: BTreeMap<&str, &str> = BTreeMap::new();
    let mut shapes: Vec<&Shape> = Vec::new();
    let mut was_channel = Vec::new();
    for (item, head) in heads {
        same_surface((first, base), (item, head))?;
        for shape in &head.shapes {
            if let Some(first) = from.insert(&shape.name, item) {
                let (first, second) = (first.to_owned(), (*item).to_owned());
                return Err(JoinShapesError::Twice { shape: shape.name.clone(), first, second });
            }
            shapes.push(shape);
            was_channel.push(matches!(shape.driver, Driver::Channel(_)));
        }
    }
    let names: Vec<String> = shapes.iter().map(|shape| shape.name.clone()).collect();
    let (channels, drivers) = shape_drivers(&names)?;
    let mut joined: Vec<Shape> =
        shapes.into_iter().zip(drivers).map(|(shape, driver)| Shape { driver, ..shape.clone() }).collect();
    if sculpts == Sculpts::Whole {
        // Combinations of few channels come before those of many, which are made of them.
        let mut order: Vec<usize> = (0..joined.len()).filter(|shape| was_channel[*shape]).collect();
        order.sort_by_key(|shape| match &joined[*shape].driver {
            Driver::Combination(channels) => channels.len(),
            _ => 0,
        });
        for shape in order {
            let parts = parts_of(&joined, shape);
            if !parts.is_empty() {
                subtract(&mut joined, shape, &parts, base.neutral.len());
            }
        }
    }
    let skinned = heads.iter().map(|(_, head)| head).find(|head| !head.skin.is_empty()).unwrap_or(base);
    let rig = Rig {
        name: name.to_owned(),
        parts: base.parts.clone(),
        neutral: base.neutral.clone(),
        channels,
        shapes: joined,
        skin: skinned.skin.clone(),
        jaw_pivot_m: skinned.jaw_pivot_m,
        jaw: None,
        joints: Vec::new(),
    };
    Ok(rig.checked()?)
}

/// Refuses heads of different surfaces, or with a jaw that has been split off already.
fn same_surface((first, base): (&str, &Rig), (item, head): (&str, &Rig)) -> Result<(), JoinShapesError> {
    let refuse = |found: String, expected: String| {
        Err(JoinShapesError::Surface { item: item.to_owned(), found, first: first.to_owned(), expected })
    };
    if head.neutral.len() != base.neutral.len() {
        return refuse(format!("{} vertices", head.neutral.len()), format!("{}", base.neutral.len()));
    }
    let differs = |(part, other): &(&crate::data::Part, &crate::data::Part)| {
        part.vertices != other.vertices || part.triangles != other.triangles
    };
    if head.parts.len() != base.parts.len() || head.parts.iter().zip(&base.parts).any(|pair| differs(&pair)) {
        return refuse("other parts or triangles".to_owned(), format!("{} parts", base.parts.len()));
    }
    let far = |(at, other): &(&Vec3, &Vec3)| !at.abs_diff_eq(**other, 1e-6);
    if let Some(vertex) = head.neutral.iter().zip(&base.neutral).position(|pair| far(&pair)) {
        let (found, expected) = (head.neutral[vertex], base.neutral[vertex]);
        return refuse(format!("vertex {vertex} of its neutral face at {found} m"), format!("it at {expected} m"));
    }
    match &head.jaw {
        Some(_) => refuse("a jaw that was split off already".to_owned(), "shapes to join".to_owned()),
        None => Ok(()),
    }
}

/// The shapes that weigh in where `shape` is at its full weight, itself left out, and how much.
fn parts_of(shapes: &[Shape], shape: usize) -> Vec<(usize, f32)> {
    let channel_shape = |channel: &u32| shapes.iter().position(|other| other.driver == Driver::Channel(*channel));
    match &shapes[shape].driver {
        Driver::Channel(_) | Driver::Turn { .. } => Vec::new(),
        Driver::InBetween { channel, peak } => channel_shape(channel).into_iter().map(|main| (main, *peak)).collect(),
        Driver::Combination(channels) => {
            let some = |other: &&Shape| match &other.driver {
                Driver::Channel(channel) => channels.contains(channel),
                Driver::Combination(own) => {
                    own.len() < channels.len() && own.iter().all(|channel| channels.contains(channel))
                }
                Driver::InBetween { .. } | Driver::Turn { .. } => false,
            };
            shapes.iter().enumerate().filter(|(_, other)| some(other)).map(|(index, _)| (index, 1.0)).collect()
        }
    }
}

/// Takes the weighed `parts` off the offsets of a shape.
fn subtract(shapes: &mut [Shape], shape: usize, parts: &[(usize, f32)], vertices: usize) {
    let mut offsets = vec![Vec3::ZERO; vertices];
    let mut add = |shape: &Shape, weight: f32| {
        for (vertex, delta) in shape.vertices.iter().zip(&shape.deltas) {
            offsets[*vertex as usize] += weight * *delta;
        }
    };
    add(&shapes[shape], 1.0);
    for (part, weight) in parts {
        add(&shapes[*part], -weight);
    }
    // What is left of rounding alone is no corrective: a micrometre is a hundredth of what a scan resolves.
    let moved = offsets.iter().enumerate().filter(|(_, offset)| offset.abs().max_element() > 1e-6);
    (shapes[shape].vertices, shapes[shape].deltas) = moved.map(|(vertex, offset)| (vertex as u32, *offset)).unzip();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::{Puppet, toy};

    /// A head with one shape, moved as `offset` says.
    fn head(shape: &str, offset: impl Fn(usize) -> Vec3) -> Rig {
        let mut rig = toy::rig(5, 4);
        let count = rig.neutral.len();
        rig.channels = vec![shape.to_owned()];
        rig.shapes = vec![Shape {
            name: shape.to_owned(),
            driver: Driver::Channel(0),
            vertices: (0..count as u32).collect(),
            deltas: (0..count).map(offset).collect(),
        }];
        rig
    }

    fn sculpts() -> Vec<(String, Rig)> {
        let wave = |phase: f32| move |vertex: usize| Vec3::new(0.01, 0.02, 0.03) * (vertex as f32 * 0.7 + phase).sin();
        let names = ["a+b+c", "a", "b@0.25", "b", "a+b", "c", "a+c"];
        names.iter().zip(0_u8..).map(|(name, phase)| ((*name).to_owned(), head(name, wave(f32::from(phase))))).collect()
    }

    fn joined(heads: &[(String, Rig)], sculpts: Sculpts) -> Result<Rig, JoinShapesError> {
        let heads: Vec<_> = heads.iter().map(|(name, head)| (name.as_str(), head)).collect();
        join_shapes(&heads, "head", sculpts)
    }

    #[test]
    fn every_sculpt_is_met_at_its_own_weights() {
        let heads = sculpts();
        let rig = joined(&heads, Sculpts::Whole).unwrap();
        assert_eq!(rig.channels, ["a", "b", "c"]);
        let puppet = Puppet::new(&rig).unwrap();
        for (name, head) in &heads {
            let (channel, peak) = name.split_once('@').unwrap_or((name, "1"));
            let weight =
                |own: &String| if channel.split('+').any(|one| one == own) { peak.parse().unwrap() } else { 0.0 };
            let weights: Vec<f32> = rig.channels.iter().map(weight).collect();
            let posed = puppet.vertices(&weights).unwrap();
            for (vertex, point) in posed.iter().enumerate() {
                let sculpted = head.neutral[vertex] + head.shapes[0].deltas[vertex];
                assert!(point.abs_diff_eq(sculpted, 3e-6), "{name}: {point} {sculpted}");
            }
        }
    }

    #[test]
    fn offsets_stay_what_they_are() {
        let heads = sculpts();
        let rig = joined(&heads, Sculpts::Offsets).unwrap();
        for ((_, head), shape) in heads.iter().zip(&rig.shapes) {
            assert_eq!((&head.shapes[0].name, &head.shapes[0].deltas), (&shape.name, &shape.deltas));
        }
        assert_eq!(rig.shapes[2].driver, Driver::InBetween { channel: 1, peak: 0.25 });
    }

    #[test]
    fn heads_that_differ_are_named() {
        assert_eq!(joined(&[], Sculpts::Whole), Err(JoinShapesError::Nothing));
        let mut heads = sculpts();
        heads[3].1 = heads[1].1.clone();
        let error = joined(&heads, Sculpts::Whole).unwrap_err().to_string();
        assert!(error.contains("`a` and `b` both hold the shape `a`"), "{error}");
        let mut heads = sculpts();
        heads[2].1.neutral[7] += Vec3::X;
        let error = joined(&heads, Sculpts::Whole).unwrap_err().to_string();
        assert!(error.contains("`b@0.25` has vertex 7") && error.contains("`a+b+c`"), "{error}");
        let mut heads = sculpts();
        heads.remove(5);
        let error = joined(&heads, Sculpts::Whole).unwrap_err().to_string();
        assert!(error.contains("`c` is no channel"), "{error}");
    }
}
