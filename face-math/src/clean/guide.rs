//! What tells a lost marker's place from the others that are seen in the same frame: its neighbours on the face, or the
//! shapes that the whole face takes. Called by [`fill_gaps`](super::fill_gaps).
//!
//! For neighbours, see [`LocalMotion`]. In a [`ShapeSpace`] with mean μ, modes P of the variances λₖ and remainder σ, the
//! seen markers y (metres, as one vector) are y = R (μ + P c) + t + noise. R and t follow from the shape by a rigid fit,
//! and the shape from R and t as the most probable one,
//!
//! ```text
//! c = (PₛᵀPₛ + σ² diag(1/λₖ))⁻¹ Pₛᵀ (Rᵀ(y − t) − μₛ)
//! ```
//!
//! (Tipping and Bishop 1999, Eq. 6, over the rows s that are seen), by turns. What a face does that the shapes do not know
//! is alike in a marker and its neighbours: the place that the shape gives is moved at last as the marker's neighbours are
//! from their places by the shape to where they are seen, by the same [`LocalMotion`].

use super::gaps::Seen;
use super::local_motion::LocalMotion;
use crate::data::ShapeSpace;
use crate::rig::fit_rigid;
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use glam::DVec3;

/// Turns between the head's motion and the shape; the second changes less than tracking can tell.
const TURNS: usize = 3;

/// Neighbours that say what the shapes do not know.
const NEIGHBOURS: usize = 8;

/// Markers that must be seen to tell a shape from.
const LEAST_SEEN: usize = 6;

/// One marker, and what tells its place.
pub(super) enum Guide<'a> {
    Neighbours(Neighbourhood),
    Shapes(ShapeGuide<'a>),
}

impl Guide<'_> {
    /// The columns that tell the marker's place in all of `frames` alike.
    pub fn chosen(&self, seen: &Seen<'_>, frames: &[usize]) -> Vec<usize> {
        let always = |column: &usize| frames.iter().all(|frame| seen.at(*column, *frame).is_some());
        match self {
            Self::Neighbours(own) => {
                let columns = own.others.iter().map(|(column, _)| *column);
                columns.filter(always).take(own.count).collect()
            }
            Self::Shapes(own) => {
                let columns = own.plan.columns.iter().map(|(column, _)| *column);
                columns.filter(|column| *column != own.column).filter(always).collect()
            }
        }
    }

    /// Where the marker is in `frame` by the markers `chosen`, and how the face around it is turned.
    pub fn motion(&self, seen: &Seen<'_>, frame: usize, chosen: &[usize]) -> Option<LocalMotion> {
        let now: Vec<DVec3> = chosen.iter().map(|column| seen.at(*column, frame)).collect::<Option<_>>()?;
        match self {
            Self::Neighbours(own) => {
                let rest: Vec<DVec3> = chosen.iter().map(|column| own.places[*column]).collect::<Option<_>>()?;
                LocalMotion::fit(own.place, &rest, &now)
            }
            Self::Shapes(own) => own.plan.fit(own.place, chosen, &now),
        }
    }
}

/// A marker on the face at rest, and the others by their distance from it.
pub(super) struct Neighbourhood {
    /// Place of the marker at rest, in metres.
    place: DVec3,
    /// Places of all columns at rest.
    places: Vec<Option<DVec3>>,
    /// Columns and places at rest (metres) of the other markers, nearest first.
    others: Vec<(usize, DVec3)>,
    /// k.
    count: usize,
}

impl Neighbourhood {
    /// Around the marker `column`, where the face at rest has it.
    pub fn of(column: usize, rest: &[Option<DVec3>], count: usize) -> Option<Self> {
        let place = rest[column]?;
        let all = rest.iter().enumerate().filter(|(other, _)| *other != column);
        let mut others: Vec<(usize, DVec3)> = all.filter_map(|(other, place)| Some((other, (*place)?))).collect();
        others.sort_by(|(_, a), (_, b)| a.distance_squared(place).total_cmp(&b.distance_squared(place)));
        Some(Self { place, places: rest.to_vec(), others, count })
    }
}

