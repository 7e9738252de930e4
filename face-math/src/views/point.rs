//! One marker in one frame: its place, from where several cameras saw it. Called by [`triangulate`](super::triangulate()).
//!
//! With πᵢ the projection of camera i ([`project`]), uᵢ where it saw the marker (pixels) and σ the noise of a coordinate
//! (pixels), the place X is the one of least
//!
//! ```text
//! C(X) = Σᵢ min(‖πᵢ(X) − uᵢ‖² / σ², T² / σ²)
//! ```
//!
//! T (pixels) being where a view counts as bad: the cost of MSAC (Torr and Zisserman, "MLESAC", 2000). Instead of trying
//! pairs of views by chance, all are tried, so that two good views suffice and the result is always the same: each pair
//! gives a place (the middle of the shortest line between its rays), Gauss-Newton on the views that agree with it refines
//! it, and the cheapest one wins. Where all views agree within the noise there is nothing to search for.
//!
//! Two places that are explained equally well, as three views of which one is off along the line that the others see it
//! on, are no result: a difference of cost below [`DECISIVE`] is told as ambiguous.
//!
//! The covariance of X is s² (Σ Jᵢᵀ Jᵢ)⁻¹ with s = σ, or the larger s that the residuals show
//! (Hartley and Zisserman, "Multiple View Geometry", section 5.2).

use super::lens::{Ray, project, ray_through};
use crate::data::CalibratedCamera;
use glam::{DMat3, DVec2, DVec3};

/// How to triangulate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TriangulateOptions {
    /// σ: standard deviation of a tracked coordinate, in pixels; positive.
    pub noise_px: f64,
    /// T: a view farther than this from where the marker should appear is bad, in pixels; positive.
    pub max_residual_px: f64,
    /// Least number of agreeing views; two or more.
    pub least_views: usize,
}

impl Default for TriangulateOptions {
    fn default() -> Self {
        Self { noise_px: 0.3, max_residual_px: 2.0, least_views: 2 }
    }
}

/// A camera that saw the marker, and where.
#[derive(Debug, Clone, Copy)]
pub struct Sight<'c> {
    /// The camera.
    pub camera: &'c CalibratedCamera,
    /// Where it saw the marker, in pixels.
    pub point_px: DVec2,
}

/// A marker found.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Its place, in metres.
    pub place_m: DVec3,
    /// Root mean square distance between where the views that were used saw it and where they should have, in pixels.
    pub residual_px: f64,
    /// Root mean square distance from the true place that noise leads one to expect, in millimetres.
    pub uncertainty_mm: f64,
    /// Whether each sight was used; the others were bad.
    pub used: Vec<bool>,
}

/// Why a marker has no place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unfound {
    /// Too few cameras saw it.
    TooFew,
    /// Too few of the cameras that saw it agree.
    Disagree,
    /// Two places are explained equally well.
    Ambiguous,
}

/// C is a squared number of standard deviations: a difference of 3² tells two places apart.
const DECISIVE: f64 = 9.0;

/// Within so many standard deviations all views agree, and nothing is searched.
const AGREEING: f64 = 3.5;

/// A place and what speaks for it.
#[derive(Clone)]
struct Candidate {
    place: DVec3,
    used: Vec<bool>,
    cost: f64,
    /// Σ Jᵢᵀ Jᵢ over the views used, in squared pixels a square metre.
    normal: DMat3,
    /// Σ ‖πᵢ(X) − uᵢ‖² over the views used, in squared pixels.
    squares: f64,
}

