//! Fills gaps in markers: points that the cameras lost. Between loading a take and the features of its solve, which want
//! every marker in every frame.
//!
//! A gap of at most G frames, seen at both ends, is bridged in time ([`bridge`]).
//!
//! A longer gap, or one that reaches the start or end of the take, follows the markers that are seen in the same frame:
//! v being the marker's place on the face at rest, s(t) = f(v) is that place moved by its k nearest seen neighbours
//! ([`LocalMotion`](super::local_motion::LocalMotion)). Faces do not bend quite as their neighbours say, so what was missing from it while the marker was
//! still seen is carried into the gap. For an end e of the gap, F the up to three seen frames at it, and s, R from the
//! neighbours seen in t and in all of F,
//!
//! ```text
//! xₑ(t) = s(t) + R(t) · mean over f in F of R(f)ᵀ (x(f) − s(f))
//! x(t) = (Σₑ wₑ xₑ(t) + w₀ s(t)) / (Σₑ wₑ + w₀),   wₑ = 1/|t − e| − 1/(C + 1),   w₀ = 1/(C + 1)
//! ```
//!
//! (inverse distance weights in time, after Shepard, "A two-dimensional interpolation function for irregularly-spaced
//! data", 1968), so that the fill leaves one end, comes in at the other, and trusts the neighbours alone from C frames on.
//!
//! Where the shapes that the whole face takes are known ([`ShapeSpace`]), s and R come from all seen markers by those
//! ([`Guide`]) instead of from the neighbours; the rest is the same.
//!
//! Frame t depends on the frames t − H to t + H alone, H = max(G, C) + 2, so a take can be filled block by block.

use super::bridge::{End, Outer, bridge};
use super::guide::{Guide, Neighbourhood, ShapePlan};
use crate::data::{DataError, Markers, ShapeSpace};
use glam::{DVec3, Vec3};
use std::ops::RangeInclusive;

/// Frames beyond an end that are looked at: for the slope there, and for what is carried from there.
const BEYOND: usize = 2;

/// Markers that a shape space must share with a take.
const LEAST_SHARED: usize = 6;

/// How to fill gaps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GapOptions {
    /// G: the longest gap that is bridged in time, in frames.
    pub max_gap_frames: usize,
    /// C: how far what was measured at the ends of a longer gap is carried into it, in frames.
    pub carry_frames: usize,
    /// k: how many neighbours a marker follows through a longer gap; at least three.
    pub neighbours: usize,
}

impl Default for GapOptions {
    fn default() -> Self {
        Self { max_gap_frames: 12, carry_frames: 30, neighbours: 8 }
    }
}

impl GapOptions {
    /// H: frames on either side of a frame that its filling depends on.
    pub fn halo_frames(&self) -> usize {
        self.max_gap_frames.max(self.carry_frames) + BEYOND
    }
}

/// The outcome of [`fill_gaps`].
#[derive(Debug, Clone, PartialEq)]
pub struct Filled {
    /// The markers; points that were seen are as they were, and those that nothing could fill are missing (NaN).
    pub markers: Markers,
    /// How many points were filled in each frame.
    pub filled: Vec<usize>,
    /// Where each point comes from, in the order of the positions.
    pub sources: Vec<Source>,
}

/// Where a point of a filled take comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// Nothing could fill it.
    Missing,
    /// It was seen.
    Seen,
    /// Bridged from the frames around it.
    Time,
    /// From the markers beside it.
    Neighbours,
    /// From the shapes that the face takes.
    Shapes,
}

