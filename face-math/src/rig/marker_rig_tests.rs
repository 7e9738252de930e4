//! Tests of [`MarkerRig`]: markers beside the puppet, derivatives by finite differences.

use super::*;
use crate::data::SurfacePoint;
use crate::rig::{Puppet, toy};
use wire::FrameAxis;

fn attachment(rig: &Rig) -> Attachment {
    let mut dice = toy::Dice(3);
    let points = rig.parts[0].triangles.iter().step_by(3).enumerate().map(|(index, triangle)| {
        let (a, b) = (0.25 + 0.2 * dice.roll(), 0.3 + 0.2 * dice.roll());
        SurfacePoint { name: format!("m{index}"), vertices: *triangle, weights: [a, b, 1.0 - a - b], distance_m: 0.0 }
    });
    Attachment { points: points.collect() }
}

#[test]
fn markers_follow_the_puppet() {
    for rig in [toy::rig(6, 5), toy::jawed(6, 5), toy::jointed(6, 5)] {
        let attachment = attachment(&rig);
        let markers = MarkerRig::attached(&rig, &attachment).unwrap();
        let weights = [0.4_f32, 0.9, 0.2, 1.0, 0.65];
        let vertices = Puppet::new(&rig).unwrap().vertices(&weights).unwrap();
        let mut pose = MarkerPose::default();
        markers.pose(&weights.map(f64::from), &mut pose);
        for (point, position) in attachment.points.iter().zip(pose.positions()) {
            let expected: DVec3 = point
                .vertices
                .iter()
                .zip(point.weights)
                .map(|(vertex, weight)| f64::from(weight) * vertices[*vertex as usize].as_dvec3())
                .sum();
            assert!(position.abs_diff_eq(expected, 1e-8), "{}", point.name);
        }
    }
}

#[test]
fn the_jacobian_equals_finite_differences_and_its_transpose_the_pull_back() {
    for rig in [toy::rig(6, 5), toy::jawed(6, 5), toy::jointed(6, 5)] {
        let markers = MarkerRig::attached(&rig, &attachment(&rig)).unwrap();
        let count = markers.names().len();
        let weights = [0.4, 0.9, 0.2, 0.85, 0.55];
        let (mut pose, mut moved) = (MarkerPose::default(), MarkerPose::default());
        let mut jacobian = Vec::new();
        markers.pose(&weights, &mut pose);
        markers.jacobian(&pose, &mut jacobian);
        let mut dice = toy::Dice(5);
        let forces: Vec<_> = (0..count).map(|_| dice.point().as_dvec3()).collect();
        let mut gradient = vec![0.0; 5];
        markers.pull_back(&mut pose, &forces, &mut gradient);
        let step = 1e-6;
        for channel in 0..5 {
            let mut shifted = weights;
            shifted[channel] += step;
            markers.pose(&shifted, &mut moved);
            let up = moved.positions().to_vec();
            shifted[channel] -= 2.0 * step;
            markers.pose(&shifted, &mut moved);
            let mut pulled = 0.0;
            for marker in 0..count {
                let slope = (up[marker] - moved.positions()[marker]) / (2.0 * step);
                let exact = jacobian[channel * count + marker];
                assert!(slope.abs_diff_eq(exact, 1e-9), "channel {channel}, marker {marker}: {slope} {exact}");
                pulled += forces[marker].dot(exact);
            }
            assert!((pulled - gradient[channel]).abs() < 1e-12, "channel {channel}");
        }
    }
}

#[test]
fn curves_that_lack_a_channel_or_hold_nan_are_refused() {
    let rig = toy::rig(4, 3);
    let markers = MarkerRig::of_vertices(&rig, &[0, 5]).unwrap();
    let axis = FrameAxis { first: 10, count: 2, rate_hz: 60.0 };
    let short = Curves::new(axis, vec!["c0".into(), "c1".into()], vec![0.0; 4]).unwrap();
    assert!(matches!(markers.drive(&short), Err(RigError::Data(DataError::Missing { name, .. })) if name == "c2"));
    let names = vec!["c0".into(), "c1".into(), "c2".into()];
    let broken = Curves::new(axis, names, vec![0.0, 0.0, 0.0, 0.0, f32::NAN, 0.0]).unwrap();
    assert!(matches!(markers.drive(&broken), Err(RigError::Weight { frame: 11, channel, .. }) if channel == "c1"));
}

#[test]
fn a_vertex_of_another_rig_is_refused() {
    let error = MarkerRig::of_vertices(&toy::rig(4, 3), &[16]).unwrap_err();
    assert!(matches!(error, RigError::Data(DataError::Index { index: 16, count: 16, .. })));
}
