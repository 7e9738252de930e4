//! Bridges a short gap in time: a cubic between the two seen ends. Called by [`fill_gaps`](super::fill_gaps).
//!
//! With h the number of frames between the ends, xₚ and xₙ the ends (metres), u in 0..1 the place between them and
//! d = (xₙ − xₚ) / h the slope of the straight line (metres a frame), the cubic Hermite spline with slopes d + eₚ and
//! d + eₙ at its ends is
//!
//! ```text
//! x(u) = xₚ + u h d + h (u (1 − u)² eₚ − u² (1 − u) eₙ)
//! ```
//!
//! The slopes are those of the parabola through an end, the other end, and a seen frame a frames outside (Bessel
//! tangents: de Boor, "A Practical Guide to Splines", chapter IV), so that parabolic motion is met exactly:
//!
//! ```text
//! e = h (d₀ − d) / (a + h),   d₀ the slope from the end to the outer frame
//! ```
//!
//! Both outer slopes rest on two measured points a frame or two apart, and their noise grows with h. So each e is cut
//! to the length of d; then x(u) stays within a quarter of the way from xₚ to xₙ of the straight line, since
//! u (1 − u)² + u² (1 − u) ≤ 1/4.

use glam::DVec3;

/// A seen point beyond an end of the gap.
#[derive(Debug, Clone, Copy)]
pub(super) struct Outer {
    /// Frames between it and the end.
    pub distance: usize,
    /// Its place in metres.
    pub place: DVec3,
}

/// An end of the gap: its place in metres, and a seen point beyond it, where there is one.
#[derive(Debug, Clone, Copy)]
pub(super) struct End {
    pub place: DVec3,
    pub outer: Option<Outer>,
}

/// The place (metres) `step` frames after the end `before`, of `span` frames between the two ends.
pub(super) fn bridge(before: End, after: End, step: usize, span: usize) -> DVec3 {
    let h = span as f64;
    let u = step as f64 / h;
    let slope = (after.place - before.place) / h;
    let bend = |end: End, sign: f64| {
        end.outer.map(|outer| {
            let distance = outer.distance as f64;
            let beyond = sign * (outer.place - end.place) / distance;
            (h / (distance + h)) * (beyond - slope)
        })
    };
    // The parabola through three points bends alike at both ends, to opposite sides of the straight slope.
    let (first, last) = match (bend(before, -1.0), bend(after, 1.0)) {
        (Some(first), Some(last)) => (first, last),
        (Some(first), None) => (first, -first),
        (None, Some(last)) => (-last, last),
        (None, None) => (DVec3::ZERO, DVec3::ZERO),
    };
    let limit = slope.length();
    let (first, last) = (first.clamp_length_max(limit), last.clamp_length_max(limit));
    let v = 1.0 - u;
    before.place + u * h * slope + h * (u * v * v * first - u * u * v * last)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn end(motion: impl Fn(f64) -> DVec3, at: f64, outer: Option<f64>) -> End {
        let outer = outer.map(|other| Outer { distance: (other - at).abs() as usize, place: motion(other) });
        End { place: motion(at), outer }
    }

    #[test]
    fn parabolic_motion_is_met_exactly_with_any_outer_frame() {
        let motion = |t: f64| DVec3::new(2.0 + 3.0 * t, 40.0 * t - 0.5 * t * t, 0.0);
        for (left, right) in [(Some(-2.0), Some(9.0)), (Some(-1.0), None), (None, Some(10.0))] {
            let (before, after) = (end(motion, 0.0, left), end(motion, 8.0, right));
            for step in 1..8 {
                let found = bridge(before, after, step, 8);
                assert!(found.abs_diff_eq(motion(step as f64), 1e-9), "{left:?} {right:?} {step}: {found}");
            }
        }
    }

    #[test]
    fn without_outer_frames_the_way_is_straight() {
        let motion = |t: f64| DVec3::new(t * t, 1.0, -t);
        let found = bridge(end(motion, 0.0, None), end(motion, 4.0, None), 1, 4);
        assert!(found.abs_diff_eq(DVec3::new(4.0, 1.0, -1.0), 1e-12));
    }

    #[test]
    fn the_way_never_strays_far_from_the_straight_line() {
        let wild = |side: f64| Some(Outer { distance: 1, place: DVec3::new(0.0, 1e3 * side, 0.0) });
        for sides in [(1.0, 1.0), (-1.0, 1.0)] {
            let before = End { place: DVec3::ZERO, outer: wild(sides.0) };
            let after = End { place: DVec3::X, outer: wild(sides.1) };
            for step in 1..12 {
                let found = bridge(before, after, step, 12);
                let straight = DVec3::X * (step as f64 / 12.0);
                assert!(found.distance(straight) <= 0.25 + 1e-12, "{step}: {found}");
            }
        }
        let still = End { place: DVec3::ONE, outer: wild(1.0) };
        assert_eq!(bridge(still, still, 5, 12), DVec3::ONE);
    }
}
