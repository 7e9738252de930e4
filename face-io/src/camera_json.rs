//! Calibrated cameras in JSON, as `OpenCV`'s conventions have them.
//!
//! ```text
//! { "cameras": [ { "name": "cam0", "width": 2048, "height": 1536,
//!                  "K": [[fx, 0, cx], [0, fy, cy], [0, 0, 1]],
//!                  "R": [[…], […], […]], "t_mm": [tx, ty, tz], "dist_k1k2p1p2": [k1, k2, p1, p2] } ] }
//! ```
//!
//! `x_cam = R x_world + t`, z forward, y down. The unit of t stands in its key (`t_mm`, `t_cm`, `t_m`). Distortion is
//! `dist_k1k2p1p2`, `dist_k1k2p1p2k3` or, in `OpenCV`'s order, `dist` with 4 or 5 numbers; none is a perfect lens. Matrices
//! may also be written as `OpenCV`'s `FileStorage` does (`{"type_id": "opencv-matrix", "rows": 3, "cols": 3, "data": […]}`),
//! under its names `camera_matrix`, `distortion_coefficients`, `image_width` and `image_height`.

use crate::{LengthUnit, ReadError};
use face_math::data::{CalibratedCamera, Cameras};
use glam::{DMat3, DVec3};
use serde_json::{Map, Value};

/// Why JSON holds no cameras.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CamerasError {
    /// No JSON.
    #[error("{line}:{column}: {problem}")]
    Json {
        /// The line, from 1.
        line: usize,
        /// The column, from 1.
        column: usize,
        /// What is wrong.
        problem: String,
    },
    /// No list of cameras.
    #[error("there is no list `cameras` with at least one camera in it")]
    NoCameras,
    /// Something is missing or wrong in a camera.
    #[error("camera {place}{}: {problem}", name.as_ref().map(|name| format!(" (`{name}`)")).unwrap_or_default())]
    Camera {
        /// Its place in the list, from 0.
        place: usize,
        /// Its name, where it has one.
        name: Option<String>,
        /// What is wrong, and what would be right.
        problem: String,
    },
}

/// Reads calibrated cameras.
///
/// # Errors
/// See [`CamerasError`]; and where the numbers make no camera.
pub fn read(bytes: &[u8]) -> Result<Cameras, ReadError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let file: Value = serde_json::from_slice(bytes).map_err(|error| {
        let text = error.to_string();
        let problem = text.rsplit_once(" at line ").map_or(text.as_str(), |(problem, _)| problem).to_owned();
        CamerasError::Json { line: error.line(), column: error.column(), problem }
    })?;
    let list = file.get("cameras").and_then(Value::as_array).filter(|list| !list.is_empty());
    let list = list.ok_or(CamerasError::NoCameras)?;
    let mut cameras = Vec::with_capacity(list.len());
    for (place, entry) in list.iter().enumerate() {
        let name = entry.get("name").and_then(Value::as_str).map(str::to_owned);
        let wrong = |problem| CamerasError::Camera { place, name: name.clone(), problem };
        let fields = entry.as_object().ok_or_else(|| wrong("it is no object in braces".to_owned()))?;
        cameras.push(camera(&Fields(fields)).map_err(wrong)?);
    }
    Ok(Cameras::new(cameras)?)
}

/// Whether bytes are JSON with a list of cameras.
pub(crate) fn detect(bytes: &[u8]) -> bool {
    serde_json::from_slice::<Value>(bytes).is_ok_and(|file| file.get("cameras").is_some_and(Value::is_array))
}

/// The fields of a camera, each under one of several names.
struct Fields<'a>(&'a Map<String, Value>);

