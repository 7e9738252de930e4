//! The numbers of faces as tables with units, which snapshots hold and compare. Tolerances are what rounding may do on
//! another machine; what is solved or trained differs by more, and says so in its golden file.

use super::{Attachment, Curves, Features, Image, MarkerNoise, Markers, Meshes, Rig, Views};
use glam::Vec3;
use wire::{Rows, Table, Tolerance};

/// A hundredth of a millimetre: a tenth of what a marker shakes.
const POSITION_MM: Tolerance = Tolerance::absolute(0.01);
/// A thousandth of the way from neutral to a full shape.
const WEIGHT: Tolerance = Tolerance::absolute(1e-3);
/// Cells along each side of the raster to which pictures are reduced.
const RASTER: usize = 24;

/// A coordinate of a point in millimetres.
fn axis_mm(point: Vec3, axis: usize) -> f64 {
    f64::from(point[axis]) * 1000.0
}

/// `chin x`, `chin y`, `chin z` for each name.
fn with_axes<'a>(names: impl Iterator<Item = &'a str>) -> Vec<String> {
    names.flat_map(|name| ["x", "y", "z"].map(|axis| format!("{name} {axis}"))).collect()
}

pub(super) fn markers(markers: &Markers) -> Vec<Table<'_>> {
    vec![Table {
        what: "positions",
        unit: "mm",
        tolerance: POSITION_MM,
        rows: Rows::Frames(markers.frame_axis()),
        columns: with_axes(markers.names().iter().map(String::as_str)),
        number: Box::new(|frame, column| axis_mm(markers.frame(frame)[column / 3], column % 3)),
    }]
}

/// The unit that a channel's name ends in; empty for weights.
fn unit_of(channel: &str) -> &'static str {
    ["mm", "deg", "px", "hz"]
        .into_iter()
        .find(|unit| channel.strip_suffix(unit).is_some_and(|rest| rest.ends_with('_')))
        .unwrap_or("")
}

pub(super) fn curves(curves: &Curves) -> Vec<Table<'_>> {
    let kinds = [
        ("weights", "", WEIGHT),
        ("distances", "mm", POSITION_MM),
        ("angles", "deg", Tolerance::absolute(0.01)),
        ("distances on pictures", "px", Tolerance::absolute(0.01)),
        ("rates", "hz", Tolerance::relative(1e-3)),
    ];
    let table = |(what, unit, tolerance)| {
        let columns: Vec<usize> =
            (0..curves.channels().len()).filter(|at| unit_of(&curves.channels()[*at]) == unit).collect();
        let names: Vec<String> = columns.iter().map(|at| curves.channels()[*at].clone()).collect();
        let number = Box::new(move |frame: usize, column: usize| f64::from(curves.frame(frame)[columns[column]]));
        Table { what, unit, tolerance, rows: Rows::Frames(curves.frame_axis()), columns: names, number }
    };
    kinds.into_iter().map(table).filter(|table| !table.columns.is_empty()).collect()
}

pub(super) fn meshes(meshes: &Meshes) -> Vec<Table<'_>> {
    let names: Vec<String> = (0..meshes.vertices()).map(|vertex| format!("vertex {vertex}")).collect();
    vec![Table {
        what: "positions",
        unit: "mm",
        tolerance: POSITION_MM,
        rows: Rows::Frames(meshes.frame_axis()),
        columns: with_axes(names.iter().map(String::as_str)),
        number: Box::new(|frame, column| axis_mm(meshes.frame(frame)[column / 3], column % 3)),
    }]
}

pub(super) fn rig(rig: &Rig) -> Vec<Table<'_>> {
    let shapes: Vec<String> = rig.shapes.iter().map(|shape| shape.name.clone()).collect();
    let measures = ["largest", "mean", "vertices"].map(str::to_owned).to_vec();
    let mut tables = vec![
        Table {
            what: "neutral",
            unit: "mm",
            tolerance: POSITION_MM,
            rows: Rows::Counted("vertex", rig.neutral.len()),
            columns: ["x", "y", "z"].map(str::to_owned).to_vec(),
            number: Box::new(|vertex, axis| axis_mm(rig.neutral[vertex], axis)),
        },
        Table {
            what: "shapes",
            unit: "mm",
            tolerance: POSITION_MM,
            rows: Rows::Named("shape", shapes),
            columns: measures,
            number: Box::new(|shape, measure| {
                let deltas = &rig.shapes[shape].deltas;
                let lengths = deltas.iter().map(|delta| f64::from(delta.length()) * 1000.0);
                match measure {
                    0 => lengths.fold(0.0, f64::max),
                    1 => lengths.sum::<f64>() / deltas.len().max(1) as f64,
                    _ => deltas.len() as f64,
                }
            }),
        },
    ];
    if let Some(jaw) = &rig.jaw {
        tables.push(Table {
            what: "jaw",
            unit: "",
            tolerance: WEIGHT,
            rows: Rows::Counted("vertex", jaw.weights.len()),
            columns: vec!["share".to_owned()],
            number: Box::new(|vertex, _| f64::from(jaw.weights[vertex])),
        });
    }
    tables
}

