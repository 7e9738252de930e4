//! Errors of solves over time: what `marker_error` measured, take by take and region by region, and `mesh_error` vertex by vertex.

use crate::ReportError;
use crate::html::{Section, figure};
use face_math::data::Curves;
use graph_core::cook::Engine;
use plot::{Ink, Line, Plot};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::Arc;

/// Plots that are drawn, of the takes with the largest errors.
const DRAWN: usize = 24;
/// Points of a line, which is what a plot can show.
const POINTS: usize = 900;
/// The channel of all markers or vertices.
pub(crate) const ALL: &str = "rms_mm";

const MARKERS: &str = "markers";

/// The errors of one solve of one take.
pub(crate) struct TakeError {
    /// The cell that measured them.
    pub cell: usize,
    /// Its name.
    pub name: String,
    /// The take; empty outside of lists.
    pub take: String,
    /// Of what: markers or vertices.
    pub of: &'static str,
    /// Millimetres, by frame: all markers or vertices, the worst, and each region of markers.
    pub curves: Arc<Curves>,
    /// Mean over the frames of the root mean square over all of them, in millimetres.
    pub mean_mm: f64,
}

/// All errors that the graph measured.
pub(crate) fn find(engine: &mut Engine) -> Result<Vec<TakeError>, ReportError> {
    let of = |kind: &str| match kind {
        "marker_error" => Some(MARKERS),
        "mesh_error" => Some("vertices"),
        _ => None,
    };
    let measured: Vec<(usize, String, String, &'static str)> = engine
        .cells()
        .into_iter()
        .filter(|cell| cell.failed.is_none())
        .filter_map(|cell| Some((cell.id, cell.name.to_owned(), cell.items.join("/"), of(cell.kind)?)))
        .collect();
    let mut found = Vec::new();
    for (cell, name, take, of) in measured {
        let Some(curves) = engine.value(cell, "error", "")?.downcast_arc::<Curves>() else { continue };
        let mean_mm = mean(&curves).unwrap_or(f64::NAN);
        found.push(TakeError { cell, name, take, of, curves, mean_mm });
    }
    Ok(found)
}

fn mean(curves: &Curves) -> Option<f64> {
    let column = curves.index(ALL)?;
    let seen =
        (0..curves.frames()).map(|frame| f64::from(curves.frame(frame)[column])).filter(|error| error.is_finite());
    let (sum, count) = seen.fold((0.0, 0_usize), |(sum, count), error| (sum + error, count + 1));
    (count > 0).then(|| sum / count as f64)
}

/// The best solve of each take by its markers: that of the least mean error.
pub(crate) fn best(errors: &[TakeError]) -> Vec<&TakeError> {
    let mut best: BTreeMap<&str, &TakeError> = BTreeMap::new();
    for error in errors.iter().filter(|error| error.of == MARKERS && error.mean_mm.is_finite()) {
        let known = best.entry(&error.take).or_insert(error);
        if error.mean_mm < known.mean_mm {
            *known = error;
        }
    }
    best.into_values().collect()
}

/// The section that shows them.
pub(crate) fn over_time(errors: &[TakeError]) -> Option<Section> {
    let mut shown: Vec<&TakeError> = errors.iter().filter(|error| error.mean_mm.is_finite()).collect();
    if shown.is_empty() {
        return None;
    }
    let all = shown.len();
    shown.sort_by(|a, b| b.mean_mm.total_cmp(&a.mean_mm));
    shown.truncate(DRAWN);
    shown.sort_by(|a, b| (&a.take, &a.name).cmp(&(&b.take, &b.name)));
    let mut body = String::from(
        "<p>Distance between the puppet's markers and the captured ones, root mean square over the markers of each region; or \
         between the vertices of meshes and where they should be.</p>\n",
    );
    if all > shown.len() {
        let _ = writeln!(body, "<p class=\"quiet\">The {} of {all} with the largest errors.</p>", shown.len());
    }
    body += "<div class=\"row\">\n";
    for error in shown {
        let drawn = plot::draw(&plot_of(error), &Ink::PAGE);
        body += &figure(&drawn, &format!("{}: mean {}", error.name, told(error.mean_mm)));
    }
    Some(Section { id: "errors", title: "Errors over time", body: body + "</div>\n" })
}

/// A distance for people: hundredths of a millimetre, or, below one, of a micrometre.
fn told(error_mm: f64) -> String {
    if error_mm < 0.01 { format!("{:.2} µm", 1000.0 * error_mm) } else { format!("{error_mm:.2} mm") }
}

fn plot_of(error: &TakeError) -> Plot {
    let curves = &error.curves;
    let axis = curves.frame_axis();
    let every = curves.frames().div_ceil(POINTS).max(1);
    let line = |(column, channel): (usize, &String)| {
        // The largest of the frames that fall on one point, so that no peak is lost.
        let point = |first: usize| {
            let frames = first..(first + every).min(curves.frames());
            let most = frames.map(|frame| f64::from(curves.frame(frame)[column])).fold(f64::NAN, f64::max);
            ((axis.first + first as i64) as f64, most)
        };
        let name =
            if channel == ALL { format!("all {}", error.of) } else { channel.trim_end_matches("_mm").to_owned() };
        Line { name, points: (0..curves.frames()).step_by(every).map(point).collect(), dots: false }
    };
    let channels = curves.channels().iter().enumerate().filter(|(_, channel)| *channel != "worst_mm");
    let (width_px, height_px) = (560.0, 320.0);
    Plot {
        title: error.name.clone(),
        x_label: "frame".to_owned(),
        y_label: "error (mm)".to_owned(),
        from_zero: true,
        width_px,
        height_px,
        lines: channels.map(line).collect(),
    }
}
