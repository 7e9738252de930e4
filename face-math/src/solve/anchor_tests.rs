//! Tests of [`find_anchor`]: offsets are told from expressions, and stay 0 where there are none.

use super::anchor::*;
use crate::data::{Curves, Markers};
use crate::rig::{MarkerRig, toy};
use glam::Vec3;
use wire::FrameAxis;

fn puppet() -> MarkerRig {
    MarkerRig::of_vertices(&toy::jawed(9, 5), &(0..80).collect::<Vec<_>>()).unwrap()
}

/// Expressions that come and go: every channel rests in some frames, and is at a fifth where it rests in the others.
fn performance(puppet: &MarkerRig, frames: usize) -> Curves {
    let mut dice = toy::Dice(31);
    let width = puppet.channels().len();
    let values = (0..frames * width).map(|_| (0.4 * dice.roll()).max(0.0)).collect();
    let axis = FrameAxis { first: 1001, count: frames, rate_hz: 60.0 };
    Curves::new(axis, puppet.channels().to_vec(), values).unwrap()
}

fn captured(puppet: &MarkerRig, offset: impl Fn(usize) -> Vec3) -> Markers {
    let exact = puppet.drive(&performance(puppet, 200)).unwrap();
    let (width, mut dice) = (exact.names().len(), toy::Dice(77));
    let moved = exact.positions().iter().enumerate();
    let moved = moved.map(|(place, point)| *point + offset(place % width) + dice.point() * 5e-5);
    exact.with_positions(moved.collect()).unwrap()
}

fn find(puppet: &MarkerRig, take: &Markers) -> FoundAnchor {
    find_anchor(puppet, take, &FindAnchorOptions::default()).unwrap()
}

/// A mask that sits off, by 2 mm and a little askew.
fn askew(marker: usize) -> Vec3 {
    let at = marker as f32 / 80.0;
    Vec3::new(0.002, 0.001 - 0.002 * at, 0.0015 * at)
}

#[test]
fn a_mask_that_sits_off_is_told_from_expressions() {
    let puppet = puppet();
    let found = find(&puppet, &captured(&puppet, askew));
    let off = (0..80).map(|marker| f64::from(found.offsets[marker].unwrap().distance_squared(askew(marker))));
    let off_mm = 1e3 * (off.sum::<f64>() / 80.0).sqrt();
    assert!(off_mm < 0.2, "{off_mm} mm of about 2.2");
    let (truth, usual) = (performance(&puppet, 200), FindAnchorOptions::default());
    let known = truth.frame(found.frame);
    let squares = found.weights.iter().zip(known).map(|(found, known)| (found - f64::from(*known)).powi(2));
    let apart = (squares.sum::<f64>() / known.len() as f64).sqrt();
    assert!(apart < 0.05, "{apart}");
    let again = find_anchor(&puppet, &captured(&puppet, askew), &usual).unwrap();
    assert_eq!(found, again);
}

#[test]
fn marks_in_their_places_stay_there() {
    let puppet = puppet();
    let found = find(&puppet, &captured(&puppet, |_| Vec3::ZERO));
    assert!(found.offsets.iter().all(|offset| *offset == Some(Vec3::ZERO)), "{:?}", found.offsets);
    assert!(found.weights.iter().all(|weight| weight.abs() < f64::MIN_POSITIVE));
    assert!(found.remaining_mm.iter().all(|remaining| *remaining < 0.5), "{:?}", found.remaining_mm);
}

#[test]
fn markers_that_are_gone_have_no_offset_and_lost_ones_count_little() {
    let puppet = puppet();
    let take = captured(&puppet, askew);
    let mut positions = take.positions().to_vec();
    for frame in 0..200 {
        positions[frame * 80 + 5] = Vec3::NAN;
        if frame % 9 == 0 {
            positions[frame * 80 + 17] += Vec3::Y * 0.03;
        }
    }
    let found = find(&puppet, &take.with_positions(positions).unwrap());
    assert!(found.offsets[5].is_none());
    assert!(found.offsets[17].unwrap().distance(askew(17)) < 0.001, "{:?}", found.offsets[17]);
}

#[test]
fn bad_input_is_named() {
    let puppet = puppet();
    let take = captured(&puppet, askew);
    let fault = |take: &Markers, options: FindAnchorOptions| find_anchor(&puppet, take, &options).unwrap_err();
    let usual = FindAnchorOptions::default();
    assert!(matches!(fault(&take, FindAnchorOptions { usual_weight: 0.0, ..usual }), FindAnchorError::Option { .. }));
    let gone = take.with_positions(vec![Vec3::NAN; take.positions().len()]).unwrap();
    assert_eq!(fault(&gone, usual), FindAnchorError::Blind { frames: 32, markers: 80 });
    let strangers = Markers::new(take.frame_axis(), vec!["nose".into()], vec![Vec3::ZERO; 200]).unwrap();
    assert_eq!(fault(&strangers, usual), FindAnchorError::NoMarker);
}
