//! Tests of [`solve_strains`](super::solve_strains()): known strains, and slopes of the loss as the rig itself gives it.

use super::banded::acceleration_loss;
use super::{Manifold, StrainSolveOptions, solve_strains};
use crate::data::{Curves, Meshes, Rig};
use crate::strain::toy;
use glam::Vec3;

const OPTIONS: StrainSolveOptions =
    StrainSolveOptions { acceleration_m2: 0.0, manifold_m2: 0.0, ridge_m2: 0.0, steps: 30 };

fn case() -> (Rig, Curves, Curves, Meshes) {
    let rig = toy::with_shapes(&toy::jointed_head(), 5, 0.01);
    let (poses, strains) = (toy::pose_curves(&rig, 12), toy::values(&rig.channels[9..], 12, 0.5, 6));
    let meshes = toy::evaluated(&rig, &toy::beside(&poses, &strains));
    (rig, poses, strains, meshes)
}

/// L by the rig itself, with no algebra.
fn loss(rig: &Rig, poses: &Curves, meshes: &Meshes, strains: &Curves, options: &StrainSolveOptions) -> f64 {
    let own = toy::evaluated(rig, &toy::beside(poses, strains));
    let data: f64 =
        own.positions().iter().zip(meshes.positions()).map(|(a, b)| a.as_dvec3().distance_squared(b.as_dvec3())).sum();
    let values: Vec<f64> = strains.values().iter().map(|value| f64::from(*value)).collect();
    data + options.acceleration_m2 * acceleration_loss(&values, strains.channels().len())
        + options.ridge_m2 * values.iter().map(|value| value * value).sum::<f64>()
}

#[test]
fn strains_that_drove_meshes_are_found_again() {
    let (rig, poses, strains, meshes) = case();
    let solved = solve_strains(&rig, &meshes, &poses, &OPTIONS, None, || true).unwrap().unwrap();
    assert_eq!(solved.strains.channels(), strains.channels());
    for (a, b) in solved.strains.values().iter().zip(strains.values()) {
        assert!((a - b).abs() < 1e-5, "{a} {b}");
    }
    assert!(solved.residual_m.iter().all(|residual| *residual < 1e-7));
    assert!(solve_strains(&rig, &meshes, &poses, &OPTIONS, None, || false).unwrap().is_none());
}

/// By finite differences of the loss as the rig itself gives it: its slope is nought at the answer.
#[test]
fn the_slope_of_the_whole_loss_is_nought() {
    let (rig, poses, strains, meshes) = case();
    let noisy =
        meshes.positions().iter().enumerate().map(|(at, point)| *point + Vec3::splat(((at * 7) % 11) as f32 * 1e-4));
    let meshes = Meshes::new(meshes.frame_axis(), meshes.parts().to_vec(), 96, noisy.collect()).unwrap();
    let options = StrainSolveOptions { acceleration_m2: 1e-3, ridge_m2: 1e-5, ..OPTIONS };
    let solved = solve_strains(&rig, &meshes, &poses, &options, None, || true).unwrap().unwrap().strains;
    let scale = loss(&rig, &poses, &meshes, &strains, &options);
    for at in 0..solved.values().len() {
        let moved = |by: f32| {
            let mut values = solved.values().to_vec();
            values[at] += by;
            let moved = Curves::new(solved.frame_axis(), solved.channels().to_vec(), values).unwrap();
            loss(&rig, &poses, &meshes, &moved, &options)
        };
        let (up, down) = (moved(0.02), moved(-0.02));
        let curve = up + down - 2.0 * moved(0.0);
        assert!((up - down).abs() < 2e-3 * curve.abs() + 1e-9 * scale, "{at}: {up} {down}");
    }
}

/// A manifold that wants every strain to be a tenth of a sine of itself.
struct Sines;

impl Manifold for Sines {
    fn residual(&self, strains: &[f64], _: &[f64]) -> Vec<f64> {
        strains.iter().map(|strain| 0.1 * (3.0 * strain).sin() - strain).collect()
    }

    fn pull_back(&self, strains: &[f64], _: &[f64], by: &[f64]) -> Vec<f64> {
        strains.iter().zip(by).map(|(strain, by)| by * (0.3 * (3.0 * strain).cos() - 1.0)).collect()
    }
}

#[test]
fn with_a_manifold_the_loss_falls_to_where_its_slope_is_nought() {
    let (rig, poses, _, meshes) = case();
    let options = StrainSolveOptions { manifold_m2: 2e-3, acceleration_m2: 1e-4, steps: 200, ..OPTIONS };
    let solved = solve_strains(&rig, &meshes, &poses, &options, Some(&Sines), || true).unwrap().unwrap();
    assert!(solved.losses_m2.windows(2).all(|pair| pair[1] < pair[0]) && solved.losses_m2.len() > 2);
    let free = solve_strains(&rig, &meshes, &poses, &OPTIONS, None, || true).unwrap().unwrap();
    let size = |curves: &Curves| curves.values().iter().map(|value| value.abs()).sum::<f32>();
    assert!(size(&solved.strains) < 0.95 * size(&free.strains));
    let off = StrainSolveOptions { manifold_m2: f64::NAN, ..options };
    assert!(solve_strains(&rig, &meshes, &poses, &off, Some(&Sines), || true).is_err());
}
