//! Inside the mouth: teeth, gums, tongue and the dark cavity.

use crate::numbers::smoothstep;
use crate::piece::{Follow, Piece, flip, sheet};
use crate::skin::{LIP_RINGS, Place, Skin};
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
    let (gum_y, edge_y, inset) = if upper { (-24.0, -38.0, 0.0) } else { (-48.0, -36.8, 4.2) };
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
        flip(&mut triangles);
    }
    let share = if upper { 0.0 } else { 1.0 };
    let follow = Follow::Jaw(vec![share; points.len()]);
    Piece { name, points, triangles, uvs, colour: [0.70, 0.66, 0.57], follow }
}

/// The gum before one row of teeth.
fn gums(name: &'static str, upper: bool) -> Piece {
    let (near, far, inset) = if upper { (-26.2, -14.0, 0.3) } else { (-46.2, -53.0, 4.6) };
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
        flip(&mut triangles);
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

/// The cavity: a dark bag from the innermost ring of the lips to the throat, seen from within. Its front moves with the
/// lips, its end stays.
fn cavity(skin: &Skin) -> Piece {
    let ring = lip_ring(skin);
    let (rows, columns) = (17, ring.len() + 1);
    let (points, mut triangles, uvs) = sheet(rows, columns, |row, column| {
        let place = (column * (columns - 1) as f32).round() as usize % ring.len();
        let at = skin.points[ring[place] as usize].at;
        // Wide behind the lips, around the teeth, then narrow to the throat.
        let narrow = 1.0 - smoothstep(0.6, 1.0, row);
        let wide = 1.0 + 0.75 * smoothstep(0.0, 0.28, row);
        // Below, the chin's skin lies close behind the lip: the bag opens later there.
        let high = if at.y > -36.0 { smoothstep(0.0, 0.12, row) } else { smoothstep(0.10, 0.36, row) };
        let up = ((at.y + 36.0) * (1.0 + 1.3 * high)).clamp(-17.0, 24.0);
        Vec3::new(at.x * wide * narrow, up * narrow - 36.0, at.z + (38.0 - at.z) * row)
    });
    let shares = points.iter().enumerate().map(|(index, point)| {
        let row = (index / columns) as f32 / (rows - 1) as f32;
        let lip = 1.0 - smoothstep(0.0, 0.13, row);
        let jaw = smoothstep(-33.0, -42.0, point.y) * (1.0 - smoothstep(0.75, 1.0, row));
        (ring[index % columns % ring.len()], lip, (1.0 - lip) * jaw)
    });
    flip(&mut triangles);
    let follow = Follow::Lining(shares.collect());
    Piece { name: "mouth_cavity", points, triangles, uvs, colour: [0.10, 0.02, 0.02], follow }
}

/// The innermost ring of the lips, once around: from the middle of the upper lip to the performer's left, and back along
/// the lower.
fn lip_ring(skin: &Skin) -> Vec<u32> {
    let innermost = |vertex: &u32| skin.points[*vertex as usize].place == Place::InsideLip(LIP_RINGS);
    // Rings are laid down as the upper edge with both corners, then the lower edge without.
    let all: Vec<u32> = (0..skin.points.len() as u32).filter(innermost).collect();
    let (upper, lower) = all.split_at(skin.mouth.upper.len().min(all.len()));
    let mut ring: Vec<u32> = upper.iter().chain(lower.iter().rev()).copied().collect();
    ring.rotate_left(upper.len() / 2);
    ring
}

/// All parts inside the mouth.
pub fn inside(skin: &Skin) -> Vec<Piece> {
    vec![
        teeth("teeth_upper", true),
        teeth("teeth_lower", false),
        gums("gums_upper", true),
        gums("gums_lower", false),
        tongue(),
        cavity(skin),
    ]
}
