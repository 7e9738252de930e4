//! Shading: a posed rig, lit by a key and a fill light that follow the camera, into a picture.

use super::camera::Camera;
use super::lights::{Lights, Material};
use super::normals::smooth_normals;
use super::occlusion::occlusion;
use super::raster::{NOTHING, Sample, rasterise};
use crate::data::{DataError, Image, Rig};
use glam::{Vec2, Vec3};
use rayon::prelude::*;

/// How a picture looks.
#[derive(Debug, Clone, PartialEq)]
pub struct Style {
    /// Width in pixels.
    pub width_px: usize,
    /// Height in pixels.
    pub height_px: usize,
    /// Samples along each side of a pixel: 1 is jagged, 2 is good, 3 is fine.
    pub supersampling: usize,
    /// Background at the top and at the bottom, sRGB.
    pub background: [[u8; 3]; 2],
    /// Towards the key light, seen from the camera: x right, y up, z towards the viewer.
    pub key_direction: Vec3,
    /// Strength of the key light.
    pub key: f32,
    /// Towards the fill light.
    pub fill_direction: Vec3,
    /// Strength of the fill light.
    pub fill: f32,
    /// Strength of the light from everywhere.
    pub ambient: f32,
    /// How strongly hollows darken, 0 to 1.
    pub occlusion: f32,
    /// Shininess of parts whose name begins so, 0 to 1; the first that fits counts, others have `0.06`.
    pub gloss: Vec<(String, f32)>,
    /// Parts to leave out.
    pub hidden: Vec<String>,
}

impl Default for Style {
    fn default() -> Self {
        let gloss = [("eye", 0.9), ("iris", 0.9), ("pupil", 0.9), ("teeth", 0.45), ("tongue", 0.3), ("lip", 0.18)];
        Self {
            width_px: 512,
            height_px: 512,
            supersampling: 2,
            background: [[58, 62, 70], [30, 32, 37]],
            key_direction: Vec3::new(-0.55, 0.6, 0.75),
            key: 0.92,
            fill_direction: Vec3::new(0.8, 0.05, 0.5),
            fill: 0.22,
            ambient: 0.20,
            occlusion: 0.75,
            gloss: gloss.into_iter().map(|(name, shine)| (name.to_owned(), shine)).collect(),
            hidden: Vec::new(),
        }
    }
}

impl Style {
    /// The default look in a picture of the given size.
    pub fn sized(width_px: usize, height_px: usize) -> Self {
        Self { width_px, height_px, ..Self::default() }
    }
}

/// Draws `positions` (metres, one a vertex of the rig) as `camera` sees them.
///
/// Triangles are drawn from both sides. Points that are not finite take their triangles with them.
///
/// # Errors
/// Where the number of positions is not the rig's number of vertices.
pub fn render_rig(rig: &Rig, positions: &[Vec3], camera: &Camera, style: &Style) -> Result<Image, DataError> {
    if positions.len() != rig.neutral.len() {
        let (expected, found) = (rig.neutral.len(), positions.len());
        return Err(DataError::Size { what: "positions to draw", expected, found });
    }
    let side = style.supersampling.max(1);
    let (width, height) = (style.width_px * side, style.height_px * side);
    let (triangles, materials, part_of) = gather(rig, style);
    let projector = camera.projector(width, height);
    let samples = rasterise(positions, &triangles, &projector, width, height);
    let hollow = hollowness(&samples, style, side, projector.scale_px);
    let normals = smooth_normals(rig, positions);
    let lights = Lights::new(style, &projector.axes);
    let encode = srgb_table();

    let scene = Scene { samples: &samples, triangles: &triangles, materials: &materials, part_of: &part_of };
    let [top, bottom] = style.background.map(|colour| Vec3::from(colour.map(|byte| srgb_decode(f32::from(byte)))));
    let mut pixels = vec![0u8; style.width_px * style.height_px * 3];
    pixels.par_chunks_mut(style.width_px.max(1) * 3).enumerate().for_each(|(y, row)| {
        let background = top.lerp(bottom, y as f32 / (style.height_px.max(2) - 1) as f32);
        for (x, pixel) in row.chunks_exact_mut(3).enumerate() {
            let own = (0..side * side).map(|i| (y * side + i / side) * width + x * side + i % side);
            let open = 1.0 - style.occlusion * hollow[y * style.width_px + x];
            let at = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) * side as f32 - projector.centre_px;
            let axes = &projector.axes;
            let ray = axes.forward + (axes.right * at.x - axes.up * at.y) / projector.scale_px;
            let light = |surface: &Surface| lights.shade(surface.material, surface.normal, -ray.normalize(), open);
            let mut sum = Vec3::ZERO;
            for (surface, count) in scene.surfaces(&normals, own) {
                sum += surface.map_or(background, |surface| light(&surface)) * count;
            }
            let mean = sum / (side * side) as f32;
            for (byte, value) in pixel.iter_mut().zip(mean.to_array()) {
                *byte = encode[(value.clamp(0.0, 1.0) * (encode.len() - 1) as f32 + 0.5) as usize];
            }
        }
    });
    Image::new(style.width_px, style.height_px, pixels)
}

