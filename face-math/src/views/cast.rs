//! Where a ray meets a surface. Called for markers that are seen on the face itself, as pupils are: "the intersection
//! between the ray and the face puppet determines the 3d eye marker" (section 8 of FDLS).
//!
//! A ray o + s d meets the triangle a, b, c where o + s d = a + v (b − a) + w (c − a); by Cramer's rule (Möller and
//! Trumbore, "Fast, minimum storage ray/triangle intersection", 1997), with e₁ = b − a, e₂ = c − a, p = d × e₂, D = e₁·p,
//! t = o − a and q = t × e₁: v = t·p / D, w = d·q / D, s = e₂·q / D.

use super::lens::Ray;
use glam::{DVec3, Vec3};

/// Where a ray first meets a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Which triangle, by its place in the list.
    pub triangle: usize,
    /// Barycentric weights of its three corners.
    pub weights: [f64; 3],
    /// How far along the ray, in metres.
    pub distance_m: f64,
    /// The point, in metres.
    pub place_m: DVec3,
}

/// By how much a ray may pass outside of a triangle, in barycentric weights: rounding must not let it slip through an
/// edge between two.
const EDGE: f64 = 1e-9;

/// The first meeting of `ray` with a triangle of `triangles` (indices into `vertices`, metres) before its origin; both
/// sides of a triangle count.
///
/// # Panics
/// Where a triangle asks for a vertex that is not there.
pub fn cast_ray<'t>(ray: &Ray, vertices: &[Vec3], triangles: impl IntoIterator<Item = &'t [u32; 3]>) -> Option<Hit> {
    meetings(ray, vertices, triangles).min_by(|a, b| a.distance_m.total_cmp(&b.distance_m))
}

/// All meetings of `ray` with triangles before its origin, in the order of the triangles.
///
/// # Panics
/// Where a triangle asks for a vertex that is not there.
pub fn meetings<'t>(
    ray: &Ray,
    vertices: &[Vec3],
    triangles: impl IntoIterator<Item = &'t [u32; 3]>,
) -> impl Iterator<Item = Hit> {
    triangles.into_iter().enumerate().filter_map(move |(triangle, corners)| {
        let corners = corners.map(|vertex| vertices[vertex as usize].as_dvec3());
        meeting(ray, corners).map(|(weights, distance_m)| {
            let place_m = weights[0] * corners[0] + weights[1] * corners[1] + weights[2] * corners[2];
            Hit { triangle, weights, distance_m, place_m }
        })
    })
}

/// Barycentric weights of the meeting with one triangle, and how far along the ray it is (metres).
fn meeting(ray: &Ray, corners: [DVec3; 3]) -> Option<([f64; 3], f64)> {
    let [a, b, c] = corners;
    let (to_second, to_third) = (b - a, c - a);
    let across = ray.direction.cross(to_third);
    let size = to_second.dot(across);
    if size == 0.0 {
        return None;
    }
    let from = ray.origin_m - a;
    let second = from.dot(across) / size;
    let around = from.cross(to_second);
    let third = ray.direction.dot(around) / size;
    let distance_m = to_third.dot(around) / size;
    let inside = second >= -EDGE && third >= -EDGE && second + third <= 1.0 + EDGE;
    (inside && distance_m > 0.0).then_some(([1.0 - second - third, second, third], distance_m))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy::Dice;

    /// A ball of radius 1 about (0, 0, 5), as rings of triangles.
    fn ball(rings: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let place = |ring: u32, step: u32| {
            let (polar, around) = (ring as f32 / rings as f32, step as f32 / rings as f32);
            let (up, turn) = (polar * std::f32::consts::PI, around * std::f32::consts::TAU);
            Vec3::new(up.sin() * turn.cos(), up.cos(), up.sin() * turn.sin()) + Vec3::Z * 5.0
        };
        let vertices = (0..=rings).flat_map(|ring| (0..rings).map(move |step| place(ring, step))).collect();
        let mut triangles = Vec::new();
        for ring in 0..rings {
            for step in 0..rings {
                let [a, b] = [step, (step + 1) % rings].map(|step| ring * rings + step);
                triangles.push([a, b, b + rings]);
                triangles.push([a, b + rings, a + rings]);
            }
        }
        (vertices, triangles)
    }

    #[test]
    fn a_ball_is_met_where_geometry_says_and_never_slipped_through() {
        let (vertices, triangles) = ball(120);
        let mut dice = Dice(8);
        for _ in 0..300 {
            let aim = 0.95 * dice.point().as_dvec3().truncate().clamp_length_max(1.0);
            let ray = Ray { origin_m: DVec3::ZERO, direction: DVec3::new(aim.x * 0.19, aim.y * 0.19, 1.0).normalize() };
            let hit = cast_ray(&ray, &vertices, &triangles).unwrap();
            // ‖s d − c‖ = 1, the nearer root.
            let along = ray.direction.z * 5.0;
            let expected = along - (1.0 - (25.0 - along * along)).sqrt();
            assert!((hit.distance_m - expected).abs() < 5e-3, "{} {expected}", hit.distance_m);
            assert!((ray.origin_m + hit.distance_m * ray.direction).distance(hit.place_m) < 1e-9);
            assert!((hit.weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn rays_that_miss_or_begin_behind_meet_nothing() {
        let (vertices, triangles) = ball(24);
        let ray = |origin_m, direction| Ray { origin_m, direction };
        assert!(cast_ray(&ray(DVec3::ZERO, DVec3::NEG_Z), &vertices, &triangles).is_none());
        assert!(cast_ray(&ray(DVec3::X * 3.0, DVec3::Z), &vertices, &triangles).is_none());
        let edge = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::ONE];
        let square = [[0, 1, 2], [2, 1, 3]];
        let through = ray(DVec3::new(0.5, 0.5, -1.0), DVec3::Z);
        assert!(cast_ray(&through, &edge, &square).is_some());
        let both = meetings(&ray(DVec3::ZERO, DVec3::new(0.01, 0.02, 1.0).normalize()), &vertices, &triangles).count();
        assert_eq!(both, 2, "a ray goes into a ball and out again");
    }
}
