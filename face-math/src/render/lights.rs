//! Light: what a surface sends to the viewer under a key and a fill light.

use super::camera::Axes;
use super::shade::Style;
use glam::Vec3;

/// What a triangle is made of.
#[derive(Debug, Clone, Copy)]
pub(super) struct Material {
    pub colour: Vec3,
    pub gloss: f32,
}

/// A key and a fill light, and light from everywhere.
pub(super) struct Lights {
    key: Vec3,
    fill: Vec3,
    strengths: [f32; 3],
}

impl Lights {
    /// The lights of a style, which follow the camera.
    pub fn new(style: &Style, axes: &Axes) -> Self {
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
    pub fn shade(&self, material: Material, normal: Vec3, viewer: Vec3, open: f32) -> Vec3 {
        let mut normal = normal.normalize_or(viewer);
        let away = -normal.dot(viewer);
        // Surfaces seen from behind are lit from before, but dimly: they are insides.
        let open = open * (1.0 - 0.65 * (away * 4.0).clamp(0.0, 1.0));
        if away > 0.0 {
            normal += viewer * (2.0 * away);
        }
        let [key, fill, ambient] = self.strengths;
        // Red light wraps further round skin than blue.
        let wrapped = |light: Vec3| {
            let facing = normal.dot(light);
            Vec3::new(0.26, 0.20, 0.17).map(|wrap| ((facing + wrap) / (1.0 + wrap)).max(0.0))
        };
        let sky = ambient * (0.75 + 0.25 * normal.y);
        let light =
            wrapped(self.key) * key * (0.35 + 0.65 * open) + wrapped(self.fill) * fill * open + Vec3::splat(sky * open);
        let shine = |towards: Vec3, power: i32| {
            let lit = (normal.dot(towards) * 4.0).clamp(0.0, 1.0);
            lit * normal.dot((towards + viewer).normalize_or(viewer)).max(0.0).powi(power)
        };
        let power = if material.gloss > 0.5 { 160 } else { 24 };
        let highlight = material.gloss * (shine(self.key, power) * key + shine(self.fill, power) * fill) * open;
        // Skin turns a little lighter where it is seen edge on.
        let rim = (1.0 - normal.dot(viewer)).max(0.0).powi(4) * 0.10 * open;
        material.colour * light * open.sqrt() + Vec3::splat(highlight) + material.colour * rim
    }
}
