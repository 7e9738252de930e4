//! Marks over a picture: where markers are, captured beside solved.

use super::camera::Camera;
use crate::data::Image;
use glam::Vec3;

/// The shape of a mark.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MarkShape {
    /// A filled disc with a dark edge: what was captured.
    Dot,
    /// An upright cross: what the puppet shows.
    Cross,
}

/// How marks look.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mark {
    /// Dot or cross.
    pub shape: MarkShape,
    /// sRGB colour.
    pub colour: [u8; 3],
    /// Half the width of a mark, in pixels.
    pub radius_px: f32,
}

impl Mark {
    /// Green dots: captured markers.
    pub const CAPTURED: Self = Self { shape: MarkShape::Dot, colour: [64, 220, 120], radius_px: 2.5 };
    /// Red crosses: the puppet's markers.
    pub const PUPPET: Self = Self { shape: MarkShape::Cross, colour: [255, 80, 60], radius_px: 3.0 };
}

/// Draws a mark at each of `points` (metres) as `camera` sees them; missing points are left out.
///
/// Marks are drawn over the picture whether or not the face hides them.
pub fn draw_marks(image: &mut Image, camera: &Camera, points: &[Vec3], mark: &Mark) {
    let (width, height) = (image.width_px(), image.height_px());
    for point in points {
        let Some((at, _)) = camera.project(*point, width, height) else { continue };
        let reach = mark.radius_px + 1.0;
        let span = |centre: f32, size: usize| {
            let low = (centre - reach).floor().max(0.0) as usize;
            low..((centre + reach).ceil().max(0.0) as usize).min(size)
        };
        for y in span(at.y, height) {
            for x in span(at.x, width) {
                let (dx, dy) = (x as f32 + 0.5 - at.x, y as f32 + 0.5 - at.y);
                let (cover, dark) = match mark.shape {
                    MarkShape::Dot => {
                        let far = dx.hypot(dy);
                        ((mark.radius_px + 0.5 - far).clamp(0.0, 1.0), far > mark.radius_px - 0.7)
                    }
                    MarkShape::Cross => {
                        let arm = (0.9 - dx.abs().min(dy.abs())).clamp(0.0, 1.0);
                        let end = (mark.radius_px + 0.5 - dx.abs().max(dy.abs())).clamp(0.0, 1.0);
                        (arm * end, false)
                    }
                };
                let colour = if dark { mark.colour.map(|byte| byte / 2) } else { mark.colour };
                blend(image, x, y, colour, cover);
            }
        }
    }
}

/// Mixes `colour` into one pixel; `cover` 0 leaves it, 1 replaces it.
fn blend(image: &mut Image, x: usize, y: usize, colour: [u8; 3], cover: f32) {
    let start = (y * image.width_px() + x) * 3;
    for (byte, new) in image.pixels_mut()[start..start + 3].iter_mut().zip(colour) {
        let old = f32::from(*byte);
        *byte = (old + (f32::from(new) - old) * cover).round() as u8;
    }
}
