//! Who follows which joint: linear blend skinning weights from animated meshes (section A.1 of Animatomy).
//!
//! Per vertex with rest position x, joints k with poses x ↦ `R_k` x + `T_k` in frame t (metres), weights w in the box
//! 0 ≤ w ≤ 1 and their start w⁰:
//!
//! ```text
//! L(w) = Σ_t ‖V(t) − x − Σ_k w_k a_k(t)‖² + λ T ‖w⁰ − w‖²,     a_k(t) = (R_k(t) − I) x + T_k(t) = A_k(t) p,   p = (x, 1)
//! ```
//!
//! which is the loss of A.1: it falls apart into vertices, and each is a bounded least-squares problem of K unknowns with
//!
//! ```text
//! H_kl = pᵀ [Σ_t A_k(t)ᵀ A_l(t)] p + λ T δ_kl,     c_k = pᵀ [Σ_t A_k(t)ᵀ (V(t) − x)] + λ T w⁰_k
//! ```
//!
//! The 4 × 4 matrices in the brackets of H are the same for all vertices, so only c looks at every frame: 12 K products a
//! vertex and frame. Each problem is then solved exactly by its active set ([`BoundedQuadratic`]). λ is in square metres:
//! how far a vertex may be off, for a weight that differs by 1 from its start.

use super::error::{StrainError, same};
use super::joints::{Poses, joints};
use crate::data::{Curves, Meshes, Rig};
use crate::solve::BoundedQuadratic;
use glam::Vec3;
use rayon::prelude::*;

/// A matrix of 3 × 4: rows of R − I with T behind.
type Offset = [[f64; 4]; 3];

/// Vertices that are fitted together.
const PIECE: usize = 128;

/// A rig with fitted weights, and how well they fit.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedSkinning {
    /// The rig with the fitted weights in its jaw and joints.
    pub rig: Rig,
    /// Σ over frames and vertices of the squared distance before and after, in square metres.
    pub squares_m2: [f64; 2],
}

/// Fits the weights of all joints of `rig` to `meshes`, whose joints stand at `poses`. Its present weights are the start.
///
/// # Errors
/// Where the meshes are not those of the rig, poses and meshes differ in frames, or something is not finite.
pub fn fit_skinning(rig: &Rig, meshes: &Meshes, poses: &Curves, prior_m2: f64) -> Result<FittedSkinning, StrainError> {
    same("vertices of the meshes", rig.neutral.len(), meshes.vertices())?;
    same("frames of the poses", meshes.frames(), poses.frames())?;
    if !(prior_m2.is_finite() && prior_m2 > 0.0) {
        return Err(StrainError::Setting {
            what: "the weight of the start",
            value: prior_m2,
            wanted: "a positive number",
        });
    }
    check_meshes(meshes)?;
    let frames = meshes.frames();
    if frames == 0 {
        return Err(StrainError::TooFewFrames { found: 0, needed: 1 });
    }
    let poses = Poses::new(rig, poses)?;
    let count = joints(rig).len();
    let offsets: Vec<Offset> = (0..frames).flat_map(|frame| poses.frame(frame)).map(offset).collect();
    let grams = grams(&offsets, count);
    let prior = prior_m2 * frames as f64;
    let starts: Vec<&[f32]> = joints(rig).iter().map(|joint| joint.skin.weights.as_slice()).collect();
    let pieces: Vec<usize> = (0..rig.neutral.len()).step_by(PIECE).collect();
    let fitted: Vec<Vec<(Vec<f32>, [f64; 2])>> = pieces
        .into_par_iter()
        .map(|first| {
            let rest = &rig.neutral[first..(first + PIECE).min(rig.neutral.len())];
            let sums = Sums::over(meshes, first, rest, &offsets, count);
            let one = |(at, x): (usize, &Vec3)| {
                let start: Vec<f64> = starts.iter().map(|weights| f64::from(weights[first + at])).collect();
                fit_vertex(*x, &grams, &sums.right(at, *x), sums.squares[at], &start, prior)
            };
            rest.iter().enumerate().map(one).collect::<Result<Vec<_>, _>>()
        })
        .collect::<Result<_, StrainError>>()?;
    let mut out = rig.clone();
    let mut squares_m2 = [0.0; 2];
    let skins = out.jaw.iter_mut().chain(out.joints.iter_mut().map(|joint| &mut joint.skin));
    for (place, skin) in skins.enumerate() {
        skin.weights = fitted.iter().flatten().map(|(weights, _)| weights[place]).collect();
    }
    for (_, squares) in fitted.iter().flatten() {
        squares_m2[0] += squares[0];
        squares_m2[1] += squares[1];
    }
    Ok(FittedSkinning { rig: out, squares_m2 })
}

