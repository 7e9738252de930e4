//! Tests of [`JawMisfit`]: beside the rig evaluated at any pose, and derivatives by finite differences.

use super::*;
use crate::data::Curves;
use crate::strain::toy;

struct Case {
    rig: Rig,
    poses: Curves,
    meshes: Meshes,
    weights: Vec<f64>,
}

impl Case {
    fn new() -> Self {
        let (rig, poses, meshes) = toy::bent_head();
        let mut dice = crate::rig::toy::Dice(92);
        let shaken = meshes.positions().iter().map(|point| *point + dice.point() * 1e-3).collect();
        let meshes = Meshes::new(poses.frame_axis(), rig.parts.clone(), 96, shaken).unwrap();
        Self { rig, poses, meshes, weights: (0..96).map(|at| 0.5 + 0.01 * f64::from(at)).collect() }
    }

    /// The poses with the jaw's six entries of every frame in place of their own.
    fn with_jaw(&self, theta: &[f64], lever: f64) -> Curves {
        let mut values = self.poses.values().to_vec();
        for (row, own) in values.chunks_exact_mut(9).zip(theta.chunks_exact(ENTRIES)) {
            for entry in 0..ENTRIES {
                row[entry] = (own[entry] * if entry < 3 { 1.0 } else { lever }) as f32;
            }
        }
        Curves::new(self.poses.frame_axis(), self.poses.channels().to_vec(), values).unwrap()
    }

    fn misfit(&self, lever: f64) -> JawMisfit {
        let still = self.with_jaw(&[0.0; ENTRIES * 14], lever);
        JawMisfit::new(&self.rig, &self.meshes, &still, &self.weights, lever).unwrap()
    }
}

fn theta() -> Vec<f64> {
    let mut dice = crate::rig::toy::Dice(93);
    (0..ENTRIES * 14).map(|_| f64::from(0.1 * dice.roll())).collect()
}

#[test]
fn it_is_how_far_the_evaluated_rig_is_off() {
    let case = Case::new();
    let (lever, theta) = (0.1, theta());
    let found = case.misfit(lever).squares(&theta);
    let evaluated = toy::evaluated(&case.rig, &case.with_jaw(&theta, lever));
    let jaw = &case.rig.jaw.as_ref().unwrap().weights;
    let turned = |vertex: usize| {
        case.rig.shapes.iter().any(|shape| {
            matches!(shape.driver, Driver::Turn { joint: 0, .. }) && shape.vertices.contains(&(vertex as u32))
        })
    };
    let rides = |vertex: usize| joints(&case.rig)[1..].iter().any(|joint| joint.skin.weights[vertex] != 0.0);
    let follows: Vec<usize> =
        (0..96).filter(|vertex| (jaw[*vertex] != 0.0 || turned(*vertex)) && !rides(*vertex)).collect();
    for (frame, square) in found.iter().enumerate() {
        let off = |vertex: &usize| {
            let (a, b) = (case.meshes.frame(frame)[*vertex].as_dvec3(), evaluated.frame(frame)[*vertex].as_dvec3());
            case.weights[*vertex] * a.distance_squared(b)
        };
        let expected: f64 = follows.iter().map(off).sum();
        assert!((square - expected).abs() < 1e-5 * expected, "frame {frame}: {square} {expected}");
    }
}

#[test]
fn blocks_and_slopes_equal_finite_differences() {
    let case = Case::new();
    let misfit = case.misfit(0.1);
    let theta = theta();
    let normals = misfit.normal(&theta);
    for frame in [0, 3, 13] {
        let (block, slope) = &normals[frame];
        for entry in 0..ENTRIES {
            let moved = |by: f64| {
                let mut moved = theta.clone();
                moved[ENTRIES * frame + entry] += by;
                misfit.squares(&moved)[frame]
            };
            let difference = (moved(1e-5) - moved(-1e-5)) / 2e-5;
            let off = (difference + 2.0 * slope[entry]).abs();
            assert!(off < 1e-6 * slope[entry].abs().max(1e-3), "{entry}: {difference} {}", slope[entry]);
            assert!(
                (0..ENTRIES)
                    .all(|other| (block[entry][other] - block[other][entry]).abs() < 1e-9 * block[entry][entry])
            );
        }
        // JᵀJ, by the residuals of the evaluated rig.
        let lever = 0.1;
        let evaluated = |entry: usize, by: f64| {
            let mut moved = theta.clone();
            moved[ENTRIES * frame + entry] += by;
            toy::evaluated(&case.rig, &case.with_jaw(&moved, lever))
        };
        let slopes: Vec<Vec<DVec3>> = (0..ENTRIES)
            .map(|entry| {
                let (more, less) = (evaluated(entry, 0.02), evaluated(entry, -0.02));
                let own = |(a, b): (&glam::Vec3, &glam::Vec3)| (a.as_dvec3() - b.as_dvec3()) / 0.04;
                more.frame(frame).iter().zip(less.frame(frame)).map(own).collect()
            })
            .collect();
        let rides = |vertex: usize| joints(&case.rig)[1..].iter().any(|joint| joint.skin.weights[vertex] != 0.0);
        for i in 0..ENTRIES {
            let dot = |vertex: usize| case.weights[vertex] * slopes[i][vertex].length_squared();
            let expected: f64 = (0..96).filter(|vertex| !rides(*vertex)).map(dot).sum();
            assert!((block[i][i] - expected).abs() < 1e-2 * expected, "{i}: {} {expected}", block[i][i]);
        }
    }
}
