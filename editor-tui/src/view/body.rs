//! Bodies in space: faces shaded, points as dots; in half blocks, or in pixels where the terminal draws them.

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
    let Some(shades) = shades(body, preview, width, height) else { return };
    half_blocks(area, buffer, |x, y| {
        let [r, g, b] = skin(shades[y * width + x])?;
        Some(theme.rgb(r, g, b))
    });
}

/// A body in pixels, `None` where it shows nothing there.
pub fn pixels(body: &Body, preview: &Preview, width: usize, height: usize) -> Option<Vec<Option<[u8; 3]>>> {
    if !body.triangles.is_empty() {
        return Some(shades(body, preview, width, height)?.into_iter().map(skin).collect());
    }
    let points = body.frames.get(preview.frame)?;
    let camera = Camera::of(body, preview, width as f32, height as f32)?;
    let mut out = vec![None; width * height];
    for (at, point) in points.iter().enumerate().filter(|(_, point)| point.is_finite()) {
        let seen = camera.see(*point);
        let (reach, colour) = if at == preview.row { (4, [137, 180, 250]) } else { (2, [249, 226, 175]) };
        let (x, y) = (seen.x.round() as i32, seen.y.round() as i32);
        for (dx, dy) in (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| (dx, dy))) {
            let (x, y) = (x + dx, y + dy);
            let inside = (0..width as i32).contains(&x) && (0..height as i32).contains(&y);
            if inside && dx * dx + dy * dy <= reach * reach {
                out[y as usize * width + x as usize] = Some(colour);
            }
        }
    }
    Some(out)
}

/// The colour of lit skin; none where there is none.
fn skin(shade: f32) -> Option<[u8; 3]> {
    shade.is_finite().then(|| [222.0, 205.0, 196.0].map(|full: f32| (full * shade) as u8))
}

/// How light faces are on each spot, not a number where there are none.
fn shades(body: &Body, preview: &Preview, width: usize, height: usize) -> Option<Vec<f32>> {
    let points = body.frames.get(preview.frame)?;
    let camera = Camera::of(body, preview, width as f32, height as f32)?;
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
    Some(shades)
}

/// Draws an image as large as it fits.
pub fn image(image: &Image, theme: Theme, area: Rect, buffer: &mut Buffer) {
    let (width, height) = (usize::from(area.width), usize::from(area.height) * 2);
    let fitted = fitted(image, width, height);
    half_blocks(area, buffer, |x, y| fitted[y * width + x].map(|[r, g, b]| theme.rgb(r, g, b)));
}

/// An image as large as it fits, in the middle; none where it does not reach.
pub fn fitted(image: &Image, room_x: usize, room_y: usize) -> Vec<Option<[u8; 3]>> {
    let (width, height) = (image.width_px().max(1), image.height_px().max(1));
    let scale = (room_x as f64 / width as f64).min(room_y as f64 / height as f64);
    let (shown_x, shown_y) = ((width as f64 * scale) as usize, (height as f64 * scale) as usize);
    let left = (room_x - shown_x.min(room_x)) / 2;
    let spot = |x: usize, y: usize| {
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
        Some(sum.map(|sum| (sum / 9) as u8))
    };
    (0..room_x * room_y).map(|at| spot(at % room_x.max(1), at / room_x.max(1))).collect()
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
