//! The ears: a shell of folds standing off the head, one part each.

use crate::features::Features;
use crate::numbers::{gauss, smoothstep};
use crate::piece::{Follow, Piece, flip, sheet};
use glam::{Mat3, Vec2, Vec3};
use std::f32::consts::TAU;

/// Height of the ear and its width, in millimetres.
const SIZE: Vec2 = Vec2::new(34.0, 62.0);

/// Outline in the ear's plane at an angle (0 forwards, quarter turn up), for a reach of 1: an egg, broad at the top.
fn outline(angle: f32) -> Vec2 {
    let (sin, cos) = angle.sin_cos();
    let broad = 1.0 + 0.20 * sin - 0.06 * (2.0 * angle).cos();
    let forwards = if cos > 0.0 { 0.82 } else { 1.0 };
    Vec2::new(cos * 0.5 * SIZE.x * broad * forwards, sin * 0.5 * SIZE.y)
}

/// How far the shell stands out at a place of the plane: `reach` from its middle (0) to its rim (1) at `angle`.
fn relief(reach: f32, angle: f32) -> f32 {
    let at = outline(angle) * reach;
    let behind = smoothstep(0.75, -0.2, angle.cos());
    let above = smoothstep(-0.75, 0.0, angle.sin());
    let rim = (behind + above * 0.9).min(1.0) * above.max(0.15);
    let ring = |centre: f32, width: f32| (-((reach - centre) / width).powi(2)).exp();
    let helix = 4.2 * ring(0.93, 0.10) * rim;
    let groove = -1.6 * ring(0.76, 0.08) * rim;
    let fold = 3.6 * ring(0.58, 0.11) * (behind * smoothstep(-0.8, -0.2, angle.sin()));
    let bowl = -7.5 * gauss(at, Vec2::new(1.5, -4.0), Vec2::new(6.0, 9.0));
    let flap = 5.0 * gauss(at, Vec2::new(11.0, -5.5), Vec2::new(3.0, 5.0));
    let notch = 3.2 * gauss(at, Vec2::new(3.0, -17.0), Vec2::new(4.5, 3.5));
    let lobe = 2.0 * gauss(at, Vec2::new(2.0, -26.0), Vec2::new(7.0, 6.0));
    helix + groove + fold + bowl + flap + notch + lobe
}

/// Both ears.
pub fn ears(features: &Features) -> [Piece; 2] {
    let colour = features.identity.colours.skin;
    let root = features.skull.at(crate::skull::U_SIDE * 1.03, 8.0).at;
    // Ear plane: forwards, up, outwards; turned so that the back stands off the head, and tilted back at the top.
    let turn = Mat3::from_rotation_y(-0.50) * Mat3::from_rotation_x(-0.17);
    let (rings, around) = (26, 64);
    let place = |row: f32, column: f32| {
        let angle = column * TAU;
        // The first three quarters of the rows are the front, from the middle to the rim; the rest is the back.
        let (reach, depth) = if row < 0.75 {
            let reach = (row / 0.75).powf(0.85);
            (reach, relief(reach, angle))
        } else {
            let behind = (row - 0.75) / 0.25;
            let rim = relief(1.0, angle);
            (1.0 + 0.03 * (behind * 9.0).min(1.0) - 0.62 * behind, rim - 1.5 * (behind * 6.0).min(1.0) - 15.0 * behind)
        };
        let flat = outline(angle) * reach;
        // In the ear's own axes: x outwards, y up, z forwards.
        let local = Vec3::new(depth, flat.y, flat.x);
        let hinge = Vec3::new(0.0, 0.0, 13.0);
        root + Vec3::new(1.0, 6.0, 3.0) + turn * (local - hinge)
    };
    let (points, triangles, uvs) = sheet(rings, around + 1, place);
    let mirrored: Vec<Vec3> = points.iter().map(|point| *point * Vec3::new(-1.0, 1.0, 1.0)).collect();
    let mut flipped = triangles.clone();
    flip(&mut flipped);
    let follow = Follow::Jaw(vec![0.0; points.len()]);
    let right =
        Piece { name: "ear_R", points: mirrored, triangles: flipped, uvs: uvs.clone(), colour, follow: follow.clone() };
    [Piece { name: "ear_L", points, triangles, uvs, colour, follow }, right]
}
