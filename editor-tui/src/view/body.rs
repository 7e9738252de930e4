//! Bodies in space: faces shaded in half blocks, points as dots.

use super::chart::Dots;
use super::theme::Theme;
use crate::preview::{Body, Preview};
use face_math::data::Image;
use glam::{Mat3, Vec3};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Color, Style};

/// How a body is looked at: its middle, its size, and how it is turned.
struct Camera {
    middle: Vec3,
    scale: f32,
    turn: Mat3,
    centre: (f32, f32),
}

impl Camera {
    fn of(body: &Body, preview: &Preview, width: f32, height: f32) -> Option<Self> {
        // The first frame sets the middle, so that nothing jumps while one scrubs.
        let points = body.frames.iter().find(|frame| frame.iter().any(|point| point.is_finite()))?;
        let finite = || points.iter().copied().filter(|point| point.is_finite());
        let (low, high) = finite().fold((Vec3::MAX, Vec3::MIN), |(low, high), point| (low.min(point), high.max(point)));
        let extent = (high - low).max_element().max(1e-6);
        Some(Self {
            middle: (low + high) / 2.0,
            scale: width.min(height) * 0.92 / extent * preview.zoom,
            turn: Mat3::from_rotation_x(preview.pitch_rad) * Mat3::from_rotation_y(-preview.yaw_rad),
            centre: (width / 2.0, height / 2.0),
        })
    }

    /// Column, row and nearness of a point.
    fn see(&self, point: Vec3) -> Vec3 {
        let p = self.turn * (point - self.middle);
        Vec3::new(self.centre.0 + p.x * self.scale, self.centre.1 - p.y * self.scale, p.z)
    }
}

/// Draws a body.
pub fn draw(body: &Body, preview: &Preview, theme: Theme, area: Rect, buffer: &mut Buffer) {
    let Some(points) = body.frames.get(preview.frame) else { return };
    if body.triangles.is_empty() {
        let mut dots = Dots::new(area);
        let (width, height) = dots.size();
        let Some(camera) = Camera::of(body, preview, width as f32, height as f32) else { return };
        for (at, point) in points.iter().enumerate().filter(|(_, point)| point.is_finite()) {
            let seen = camera.see(*point);
            let chosen = at == preview.row;
            let colour = if chosen { theme.accent().fg.unwrap_or(Color::Reset) } else { theme.of_type("Markers") };
            let (x, y) = (seen.x.round() as i32, seen.y.round() as i32);
            let reach = i32::from(chosen);
            for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1), (-reach, 0), (0, -reach)] {
                dots.set(x + dx, y + dy, colour);
            }
        }
        dots.draw(buffer);
        return;
    }
    let (width, height) = (usize::from(area.width), usize::from(area.height) * 2);
    let Some(camera) = Camera::of(body, preview, width as f32, height as f32) else { return };
    let mut shades = vec![f32::NAN; width * height];
    let mut near = vec![f32::NEG_INFINITY; width * height];
    let seen: Vec<Vec3> = points.iter().map(|point| camera.see(*point)).collect();
    let light = Vec3::new(0.35, 0.5, 0.8).normalize();
    for triangle in &body.triangles {
        let [Some(a), Some(b), Some(c)] = triangle.map(|corner| seen.get(corner as usize).copied()) else { continue };
        // Rows count downwards, so the sense of the corners is turned once more.
        let flat = |v: Vec3| Vec3::new(v.x / camera.scale, -v.y / camera.scale, v.z);
        let normal = (flat(b) - flat(a)).cross(flat(c) - flat(a)).normalize_or_zero();
        if normal.z <= 0.0 {
            continue;
        }
        let shade = 0.18 + 0.82 * normal.dot(light).max(0.0);
        let area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        if area.abs() < 1e-9 {
            continue;
        }
        let columns =
            a.x.min(b.x).min(c.x).max(0.0) as usize..(a.x.max(b.x).max(c.x).ceil().max(0.0) as usize + 1).min(width);
        let rows =
            a.y.min(b.y).min(c.y).max(0.0) as usize..(a.y.max(b.y).max(c.y).ceil().max(0.0) as usize + 1).min(height);
        for y in rows {
            for x in columns.clone() {
                let (px, py) = (x as f32 + 0.5, y as f32 + 0.5);
                let v = ((px - a.x) * (c.y - a.y) - (py - a.y) * (c.x - a.x)) / area;
                let w = ((b.x - a.x) * (py - a.y) - (b.y - a.y) * (px - a.x)) / area;
                if v < 0.0 || w < 0.0 || v + w > 1.0 {
                    continue;
                }
                let depth = a.z + v * (b.z - a.z) + w * (c.z - a.z);
                let at = y * width + x;
                if depth > near[at] {
                    (near[at], shades[at]) = (depth, shade);
                }
            }
        }
    }
    half_blocks(area, buffer, |x, y| {
        let shade = shades[y * width + x];
        let part = |full: f32| (full * shade) as u8;
        shade.is_finite().then(|| theme.rgb(part(222.0), part(205.0), part(196.0)))
    });
}

/// Draws an image as large as it fits.
pub fn image(image: &Image, theme: Theme, area: Rect, buffer: &mut Buffer) {
    let (width, height) = (image.width_px().max(1), image.height_px().max(1));
    let (room_x, room_y) = (usize::from(area.width), usize::from(area.height) * 2);
    let scale = (room_x as f64 / width as f64).min(room_y as f64 / height as f64);
    let (shown_x, shown_y) = ((width as f64 * scale) as usize, (height as f64 * scale) as usize);
    let left = (room_x - shown_x.min(room_x)) / 2;
    half_blocks(area, buffer, |x, y| {
        let x = x.checked_sub(left)?;
        if x >= shown_x || y >= shown_y {
            return None;
        }
        // The mean of what falls on the spot, a few pixels of it.
        let mut sum = [0_u32; 3];
        for part in 0..9 {
            let px = ((x as f64 + (f64::from(part % 3) + 0.5) / 3.0) / scale) as usize;
            let py = ((y as f64 + (f64::from(part / 3) + 0.5) / 3.0) / scale) as usize;
            let at = (py.min(height - 1) * width + px.min(width - 1)) * 3;
            let pixel = image.pixels().get(at..at + 3)?;
            sum.iter_mut().zip(pixel).for_each(|(sum, part)| *sum += u32::from(*part));
        }
        let [r, g, b] = sum.map(|sum| (sum / 9) as u8);
        Some(theme.rgb(r, g, b))
    });
}

/// Two spots a cell, one above the other.
fn half_blocks(area: Rect, buffer: &mut Buffer, colour: impl Fn(usize, usize) -> Option<Color>) {
    for row in 0..area.height {
        for column in 0..area.width {
            let at = |half: u16| colour(usize::from(column), usize::from(row * 2 + half));
            let (sign, style) = match (at(0), at(1)) {
                (None, None) => continue,
                (Some(upper), None) => ('▀', Style::new().fg(upper)),
                (None, Some(lower)) => ('▄', Style::new().fg(lower)),
                (Some(upper), Some(lower)) => ('▀', Style::new().fg(upper).bg(lower)),
            };
            buffer[(area.x + column, area.y + row)].set_char(sign).set_style(style);
        }
    }
}
