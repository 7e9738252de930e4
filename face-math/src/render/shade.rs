//! Shading: a posed rig, lit by a key and a fill light that follow the camera, into a picture.

use super::camera::{Axes, Camera};
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
            key: 0.85,
            fill_direction: Vec3::new(0.8, 0.05, 0.5),
            fill: 0.28,
            ambient: 0.24,
            occlusion: 0.9,
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

/// What a triangle is made of.
#[derive(Debug, Clone, Copy)]
struct Material {
    colour: Vec3,
    gloss: f32,
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

    let mut pixels = vec![0u8; style.width_px * style.height_px * 3];
    pixels.par_chunks_mut(style.width_px.max(1) * 3).enumerate().for_each(|(y, row)| {
        let part = y as f32 / (style.height_px.max(2) - 1) as f32;
        let [top, bottom] = style.background.map(|colour| Vec3::from(colour.map(|byte| srgb_decode(f32::from(byte)))));
        let background = top.lerp(bottom, part);
        for (x, pixel) in row.chunks_exact_mut(3).enumerate() {
            let mut sum = Vec3::ZERO;
            for (sx, sy) in (0..side * side).map(|i| (x * side + i % side, y * side + i / side)) {
                let sample = &samples[sy * width + sx];
                if sample.triangle == NOTHING {
                    sum += background;
                    continue;
                }
                let index = sample.triangle as usize;
                let corners = triangles[index].map(|vertex| vertex as usize);
                let [wb, wc] = sample.weights;
                let normal =
                    normals[corners[0]] * (1.0 - wb - wc) + normals[corners[1]] * wb + normals[corners[2]] * wc;
                let at = Vec2::new(sx as f32 + 0.5, sy as f32 + 0.5) - projector.centre_px;
                let axes = &projector.axes;
                let ray = axes.forward + (axes.right * at.x - axes.up * at.y) / projector.scale_px;
                let open = 1.0 - style.occlusion * hollow[y * style.width_px + x];
                sum += lights.shade(materials[part_of[index] as usize], normal, -ray.normalize(), open);
            }
            let mean = sum / (side * side) as f32;
            for (byte, value) in pixel.iter_mut().zip(mean.to_array()) {
                *byte = encode[(value.clamp(0.0, 1.0) * (encode.len() - 1) as f32 + 0.5) as usize];
            }
        }
    });
    Image::new(style.width_px, style.height_px, pixels)
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

/// Occlusion at pixel size: from the nearest sample of each pixel, over two radii (folds, then cavities).
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
    let small = occlusion(&depths, style.width_px, style.height_px, scale, 0.004);
    let large = occlusion(&depths, style.width_px, style.height_px, scale, 0.016);
    small.iter().zip(&large).map(|(a, b)| (a * 0.7 + b * 1.1).min(1.0)).collect()
}

struct Lights {
    key: Vec3,
    fill: Vec3,
    strengths: [f32; 3],
}

impl Lights {
    fn new(style: &Style, axes: &Axes) -> Self {
        let world = |d: Vec3| (axes.right * d.x + axes.up * d.y - axes.forward * d.z).normalize_or(Vec3::Y);
        Self {
            key: world(style.key_direction),
            fill: world(style.fill_direction),
            strengths: [style.key, style.fill, style.ambient],
        }
    }

    /// Reflected light (linear RGB): wrapped diffuse, as light that bleeds through skin, and a Blinn-Phong highlight.
    ///
    /// Diffuse ((n·l + w) / (1 + w))₊ with wrap w; highlight (n·h)₊ᵏ with h halfway between light and viewer.
    fn shade(&self, material: Material, normal: Vec3, viewer: Vec3, open: f32) -> Vec3 {
        let mut normal = normal.normalize_or(viewer);
        if normal.dot(viewer) < 0.0 {
            normal -= viewer * (2.0 * normal.dot(viewer));
        }
        let [key, fill, ambient] = self.strengths;
        // Red light wraps further round skin than blue.
        let wrapped = |light: Vec3| {
            let facing = normal.dot(light);
            Vec3::new(0.28, 0.18, 0.14).map(|wrap| ((facing + wrap) / (1.0 + wrap)).max(0.0))
        };
        let sky = ambient * (0.75 + 0.25 * normal.y);
        let light =
            wrapped(self.key) * key * (0.35 + 0.65 * open) + wrapped(self.fill) * fill * open + Vec3::splat(sky * open);
        let shine =
            |towards: Vec3, power: i32| normal.dot((towards + viewer).normalize_or(viewer)).max(0.0).powi(power);
        let power = if material.gloss > 0.5 { 160 } else { 24 };
        let highlight = material.gloss * (shine(self.key, power) * key + shine(self.fill, power) * fill) * open;
        // Skin turns a little lighter where it is seen edge on.
        let rim = (1.0 - normal.dot(viewer)).max(0.0).powi(4) * 0.10 * open;
        material.colour * light * open.sqrt() + Vec3::splat(highlight) + material.colour * rim
    }
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