/// What the samples saw.
struct Scene<'a> {
    samples: &'a [Sample],
    triangles: &'a [[u32; 3]],
    materials: &'a [Material],
    part_of: &'a [u32],
}

/// A piece of surface within a pixel.
#[derive(Clone, Copy)]
struct Surface {
    material: Material,
    normal: Vec3,
}

impl Scene<'_> {
    /// The surfaces within a pixel (`None` for the background), with the number of samples each covers. Samples in a
    /// row that see the same part at nearly the same depth are one surface with their mean normal, lit once.
    fn surfaces(
        &self,
        normals: &[Vec3],
        samples: impl Iterator<Item = usize>,
    ) -> impl Iterator<Item = (Option<Surface>, f32)> {
        let mut found: Vec<(Option<Surface>, f32)> = Vec::with_capacity(2);
        let mut last: (u32, f32) = (NOTHING, 0.0);
        for sample in samples.map(|index| &self.samples[index]) {
            let index = sample.triangle as usize;
            let part = if sample.triangle == NOTHING { NOTHING } else { self.part_of[index] };
            let near = (sample.inverse_depth - last.1).abs() <= 0.004 * sample.inverse_depth;
            let same = !found.is_empty() && part == last.0 && near;
            last = (part, sample.inverse_depth);
            if sample.triangle == NOTHING {
                match found.last_mut() {
                    Some((None, count)) => *count += 1.0,
                    _ => found.push((None, 1.0)),
                }
                continue;
            }
            let [a, b, c] = self.triangles[index].map(|vertex| normals[vertex as usize]);
            let [wb, wc] = sample.weights;
            let normal = a * (1.0 - wb - wc) + b * wb + c * wc;
            match found.last_mut() {
                Some((Some(surface), count)) if same => {
                    surface.normal += normal;
                    *count += 1.0;
                }
                _ => found.push((Some(Surface { material: self.materials[part as usize], normal }), 1.0)),
            }
        }
        found.into_iter()
    }
}

fn gather(rig: &Rig, style: &Style) -> (Vec<[u32; 3]>, Vec<Material>, Vec<u32>) {
    let mut triangles = Vec::new();
    let mut part_of = Vec::new();
    let mut materials = Vec::new();
    for part in &rig.parts {
        let gloss = style.gloss.iter().find(|(name, _)| part.name.starts_with(name.as_str()));
        let gloss = gloss.map_or(0.06, |(_, gloss)| *gloss);
        materials.push(Material { colour: Vec3::from(part.colour), gloss });
        if !style.hidden.contains(&part.name) {
            triangles.extend_from_slice(&part.triangles);
            part_of.resize(triangles.len(), materials.len() as u32 - 1);
        }
    }
    (triangles, materials, part_of)
}

/// Occlusion at pixel size: from the middle sample of each pixel.
fn hollowness(samples: &[Sample], style: &Style, side: usize, scale_px: f32) -> Vec<f32> {
    if style.occlusion <= 0.0 {
        return vec![0.0; style.width_px * style.height_px];
    }
    let width = style.width_px * side;
    let mut depths = vec![f32::INFINITY; style.width_px * style.height_px];
    for (index, depth) in depths.iter_mut().enumerate() {
        let (x, y) = (index % style.width_px * side, index / style.width_px * side);
        let sample = &samples[(y + side / 2) * width + x + side / 2];
        if sample.triangle != NOTHING {
            *depth = 1.0 / sample.inverse_depth;
        }
    }
    let scale = scale_px / side as f32;
    occlusion(&depths, style.width_px, style.height_px, scale)
}

