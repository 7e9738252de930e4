//! Pictures: the worst frames, rendered with the captured markers, and what the graph drew: contact sheets, and how far meshes are
//! off, truth beside result.

use crate::ReportError;
use crate::errors::{ALL, TakeError, best};
use crate::html::Section;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use face_math::data::{Attachment, Curves, Image, Markers, Rig};
use face_math::render::{Camera, Mark, Style, draw_marks, render_rig};
use face_math::solve::worst_frames;
use graph_core::cook::Engine;
use nodes::save::scene::{Scene, moved};
use plot::escaped;
use std::fmt::Write;
use std::sync::Arc;
use wire::Value;

/// Takes whose worst frames are drawn, those with the largest errors.
const TAKES: usize = 8;
/// Frames of each.
const FRAMES: usize = 3;
/// Turns of the camera, in degrees: from the front and from the side.
const YAWS_DEG: [f32; 2] = [0.0, 35.0];
/// Width and height of a picture, and how large it is shown: three frames from two sides beside each other, sharp on fine screens.
const SIZE_PX: usize = 270;
const SHOWN_PX: usize = 180;
/// Contact sheets that are shown, and how wide they are at most.
const SHEETS: usize = 6;
const SHEET_PX: usize = 1100;

/// A picture within the page.
fn embedded(image: &Image, width: usize, alt: &str) -> Result<String, ReportError> {
    let bytes = face_io::png::write(image)?;
    let height = image.height_px() * width / image.width_px().max(1);
    Ok(format!(
        "<img src=\"data:image/png;base64,{}\" width=\"{width}\" height=\"{height}\" alt=\"{}\">",
        STANDARD.encode(bytes),
        escaped(alt)
    ))
}

/// The worst frames of the best solve of each take.
pub(crate) fn worst(engine: &mut Engine, errors: &[TakeError]) -> Result<Option<Section>, ReportError> {
    let mut takes = best(errors);
    takes.sort_by(|a, b| b.mean_mm.total_cmp(&a.mean_mm));
    takes.truncate(TAKES);
    if takes.is_empty() {
        return Ok(None);
    }
    let mut body = String::from(
        "<p>The frames of the largest errors, of the best solve of each take: the solved puppet, its markers as red crosses, \
         the captured ones as green dots.</p>\n",
    );
    for take in takes {
        let title = if take.take.is_empty() { take.name.clone() } else { format!("{} ({})", take.take, take.name) };
        let _ = writeln!(body, "<h3>{}</h3>\n<div class=\"row\">", escaped(&title));
        body += &drawn(engine, take)?;
        body += "</div>\n";
    }
    Ok(Some(Section { id: "worst", title: "Worst frames", body }))
}

fn one<T: Value>(engine: &mut Engine, cell: usize, port: &str) -> Result<Option<Arc<T>>, ReportError> {
    let found = engine.input(cell, port)?.into_iter().next();
    Ok(found.and_then(|(_, value)| value.downcast_arc::<T>()))
}

fn drawn(engine: &mut Engine, take: &TakeError) -> Result<String, ReportError> {
    let rig = one::<Rig>(engine, take.cell, "rig")?;
    let curves = one::<Curves>(engine, take.cell, "curves")?;
    let markers = one::<Markers>(engine, take.cell, "markers")?;
    let attachment = one::<Attachment>(engine, take.cell, "attachment")?;
    let (Some(rig), Some(curves)) = (rig, curves) else { return Ok(String::new()) };
    let failed = |problem: String| ReportError::Frame { node: take.name.clone(), problem };
    let scene = Scene::new(&rig, &curves, markers.as_deref(), attachment.as_deref())
        .map_err(|error| failed(error.to_string()))?;
    let camera = Camera::framing(&moved(&rig));
    let style = Style::sized(SIZE_PX, SIZE_PX);
    let mut out = String::new();
    for (position, error_mm) in worst_frames(&take.curves, ALL, FRAMES) {
        let pose = scene.pose(position).map_err(|error| failed(error.to_string()))?;
        out += "<figure><div class=\"row\">";
        for yaw_deg in YAWS_DEG {
            let camera = camera.turned(yaw_deg.to_radians(), 0.0);
            let mut image =
                render_rig(&rig, &pose.vertices, &camera, &style).map_err(|error| failed(error.to_string()))?;
            draw_marks(&mut image, &camera, pose.captured, &Mark::CAPTURED);
            draw_marks(&mut image, &camera, &pose.own, &Mark::PUPPET);
            out += &embedded(
                &image,
                SHOWN_PX,
                &format!("{}, frame {}, from {yaw_deg:.0} degrees", take.name, pose.frame),
            )?;
        }
        let _ = writeln!(out, "</div><figcaption>frame {}: {error_mm:.2} mm</figcaption></figure>", pose.frame);
    }
    Ok(out)
}