/// Why gaps cannot be filled.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GapError {
    /// The face at rest has more than its one frame, or none.
    #[error("the face at rest has {frames} frames; give exactly one, such as one chosen frame of a take")]
    NeutralFrames {
        /// Its frames.
        frames: usize,
    },
    /// The face at rest shares too few markers with the take.
    #[error(
        "the face at rest places {shared} of the take's {markers} markers; at least three are needed, under the same names"
    )]
    NeutralMarkers {
        /// Markers that both have.
        shared: usize,
        /// Markers of the take.
        markers: usize,
    },
    /// The shape space and the take share too few markers.
    #[error("the shape space knows {shared} of the take's {markers} markers; learn it from markers of the same names")]
    Shapes {
        /// Markers that both have.
        shared: usize,
        /// Markers of the take.
        markers: usize,
    },
    /// Too few neighbours are asked for.
    #[error("{neighbours} neighbours; at least three fix the motion of skin")]
    Neighbours {
        /// The number asked for.
        neighbours: usize,
    },
    /// A point is infinite: neither seen nor missing.
    #[error("marker `{marker}` is infinite in frame {frame}; mark points that were not seen as missing (NaN)")]
    Infinite {
        /// The marker.
        marker: String,
        /// The number of the frame, as the take counts.
        frame: i64,
    },
    /// The filled points do not make markers.
    #[error(transparent)]
    Data(#[from] DataError),
}

/// Fills the gaps of `take` (metres). `neutral` is one frame with the markers' places on the face at rest (metres), in any
/// pose of the head and any order. `shapes` are those that the face takes; they go before the neighbours. For markers that
/// neither has, only short gaps are filled.
///
/// # Errors
/// Where `neutral` has not one frame or shares fewer than three markers with the take, `shapes` share too few, fewer than
/// three neighbours are asked for, or a point is infinite.
pub fn fill_gaps(
    take: &Markers,
    neutral: Option<&Markers>,
    shapes: Option<&ShapeSpace>,
    options: &GapOptions,
) -> Result<Filled, GapError> {
    if options.neighbours < 3 {
        return Err(GapError::Neighbours { neighbours: options.neighbours });
    }
    let seen = Seen::new(take)?;
    let rest = neutral.map(|neutral| places(take, neutral)).transpose()?;
    let plan = shapes.map(|shapes| ShapePlan::new(shapes, take.names()));
    if let Some(plan) = plan.as_ref().filter(|plan| plan.shared() < LEAST_SHARED) {
        return Err(GapError::Shapes { shared: plan.shared(), markers: take.names().len() });
    }
    let mut positions = take.positions().to_vec();
    let mut filled = vec![0; take.frames()];
    let mut sources = vec![Source::Seen; positions.len()];
    for column in 0..seen.width {
        let gaps: Vec<usize> = (0..take.frames()).filter(|frame| seen.at(column, *frame).is_none()).collect();
        if gaps.is_empty() {
            continue;
        }
        let by_shapes =
            plan.as_ref().and_then(|plan| plan.guide(column)).map(|own| (Guide::Shapes(own), Source::Shapes));
        let guide = by_shapes.or_else(|| {
            let own = Neighbourhood::of(column, rest.as_ref()?, options.neighbours)?;
            Some((Guide::Neighbours(own), Source::Neighbours))
        });
        for frame in gaps {
            let bridged = seen.bridged(column, frame, options.max_gap_frames).map(|place| (place, Source::Time));
            let found = bridged.or_else(|| {
                let (guide, source) = guide.as_ref()?;
                Some((guided(&seen, guide, column, frame, options.carry_frames)?, *source))
            });
            let index = frame * seen.width + column;
            sources[index] = found.map_or(Source::Missing, |(_, source)| source);
            if let Some((place, _)) = found {
                positions[index] = place.as_vec3();
                filled[frame] += 1;
            }
        }
    }
    Ok(Filled { markers: take.with_positions(positions)?, filled, sources })
}

/// Where each marker of the take is on the face at rest, in metres.
fn places(take: &Markers, neutral: &Markers) -> Result<Vec<Option<DVec3>>, GapError> {
    if neutral.frames() != 1 {
        return Err(GapError::NeutralFrames { frames: neutral.frames() });
    }
    let place = |name: &String| {
        let place = neutral.frame(0)[neutral.index(name)?];
        place.is_finite().then(|| place.as_dvec3())
    };
    let places: Vec<_> = take.names().iter().map(place).collect();
    let shared = places.iter().flatten().count();
    if shared < 3 {
        return Err(GapError::NeutralMarkers { shared, markers: take.names().len() });
    }
    Ok(places)
}

/// A take, asked for points that were seen.
pub(super) struct Seen<'a> {
    positions: &'a [Vec3],
    width: usize,
    frames: usize,
}