/// The shapes of a face, beside the columns of a take.
pub(super) struct ShapePlan<'a> {
    space: &'a ShapeSpace,
    /// Column in the take and place in the space of each marker that both have.
    columns: Vec<(usize, usize)>,
}

/// A marker of the shapes of a face.
pub(super) struct ShapeGuide<'a> {
    column: usize,
    /// Its place in the space.
    place: usize,
    plan: &'a ShapePlan<'a>,
}

impl<'a> ShapePlan<'a> {
    /// The shapes of `space` for a take whose markers are called `names`.
    pub fn new(space: &'a ShapeSpace, names: &[String]) -> Self {
        let place = |name: &String| space.markers().iter().position(|own| own == name);
        let columns = names.iter().enumerate().filter_map(|(column, name)| Some((column, place(name)?)));
        Self { space, columns: columns.collect() }
    }

    /// How many markers both have.
    pub fn shared(&self) -> usize {
        self.columns.len()
    }

    /// The guide of the marker `column`, where the space has it.
    pub fn guide(&'a self, column: usize) -> Option<ShapeGuide<'a>> {
        let (_, place) = *self.columns.iter().find(|(own, _)| *own == column)?;
        Some(ShapeGuide { column, place, plan: self })
    }

    /// The most probable place of the marker at `wanted` in the space, where the markers `chosen` are seen at `now`.
    fn fit(&self, wanted: usize, chosen: &[usize], now: &[DVec3]) -> Option<LocalMotion> {
        if chosen.len() < LEAST_SEEN {
            return None;
        }
        let find = |column: &usize| self.columns.iter().find(|(own, _)| own == column).map(|(_, place)| *place);
        let places: Vec<usize> = chosen.iter().map(find).collect::<Option<_>>()?;
        let count = self.space.spreads_m().len();
        let modes = Mat::from_fn(3 * places.len(), count, |row, mode| {
            f64::from(self.space.mode(mode)[places[row / 3]][row % 3])
        });
        let noise = self.space.remainder_m().powi(2);
        let mut normal = modes.transpose() * &modes;
        for (mode, spread) in self.space.spreads_m().iter().enumerate() {
            normal[(mode, mode)] += noise / spread.powi(2);
        }
        let factor = normal.llt(Side::Lower).ok()?;
        let mean: Vec<DVec3> = places.iter().map(|place| self.space.mean()[*place].as_dvec3()).collect();
        let mut shape = mean.clone();
        let (mut moved, mut head) = (DVec3::ZERO, None);
        for _ in 0..TURNS {
            let turned = fit_rigid(&shape, now, None).ok()?.motion;
            let back = turned.inverse();
            let offsets =
                Mat::from_fn(3 * places.len(), 1, |row, _| (back.apply(now[row / 3]) - mean[row / 3])[row % 3]);
            let by = factor.solve(modes.transpose() * &offsets);
            let bent = &modes * &by;
            for (marker, point) in shape.iter_mut().enumerate() {
                *point = mean[marker] + DVec3::from_array(std::array::from_fn(|axis| bent[(3 * marker + axis, 0)]));
            }
            let own: DVec3 = (0..count).map(|mode| by[(mode, 0)] * self.space.mode(mode)[wanted].as_dvec3()).sum();
            moved = turned.apply(self.space.mean()[wanted].as_dvec3() + own);
            head = Some(turned);
        }
        let head = head?;
        // The nearest on the mean face, where the shape puts them and where they are seen.
        let here = self.space.mean()[wanted].as_dvec3();
        let mut near: Vec<usize> = (0..places.len()).collect();
        near.sort_by(|a, b| mean[*a].distance_squared(here).total_cmp(&mean[*b].distance_squared(here)));
        near.truncate(NEIGHBOURS);
        let by_shape: Vec<DVec3> = near.iter().map(|marker| head.apply(shape[*marker])).collect();
        let as_seen: Vec<DVec3> = near.iter().map(|marker| now[*marker]).collect();
        let moved = LocalMotion::fit(moved, &by_shape, &as_seen).map_or(moved, |local| local.moved);
        Some(LocalMotion { rotation: head.rotation, moved })
    }
}
