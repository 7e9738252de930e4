//! Neutral markers onto the neutral surface of a rig ("each marker is projected on the facial puppet", section 7 of
//! FDLS): the markers then move as the surface does.
//!
//! A head is not one surface. A marker at the edge of an eyelid lies a tenth of a millimetre off the lid *and* off the
//! eyeball behind it, one on the lips near the mouth's inside; noise would decide. So the part that most markers lie
//! nearest to is taken for the skin, and a marker leaves the skin only where another part is nearer by a clear margin,
//! as for pupils (millimetres before the lids) and markers on the skull.

use super::RigError;
use super::closest::{ClosestPoint, closest_on_triangle};
use crate::data::{Attachment, DataError, Markers, Part, Rig, SurfacePoint, nearest_name};
use glam::DVec3;

/// How to attach.
#[derive(Debug, Clone, PartialEq)]
pub struct AttachOptions {
    /// Parts that markers may sit on; all parts where empty.
    pub parts: Vec<String>,
    /// By how much another part must be nearer than the skin for a marker to leave the skin, in metres.
    pub skin_margin_m: f64,
    /// Markers farther from the surface than this are reported instead of attached, in metres.
    pub max_distance_m: f64,
}

impl Default for AttachOptions {
    fn default() -> Self {
        Self { parts: Vec::new(), skin_margin_m: 0.002, max_distance_m: 0.01 }
    }
}

/// A marker too far from the surface to be attached.
#[derive(Debug, Clone, PartialEq)]
pub struct FarMarker {
    /// Name of the marker.
    pub name: String,
    /// Name of the part nearest to it.
    pub part: String,
    /// Distance from that part, in metres.
    pub distance_m: f64,
}

/// The outcome of [`attach_markers`].
#[derive(Debug, Clone, PartialEq)]
pub struct Attached {
    /// The markers that sit on the surface, in their own order.
    pub attachment: Attachment,
    /// The part that each of them sits on.
    pub parts: Vec<String>,
    /// The markers that are too far from it.
    pub far: Vec<FarMarker>,
}

struct Surface<'r> {
    part: &'r Part,
    triangles: Vec<Triangle>,
}

/// A triangle with a sphere around it, to pass over what cannot be nearest.
struct Triangle {
    vertices: [u32; 3],
    corners: [DVec3; 3],
    middle: DVec3,
    radius: f64,
}

/// Attaches the markers of the first frame of `neutral` (metres) to the neutral surface of `rig`.
///
/// # Errors
/// Where a part is not there, the parts have no triangles, there is no frame, or a marker is missing in it.
pub fn attach_markers(rig: &Rig, neutral: &Markers, options: &AttachOptions) -> Result<Attached, RigError> {
    let surfaces = surfaces(rig, &options.parts)?;
    if neutral.frames() == 0 {
        return Err(RigError::NoFrame);
    }
    let mut nearest = Vec::new();
    for (name, position) in neutral.names().iter().zip(neutral.frame(0)) {
        if !position.is_finite() {
            return Err(RigError::MissingMarker { marker: name.clone(), frame: neutral.frame_axis().first });
        }
        let position = position.as_dvec3();
        nearest.push(surfaces.iter().map(|surface| surface.closest(position)).collect::<Vec<_>>());
    }

    let best_of = |found: &[([u32; 3], ClosestPoint)]| {
        (0..found.len()).min_by(|a, b| found[*a].1.distance_m.total_cmp(&found[*b].1.distance_m)).unwrap_or_default()
    };
    let mut votes = vec![0_usize; surfaces.len()];
    for found in &nearest {
        votes[best_of(found)] += 1;
    }
    let skin = (0..votes.len()).max_by_key(|index| (votes[*index], std::cmp::Reverse(*index))).unwrap_or_default();

    let mut attached = Attached { attachment: Attachment { points: Vec::new() }, parts: Vec::new(), far: Vec::new() };
    for (name, found) in neutral.names().iter().zip(&nearest) {
        let best = best_of(found);
        let stays = found[skin].1.distance_m - found[best].1.distance_m <= options.skin_margin_m;
        let chosen = if stays { skin } else { best };
        let (vertices, closest) = found[chosen];
        let part = surfaces[chosen].part.name.clone();
        if closest.distance_m > options.max_distance_m {
            attached.far.push(FarMarker { name: name.clone(), part, distance_m: closest.distance_m });
        } else {
            attached.parts.push(part);
            attached.attachment.points.push(SurfacePoint {
                name: name.clone(),
                vertices,
                weights: closest.weights.map(|weight| weight as f32),
                distance_m: closest.distance_m as f32,
            });
        }
    }
    Ok(attached)
}

fn surfaces<'r>(rig: &'r Rig, names: &[String]) -> Result<Vec<Surface<'r>>, RigError> {
    let parts: Vec<&Part> = if names.is_empty() {
        rig.parts.iter().collect()
    } else {
        let find = |name: &String| {
            rig.part(name).ok_or_else(|| DataError::Missing {
                what: "part",
                name: name.clone(),
                near: nearest_name(name, rig.parts.iter().map(|part| part.name.as_str())),
            })
        };
        names.iter().map(find).collect::<Result<_, _>>()?
    };
    let surfaces: Vec<_> = parts
        .iter()
        .filter(|part| !part.triangles.is_empty())
        .map(|part| Surface { part, triangles: part.triangles.iter().map(|t| Triangle::new(rig, *t)).collect() })
        .collect();
    if surfaces.is_empty() {
        let parts = if names.is_empty() { "any part".to_owned() } else { format!("`{}`", names.join("`, `")) };
        return Err(RigError::NoSurface { rig: rig.name.clone(), parts });
    }
    Ok(surfaces)
}