/// sRGB byte to linear light, IEC 61966-2-1.
fn srgb_decode(byte: f32) -> f32 {
    let value = byte / 255.0;
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

/// Linear light in 4,096 steps to sRGB bytes, IEC 61966-2-1.
fn srgb_table() -> Vec<u8> {
    (0..4096u16)
        .map(|step| {
            let value = f32::from(step) / 4095.0;
            let encoded = if value <= 0.003_130_8 { value * 12.92 } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 };
            (encoded * 255.0).round() as u8
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Part;
    use crate::render::{Mark, draw_marks};

    /// A white square before a red one, both facing +Z.
    fn squares() -> Rig {
        let square = |half: f32, z: f32| {
            [[-half, -half], [half, -half], [half, half], [-half, half]].map(|[x, y]| Vec3::new(x, y, z))
        };
        let part = |name: &str, first: u32, colour: [f32; 3]| Part {
            name: name.to_owned(),
            vertices: first..first + 4,
            triangles: vec![[first, first + 1, first + 2], [first, first + 2, first + 3]],
            uvs: Vec::new(),
            colour,
        };
        Rig {
            name: "squares".to_owned(),
            parts: vec![part("back", 0, [0.8, 0.0, 0.0]), part("front", 4, [0.8, 0.8, 0.8])],
            neutral: [square(0.1, 0.0), square(0.04, 0.05)].concat(),
            channels: Vec::new(),
            shapes: Vec::new(),
            skin: Vec::new(),
            jaw_pivot_m: None,
            jaw: None,
            joints: Vec::new(),
        }
    }

    fn pixel(image: &Image, x: usize, y: usize) -> [u8; 3] {
        let start = (y * image.width_px() + x) * 3;
        [0, 1, 2].map(|channel| image.pixels()[start + channel])
    }

    #[test]
    fn the_nearer_part_hides_the_farther_whichever_comes_first() {
        let mut rig = squares();
        let camera = Camera::framing(&rig.neutral);
        let style = Style::sized(64, 64);
        for _ in 0..2 {
            let image = render_rig(&rig, &rig.neutral, &camera, &style).unwrap();
            let [r, g, b] = pixel(&image, 32, 32);
            assert!(r > 100 && g > 100 && b > 100, "white before red: {r} {g} {b}");
            let [r, g, b] = pixel(&image, 14, 32);
            assert!(r > 100 && g < 90 && b < 90, "red beside white: {r} {g} {b}");
            assert_eq!(pixel(&image, 0, 0), [58, 62, 70]);
            rig.parts.reverse();
        }
    }

    #[test]
    fn no_gap_opens_between_neighbouring_triangles() {
        let rig = squares();
        let style = Style { supersampling: 1, ..Style::sized(97, 97) };
        for step in 0..7 {
            let camera = Camera::framing(&rig.neutral).closer(3.0).turned(step as f32 * 0.1, step as f32 * 0.07);
            let image = render_rig(&rig, &rig.neutral, &camera, &style).unwrap();
            for at in 35..60 {
                assert!(pixel(&image, at, at)[0] > 80 && pixel(&image, at, 96 - at)[0] > 80, "{at} at step {step}");
            }
        }
    }

    #[test]
    fn bad_positions_are_refused_and_missing_points_leave_a_hole() {
        let rig = squares();
        let camera = Camera::framing(&rig.neutral);
        let style = Style::sized(64, 64);
        assert!(render_rig(&rig, &rig.neutral[1..], &camera, &style).is_err());
        let mut positions = rig.neutral.clone();
        positions[4..].fill(Vec3::NAN);
        let image = render_rig(&rig, &positions, &camera, &style).unwrap();
        assert!(pixel(&image, 32, 32)[1] < 90, "the red square shows");
    }

    #[test]
    fn hidden_parts_do_not_show_and_marks_do() {
        let rig = squares();
        let camera = Camera::framing(&rig.neutral);
        let hidden = vec!["front".to_owned(), "back".to_owned()];
        let style = Style { hidden, ..Style::sized(64, 64) };
        let mut image = render_rig(&rig, &rig.neutral, &camera, &style).unwrap();
        let empty = pixel(&image, 32, 32);
        draw_marks(&mut image, &camera, &[Vec3::new(0.0, 0.0, 0.025), Vec3::NAN], &Mark::CAPTURED);
        assert!(empty[1] < 70 && pixel(&image, 32, 32)[1] > 150);
    }
}
