//! Tests of [`solve_jaw_pose`]: known jaws.

use super::*;
use crate::strain::toy::bent_head as case;

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