impl Triangle {
    fn new(rig: &Rig, vertices: [u32; 3]) -> Self {
        let corners = vertices.map(|vertex| rig.neutral[vertex as usize].as_dvec3());
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        let radius = corners.iter().map(|corner| corner.distance(middle)).fold(0.0, f64::max);
        Self { vertices, corners, middle, radius }
    }
}

impl Surface<'_> {
    fn closest(&self, point: DVec3) -> ([u32; 3], ClosestPoint) {
        let mut best: Option<([u32; 3], ClosestPoint)> = None;
        for triangle in &self.triangles {
            if best.is_some_and(|(_, best)| point.distance(triangle.middle) - triangle.radius >= best.distance_m) {
                continue;
            }
            let found = closest_on_triangle(point, triangle.corners);
            if best.is_none_or(|(_, best)| found.distance_m < best.distance_m) {
                best = Some((triangle.vertices, found));
            }
        }
        best.expect("a surface is made of at least one triangle")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy;
    use glam::Vec3;
    use wire::FrameAxis;

    fn markers(points: &[(&str, Vec3)]) -> Markers {
        let names = points.iter().map(|(name, _)| (*name).to_owned()).collect();
        Markers::new(FrameAxis::new(1, 60.0), names, points.iter().map(|(_, point)| *point).collect()).unwrap()
    }

    /// A flat square skin at z = 0, and a ball's square 0.2 mm behind it that bulges 4 mm before it in the middle.
    fn two_parts() -> Rig {
        let mut rig = toy::rig(4, 3);
        let square = |size: f32, z: f32| {
            [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| Vec3::new(x * size, y * size, z))
        };
        rig.neutral = [square(0.1, 0.0), square(0.02, -0.0002)].concat();
        rig.neutral.push(Vec3::new(0.0, 0.0, 0.004));
        let part = |name: &str, vertices, triangles| Part {
            name: name.to_owned(),
            vertices,
            triangles,
            uvs: Vec::new(),
            colour: [1.0; 3],
        };
        rig.parts = vec![
            part("ball", 4..9, vec![[4, 5, 8], [5, 6, 8], [6, 7, 8], [7, 4, 8]]),
            part("skin", 0..4, vec![[0, 1, 2], [0, 2, 3]]),
        ];
        rig.shapes.clear();
        rig
    }

    #[test]
    fn markers_near_two_parts_stay_on_the_skin_and_clear_ones_leave_it() {
        let rig = two_parts();
        let neutral = markers(&[
            ("lid", Vec3::new(0.02, 0.0, -0.000_15)),
            ("cheek", Vec3::new(0.05, 0.03, 0.0001)),
            ("brow", Vec3::new(-0.05, 0.06, 0.0)),
            ("pupil", Vec3::new(0.0, 0.0, 0.0041)),
            ("wand", Vec3::new(0.0, 0.5, 0.0)),
        ]);
        let attached = attach_markers(&rig, &neutral, &AttachOptions::default()).unwrap();
        assert_eq!(attached.parts, ["skin", "skin", "skin", "ball"]);
        assert_eq!(attached.far.len(), 1);
        assert_eq!(attached.far[0].name, "wand");
        assert!((attached.far[0].distance_m - 0.4).abs() < 1e-6);
        let pupil = &attached.attachment.points[3];
        assert!(pupil.weights.iter().any(|weight| (*weight - 1.0).abs() < 1e-6));
        assert!((pupil.distance_m - 0.0001).abs() < 1e-7);
    }

    #[test]
    fn the_attached_point_is_the_foot_of_the_marker() {
        let rig = two_parts();
        let neutral = markers(&[("cheek", Vec3::new(0.05, 0.03, 0.001))]);
        let attached = attach_markers(&rig, &neutral, &AttachOptions::default()).unwrap();
        let point = &attached.attachment.points[0];
        let foot: Vec3 = point
            .vertices
            .iter()
            .zip(point.weights)
            .map(|(vertex, weight)| weight * rig.neutral[*vertex as usize])
            .sum();
        assert!(foot.abs_diff_eq(Vec3::new(0.05, 0.03, 0.0), 1e-7));
        assert!((point.distance_m - 0.001).abs() < 1e-8);
    }

    #[test]
    fn bad_input_is_named() {
        let rig = two_parts();
        let named = |parts: &[&str]| AttachOptions {
            parts: parts.iter().map(|part| (*part).to_owned()).collect(),
            ..AttachOptions::default()
        };
        let good = markers(&[("a", Vec3::ZERO)]);
        let error = attach_markers(&rig, &good, &named(&["skim"])).unwrap_err();
        assert!(error.to_string().contains("did you mean `skin`"), "{error}");
        let lost = markers(&[("a", Vec3::ZERO), ("b", Vec3::NAN)]);
        let error = attach_markers(&rig, &lost, &named(&[])).unwrap_err();
        assert_eq!(error, RigError::MissingMarker { marker: "b".into(), frame: 0 });
        let only = attach_markers(&rig, &markers(&[("pupil", Vec3::new(0.0, 0.0, 0.004))]), &named(&["skin"])).unwrap();
        assert_eq!(only.parts, ["skin"]);
    }
}
