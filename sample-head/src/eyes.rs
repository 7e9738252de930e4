//! The eyeballs: white, iris and pupil as three parts each, since a part has one colour.

use crate::features::{EYE_RADIUS, Features};
use crate::piece::{Follow, Piece, flip};
use glam::Vec3;
use std::f32::consts::{PI, TAU};

/// Angles from the line of sight: where the pupil, the iris and the white end.
const PUPIL_RAD: f32 = 0.185;
const IRIS_RAD: f32 = 0.505;
const BACK_RAD: f32 = PI;

/// Eyeball, iris and pupil of both eyes; the vertex 0 of each pupil is its centre.
pub fn eyes(features: &Features, density: f32) -> Vec<Piece> {
    let mut pieces = Vec::new();
    for (eye, names) in [["eyeball_L", "iris_L", "pupil_L"], ["eyeball_R", "iris_R", "pupil_R"]].into_iter().enumerate()
    {
        let mut centre = features.eye;
        if eye == 1 {
            centre.x = -centre.x;
        }
        let around = ((32.0 * density) as usize).max(16);
        let bands = [
            (names[0], [IRIS_RAD, BACK_RAD], ((16.0 * density) as usize).max(8), [0.80, 0.77, 0.74]),
            (names[1], [PUPIL_RAD, IRIS_RAD], 4, features.identity.colours.iris),
            (names[2], [0.0, PUPIL_RAD], 2, [0.004, 0.004, 0.005]),
        ];
        for (name, [from, to], rings, colour) in bands {
            pieces.push(band(name, eye, centre, [from, to], rings, around, colour));
        }
    }
    pieces
}

/// The part of the sphere between two angles from the line of sight (+Z).
fn band(
    name: &'static str,
    eye: usize,
    centre: Vec3,
    [from, to]: [f32; 2],
    rings: usize,
    around: usize,
    colour: [f32; 3],
) -> Piece {
    let (mut points, mut uvs, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    // For each ring its first vertex and their number: one at a pole.
    let mut starts: Vec<(u32, u32)> = Vec::new();
    for ring in 0..=rings {
        let angle = from + (to - from) * ring as f32 / rings as f32;
        let pole = angle.sin() < 1e-3;
        let count = if pole { 1 } else { around };
        starts.push((points.len() as u32, count as u32));
        for step in 0..count {
            let turn = step as f32 / around as f32 * TAU;
            // The right eye is the mirror image of the left, vertex by vertex.
            let turn = if eye == 0 { turn } else { PI - turn };
            let direction = Vec3::new(angle.sin() * turn.cos(), angle.sin() * turn.sin(), angle.cos());
            points.push(centre + direction * EYE_RADIUS);
            let reach = angle / BACK_RAD * 0.5;
            uvs.push([0.5 + reach * turn.cos(), 0.5 - reach * turn.sin()]);
        }
    }
    for pair in starts.windows(2) {
        let at = |(first, count): (u32, u32), step: usize| first + step as u32 % count;
        for step in 0..around {
            let (a, b) = (at(pair[0], step), at(pair[0], step + 1));
            let (c, d) = (at(pair[1], step), at(pair[1], step + 1));
            if a != b {
                triangles.push([a, d, b]);
            }
            if c != d {
                triangles.push([a, c, d]);
            }
        }
    }
    if eye == 1 {
        flip(&mut triangles);
    }
    Piece { name, points, triangles, uvs, colour, follow: Follow::Eye(eye) }
}