impl<'a> Seen<'a> {
    fn new(take: &'a Markers) -> Result<Self, GapError> {
        let width = take.names().len();
        if let Some(index) = take.positions().iter().position(|point| !point.is_nan() && !point.is_finite()) {
            let frame = index / width;
            return Err(GapError::Infinite {
                marker: take.names()[index % width].clone(),
                frame: take.frame_axis().slice(&(frame..frame + 1)).first,
            });
        }
        Ok(Self { positions: take.positions(), width, frames: take.frames() })
    }

    /// The place of a marker in a frame (metres), where it was seen.
    pub fn at(&self, column: usize, frame: usize) -> Option<DVec3> {
        let point = self.positions[frame * self.width + column];
        (!point.is_nan()).then(|| point.as_dvec3())
    }

    /// The nearest frame before `frame` that saw the marker, at most `reach` frames away.
    fn before(&self, column: usize, frame: usize, reach: usize) -> Option<usize> {
        (frame.saturating_sub(reach)..frame).rev().find(|other| self.at(column, *other).is_some())
    }

    /// The nearest frame after `frame` that saw the marker, at most `reach` frames away.
    fn after(&self, column: usize, frame: usize, reach: usize) -> Option<usize> {
        let last = frame.saturating_add(reach).min(self.frames - 1);
        (frame + 1..=last).find(|other| self.at(column, *other).is_some())
    }

    /// The place of a marker in a gap of at most `longest` frames.
    fn bridged(&self, column: usize, frame: usize, longest: usize) -> Option<DVec3> {
        let (before, after) = (self.before(column, frame, longest)?, self.after(column, frame, longest)?);
        if after - before > longest + 1 {
            return None;
        }
        // The frame farther out first: over two frames the noise of a slope is half of that over one.
        let end = |at: usize, outward: &dyn Fn(usize) -> Option<usize>| {
            let outer = (1..=BEYOND).rev().find_map(|distance| {
                let place = self.at(column, outward(distance)?)?;
                Some(Outer { distance, place })
            });
            Some(End { place: self.at(column, at)?, outer })
        };
        let first = end(before, &|distance| before.checked_sub(distance))?;
        let last = end(after, &|distance| Some(after + distance).filter(|other| *other < self.frames))?;
        Some(bridge(first, last, frame - before, after - before))
    }

    /// Those of the frames `near` that saw the marker.
    fn frames_seen(&self, column: usize, near: RangeInclusive<usize>) -> Vec<usize> {
        near.filter(|frame| *frame < self.frames && self.at(column, *frame).is_some()).collect()
    }
}

/// The place of the marker `column` in `frame` (metres), by what guides it and by what is carried from up to `carry`
/// frames away.
fn guided(seen: &Seen<'_>, guide: &Guide<'_>, column: usize, frame: usize, carry: usize) -> Option<DVec3> {
    let alone = guide.motion(seen, frame, &guide.chosen(seen, &[frame]))?.moved;
    let least = 1.0 / (carry + 1) as f64;
    let (mut sum, mut total) = (alone * least, least);
    let ends = [
        seen.before(column, frame, carry).map(|end| (end, end.saturating_sub(BEYOND)..=end)),
        seen.after(column, frame, carry).map(|end| (end, end..=end + BEYOND)),
    ];
    for (end, near) in ends.into_iter().flatten() {
        let near = seen.frames_seen(column, near);
        if let Some(place) = carried(seen, guide, column, frame, &near) {
            let weight = 1.0 / frame.abs_diff(end) as f64 - least;
            sum += place * weight;
            total += weight;
        }
    }
    Some(sum / total)
}

/// xₑ: the place in `frame` (metres), as the seen frames `near` an end say it.
fn carried(seen: &Seen<'_>, guide: &Guide<'_>, column: usize, frame: usize, near: &[usize]) -> Option<DVec3> {
    let all: Vec<usize> = near.iter().copied().chain([frame]).collect();
    let chosen = guide.chosen(seen, &all);
    let now = guide.motion(seen, frame, &chosen)?;
    let mut offset = DVec3::ZERO;
    for other in near {
        let then = guide.motion(seen, *other, &chosen)?;
        offset += then.rotation.transpose() * (seen.at(column, *other)? - then.moved);
    }
    Some(now.moved + now.rotation * (offset / near.len() as f64))
}
