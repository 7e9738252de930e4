//! Inside the mouth: teeth, gums, tongue and the dark cavity.

use crate::numbers::smoothstep;
use crate::piece::{Follow, Piece, sheet};
use glam::Vec3;
use std::f32::consts::PI;

/// Front of the upper incisors.
const ARCH_Z: f32 = 106.0;

/// The dental arch, a parabola seen from above: x and z at `t` (−1 right, 1 left), `inset` behind its front.
fn arch(t: f32, inset: f32) -> (f32, f32) {
    let x = t * (26.0 - inset * 0.7);
    (x, ARCH_Z - inset - x * x / 19.5)
}

/// One row of teeth: front, edge and back, with grooves between the teeth.
fn teeth(name: &'static str, upper: bool) -> Piece {
    // Widths of the teeth from the middle, in millimetres along x: incisors, canine, premolars, molars.
    let widths: [f32; 7] =
        if upper { [8.4, 6.6, 7.4, 3.6, 3.0, 2.6, 2.4] } else { [5.4, 5.8, 6.6, 4.4, 3.4, 2.8, 2.6] };
    let total: f32 = widths.iter().sum();
    let steps_per_tooth = 8;
    let columns = widths.len() * 2 * steps_per_tooth + 1;
    let bounds: Vec<f32> = std::iter::once(0.0)
        .chain(widths.iter().scan(0.0, |sum, width| {
            *sum += width / total;
            Some(*sum)
        }))
        .collect();
    let (gum_y, edge_y, inset) = if upper { (-24.0, -38.0, 0.0) } else { (-48.0, -36.8, 3.6) };
    let (points, mut triangles, uvs) = sheet(13, columns, |row, column| {
        // Whole steps, so that both halves meet the teeth's bounds alike.
        let steps = (widths.len() * steps_per_tooth) as f32;
        let place = ((column * 2.0 - 1.0).abs() * steps).round() / steps_per_tooth as f32;
        let tooth = (place as usize).min(widths.len() - 1);
        let within = place - tooth as f32;
        let t = (column * 2.0 - 1.0).signum() * (bounds[tooth] + (bounds[tooth + 1] - bounds[tooth]) * within);
        let round = (PI * within).sin().max(0.0).powf(0.4);
        // Rows go from the gum along the front to the edge, and along the back to the gum.
        let down = row;
        let height = 1.0 - (down * 2.0 - 1.0).abs();
        let back = smoothstep(0.44, 0.56, down);
        let shorter = [0.0, 0.9, -0.1, 0.6, 0.9, 1.2, 1.4][tooth] + 0.5 * (1.0 - round);
        let edge = if upper { edge_y + shorter } else { edge_y - shorter * 0.6 };
        let bulge = 0.9 * (PI * height * 0.9).sin();
        let thick = 2.2 + 3.0 * smoothstep(1.5, 4.0, tooth as f32) + 2.5 * (1.0 - height);
        let (x, z) = arch(t, inset + back * thick - (1.0 - back) * (bulge + 1.1 * round - 1.1));
        Vec3::new(x, gum_y + (edge - gum_y) * height.powf(0.9), z)
    });
    if upper {
        triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
    }
    let share = if upper { 0.0 } else { 1.0 };
    let follow = Follow::Jaw(vec![share; points.len()]);
    Piece { name, points, triangles, uvs, colour: [0.70, 0.66, 0.57], follow }
}

/// The gum before one row of teeth.
fn gums(name: &'static str, upper: bool) -> Piece {
    let (near, far, inset) = if upper { (-26.2, -14.0, 0.3) } else { (-46.2, -57.0, 3.9) };
    let (points, mut triangles, uvs) = sheet(9, 57, |row, column| {
        let t = column * 2.0 - 1.0;
        // Scallops between the teeth.
        let scallop = (t.abs() * 22.0).sin().abs() * 0.9;
        let y = near + (far - near) * row + if upper { -scallop } else { scallop } * (1.0 - row).powi(3);
        let lip = (1.0 - row) * 1.0;
        let (x, z) = arch(t, inset + 2.2 * row * row - lip * (PI * (1.0 - row)).sin() + 0.6 * (1.0 - row).powi(6));
        Vec3::new(x, y, z)
    });
    if !upper {
        triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
    }
    let share = if upper { 0.0 } else { 1.0 };
    let follow = Follow::Jaw(vec![share; points.len()]);
    Piece { name, points, triangles, uvs, colour: [0.42, 0.13, 0.12], follow }
}

/// The tongue, resting behind the lower teeth.
fn tongue() -> Piece {
    let (points, triangles, uvs) = sheet(17, 25, |row, column| {
        // Row along the tongue from back to tip, column around it.
        let along = row;
        let turn = (column - 0.25) * 2.0 * PI;
        let tip = (1.0 - along.powi(6)).max(0.0).sqrt();
        let (half_width, half_height) = (17.0 * tip * (0.85 + 0.15 * (1.0 - along)), 6.5 * tip);
        let groove = -1.6 * (-((turn - PI * 0.5) / 0.35).powi(2)).exp() * (1.0 - along * 0.7);
        let y = -45.5 + 3.0 * (1.0 - along) + half_height * turn.sin() + groove;
        Vec3::new(half_width * turn.cos(), y, 52.0 + 48.5 * along)
    });
    let follow = Follow::Jaw(vec![1.0; points.len()]);
    Piece { name: "tongue", points, triangles, uvs, colour: [0.45, 0.14, 0.13], follow }
}

/// The cavity: a dark bag from inside the lips to the throat, seen from within.
fn cavity() -> Piece {
    let mut share = Vec::new();
    let (points, triangles, uvs) = sheet(15, 41, |row, column| {
        let turn = (column - 0.25) * 2.0 * PI;
        let deep = row;
        let size = (1.0 - deep * deep).max(0.0).sqrt();
        let (x, y) = (30.0 * size * turn.cos(), -36.0 + 20.0 * size * turn.sin());
        Vec3::new(x, y, 98.0 - 60.0 * deep - x * x / 26.0)
    });
    for point in &points {
        share.push(smoothstep(-30.0, -44.0, point.y) * smoothstep(30.0, 50.0, point.z));
    }
    Piece { name: "mouth_cavity", points, triangles, uvs, colour: [0.10, 0.02, 0.02], follow: Follow::Jaw(share) }
}

/// All parts inside the mouth.
pub fn inside() -> Vec<Piece> {
    vec![
        teeth("teeth_upper", true),
        teeth("teeth_lower", false),
        gums("gums_upper", true),
        gums("gums_lower", false),
        tongue(),
        cavity(),
    ]
}
