//! The jaw from meshes (section B.2 of Animatomy), for a whole take at once.
//!
//! ```text
//! L(Θ) = Σ_t ‖V(t) − M(θ(t), 0)‖²_W + λ Σ_t ‖θ(t−1) − 2 θ(t) + θ(t+1)‖²_ρ
//! ```
//!
//! θ are the jaw's three angles (radians) and three translations (metres, divided by the lever ρ in metres, so that both
//! weigh alike); first and last frames are repeated at the ends. Eyes are known. Gauss and Newton's steps: J(t)ᵀ J(t) of each
//! frame on the diagonal, λ `D2ᵀ D2` beside it, so the matrix is banded and a step takes time that grows with the frames; a
//! step that does not lower L is shortened by damping (Levenberg 1944, Marquardt 1963).
//!
//! Vertices weigh by W: 1 as in the paper, or less where expressions move them, 1 / (1 + `e_i²` / σ²), `e_i` the root mean square
//! of what strains did to the vertex in training. Lips and cheeks then do not pull the jaw along with a smile.

use super::banded::{Banded, acceleration, acceleration_loss};
use super::error::{StrainError, same};
use super::joints::{Poses, joints, pose_channels};
use super::skinning::check_meshes;
use crate::data::{Curves, Driver, Meshes, Rig};
use crate::rig::JawPose;
use glam::{DMat3, DVec3};
use rayon::prelude::*;

/// How the jaw is solved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JawSolveOptions {
    /// λ in square metres (a radian to the fourth power over frames).
    pub acceleration_m2: f64,
    /// ρ: the translation that weighs as much as a radian, in metres.
    pub lever_m: f64,
    /// Steps at most.
    pub steps: usize,
}

impl Default for JawSolveOptions {
    fn default() -> Self {
        Self { acceleration_m2: 0.0, lever_m: 0.1, steps: 30 }
    }
}

/// A solved jaw.
#[derive(Debug, Clone, PartialEq)]
pub struct SolvedJaw {
    /// The poses of all joints: the jaw's solved, the others as given.
    pub poses: Curves,
    /// Root mean square distance that is left over the weighed vertices, in each frame, in metres.
    pub residual_m: Vec<f64>,
    /// L from the start on, in square metres.
    pub losses_m2: Vec<f64>,
}

/// A vertex that the jaw moves.
struct Follower {
    vertex: usize,
    weight: f64,
    share: f64,
    rest: DVec3,
    /// Whether a pose shape moves it.
    shaped: bool,
    /// Pose shapes of the jaw's rotation (row after row), then of its translation.
    shapes: [DVec3; 12],
}