/// The contact sheets that the graph drew.
pub(crate) fn sheets(engine: &mut Engine) -> Result<Option<Section>, ReportError> {
    Ok(drawn_by(engine, "render_faces")?.map(|body| Section { id: "sheets", title: "Contact sheets", body }))
}

/// The meshes that the graph drew beside those that they should be, with their distance in colours.
pub(crate) fn meshes(engine: &mut Engine) -> Result<Option<Section>, ReportError> {
    Ok(drawn_by(engine, "render_errors")?.map(|body| Section { id: "meshes", title: "Where meshes are off", body }))
}

/// The pictures of the cells of one kind; `None` where there are none.
fn drawn_by(engine: &mut Engine, kind: &str) -> Result<Option<String>, ReportError> {
    let drawn: Vec<(usize, String, &'static str)> = engine
        .cells()
        .into_iter()
        .filter(|cell| cell.kind == kind && cell.failed.is_none())
        .filter_map(|cell| Some((cell.id, cell.name.to_owned(), cell.outputs.first()?.0)))
        .collect();
    if drawn.is_empty() {
        return Ok(None);
    }
    let mut body = String::new();
    if drawn.len() > SHEETS {
        let _ = writeln!(body, "<p class=\"quiet\">The first {SHEETS} of {}.</p>", drawn.len());
    }
    for (cell, name, port) in drawn.into_iter().take(SHEETS) {
        let value = engine.value(cell, port, "")?;
        let Some(image) = value.downcast_ref::<Image>() else { continue };
        let small = reduced(image);
        let picture = embedded(&small, small.width_px(), &format!("picture of {name}"))?;
        let _ = writeln!(body, "<figure>{picture}<figcaption>{}</figcaption></figure>", escaped(&name));
    }
    Ok(Some(body))
}

/// The picture, reduced by a whole factor to what a page can show.
fn reduced(image: &Image) -> Image {
    let factor = image.width_px().div_ceil(SHEET_PX).max(1);
    let (width, height) = (image.width_px() / factor, image.height_px() / factor);
    let mut small = Image::filled(width, height, [0; 3]);
    let count = (factor * factor) as u32;
    for (at, level) in small.pixels_mut().iter_mut().enumerate() {
        let (x, y, channel) = (at / 3 % width * factor, at / 3 / width * factor, at % 3);
        let rows = (y..y + factor).flat_map(|y| (x..x + factor).map(move |x| (y * image.width_px() + x) * 3 + channel));
        let sum: u32 = rows.map(|place| u32::from(image.pixels()[place])).sum();
        *level = ((sum + count / 2) / count) as u8;
    }
    small
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wide_sheets_are_reduced_and_small_ones_stay() {
        let wide = reduced(&Image::filled(2400, 30, [9, 90, 200]));
        assert_eq!((wide.width_px(), wide.height_px(), &wide.pixels()[..3]), (800, 10, &[9, 90, 200][..]));
        let small = Image::filled(64, 64, [1, 2, 3]);
        assert_eq!(reduced(&small), small);
    }
}
