//! Where a capture lies on a rig: a rigid motion from the capture's own space onto the rig's surface, from a few markers
//! whose vertices are roughly known. Before markers are attached, where capture and rig do not share a space.
//!
//! The known markers give a first motion by least squares; then every marker is drawn to the surface point that is nearest
//! to where the motion takes it, and the motion is fitted anew, until it stays (iterated closest points; Besl and `McKay`,
//! "A method for registration of 3-D shapes", 1992). Known markers keep drawing to their vertices as well, with the weight
//! of one marker in four, so that the capture does not slide along the surface.

use super::closest::closest_on_triangle;
use super::rigid::{Rigid, RigidError, fit_rigid};
use crate::data::Rig;
use glam::DVec3;

/// The outcome of [`register`].
#[derive(Debug, Clone, PartialEq)]
pub struct Registered {
    /// From the capture to the rig.
    pub motion: Rigid,
    /// Distance of the markers from the surface, root mean square, in metres.
    pub off_m: f64,
}

/// Rounds at most, and the way of the markers (metres, root mean square) at which the motion stays.
const ROUNDS: usize = 100;
const STAYS_M: f64 = 1e-7;
const KNOWN_WEIGHT: f64 = 0.25;

/// Registers `points` (metres, in the capture) on the triangles of `part` of `rig`; `known` are positions in `points`, each
/// with a vertex of the rig.
///
/// # Errors
/// Where fewer than three are known, or they are on a line.
///
/// # Panics
/// Where a known point, a vertex or the part is not there.
pub fn register(rig: &Rig, part: usize, points: &[DVec3], known: &[(usize, u32)]) -> Result<Registered, RigidError> {
    let vertex = |vertex: u32| rig.neutral[vertex as usize].as_dvec3();
    let places: Vec<DVec3> = known.iter().map(|(_, at)| vertex(*at)).collect();
    let from: Vec<DVec3> = known.iter().map(|(point, _)| points[*point]).collect();
    let mut motion = fit_rigid(&from, &places, None)?.motion;
    let triangles: Vec<[DVec3; 3]> = rig.parts[part].triangles.iter().map(|corners| corners.map(vertex)).collect();
    let all_from: Vec<DVec3> = points.iter().chain(&from).copied().collect();
    let weights: Vec<f64> = points.iter().map(|_| 1.0).chain(from.iter().map(|_| KNOWN_WEIGHT)).collect();
    let mut off_m = f64::INFINITY;
    for _ in 0..ROUNDS {
        let nearest: Vec<(DVec3, f64)> = points.iter().map(|point| nearest(&triangles, motion.apply(*point))).collect();
        off_m = (nearest.iter().map(|(_, off)| off * off).sum::<f64>() / nearest.len() as f64).sqrt();
        let to: Vec<DVec3> = nearest.iter().map(|(place, _)| *place).chain(places.iter().copied()).collect();
        let next = fit_rigid(&all_from, &to, Some(&weights))?.motion;
        let way = points.iter().map(|point| next.apply(*point).distance_squared(motion.apply(*point)));
        let way = (way.sum::<f64>() / points.len() as f64).sqrt();
        motion = next;
        if way < STAYS_M {
            break;
        }
    }
    Ok(Registered { motion, off_m })
}

/// The nearest point of the triangles, and its distance.
fn nearest(triangles: &[[DVec3; 3]], point: DVec3) -> (DVec3, f64) {
    let mut best = (point, f64::INFINITY);
    for corners in triangles {
        let found = closest_on_triangle(point, *corners);
        if found.distance_m < best.1 {
            best = (found.position_m, found.distance_m);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy;
    use glam::{DMat3, DQuat};

    #[test]
    fn a_moved_face_comes_back_though_its_hints_are_rough() {
        let rig = toy::rig(9, 5);
        let rotation = DMat3::from_quat(DQuat::from_scaled_axis(DVec3::new(0.2, -0.5, 0.3)));
        let away = Rigid { rotation, translation_m: DVec3::new(0.3, 1.1, -0.2) };
        let vertices: Vec<u32> = (0..rig.neutral.len() as u32).step_by(3).collect();
        let rest: Vec<DVec3> = vertices.iter().map(|vertex| rig.neutral[*vertex as usize].as_dvec3()).collect();
        let points: Vec<DVec3> = rest.iter().map(|point| away.apply(*point)).collect();
        let exact: Vec<(usize, u32)> = [0, 4, 9, 14].map(|point| (point, vertices[point])).to_vec();
        let found = register(&rig, 0, &points, &exact).unwrap();
        assert!(found.off_m < 1e-6, "{}", found.off_m);
        for (point, rest) in points.iter().zip(&rest) {
            assert!(found.motion.apply(*point).distance(*rest) < 1e-5);
        }
        assert!(register(&rig, 0, &points, &exact[..2]).is_err());
    }
}