/// Solves the jaw of `rig` in every frame of `meshes`. `others` holds the poses of the other joints (at rest where not given),
/// `weights` W, one a vertex.
///
/// # Errors
/// Where meshes and rig do not fit, the rig has no jaw that channels turn and move, or a setting is out of range.
pub fn solve_jaw_pose(
    rig: &Rig,
    meshes: &Meshes,
    others: Option<&Curves>,
    weights: &[f64],
    options: &JawSolveOptions,
    mut go_on: impl FnMut() -> bool,
) -> Result<Option<SolvedJaw>, StrainError> {
    same("vertices of the meshes", rig.neutral.len(), meshes.vertices())?;
    same("weights of the vertices", rig.neutral.len(), weights.len())?;
    check_meshes(meshes)?;
    let frames = meshes.frames();
    if frames == 0 {
        return Err(StrainError::TooFewFrames { found: 0, needed: 1 });
    }
    for (what, value, allowed) in [
        ("the acceleration's weight", options.acceleration_m2, options.acceleration_m2 >= 0.0),
        ("the lever", options.lever_m, options.lever_m > 0.0),
    ] {
        if !(value.is_finite() && allowed) {
            return Err(StrainError::Setting { what, value, wanted: "a positive number" });
        }
    }
    let names = pose_channels(rig)?;
    let six = rig.jaw.as_ref().is_some_and(|jaw| jaw.motions.len() == 6);
    if !six {
        return Err(StrainError::NoJoints { rig: rig.name.clone() });
    }
    let given = match others {
        Some(others) => {
            same("frames of the poses", frames, others.frames())?;
            others.arrange(&names, Some(0.0))?
        }
        None => Curves::new(meshes.frame_axis(), names.clone(), vec![0.0; frames * names.len()])?,
    };
    // The eyes' part of the pose, with the jaw at rest.
    let mut still = given.values().to_vec();
    still.chunks_exact_mut(names.len()).for_each(|row| row[..6].fill(0.0));
    let still = Curves::new(meshes.frame_axis(), names.clone(), still)?;
    let problem = Problem::new(rig, meshes, &still, weights, options)?;
    let mut theta = vec![0.0; 6 * frames];
    let mut now = problem.loss(&theta);
    let (mut losses_m2, mut damping) = (vec![now], 0.0);
    for _ in 0..options.steps {
        if !go_on() {
            return Ok(None);
        }
        let (blocks, slopes) = problem.normal(&theta);
        let mut lowered = false;
        for _ in 0..12 {
            let moved = problem.step(&theta, &blocks, &slopes, damping)?;
            let own = problem.loss(&moved);
            if own <= now {
                lowered = now - own > 1e-12 * now;
                (theta, now) = (moved, own);
                damping *= 0.1;
                break;
            }
            damping = if damping == 0.0 { 1e-6 } else { damping * 10.0 };
        }
        losses_m2.push(now);
        if !lowered {
            break;
        }
    }
    let total: f64 = problem.followers.iter().map(|follower| follower.weight).sum();
    let residual_m = (0..frames).map(|t| (problem.misfit(t, &theta[6 * t..6 * t + 6]) / total).sqrt()).collect();
    let mut values = given.values().to_vec();
    for (row, own) in values.chunks_exact_mut(names.len()).zip(theta.chunks_exact(6)) {
        for place in 0..6 {
            row[place] = (own[place] * if place < 3 { 1.0 } else { options.lever_m }) as f32;
        }
    }
    Ok(Some(SolvedJaw { poses: Curves::new(meshes.frame_axis(), names, values)?, residual_m, losses_m2 }))
}

/// How little a vertex counts that strains move: 1 / (1 + e² / σ²), e by the given curves of strains; σ in metres.
///
/// # Errors
/// Where the strains are not those of the rig.
pub fn expression_weights(rig: &Rig, strains: &Curves, noise_m: f64) -> Result<Vec<f64>, StrainError> {
    let names = super::strain_channels(rig)?;
    let arranged = strains.arrange(&names, None)?;
    let mut squares = vec![0.0; rig.neutral.len()];
    let mut offsets = vec![DVec3::ZERO; rig.neutral.len()];
    let shapes: Vec<_> = rig
        .shapes
        .iter()
        .filter_map(|shape| match shape.driver {
            Driver::Channel(channel) => {
                Some((names.iter().position(|name| *name == rig.channels[channel as usize])?, shape))
            }
            _ => None,
        })
        .collect();
    // A hundred frames tell the spread well enough.
    let step = arranged.frames().div_ceil(100).max(1);
    let looked_at = (0..arranged.frames()).step_by(step);
    let count = looked_at.len().max(1) as f64;
    for frame in looked_at {
        offsets.fill(DVec3::ZERO);
        for (column, shape) in &shapes {
            let weight = f64::from(arranged.frame(frame)[*column]);
            for (vertex, delta) in shape.vertices.iter().zip(&shape.deltas) {
                offsets[*vertex as usize] += weight * delta.as_dvec3();
            }
        }
        squares.iter_mut().zip(&offsets).for_each(|(sum, offset)| *sum += offset.length_squared() / count);
    }
    Ok(squares.iter().map(|square| 1.0 / (1.0 + square / (noise_m * noise_m))).collect())
}

struct Problem<'a> {
    followers: Vec<Follower>,
    /// For each frame, what eyes add to the followers at rest.
    meshes: &'a Meshes,
    eyes: Vec<Vec<DVec3>>,
    pivot: DVec3,
    acceleration: f64,
    lever: f64,
    frames: usize,
}

