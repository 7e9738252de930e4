//! The point of a triangle that is nearest to a given point: what markers are attached by.

use glam::DVec3;

/// The nearest point of a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClosestPoint {
    /// Barycentric weights of the three corners; none is negative, they sum to 1.
    pub weights: [f64; 3],
    /// The point, in metres.
    pub position_m: DVec3,
    /// Its distance from the given point, in metres.
    pub distance_m: f64,
}

/// The point of the triangle `corners` nearest to `point` (metres). A triangle without area is treated as the segments
/// it consists of.
///
/// Where the foot of the perpendicular lies inside, it is the foot: with e₁ = b − a, e₂ = c − a, d = p − a and the Gram
/// entries gᵢⱼ = eᵢ·eⱼ, the weights of b and c are
/// ((g₂₂ e₁·d − g₁₂ e₂·d), (g₁₁ e₂·d − g₁₂ e₁·d)) / (g₁₁ g₂₂ − g₁₂²). Otherwise it lies on the nearest edge.
pub fn closest_on_triangle(point: DVec3, corners: [DVec3; 3]) -> ClosestPoint {
    let [a, b, c] = corners;
    let (first, second, d) = (b - a, c - a, point - a);
    let (g11, g12, g22) = (first.length_squared(), first.dot(second), second.length_squared());
    let (along_first, along_second) = (first.dot(d), second.dot(d));
    let area = g11 * g22 - g12 * g12;
    if area > 1e-12 * g11 * g22 {
        let v = (g22 * along_first - g12 * along_second) / area;
        let w = (g11 * along_second - g12 * along_first) / area;
        if v >= 0.0 && w >= 0.0 && v + w <= 1.0 {
            return at(point, corners, [1.0 - v - w, v, w]);
        }
    }
    let mut best: Option<ClosestPoint> = None;
    for (from, to) in [(0, 1), (1, 2), (2, 0)] {
        let edge = corners[to] - corners[from];
        let length = edge.length_squared();
        let along = if length > 0.0 { (edge.dot(point - corners[from]) / length).clamp(0.0, 1.0) } else { 0.0 };
        let mut weights = [0.0; 3];
        weights[from] = 1.0 - along;
        weights[to] = along;
        let found = at(point, corners, weights);
        if best.is_none_or(|best| found.distance_m < best.distance_m) {
            best = Some(found);
        }
    }
    best.unwrap_or_else(|| at(point, corners, [1.0, 0.0, 0.0]))
}

fn at(point: DVec3, corners: [DVec3; 3], weights: [f64; 3]) -> ClosestPoint {
    let position = weights[0] * corners[0] + weights[1] * corners[1] + weights[2] * corners[2];
    ClosestPoint { weights, position_m: position, distance_m: position.distance(point) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy::Dice;

    /// No point of a fine grid over the triangle is nearer than the one found.
    #[test]
    fn nothing_on_the_triangle_is_nearer() {
        let mut dice = Dice(23);
        for _ in 0..200 {
            let corners = std::array::from_fn(|_| dice.point().as_dvec3());
            let point = 2.0 * dice.point().as_dvec3();
            let found = closest_on_triangle(point, corners);
            assert!((found.weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            assert!(found.weights.iter().all(|weight| *weight >= 0.0));
            let steps = 40;
            for i in 0..=steps {
                for j in 0..=steps - i {
                    let (v, w) = (f64::from(i) / f64::from(steps), f64::from(j) / f64::from(steps));
                    let other = at(point, corners, [1.0 - v - w, v, w]);
                    assert!(other.distance_m >= found.distance_m - 1e-12);
                }
            }
        }
    }

    #[test]
    fn flat_triangles_are_segments_and_points() {
        let line = [DVec3::ZERO, DVec3::X, 2.0 * DVec3::X];
        let found = closest_on_triangle(DVec3::new(1.5, 1.0, 0.0), line);
        assert!(found.position_m.abs_diff_eq(DVec3::new(1.5, 0.0, 0.0), 1e-12));
        let dot = closest_on_triangle(DVec3::Y, [DVec3::X; 3]);
        assert_eq!(dot.position_m, DVec3::X);
    }
}