/// A picture is reduced to the mean colours of a raster of cells: an edge that moves by a part of a pixel is no difference.
pub(super) fn image(image: &Image) -> Vec<Table<'_>> {
    let (width, height) = (image.width_px(), image.height_px());
    let (across, down) = (RASTER.min(width), RASTER.min(height));
    let colours = ["red", "green", "blue"];
    let size = Table {
        what: "size",
        unit: "px",
        tolerance: Tolerance::absolute(0.0),
        rows: Rows::Counted("picture", 1),
        columns: vec!["width".to_owned(), "height".to_owned()],
        number: Box::new(move |_, side| if side == 0 { width as f64 } else { height as f64 }),
    };
    let raster = Table {
        what: "raster",
        unit: "levels of 255",
        tolerance: Tolerance::absolute(2.0),
        rows: Rows::Counted("row", down),
        columns: (0..across).flat_map(|column| colours.map(|colour| format!("{column} {colour}"))).collect(),
        number: Box::new(move |row, column| {
            let (cell, channel) = (column / 3, column % 3);
            let (xs, ys) =
                (cell * width / across..(cell + 1) * width / across, row * height / down..(row + 1) * height / down);
            let count = (xs.len() * ys.len()).max(1) as f64;
            let level = |x: usize, y: usize| u64::from(image.pixels()[(y * width + x) * 3 + channel]);
            let sum: u64 = ys.map(|y| xs.clone().map(|x| level(x, y)).sum::<u64>()).sum();
            sum as f64 / count
        }),
    };
    vec![size, raster]
}

pub(super) fn features(features: &Features) -> Vec<Table<'_>> {
    let places: Vec<(usize, usize)> = features
        .regions()
        .iter()
        .enumerate()
        .flat_map(|(region, all)| (0..all.width).map(move |at| (region, at)))
        .collect();
    let columns = places.iter().map(|(region, at)| format!("{} {at}", features.regions()[*region].region)).collect();
    vec![Table {
        what: "features",
        unit: "",
        tolerance: Tolerance::absolute(1e-4),
        rows: Rows::Frames(features.frame_axis()),
        columns,
        number: Box::new(move |frame, column| {
            let (region, at) = places[column];
            let region = &features.regions()[region];
            f64::from(region.values[frame * region.width + at])
        }),
    }]
}

pub(super) fn views(views: &Views) -> Vec<Table<'_>> {
    let seen = views
        .cameras()
        .iter()
        .flat_map(|camera| views.markers().iter().map(move |marker| format!("{camera} {marker}")));
    let width = views.cameras().len() * views.markers().len();
    vec![Table {
        what: "points",
        unit: "px",
        tolerance: Tolerance::absolute(0.01),
        rows: Rows::Frames(views.frame_axis()),
        columns: seen.flat_map(|name| ["x", "y"].map(|axis| format!("{name} {axis}"))).collect(),
        number: Box::new(move |frame, column| f64::from(views.points_px()[frame * width + column / 2][column % 2])),
    }]
}

pub(super) fn noise(noise: &MarkerNoise) -> Vec<Table<'_>> {
    vec![Table {
        what: "noise",
        unit: "mm",
        tolerance: Tolerance::absolute(1e-3),
        rows: Rows::Named("marker", noise.markers().iter().map(|one| one.marker.clone()).collect()),
        columns: vec!["sigma".to_owned()],
        number: Box::new(|marker, _| noise.markers()[marker].sigma_mm),
    }]
}

pub(super) fn attachment(attachment: &Attachment) -> Vec<Table<'_>> {
    let rows = || Rows::Named("marker", attachment.names());
    let corners = || ["a", "b", "c"].map(str::to_owned).to_vec();
    vec![
        Table {
            what: "vertices",
            unit: "",
            tolerance: Tolerance::absolute(0.0),
            rows: rows(),
            columns: corners(),
            number: Box::new(|marker, corner| f64::from(attachment.points[marker].vertices[corner])),
        },
        Table {
            what: "weights",
            unit: "",
            tolerance: WEIGHT,
            rows: rows(),
            columns: corners(),
            number: Box::new(|marker, corner| f64::from(attachment.points[marker].weights[corner])),
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use wire::{FrameAxis, Value};

    #[test]
    fn positions_are_millimetres_by_marker_and_axis() {
        let axis = FrameAxis { first: 7, count: 2, rate_hz: 60.0 };
        let points = vec![Vec3::ZERO, Vec3::new(0.001, 0.002, 0.003), Vec3::NAN, Vec3::X];
        let markers = Markers::new(axis, vec!["a".into(), "b".into()], points).unwrap();
        let table = &markers.tables()[0];
        assert_eq!(table.columns[5], "b z");
        assert!(((table.number)(0, 5) - 3.0).abs() < 1e-6 && (table.number)(1, 0).is_nan());
        assert_eq!((table.rows.name(1).as_str(), table.unit), ("frame 8", "mm"));
    }

    #[test]
    fn channels_are_told_apart_by_their_units() {
        let axis = FrameAxis::new(1, 60.0);
        let curves =
            Curves::new(axis, vec!["jawOpen".into(), "rms_mm".into(), "yaw_deg".into()], vec![0.5, 2.0, 9.0]).unwrap();
        let found: Vec<_> = curves.tables().iter().map(|table| (table.unit, (table.number)(0, 0))).collect();
        assert_eq!(found, [("", 0.5), ("mm", 2.0), ("deg", 9.0)]);
    }

    #[test]
    fn pictures_are_reduced_to_means() {
        let mut image = Image::filled(48, 48, [10, 20, 30]);
        image.pixels_mut()[0] = 50;
        let tables = image.tables();
        assert_eq!(((tables[0].number)(0, 0), (tables[1].number)(0, 0), (tables[1].number)(5, 4)), (48.0, 20.0, 20.0));
        assert_eq!((tables[1].rows.count(), tables[1].columns.len()), (24, 72));
    }
}