/// Refuses meshes with a vertex that is not finite.
pub(super) fn check_meshes(meshes: &Meshes) -> Result<(), StrainError> {
    let count = meshes.vertices().max(1);
    match meshes.positions().iter().position(|point| !point.is_finite()) {
        None => Ok(()),
        Some(at) => {
            let frame = meshes.frame_axis().slice(&(at / count..at / count + 1)).first;
            Err(StrainError::NotFinite { what: "vertex", index: at % count, frame })
        }
    }
}

fn offset(pose: &crate::rig::JawPose) -> Offset {
    std::array::from_fn(|row| {
        std::array::from_fn(|column| match column {
            3 => pose.translation_m[row],
            _ => pose.rotation.col(column)[row] - f64::from(u8::from(row == column)),
        })
    })
}

/// Σ over frames of `A_kᵀ A_l`, for all pairs of joints, row after row.
fn grams(offsets: &[Offset], joints: usize) -> Vec<[[f64; 4]; 4]> {
    let mut grams = vec![[[0.0; 4]; 4]; joints * joints];
    for frame in offsets.chunks_exact(joints) {
        for k in 0..joints {
            for l in 0..joints {
                for (i, row) in grams[k * joints + l].iter_mut().enumerate() {
                    for (j, entry) in row.iter_mut().enumerate() {
                        *entry += (0..3).map(|axis| frame[k][axis][i] * frame[l][axis][j]).sum::<f64>();
                    }
                }
            }
        }
    }
    grams
}

/// Σ over frames of `A_kᵀ (V − x)` for a run of vertices, entry by entry, and of ‖V − x‖².
struct Sums {
    entries: Vec<[f64; PIECE]>,
    squares: [f64; PIECE],
}

impl Sums {
    fn over(meshes: &Meshes, first: usize, rest: &[Vec3], offsets: &[Offset], joints: usize) -> Self {
        let mut sums = Self { entries: vec![[0.0; PIECE]; 4 * joints], squares: [0.0; PIECE] };
        let mut moved = [[0.0; PIECE]; 3];
        for (frame, offsets) in offsets.chunks_exact(joints).enumerate() {
            let posed = &meshes.frame(frame)[first..first + rest.len()];
            for (at, (posed, rest)) in posed.iter().zip(rest).enumerate() {
                let offset = posed.as_dvec3() - rest.as_dvec3();
                (moved[0][at], moved[1][at], moved[2][at]) = (offset.x, offset.y, offset.z);
            }
            let [x, y, z] = &moved;
            for (at, square) in sums.squares.iter_mut().enumerate() {
                *square += x[at] * x[at] + y[at] * y[at] + z[at] * z[at];
            }
            for (joint, offset) in offsets.iter().enumerate() {
                let rows = offset[0].iter().zip(&offset[1]).zip(&offset[2]);
                let sums = &mut sums.entries[joint * 4..joint * 4 + 4];
                for (((a, b), c), sum) in rows.zip(sums) {
                    for at in 0..PIECE {
                        sum[at] += a * x[at] + b * y[at] + c * z[at];
                    }
                }
            }
        }
        sums
    }

    /// For the vertex `at` of the run, at rest at x: Σ `a_k · (V − x)`, joint by joint.
    fn right(&self, at: usize, x: Vec3) -> Vec<f64> {
        let p = homogeneous(x);
        self.entries.chunks_exact(4).map(|own| (0..4).map(|i| own[i][at] * p[i]).sum()).collect()
    }
}

fn homogeneous(x: Vec3) -> [f64; 4] {
    [x.x.into(), x.y.into(), x.z.into(), 1.0]
}

