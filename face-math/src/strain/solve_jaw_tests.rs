//! Tests of [`solve_jaw_pose`]: known jaws, and derivatives by finite differences.

use super::*;
use crate::strain::{Keep, fit_pose_shapes, toy, unpose_meshes};

fn case() -> (Rig, Curves, Meshes) {
    let base = toy::jointed_head();
    let poses = toy::pose_curves(&base, 14);
    let mut dice = crate::rig::toy::Dice(91);
    let bent = toy::evaluated(&base, &poses);
    let bent = bent.positions().iter().map(|point| *point + dice.point() * 1e-3).collect();
    let bent = Meshes::new(poses.frame_axis(), base.parts.clone(), 96, bent).unwrap();
    let unposed = unpose_meshes(&base, &bent, &poses, Keep::PoseShapes).unwrap();
    let rig = fit_pose_shapes(&base, &unposed, &poses, 0.0).unwrap();
    let meshes = toy::evaluated(&rig, &poses);
    (rig, poses, meshes)
}

#[test]
fn jaws_that_moved_meshes_are_found_again() {
    let (rig, poses, meshes) = case();
    let weights = vec![1.0; 96];
    let solved = solve_jaw_pose(&rig, &meshes, Some(&poses), &weights, &JawSolveOptions::default(), || true);
    let solved = solved.unwrap().unwrap();
    assert!(solved.losses_m2.windows(2).all(|pair| pair[1] <= pair[0]), "{:?}", solved.losses_m2);
    for (a, b) in solved.poses.values().iter().zip(poses.values()) {
        assert!((a - b).abs() < 1e-4, "{a} {b}");
    }
    assert!(solved.residual_m.iter().all(|residual| *residual < 1e-6));
    assert!(solve_jaw_pose(&rig, &meshes, None, &weights, &JawSolveOptions::default(), || false).unwrap().is_none());
}

#[test]
fn blocks_and_slopes_equal_finite_differences() {
    let (rig, poses, meshes) = case();
    let weights: Vec<f64> = (0..96).map(|at| 0.5 + 0.01 * f64::from(at)).collect();
    let mut still = poses.values().to_vec();
    still.chunks_exact_mut(9).for_each(|row| row[..6].fill(0.0));
    let still = Curves::new(poses.frame_axis(), poses.channels().to_vec(), still).unwrap();
    let problem = Problem::new(&rig, &meshes, &still, &weights, &JawSolveOptions::default()).unwrap();
    let theta = [0.1, -0.05, 0.07, 0.02, -0.03, 0.01];
    let (_, slope) = problem.normal_of(3, &theta);
    for place in 0..6 {
        let moved = |by: f64| {
            let mut moved = theta;
            moved[place] += by;
            problem.misfit(3, &moved)
        };
        let difference = (moved(1e-5) - moved(-1e-5)) / 2e-5;
        assert!(
            (difference + 2.0 * slope[place]).abs() < 1e-6 * slope[place].abs().max(1e-3),
            "{place}: {difference} {}",
            slope[place]
        );
    }
}

#[test]
fn acceleration_calms_the_jaw() {
    let (rig, poses, meshes) = case();
    let weights = vec![1.0; 96];
    let wild = |acceleration_m2: f64| {
        let options = JawSolveOptions { acceleration_m2, ..JawSolveOptions::default() };
        let solved = solve_jaw_pose(&rig, &meshes, Some(&poses), &weights, &options, || true).unwrap().unwrap();
        let angles: Vec<f64> = (0..14).map(|t| f64::from(solved.poses.frame(t)[0])).collect();
        acceleration_loss(&angles, 1)
    };
    assert!(wild(1.0) < 0.1 * wild(0.0));
}
