//! One head's meshes on another (the transfer of Fig. S1 of Animatomy), and guide shapes on top (its section C).
//!
//! **Warp.** φ(x) = `Σ_j` `c_j` ‖x − `p_j`‖ + A x + b takes the actor's landmarks and curve points `p_j` to the character's `q_j`, with
//! the least bending (the biharmonic spline of space; Σ `c_j` = 0, Σ `c_j` `p_jᵀ` = 0). `smoothing_m` ≥ 0 on the diagonal lets it
//! miss them a little.
//!
//! **Surface.** A vertex y of the character sits at the point of the warped actor's surface nearest to it, at weights b of a
//! triangle: it moves to y + φ(Σ b V(t)) − φ(Σ b N), V the actor's mesh and N its rest (metres).
//!
//! **Guides.** Pairs of guide shapes Gᵃ, Gᶜ with Δᵃ = Gᵃ − Rᵃ and Δᶜ = Gᶜ − Tᶜ(Gᵃ): for the actor's mesh Sᵃ,
//!
//! ```text
//! λ = argmin ‖Sᵃ − Rᵃ − Σ λ_i Δᵃ_i‖,      Sᶜ = Tᶜ + Σ λ_i Δᶜ_i
//! ```
//!
//! free, or with 0 ≤ λ ≤ 1 exactly by active set.

use super::error::{StrainError, same};
use super::matrix::product;
use super::pose_shapes::offsets;
use super::surface::Surface;
use crate::data::{Attachment, Curves, Meshes, Muscles, Part, RidingPoint, Rig};
use crate::solve::BoundedQuadratic;
use faer::Mat;
use faer::prelude::Solve;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// How heads are brought together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TransferOptions {
    /// How far the warp may miss landmarks and curves, in metres.
    pub smoothing_m: f64,
}

/// A warp of space.
#[derive(Debug, Clone)]
struct Warp {
    centres: Vec<DVec3>,
    strengths: Vec<DVec3>,
    affine: [DVec3; 4],
}

impl Warp {
    fn new(from: &[DVec3], to: &[DVec3], smoothing_m: f64) -> Result<Self, StrainError> {
        let count = from.len();
        if count < 4 {
            return Err(StrainError::TooFewFrames { found: count, needed: 4 });
        }
        let mut system = Mat::<f64>::zeros(count + 4, count + 4);
        let mut right = Mat::<f64>::zeros(count + 4, 3);
        for i in 0..count {
            for j in 0..count {
                system[(i, j)] = from[i].distance(from[j]);
            }
            system[(i, i)] -= smoothing_m;
            for (column, value) in [1.0, from[i].x, from[i].y, from[i].z].into_iter().enumerate() {
                system[(i, count + column)] = value;
                system[(count + column, i)] = value;
            }
            for axis in 0..3 {
                right[(i, axis)] = to[i][axis];
            }
        }
        let solved = system.partial_piv_lu().solve(&right);
        let row = |i: usize| DVec3::new(solved[(i, 0)], solved[(i, 1)], solved[(i, 2)]);
        let warp = Self {
            centres: from.to_vec(),
            strengths: (0..count).map(row).collect(),
            affine: std::array::from_fn(|i| row(count + i)),
        };
        let finite = warp.strengths.iter().chain(&warp.affine).all(|strength| strength.is_finite());
        if finite { Ok(warp) } else { Err(StrainError::Decomposition { what: "the warp between the heads" }) }
    }

    fn apply(&self, x: DVec3) -> DVec3 {
        let [shift, a, b, c] = self.affine;
        let bent: DVec3 = self.centres.iter().zip(&self.strengths).map(|(centre, by)| x.distance(*centre) * *by).sum();
        shift + x.x * a + x.y * b + x.z * c + bent
    }
}

/// Two heads brought together.
#[derive(Debug)]
pub struct Transfer<'r> {
    character: &'r Rig,
    actor_vertices: usize,
    warp: Warp,
    /// For each vertex of the character, where it rides on the actor, and where the warp takes that point at rest.
    riding: Vec<(RidingPoint, DVec3)>,
}