impl<'a> Problem<'a> {
    fn new(
        rig: &Rig,
        meshes: &'a Meshes,
        still: &Curves,
        weights: &[f64],
        options: &JawSolveOptions,
    ) -> Result<Self, StrainError> {
        let Some(jaw) = &rig.jaw else { return Err(StrainError::NoJoints { rig: rig.name.clone() }) };
        let count = rig.neutral.len();
        let mut shapes = vec![[DVec3::ZERO; 12]; count];
        for (index, shape) in rig.shapes.iter().enumerate() {
            let place = match shape.driver {
                Driver::Turn { joint: 0, row, column } => 3 * row as usize + column as usize,
                _ => match jaw.motions.iter().position(|motion| motion.shape as usize == index) {
                    Some(motion) if motion >= 3 => 6 + motion,
                    _ => continue,
                },
            };
            for (vertex, delta) in shape.vertices.iter().zip(&shape.deltas) {
                shapes[*vertex as usize][place] = delta.as_dvec3();
            }
        }
        let eyes: Vec<&[f32]> = joints(rig)[1..].iter().map(|joint| joint.skin.weights.as_slice()).collect();
        let followers: Vec<Follower> = (0..count)
            .filter(|vertex| {
                let moves = jaw.weights[*vertex] != 0.0 || shapes[*vertex].iter().any(|shape| *shape != DVec3::ZERO);
                // Skin that rides on an eye tells the eye, not the jaw.
                moves && weights[*vertex] > 0.0 && eyes.iter().all(|eye| eye[*vertex] == 0.0)
            })
            .map(|vertex| Follower {
                vertex,
                weight: weights[vertex],
                share: jaw.weights[vertex].into(),
                rest: rig.neutral[vertex].as_dvec3(),
                shaped: shapes[vertex].iter().any(|shape| *shape != DVec3::ZERO),
                shapes: shapes[vertex],
            })
            .collect();
        if followers.is_empty() {
            return Err(StrainError::NothingRigid { joint: "jaw".to_owned() });
        }
        let pose_shapes = super::unpose::PoseShapes::new(rig, still)?;
        let eyes = (0..meshes.frames())
            .into_par_iter()
            .map(|frame| {
                let mut offsets = vec![glam::Vec3::ZERO; count];
                pose_shapes.add(rig, frame, &mut offsets);
                followers.iter().map(|follower| offsets[follower.vertex].as_dvec3()).collect()
            })
            .collect();
        // Poses are looked at once here, so that a channel that is not finite is named.
        Poses::new(rig, still)?;
        Ok(Self {
            followers,
            meshes,
            eyes,
            pivot: jaw.pivot_m.as_dvec3(),
            acceleration: options.acceleration_m2,
            lever: options.lever_m,
            frames: meshes.frames(),
        })
    }

    fn pose(&self, theta: &[f64]) -> (JawPose, DVec3) {
        let turn = DVec3::new(theta[0], theta[1], theta[2]);
        let shift = self.lever * DVec3::new(theta[3], theta[4], theta[5]);
        (JawPose::about(self.pivot, turn, shift), shift)
    }

    /// x of a follower: its rest with pose shapes.
    fn shaped(follower: &Follower, eye: DVec3, pose: &JawPose, shift: DVec3) -> DVec3 {
        let mut x = follower.rest + eye;
        if !follower.shaped {
            return x;
        }
        for row in 0..3 {
            for column in 0..3 {
                let feature = pose.rotation.col(column)[row] - f64::from(u8::from(row == column));
                x += feature * follower.shapes[3 * row + column];
            }
            x += shift[row] * follower.shapes[9 + row];
        }
        x
    }

    /// How x changes with θ, by the number of the entry.
    fn shape_slope(follower: &Follower, pose: &JawPose, place: usize, lever: f64) -> DVec3 {
        if place >= 3 {
            return lever * follower.shapes[6 + place];
        }
        let turn = pose.turns[place];
        (0..9).map(|entry| turn.col(entry % 3)[entry / 3] * follower.shapes[entry]).sum()
    }