fn fit_vertex(
    x: Vec3,
    grams: &[[[f64; 4]; 4]],
    right: &[f64],
    squares: f64,
    start: &[f64],
    prior: f64,
) -> Result<(Vec<f32>, [f64; 2]), StrainError> {
    let (count, p) = (start.len(), homogeneous(x));
    let mut matrix: Vec<f64> =
        grams.iter().map(|gram| (0..4).map(|i| p[i] * (0..4).map(|j| gram[i][j] * p[j]).sum::<f64>()).sum()).collect();
    // Σ ‖V − x − Σ w a‖² = Σ ‖V − x‖² − 2 w·r + wᵀ G w.
    let misfit = |weights: &[f64], matrix: &[f64]| {
        let rows = matrix.chunks_exact(count).zip(weights);
        let quadratic: f64 = rows.map(|(row, w)| w * row.iter().zip(weights).map(|(a, b)| a * b).sum::<f64>()).sum();
        (squares - 2.0 * weights.iter().zip(right).map(|(w, r)| w * r).sum::<f64>() + quadratic).max(0.0)
    };
    let before = misfit(start, &matrix);
    let plain = matrix.clone();
    for k in 0..count {
        matrix[k * count + k] += prior;
    }
    let c: Vec<f64> = right.iter().zip(start).map(|(r, w)| r + prior * w).collect();
    let unsolved = |_| StrainError::Decomposition { what: "the skinning of a vertex" };
    let problem = BoundedQuadratic::new(matrix, vec![0.0; count], vec![1.0; count]).map_err(unsolved)?;
    let mut warm = problem.cold();
    let weights = problem.solve(&c, &mut warm).map_err(unsolved)?;
    let after = misfit(weights, &plain);
    Ok((weights.iter().map(|weight| *weight as f32).collect(), [before, after]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strain::toy;

    #[test]
    fn known_weights_are_found_again() {
        let rig = toy::jointed_head();
        let curves = toy::pose_curves(&rig, 30);
        let meshes = toy::evaluated(&rig, &curves);
        let mut blind = rig.clone();
        blind.jaw.as_mut().unwrap().weights[..64].fill(0.0);
        blind.joints[0].skin.weights[..64].fill(0.0);
        let fitted = fit_skinning(&blind, &meshes, &curves, 1e-12).unwrap();
        for (found, known) in fitted.rig.all_joints().zip(rig.all_joints()) {
            for (found, known) in found.weights.iter().zip(&known.weights) {
                assert!((found - known).abs() < 1e-4, "{found} {known}");
            }
        }
        assert!(fitted.squares_m2[1] < 1e-8 * fitted.squares_m2[0], "{:?}", fitted.squares_m2);
    }

    /// The conditions of Karush, Kuhn and Tucker at the answer, on meshes that no weights explain.
    #[test]
    fn the_slope_is_nought_inside_the_box_and_points_outwards_at_its_sides() {
        let rig = toy::with_shapes(&toy::jointed_head(), 4, 0.05);
        let poses = toy::pose_curves(&rig, 25);
        let names: Vec<String> = rig.channels[9..].to_vec();
        let meshes = toy::evaluated(&rig, &toy::beside(&poses, &toy::values(&names, 25, 1.0, 3)));
        let prior = 1e-5;
        let fitted = fit_skinning(&rig, &meshes, &poses, prior).unwrap().rig;
        let at = Poses::new(&rig, &poses).unwrap();
        let loss = |vertex: usize, weights: [f64; 2], start: [f64; 2]| {
            let x = rig.neutral[vertex].as_dvec3();
            let mut sum = 0.0;
            for frame in 0..25 {
                let mut posed = x;
                for (pose, weight) in at.frame(frame).iter().zip(weights) {
                    posed += weight * (pose.rotation * x + pose.translation_m - x);
                }
                sum += meshes.frame(frame)[vertex].as_dvec3().distance_squared(posed);
            }
            sum + prior * 25.0 * (0..2).map(|k| (weights[k] - start[k]).powi(2)).sum::<f64>()
        };
        let of = |rig: &Rig, vertex: usize| {
            let weights: Vec<f64> = rig.all_joints().map(|joint| f64::from(joint.weights[vertex])).collect();
            [weights[0], weights[1]]
        };
        let (mut inside, mut low) = (0, 0);
        for vertex in 0..96 {
            let (weights, start) = (of(&fitted, vertex), of(&rig, vertex));
            for k in 0..2 {
                let step = |by: f64| {
                    let mut moved = weights;
                    moved[k] += by;
                    loss(vertex, moved, start)
                };
                let slope = (step(1e-4) - step(-1e-4)) / 2e-4;
                let scale = loss(vertex, weights, start).max(1e-6);
                if weights[k] <= 0.0 {
                    low += 1;
                    assert!(slope > -1e-3 * scale, "vertex {vertex}: {slope}");
                } else if weights[k] >= 1.0 {
                    assert!(slope < 1e-3 * scale, "vertex {vertex}: {slope}");
                } else {
                    inside += 1;
                    assert!(slope.abs() < 1e-3 * scale, "vertex {vertex}: {slope} of {scale}");
                }
            }
        }
        assert!(inside > 20 && low > 20, "{inside} {low}");
    }

    #[test]
    fn what_does_not_fit_is_named() {
        let rig = toy::jointed_head();
        let curves = toy::pose_curves(&rig, 4);
        let meshes = toy::evaluated(&rig, &curves);
        let fewer = toy::pose_curves(&rig, 3);
        assert!(fit_skinning(&rig, &meshes, &fewer, 1e-6).unwrap_err().to_string().contains("frames of the poses"));
        let mut positions = meshes.positions().to_vec();
        positions[96 + 5].y = f32::NAN;
        let broken = Meshes::new(meshes.frame_axis(), rig.parts.clone(), 96, positions).unwrap();
        let error = fit_skinning(&rig, &broken, &curves, 1e-6).unwrap_err();
        assert_eq!(error, StrainError::NotFinite { what: "vertex", index: 5, frame: 101 });
        assert!(fit_skinning(&rig, &meshes, &curves, 0.0).is_err());
    }
}