impl<'r> Transfer<'r> {
    /// Brings `actor` and `character` together. Parts of the character ride on the actor's part of their name, others on the
    /// first of `parts`.
    ///
    /// # Errors
    /// Where landmarks or muscles share too few names, or lie on vertices that are not there.
    pub fn new(
        actor: &'r Rig,
        character: &'r Rig,
        parts: &[&'r Part],
        landmarks: (&Attachment, &Attachment),
        muscles: Option<(&Muscles, &Muscles)>,
        options: &TransferOptions,
    ) -> Result<Self, StrainError> {
        let (mut from, mut to) = (Vec::new(), Vec::new());
        let mut add = |own: DVec3, other: DVec3| {
            // Points nearly at one place would ask for a fold.
            if from.iter().all(|known: &DVec3| known.distance(own) > 2e-4) {
                from.push(own);
                to.push(other);
            }
        };
        let at = |vertices: [u32; 3], weights: [f32; 3], rig: &Rig| {
            let beyond = vertices.iter().find(|vertex| **vertex as usize >= rig.neutral.len());
            match beyond {
                Some(vertex) => Err(StrainError::Data(crate::data::DataError::Index {
                    what: format!("vertex of a landmark on `{}`", rig.name),
                    index: *vertex as usize,
                    count: rig.neutral.len(),
                })),
                None => Ok(RidingPoint { vertices, weights }.at(&rig.neutral)),
            }
        };
        for point in &landmarks.0.points {
            if let Some(other) = landmarks.1.points.iter().find(|other| other.name == point.name) {
                add(at(point.vertices, point.weights, actor)?, at(other.vertices, other.weights, character)?);
            }
        }
        if let Some((own, other)) = muscles {
            same("vertices of the actor's muscles", actor.neutral.len(), own.vertices())?;
            same("vertices of the character's muscles", character.neutral.len(), other.vertices())?;
            for curve in own.curves() {
                if let Some(twin) = other.curves().iter().find(|twin| twin.name == curve.name) {
                    for share in [0.0, 0.25, 0.5, 0.75, 1.0] {
                        add(along(curve, &actor.neutral, share), along(twin, &character.neutral, share));
                    }
                }
            }
        }
        let warp = Warp::new(&from, &to, options.smoothing_m)?;
        let warped: Vec<Vec3> = actor.neutral.par_iter().map(|point| warp.apply(point.as_dvec3()).as_vec3()).collect();
        let mut riding =
            vec![(RidingPoint { vertices: [0; 3], weights: [1.0, 0.0, 0.0] }, DVec3::ZERO); character.neutral.len()];
        for part in &character.parts {
            let Some(own) = parts.iter().find(|own| own.name == part.name).or_else(|| parts.first()) else { continue };
            let surface = Surface::new(&warped, [*own]);
            let range = part.vertices.start as usize..part.vertices.end as usize;
            riding[range.clone()].par_iter_mut().zip(&character.neutral[range]).for_each(|(riding, point)| {
                if let Some(nearest) = surface.nearest(point.as_dvec3()) {
                    *riding = (nearest, warp.apply(nearest.at(&actor.neutral)));
                }
            });
        }
        Ok(Self { character, actor_vertices: actor.neutral.len(), warp, riding })
    }

    /// The character's meshes for the actor's.
    ///
    /// # Errors
    /// Where they are not those of the actor.
    pub fn meshes(&self, meshes: &Meshes) -> Result<Meshes, StrainError> {
        same("vertices of the actor's meshes", self.actor_vertices, meshes.vertices())?;
        super::skinning::check_meshes(meshes)?;
        let frames: Vec<Vec<Vec3>> = (0..meshes.frames())
            .into_par_iter()
            .map(|frame| {
                let offsets = self.offsets(meshes.frame(frame));
                self.character.neutral.iter().zip(offsets).map(|(rest, by)| (rest.as_dvec3() + by).as_vec3()).collect()
            })
            .collect();
        let count = self.character.neutral.len();
        Ok(Meshes::new(meshes.frame_axis(), self.character.parts.clone(), count, frames.concat())?)
    }

    /// How far each vertex of the character goes from its rest, in metres, where the actor's vertices are at `posed`.
    pub(super) fn offsets(&self, posed: &[Vec3]) -> Vec<DVec3> {
        self.riding.iter().map(|(point, before)| self.warp.apply(point.at(posed)) - *before).collect()
    }

    /// How many vertices the actor has.
    pub(super) fn actor_vertices(&self) -> usize {
        self.actor_vertices
    }

    /// The head that is moved.
    pub(super) fn character(&self) -> &'r Rig {
        self.character
    }