    fn misfit(&self, frame: usize, theta: &[f64]) -> f64 {
        let (pose, shift) = self.pose(theta);
        let posed = self.meshes.frame(frame);
        let of = |(follower, eye): (&Follower, &DVec3)| {
            let x = Self::shaped(follower, *eye, &pose, shift);
            let found = x + follower.share * (pose.rotation * x + pose.translation_m - x);
            follower.weight * posed[follower.vertex].as_dvec3().distance_squared(found)
        };
        self.followers.iter().zip(&self.eyes[frame]).map(of).sum()
    }

    fn loss(&self, theta: &[f64]) -> f64 {
        let data: Vec<f64> =
            (0..self.frames).into_par_iter().map(|t| self.misfit(t, &theta[6 * t..6 * t + 6])).collect();
        data.iter().sum::<f64>() + self.acceleration * acceleration_loss(theta, 6)
    }

    /// `JᵀJ` and Jᵀr of every frame, r = V − M.
    fn normal(&self, theta: &[f64]) -> (Vec<[[f64; 6]; 6]>, Vec<[f64; 6]>) {
        (0..self.frames).into_par_iter().map(|t| self.normal_of(t, &theta[6 * t..6 * t + 6])).unzip()
    }

    fn normal_of(&self, frame: usize, theta: &[f64]) -> ([[f64; 6]; 6], [f64; 6]) {
        let (pose, shift) = self.pose(theta);
        let posed = self.meshes.frame(frame);
        let (mut block, mut slope) = ([[0.0; 6]; 6], [0.0; 6]);
        for (follower, eye) in self.followers.iter().zip(&self.eyes[frame]) {
            let x = Self::shaped(follower, *eye, &pose, shift);
            let found = x + follower.share * (pose.rotation * x + pose.translation_m - x);
            let residual = posed[follower.vertex].as_dvec3() - found;
            let matrix = DMat3::IDENTITY + follower.share * (pose.rotation - DMat3::IDENTITY);
            let arm = x - self.pivot;
            let mut columns: [DVec3; 6] = std::array::from_fn(|place| match place {
                0..3 => follower.share * (pose.turns[place] * arm),
                _ => self.lever * follower.share * DVec3::AXES[place - 3],
            });
            if follower.shaped {
                for (place, column) in columns.iter_mut().enumerate() {
                    *column += matrix * Self::shape_slope(follower, &pose, place, self.lever);
                }
            }
            for i in 0..6 {
                slope[i] += follower.weight * columns[i].dot(residual);
                for j in 0..=i {
                    block[i][j] += follower.weight * columns[i].dot(columns[j]);
                }
            }
        }
        (block, slope)
    }

    /// θ after one damped step.
    fn step(
        &self,
        theta: &[f64],
        blocks: &[[[f64; 6]; 6]],
        slopes: &[[f64; 6]],
        damping: f64,
    ) -> Result<Vec<f64>, StrainError> {
        let mut system = Banded::zeros(6 * self.frames, 17);
        let mut right: Vec<f64> = slopes.iter().flatten().copied().collect();
        let largest = blocks.iter().flat_map(|block| (0..6).map(|i| block[i][i])).fold(f64::MIN_POSITIVE, f64::max);
        for (t, block) in blocks.iter().enumerate() {
            for (i, row) in block.iter().enumerate() {
                for (j, entry) in row[..i].iter().enumerate() {
                    system.add(6 * t + i, 6 * t + j, *entry);
                }
                system.add(6 * t + i, 6 * t + i, row[i] * (1.0 + damping) + 1e-12 * largest);
            }
        }
        acceleration(self.frames, |a, b, factor| {
            for i in 0..6 {
                system.add(6 * a + i, 6 * b + i, self.acceleration * factor);
                right[6 * a + i] -= self.acceleration * factor * theta[6 * b + i];
                if a != b {
                    right[6 * b + i] -= self.acceleration * factor * theta[6 * a + i];
                }
            }
        });
        system.factored()?.solve(&mut right);
        Ok(theta.iter().zip(right).map(|(theta, step)| theta + step).collect())
    }
}

#[cfg(test)]
#[path = "solve_jaw_tests.rs"]
mod tests;
