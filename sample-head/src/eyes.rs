//! The eyeballs: white, iris and pupil as three parts each, since a part has one colour.

use crate::features::{EYE_RADIUS, Features};
use crate::piece::{Follow, Piece};
use glam::Vec3;

/// Angles from the line of sight: where the pupil, the iris and the white end.
const PUPIL_RAD: f32 = 0.185;
const IRIS_RAD: f32 = 0.505;
const BACK_RAD: f32 = std::f32::consts::PI;

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
            (names[1], [PUPIL_RAD, IRIS_RAD], 4, [0.09, 0.16, 0.20]),
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
    for ring in 0..=rings {
        let angle = from + (to - from) * ring as f32 / rings as f32;
        let pole = angle < 1e-3 || angle > BACK_RAD - 1e-3;
        for step in 0..if pole { 1 } else { around } {
            let turn = step as f32 / around as f32 * std::f32::consts::TAU;
            // Mirrored eyes are mirror images, vertex by vertex.
            let turn = if eye == 0 { turn } else { std::f32::consts::PI - turn };
            let (sin, cos) = (angle.sin(), angle.cos());
            let direction = Vec3::new(sin * turn.cos(), sin * turn.sin(), cos);
            points.push(centre + direction * EYE_RADIUS);
            let reach = angle / BACK_RAD * 0.5;
            uvs.push([0.5 + reach * turn.cos(), 0.5 - reach * turn.sin()]);
        }
    }
    let start = |ring: usize| {
        let first = if from < 1e-3 { 1 } else { around };
        if ring == 0 { 0 } else { (first + (ring - 1) * around) as u32 }
    };
    let at_pole = |ring: usize| (ring == 0 && from < 1e-3) || (ring == rings && to > BACK_RAD - 1e-3);
    for ring in 0..rings {
        let at = |r: usize, step: usize| if at_pole(r) { start(r) } else { start(r) + (step % around) as u32 };
        for step in 0..around {
            let (a, b) = (at(ring, step), at(ring, step + 1));
            let (c, d) = (at(ring + 1, step), at(ring + 1, step + 1));
            let mut pair = Vec::new();
            if a != b {
                pair.push([a, d, b]);
            }
            if c != d {
                pair.push([a, c, d]);
            }
            if eye == 1 {
                pair.iter_mut().for_each(|corners| corners.swap(1, 2));
            }
            triangles.extend(pair);
        }
    }
    Piece { name, points, triangles, uvs, colour, follow: Follow::Eye(eye) }
}