impl<'a> Fields<'a> {
    fn may_find(&self, keys: &[&'static str]) -> Result<Option<(&'static str, &'a Value)>, String> {
        let mut found = keys.iter().filter_map(|key| Some((*key, self.0.get(*key)?)));
        match (found.next(), found.next()) {
            (Some((first, _)), Some((second, _))) => Err(format!("`{first}` and `{second}` say the same; keep one")),
            (first, _) => Ok(first),
        }
    }

    fn find(&self, keys: &[&'static str]) -> Result<(&'static str, &'a Value), String> {
        self.may_find(keys)?.ok_or_else(|| format!("it has no `{}`", keys.join("` or `")))
    }

    fn size(&self, keys: &[&'static str]) -> Result<u32, String> {
        let (key, value) = self.find(keys)?;
        let size = value.as_u64().and_then(|size| u32::try_from(size).ok()).filter(|size| *size > 0);
        size.ok_or_else(|| format!("`{key}` is no number of pixels"))
    }

    /// A matrix of the given numbers of entries, row after row.
    fn numbers(&self, keys: &[&'static str], counts: &[usize]) -> Result<(&'static str, Vec<f64>), String> {
        let (key, value) = self.find(keys)?;
        let numbers = flat(value).filter(|numbers| counts.contains(&numbers.len()));
        let counts: Vec<_> = counts.iter().map(usize::to_string).collect();
        Ok((key, numbers.ok_or_else(|| format!("`{key}` is no list of {} numbers", counts.join(" or ")))?))
    }
}

/// The numbers of a list, of a list of lists, or of an `OpenCV` matrix.
fn flat(value: &Value) -> Option<Vec<f64>> {
    if let Some(data) = value.get("data") {
        let side = |key| usize::try_from(value.get(key)?.as_u64()?).ok();
        return flat(data).filter(|numbers| side("rows").zip(side("cols")).is_none_or(|(r, c)| r * c == numbers.len()));
    }
    let mut numbers = Vec::new();
    for entry in value.as_array()? {
        match entry.as_array() {
            Some(row) => numbers.extend(row.iter().map(Value::as_f64).collect::<Option<Vec<_>>>()?),
            None => numbers.push(entry.as_f64()?),
        }
    }
    Some(numbers)
}

fn camera(fields: &Fields<'_>) -> Result<CalibratedCamera, String> {
    let (_, name) = fields.find(&["name"])?;
    let name = name.as_str().filter(|name| !name.is_empty()).ok_or("`name` is no text")?.to_owned();
    let size_px = [fields.size(&["width", "image_width"])?, fields.size(&["height", "image_height"])?];
    let (key, k) = fields.numbers(&["K", "camera_matrix"], &[9])?;
    // Zero and one stand there as they are, in any calibration.
    let plain = [(1, 0.0), (3, 0.0), (6, 0.0), (7, 0.0), (8, 1.0)];
    if let Some((place, wanted)) = plain.iter().find(|(place, wanted)| (k[*place] - wanted).abs() > 1e-12) {
        return Err(format!(
            "`{key}` has {} in row {}, column {}, where {wanted} belongs: a camera without skew is read",
            k[*place],
            place / 3 + 1,
            place % 3 + 1
        ));
    }
    let (_, r) = fields.numbers(&["R"], &[9])?;
    let (key, t) = fields.numbers(&["t_mm", "t_cm", "t_m"], &[3])?;
    let unit = LengthUnit::from_text(key.trim_start_matches("t_")).ok_or("the key of t states no unit")?;
    let distortions = ["dist_k1k2p1p2", "dist_k1k2p1p2k3", "dist", "distortion_coefficients"];
    let distortion = match fields.may_find(&distortions)? {
        None => Vec::new(),
        Some(("dist_k1k2p1p2", _)) => fields.numbers(&["dist_k1k2p1p2"], &[4])?.1,
        Some(("dist_k1k2p1p2k3", _)) => fields.numbers(&["dist_k1k2p1p2k3"], &[5])?.1,
        Some((key, _)) => fields.numbers(&[key], &[4, 5])?.1,
    };
    let row = |row: usize| DVec3::new(r[3 * row], r[3 * row + 1], r[3 * row + 2]);
    Ok(CalibratedCamera {
        name,
        size_px,
        focal_px: [k[0], k[4]],
        centre_px: [k[2], k[5]],
        rotation: DMat3::from_cols(row(0), row(1), row(2)).transpose(),
        translation_m: DVec3::from_slice(&t) * unit.metres(),
        distortion: std::array::from_fn(|index| distortion.get(index).copied().unwrap_or_default()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAMERA: &str = r#"{"name": "a", "width": 640, "height": 480, "K": [[500, 0, 320], [0, 510, 240], [0, 0, 1]],
        "R": [[0, -1, 0], [1, 0, 0], [0, 0, 1]], "t_mm": [10, 20, 700], "dist_k1k2p1p2": [-0.1, 0.02, 0.001, -0.002]}"#;

    fn parse(cameras: &str) -> Result<Cameras, String> {
        read(format!("{{\"cameras\": [{cameras}]}}").as_bytes()).map_err(|error| error.to_string())
    }

    #[test]
    fn every_number_finds_its_place() {
        let cameras = parse(CAMERA).unwrap();
        let camera = &cameras.cameras()[0];
        assert_eq!((camera.name.as_str(), camera.size_px), ("a", [640, 480]));
        let numbers = [camera.focal_px, camera.centre_px].concat();
        assert_eq!(numbers.iter().map(|number| *number as i32).collect::<Vec<_>>(), [500, 510, 320, 240]);
        assert_eq!(camera.rotation * DVec3::X, DVec3::Y, "R stands row by row");
        assert!(camera.translation_m.abs_diff_eq(DVec3::new(0.01, 0.02, 0.7), 1e-12));
        let expected = [-0.1_f64, 0.02, 0.001, -0.002, 0.0];
        assert_eq!(camera.distortion.map(f64::to_bits), expected.map(f64::to_bits));
    }

    #[test]
    fn names_and_matrices_of_opencv_are_understood() {
        let matrix = |rows: usize, cols: usize, data: &str| {
            format!(r#"{{"type_id": "opencv-matrix", "rows": {rows}, "cols": {cols}, "dt": "d", "data": [{data}]}}"#)
        };
        let text = format!(
            r#"{{"name": "a", "image_width": 640, "image_height": 480, "camera_matrix": {}, "R": {}, "t_m": {},
                "distortion_coefficients": {}}}"#,
            matrix(3, 3, "500, 0, 320, 0, 510, 240, 0, 0, 1"),
            matrix(3, 3, "0, -1, 0, 1, 0, 0, 0, 0, 1"),
            matrix(3, 1, "0.01, 0.02, 0.7"),
            matrix(1, 5, "-0.1, 0.02, 0.001, -0.002, 0")
        );
        let (own, other) = (parse(&text).unwrap(), parse(CAMERA).unwrap());
        let (own, other) = (&own.cameras()[0], &other.cameras()[0]);
        assert_eq!((own.size_px, own.focal_px, own.centre_px), (other.size_px, other.focal_px, other.centre_px));
        assert_eq!(own.rotation, other.rotation);
        assert!(own.distortion.iter().zip(other.distortion).all(|(one, other)| (one - other).abs() < 1e-12));
        assert!(own.translation_m.abs_diff_eq(other.translation_m, 1e-12), "{own:?}");
    }

    #[test]
    fn mistakes_name_the_camera_and_the_key() {
        let changed = |from: &str, to: &str| {
            let text = CAMERA.replace(from, to);
            assert_ne!(text, CAMERA);
            parse(&text).unwrap_err()
        };
        assert!(changed("\"K\"", "\"k\"").contains("camera 0 (`a`): it has no `K` or `camera_matrix`"));
        assert!(changed("[500, 0,", "[500, 3,").contains("without skew"));
        assert!(changed("t_mm", "t").contains("`t_mm` or `t_cm` or `t_m`"));
        assert!(changed("[10, 20, 700]", "[10, 20]").contains("`t_mm` is no list of 3 numbers"));
        assert!(changed("-0.002]", "-0.002, 1]").contains("`dist_k1k2p1p2` is no list of 4 numbers"));
        assert!(changed("[0, -1, 0]", "[0, -2, 0]").contains("R is a rotation"));
        assert!(changed("640", "0").contains("`width`"));
        let twice = CAMERA.replace("\"t_mm\"", "\"dist\": [0, 0, 0, 0], \"t_mm\"");
        assert!(parse(&twice).unwrap_err().contains("say the same"));
        assert!(parse(&format!("{CAMERA},{CAMERA}")).unwrap_err().contains("stands twice"));
        assert!(read(b"{}").unwrap_err().to_string().contains("no list `cameras`"));
        assert!(read(b"{\"cameras\": [").unwrap_err().to_string().starts_with("cameras: 1:"));
    }
}
