//! What lips do by themselves: pucker, funnel, roll, press, close. In terms of place along the lip and distance from
//! the line between the lips.

use crate::features::{Features, LIP_CHART, Side, V_MOUTH};
use crate::numbers::smoothstep;
use crate::skin::{Place, SkinPoint};
use glam::Vec3;

/// Where a vertex stands on the lips.
#[derive(Debug, Clone, Copy)]
struct Spot {
    /// Along the lip: −1 right corner, 0 middle, 1 left corner; beyond outside.
    along: f32,
    /// 1 on the upper lip, −1 on the lower.
    sign: f32,
    /// From the line between the lips (0) over the border of the red (1) outwards; negative behind the edge.
    away: f32,
    /// 1 on the lips, 0 from 2.6 heights of the red outwards and from 0.8 half widths beyond the corners.
    near: f32,
}

impl Spot {
    fn new(point: &SkinPoint, mouth: f32) -> Option<Self> {
        let up = point.v - V_MOUTH;
        let sign = if up > 0.0 || (up == 0.0 && point.side == Side::Upper) { 1.0 } else { -1.0 };
        let away = match point.place {
            Place::Outside => up.abs() / LIP_CHART,
            Place::InsideLip(ring) => -0.18 * ring as f32,
            Place::BehindLid(_) => return None,
        };
        let along = point.u / mouth;
        // What lies deep behind the lip goes along less.
        let deep = (1.0 + 0.75 * away.min(0.0)).max(0.0);
        let near = (1.0 - smoothstep(0.7, 2.6, away)) * (1.0 - smoothstep(0.9, 1.8, along.abs())) * deep;
        (near > 0.0).then_some(Self { along, sign, away, near })
    }

    /// 1 in the middle of the lip, 0 at the corners.
    fn arch(&self) -> f32 {
        (1.0 - self.along * self.along).max(0.0).sqrt()
    }
}

/// Displacement (mm) of `point`, which stands at `at`, for the lips' own channels; zero for others.
pub fn delta(features: &Features, channel: &str, point: &SkinPoint, at: Vec3) -> Vec3 {
    let Some(spot) = Spot::new(point, features.mouth()) else { return Vec3::ZERO };
    let Spot { along, sign, away, near } = spot;
    let arch = spot.arch();
    // 1 at the edge, 0 at the border of the red and outside it.
    let edge = 1.0 - smoothstep(0.0, 1.15, away);
    // 1 at the border of the red, 0 at the edge and far out.
    let border = smoothstep(0.0, 0.9, away) * (1.0 - smoothstep(1.0, 2.4, away));
    match channel {
        "mouthPucker" => {
            // Lips gather to the middle and come forward; they grow thicker as they shorten.
            let gather = 0.44 * near * (1.0 - 0.16 * along * along);
            let thick = 1.3 * sign * arch * border;
            Vec3::new(-at.x * gather, thick + 0.8 * near, near * (7.5 - 1.5 * along.abs().min(1.2)) + 1.5 * edge * arch)
        }
        "mouthFunnel" => {
            // Lips open to a round, with their edges turned out.
            let gather = 0.26 * near;
            let open = if sign > 0.0 { 4.2 } else { 5.4 } * arch * near;
            let flare = 2.6 * edge * arch;
            Vec3::new(-at.x * gather, sign * open, near * 4.8 + flare)
        }
        "mouthRollLower" if sign < 0.0 => roll(sign, edge, border, arch, near),
        "mouthRollUpper" if sign > 0.0 => roll(sign, edge, border, arch, near),
        "mouthPress_L" => {
            // The left halves of the lips flatten against each other.
            let half = smoothstep(-0.35, 0.35, along) * (0.35 + 0.65 * arch);
            let squeeze = -sign * 2.3 * border * half;
            let corner = (-((along - 1.0) / 0.35).powi(2)).exp() * near;
            Vec3::new(1.3 * corner, squeeze, -1.9 * half * near * (1.0 - 0.5 * edge) - 1.2 * corner)
        }
        _ => Vec3::ZERO,
    }
}

/// The lip turns in over the teeth: its border comes to the line between the lips, its edge goes back.
fn roll(sign: f32, edge: f32, border: f32, arch: f32, near: f32) -> Vec3 {
    Vec3::new(0.0, -sign * (4.2 * border + 0.2 * edge) * arch, (-3.6 * edge - 2.4 * border) * arch - 0.3 * near)
}

/// How strongly `point` takes part in closing the lips over an open jaw: 1 on the lips, falling outwards.
pub fn closing(features: &Features, point: &SkinPoint) -> f32 {
    Spot::new(point, features.mouth()).map_or(0.0, |spot| {
        (1.0 - smoothstep(0.3, if spot.sign > 0.0 { 2.4 } else { 2.8 }, spot.away))
            * (1.0 - smoothstep(0.9, 1.5, spot.along.abs()))
    })
}