/// The place of a marker that was seen by `sights`.
///
/// # Errors
/// Where too few views there are, or agree, or two places are equally good.
pub fn locate(sights: &[Sight<'_>], options: &TriangulateOptions) -> Result<Found, Unfound> {
    let least = options.least_views.max(2);
    let rays: Vec<Option<Ray>> = sights.iter().map(|sight| ray_through(sight.camera, sight.point_px)).collect();
    if rays.iter().flatten().count() < least {
        return Err(Unfound::TooFew);
    }
    let agreeing = AGREEING * options.noise_px;
    let all: Vec<usize> = (0..sights.len()).filter(|index| rays[*index].is_some()).collect();
    if let Some(best) = meeting(&all.iter().filter_map(|index| rays[*index]).collect::<Vec<_>>())
        .and_then(|start| settle(sights, start, agreeing.min(options.max_residual_px), options))
        .filter(|candidate| candidate.used.iter().filter(|used| **used).count() == sights.len())
    {
        return Ok(found(&best, options));
    }
    let mut candidates: Vec<Candidate> = Vec::new();
    for (order, first) in all.iter().enumerate() {
        for second in &all[order + 1..] {
            let pair = [rays[*first], rays[*second]].into_iter().flatten().collect::<Vec<_>>();
            let settled = meeting(&pair).and_then(|start| settle(sights, start, options.max_residual_px, options));
            candidates.extend(settled.filter(|one| one.used.iter().filter(|used| **used).count() >= least));
        }
    }
    candidates.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let best = candidates.first().ok_or(Unfound::Disagree)?;
    let chosen = found(best, options);
    let rival = candidates.iter().find(|other| {
        let own = found(other, options);
        let apart_mm = 1000.0 * other.place.distance(best.place);
        other.used != best.used && apart_mm > 3.0 * (own.uncertainty_mm + chosen.uncertainty_mm)
    });
    match rival {
        Some(rival) if rival.cost - best.cost < DECISIVE => Err(Unfound::Ambiguous),
        _ => Ok(chosen),
    }
}

/// The point nearest to all of `rays` (metres): the sum of squared distances is least where Σ (I − d dᵀ)(X − o) = 0.
fn meeting(rays: &[Ray]) -> Option<DVec3> {
    let (mut matrix, mut right) = (DMat3::ZERO, DVec3::ZERO);
    for ray in rays {
        let d = ray.direction;
        let across = DMat3::IDENTITY - DMat3::from_cols(d * d.x, d * d.y, d * d.z);
        matrix += across;
        right += across * ray.origin_m;
    }
    // The determinant is about (number of rays) × sin² of the angle between them; a hundredth of a degree is nothing.
    (matrix.determinant() > 1e-8).then(|| matrix.inverse() * right)
}

/// Refines `start` on the views within `limit_px`, which are told anew until they stay the same.
fn settle(sights: &[Sight<'_>], start: DVec3, limit_px: f64, options: &TriangulateOptions) -> Option<Candidate> {
    // The start is rough; views that it misses by a little more may still agree.
    let mut used = within(sights, start, 2.0 * limit_px);
    let mut place = start;
    for _ in 0..6 {
        place = refine(sights, &used, place)?;
        let now = within(sights, place, limit_px);
        if now == used {
            break;
        }
        used = now;
    }
    let (normal, squares) = normal_equations(sights, &used, place).map(|(normal, _, squares)| (normal, squares))?;
    let bad = used.iter().filter(|used| !**used).count() as f64;
    let cost = (squares + bad * options.max_residual_px.powi(2)) / options.noise_px.powi(2);
    Some(Candidate { place, used, cost, normal, squares })
}

/// Which sights see `place` within `limit_px` of where they saw the marker.
fn within(sights: &[Sight<'_>], place: DVec3, limit_px: f64) -> Vec<bool> {
    let near = |sight: &Sight<'_>| {
        project(sight.camera, place).is_some_and(|seen| seen.point_px.distance(sight.point_px) <= limit_px)
    };
    sights.iter().map(near).collect()
}

/// Σ Jᵀ J, Σ Jᵀ r and Σ r² over the used sights; none where fewer than two are used or one does not see the place.
fn normal_equations(sights: &[Sight<'_>], used: &[bool], place: DVec3) -> Option<(DMat3, DVec3, f64)> {
    let (mut normal, mut right, mut squares) = (DMat3::ZERO, DVec3::ZERO, 0.0);
    for (sight, _) in sights.iter().zip(used).filter(|(_, used)| **used) {
        let seen = project(sight.camera, place)?;
        let apart = sight.point_px - seen.point_px;
        for (gradient, apart) in seen.gradients.into_iter().zip(apart.to_array()) {
            normal += DMat3::from_cols(gradient * gradient.x, gradient * gradient.y, gradient * gradient.z);
            right += gradient * apart;
        }
        squares += apart.length_squared();
    }
    (used.iter().filter(|used| **used).count() >= 2).then_some((normal, right, squares))
}

/// Gauss-Newton from `place`, to where its steps are below a nanometre.
fn refine(sights: &[Sight<'_>], used: &[bool], mut place: DVec3) -> Option<DVec3> {
    for _ in 0..20 {
        let (normal, right, _) = normal_equations(sights, used, place)?;
        let step = normal.inverse() * right;
        if !step.is_finite() {
            return None;
        }
        place += step;
        if step.length() < 1e-9 {
            break;
        }
    }
    Some(place)
}

fn found(candidate: &Candidate, options: &TriangulateOptions) -> Found {
    let views = candidate.used.iter().filter(|used| **used).count() as f64;
    // Two coordinates a view, three of them spent on the place.
    let freedom = 2.0 * views - 3.0;
    let shown = candidate.squares / freedom;
    let variance = shown.max(options.noise_px.powi(2));
    let inverse = candidate.normal.inverse();
    let trace = inverse.x_axis.x + inverse.y_axis.y + inverse.z_axis.z;
    Found {
        place_m: candidate.place,
        residual_px: (candidate.squares / views).sqrt(),
        uncertainty_mm: 1000.0 * (variance * trace).sqrt(),
        used: candidate.used.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::lens::tests::camera;
    use super::*;
    use crate::rig::toy::Dice;

    fn cameras() -> Vec<CalibratedCamera> {
        [-0.8, -0.4, 0.0, 0.4, 0.8].into_iter().map(|yaw| camera("c", yaw)).collect()
    }

    /// Nearly normal numbers of variance 1: twelve evenly spread ones have variance 4.
    fn normal(dice: &mut Dice) -> f64 {
        (0..12).map(|_| f64::from(dice.roll())).sum::<f64>() / 2.0
    }

    fn sights<'c>(cameras: &'c [CalibratedCamera], place: DVec3, noise_px: f64, dice: &mut Dice) -> Vec<Sight<'c>> {
        let seen = |camera: &'c CalibratedCamera| {
            let shake = DVec2::new(normal(dice), normal(dice)) * noise_px;
            Sight { camera, point_px: project(camera, place).unwrap().point_px + shake }
        };
        cameras.iter().map(seen).collect()
    }

    #[test]
    fn exact_views_give_the_exact_place() {
        let cameras = cameras();
        let mut dice = Dice(1);
        for count in 2..=5 {
            let place = dice.point().as_dvec3() * 0.1;
            let found =
                locate(&sights(&cameras[..count], place, 0.0, &mut dice), &TriangulateOptions::default()).unwrap();
            assert!(found.place_m.distance(place) < 1e-9 && found.residual_px < 1e-6, "{found:?}");
            assert!(found.used.iter().all(|used| *used));
        }
    }

    #[test]
    fn the_uncertainty_is_the_error_that_noise_makes() {
        let cameras = cameras();
        let mut dice = Dice(2);
        let options = TriangulateOptions { noise_px: 0.2, ..Default::default() };
        let (mut squares, mut expected) = (0.0, 0.0);
        for _ in 0..2000 {
            let place = dice.point().as_dvec3() * 0.1;
            let found = locate(&sights(&cameras[1..4], place, 0.2, &mut dice), &options).unwrap();
            squares += (1000.0 * found.place_m.distance(place)).powi(2);
            expected += found.uncertainty_mm.powi(2);
        }
        let ratio = (expected / squares).sqrt();
        assert!((0.9..1.3).contains(&ratio), "{ratio}");
    }

    #[test]
    fn a_bad_view_among_three_to_five_does_not_count() {
        let cameras = cameras();
        let mut dice = Dice(3);
        let options = TriangulateOptions { noise_px: 0.15, ..Default::default() };
        let (mut right, mut ambiguous, mut rounds) = (0, 0, 0);
        for round in 0..900 {
            let count = 3 + round % 3;
            let place = dice.point().as_dvec3() * 0.1;
            let mut sights = sights(&cameras[..count], place, 0.15, &mut dice);
            let turn = f64::from(dice.roll()) * std::f64::consts::PI;
            let bad = round % count;
            sights[bad].point_px += 20.0 * DVec2::new(turn.cos(), turn.sin());
            rounds += 1;
            match locate(&sights, &options) {
                Ok(found) if 1000.0 * found.place_m.distance(place) < 0.5 => {
                    assert!(!found.used[bad], "{found:?}");
                    right += 1;
                }
                Ok(found) => assert!(count == 3, "a wrong place though three views are good: {found:?}"),
                Err(Unfound::Ambiguous) => ambiguous += 1,
                Err(other) => panic!("{other:?}"),
            }
        }
        assert!(right > rounds * 97 / 100 && right + ambiguous > rounds * 99 / 100, "{right} {ambiguous} of {rounds}");
    }

    #[test]
    fn turning_the_world_turns_the_place() {
        let cameras = cameras();
        let mut dice = Dice(4);
        let seen = sights(&cameras, DVec3::new(0.02, 0.03, 0.05), 0.3, &mut dice);
        let here = locate(&seen, &TriangulateOptions::default()).unwrap();
        let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 1.1);
        let shift = DVec3::new(1.0, -2.0, 0.5);
        // x ↦ turn x + shift; R ↦ R turnᵀ, t ↦ t − R turnᵀ shift.
        let moved: Vec<_> = cameras
            .iter()
            .map(|camera| {
                let rotation = camera.rotation * turn.transpose();
                let translation_m = camera.translation_m - rotation * shift;
                CalibratedCamera { rotation, translation_m, ..camera.clone() }
            })
            .collect();
        let sights: Vec<_> =
            seen.iter().zip(&moved).map(|(sight, camera)| Sight { camera, point_px: sight.point_px }).collect();
        let there = locate(&sights, &TriangulateOptions::default()).unwrap();
        assert!(there.place_m.distance(turn * here.place_m + shift) < 1e-8);
        assert!((there.residual_px - here.residual_px).abs() < 1e-6);
    }

    #[test]
    fn what_cannot_be_told_is_no_place() {
        let cameras = cameras();
        let mut dice = Dice(5);
        let mut two = sights(&cameras[1..3], DVec3::ZERO, 0.0, &mut dice);
        assert_eq!(locate(&two[..1], &TriangulateOptions::default()), Err(Unfound::TooFew));
        two[0].point_px.y += 30.0;
        assert_eq!(locate(&two, &TriangulateOptions::default()), Err(Unfound::Disagree));
        let many = TriangulateOptions { least_views: 4, ..Default::default() };
        let three = sights(&cameras[..3], DVec3::ZERO, 0.0, &mut dice);
        assert_eq!(locate(&three, &many), Err(Unfound::TooFew));
    }
}