    /// Where the warp takes a point beside the actor.
    pub(super) fn warped(&self, point: Vec3) -> Vec3 {
        self.warp.apply(point.as_dvec3()).as_vec3()
    }

    /// Numbers of the actor's vertices on the character's.
    pub(super) fn carried(&self, numbers: &[f32]) -> Vec<f32> {
        let at = |point: &RidingPoint| {
            let own = point.vertices.iter().zip(&point.weights);
            own.map(|(vertex, weight)| weight * numbers[*vertex as usize]).sum()
        };
        self.riding.iter().map(|(point, _)| at(point)).collect()
    }
}

/// The point at a share of a curve's length.
fn along(curve: &crate::data::MuscleCurve, neutral: &[Vec3], share: f64) -> DVec3 {
    let places: Vec<DVec3> = curve.points.iter().map(|point| point.at(neutral)).collect();
    let mut left = share * places.windows(2).map(|pair| pair[0].distance(pair[1])).sum::<f64>();
    for pair in places.windows(2) {
        let length = pair[0].distance(pair[1]);
        if left <= length && length > 0.0 {
            return pair[0].lerp(pair[1], left / length);
        }
        left -= length;
    }
    places.last().copied().unwrap_or_default()
}

/// Corrects `transferred` meshes of a character by guides: the actor's shapes, the same as transferred, and as they should be
/// on the character. Gives the meshes and the weights of the guides.
///
/// # Errors
/// Where sizes do not fit, or two guides are alike.
pub fn transfer_guides(
    meshes: &Meshes,
    transferred: &Meshes,
    actor_rest: &[Vec3],
    [actor, carried, character]: [&Meshes; 3],
    bounded: bool,
) -> Result<(Meshes, Curves), StrainError> {
    same("vertices of the actor's meshes", actor_rest.len(), meshes.vertices())?;
    same("vertices of the actor's guides", actor_rest.len(), actor.vertices())?;
    same("frames of the transferred meshes", meshes.frames(), transferred.frames())?;
    same("vertices of the transferred guides", transferred.vertices(), carried.vertices())?;
    same("vertices of the character's guides", transferred.vertices(), character.vertices())?;
    same("transferred guides", actor.frames(), carried.frames())?;
    same("guides of the character", actor.frames(), character.frames())?;
    let count = actor.frames();
    let guides = offsets(actor_rest, actor);
    let delta = |guide: usize, vertex: usize| {
        DVec3::new(guides[(3 * vertex, guide)], guides[(3 * vertex + 1, guide)], guides[(3 * vertex + 2, guide)])
    };
    let normal = product(guides.transpose(), guides.as_ref());
    let matrix: Vec<f64> = (0..count * count).map(|at| normal[(at / count, at % count)]).collect();
    let (low, high) = if bounded { (0.0, 1.0) } else { (-1e6, 1e6) };
    let unsolved = |_| StrainError::Decomposition { what: "the guide shapes (are two of them alike?)" };
    let problem = BoundedQuadratic::new(matrix, vec![low; count], vec![high; count]).map_err(unsolved)?;
    let (mut values, mut positions) = (Vec::new(), Vec::new());
    for frame in 0..meshes.frames() {
        // Summed vertex by vertex, so that a frame has the same bits whatever frames stand beside it.
        let pulled = |guide: usize| -> f64 {
            let posed = meshes.frame(frame).iter().zip(actor_rest).enumerate();
            posed.map(|(vertex, (posed, rest))| delta(guide, vertex).dot(posed.as_dvec3() - rest.as_dvec3())).sum()
        };
        let c: Vec<f64> = (0..count).map(pulled).collect();
        // A start of its own for each frame: a frame does not depend on those before it.
        let mut start = problem.cold();
        let weights = problem.solve(&c, &mut start).map_err(unsolved)?.to_vec();
        let mut own: Vec<DVec3> = transferred.frame(frame).iter().map(|point| point.as_dvec3()).collect();
        for (guide, weight) in weights.iter().enumerate() {
            for ((point, good), carried) in own.iter_mut().zip(character.frame(guide)).zip(carried.frame(guide)) {
                *point += *weight * (good.as_dvec3() - carried.as_dvec3());
            }
        }
        positions.extend(own.iter().map(|point| point.as_vec3()));
        values.extend(weights.iter().map(|weight| *weight as f32));
    }
    let names = (1..=count).map(|guide| format!("guide_{guide}")).collect();
    let axis = meshes.frame_axis();
    let meshes = Meshes::new(axis, transferred.parts().to_vec(), transferred.vertices(), positions)?;
    Ok((meshes, Curves::new(axis, names, values)?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy::Dice;
    use crate::strain::toy;

    #[test]
    fn a_warp_meets_its_points_and_keeps_affine_maps() {
        let mut dice = Dice(81);
        let from: Vec<DVec3> = (0..30).map(|_| dice.point().as_dvec3() * 0.1).collect();
        let to: Vec<DVec3> = from.iter().map(|point| *point + dice.point().as_dvec3() * 0.01).collect();
        let warp = Warp::new(&from, &to, 0.0).unwrap();
        for (from, to) in from.iter().zip(&to) {
            assert!(warp.apply(*from).abs_diff_eq(*to, 1e-10));
        }
        let map = |x: DVec3| DVec3::new(1.2 * x.x + 0.1 * x.y, 0.9 * x.y, x.z - 0.2 * x.x) + DVec3::splat(0.3);
        let affine = Warp::new(&from, &from.iter().map(|x| map(*x)).collect::<Vec<_>>(), 0.0).unwrap();
        let x = DVec3::new(0.2, -0.1, 0.05);
        assert!(affine.apply(x).abs_diff_eq(map(x), 1e-9));
        assert!(Warp::new(&from[..3], &to[..3], 0.0).is_err());
    }

    #[test]
    fn guide_weights_are_those_of_least_squares_and_keep_their_bounds() {
        let rig = toy::with_shapes(&toy::jointed_head(), 3, 0.01);
        let names = rig.channels[9..].to_vec();
        let meshes = toy::evaluated(&rig, &toy::values(&names, 8, 2.0, 4));
        let ones = (0..9).map(|at| if at % 4 == 0 { 1.0 } else { 0.0 }).collect();
        let guides = toy::evaluated(&rig, &Curves::new(wire::FrameAxis::new(3, 60.0), names, ones).unwrap());
        let wanted = toy::values(&rig.channels[9..], 8, 2.0, 4);
        let free = transfer_guides(&meshes, &meshes, &rig.neutral, [&guides, &guides, &guides], false).unwrap();
        for (a, b) in free.1.values().iter().zip(wanted.values()) {
            assert!((a - b).abs() < 1e-4, "{a} {b}");
        }
        assert_eq!(free.0.positions(), meshes.positions(), "guides that correct nothing");
        let held = transfer_guides(&meshes, &meshes, &rig.neutral, [&guides, &guides, &guides], true).unwrap();
        assert!(held.1.values().iter().all(|weight| (0.0..=1.0).contains(weight)));
        assert!(transfer_guides(&meshes, &guides, &rig.neutral, [&guides, &guides, &guides], true).is_err());
    }
}
