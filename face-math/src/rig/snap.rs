//! Puts attached markers onto the vertices they were laid out on. After [`super::attach_markers`].
//!
//! A mask is often drawn on vertices of the very mesh that the markers later sit on. The captured neutral then lies off each
//! vertex by its own noise, about a tenth of a millimetre, and the projection keeps the part of it along the surface: an error
//! that no solve can take out again. Where at least half of the markers lie on a vertex up to such a distance, the layout
//! was made of vertices, and those markers sit on theirs. Markers painted freely meet a vertex that closely only by chance,
//! some per cent of them on a head of 10,000 vertices, and stay where they are.

use super::RigError;
use crate::data::{Attachment, DataError, Rig};
use glam::DVec3;

/// How near a vertex a marker usually lies that was laid out on it, in metres.
pub const SNAP_M: f64 = 0.0002;

/// The outcome of [`snap_to_vertices`].
#[derive(Debug, Clone, PartialEq)]
pub struct Snapped {
    /// The attachment, with some markers moved onto vertices.
    pub attachment: Attachment,
    /// Names of those markers; empty where the layout was not made of vertices.
    pub on_vertices: Vec<String>,
}

/// Puts the markers that lie within `snap_m` (metres) of a vertex onto it, where that holds for at least half of them. A vertex
/// must also be clearly the nearest: no farther than a third of its triangle's shortest edge.
///
/// # Errors
/// Where the attachment belongs to another rig: its vertices are not there.
pub fn snap_to_vertices(rig: &Rig, attachment: &Attachment, snap_m: f64) -> Result<Snapped, RigError> {
    let mut corners = Vec::with_capacity(attachment.points.len());
    for point in &attachment.points {
        let mut ends = [DVec3::ZERO; 3];
        for (end, vertex) in ends.iter_mut().zip(point.vertices) {
            let index = vertex as usize;
            let position = rig.neutral.get(index).ok_or_else(|| DataError::Index {
                what: format!("vertex of marker `{}` on rig `{}`", point.name, rig.name),
                index,
                count: rig.neutral.len(),
            })?;
            *end = position.as_dvec3();
        }
        let position: DVec3 = ends.iter().zip(point.weights).map(|(end, weight)| f64::from(weight) * *end).sum();
        let edge = (0..3).map(|i| ends[i].distance(ends[(i + 1) % 3])).fold(f64::INFINITY, f64::min);
        corners.push((0..3).find(|corner| ends[*corner].distance(position) <= snap_m.min(edge / 3.0)));
    }
    let mut attachment = attachment.clone();
    let mut on_vertices = Vec::new();
    if 2 * corners.iter().flatten().count() >= corners.len() {
        for (point, corner) in attachment.points.iter_mut().zip(corners) {
            if let Some(corner) = corner {
                point.weights = [0.0; 3];
                point.weights[corner] = 1.0;
                on_vertices.push(point.name.clone());
            }
        }
    }
    Ok(Snapped { attachment, on_vertices })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Markers;
    use crate::rig::{AttachOptions, attach_markers, toy};
    use glam::Vec3;
    use wire::FrameAxis;

    fn attach(rig: &Rig, points: Vec<Vec3>) -> Attachment {
        let names = (0..points.len()).map(|marker| (marker + 9).to_string()).collect();
        let neutral = Markers::new(FrameAxis::new(1, 60.0), names, points).unwrap();
        attach_markers(rig, &neutral, &AttachOptions::default()).unwrap().attachment
    }

    #[test]
    fn a_mask_laid_out_on_vertices_sits_on_them_and_a_free_one_does_not() {
        let rig = toy::rig(8, 3);
        let mut dice = toy::Dice(61);
        let on_vertices: Vec<_> = (9..30).map(|vertex| rig.neutral[vertex] + dice.point() * 1e-4).collect();
        let mask = snap_to_vertices(&rig, &attach(&rig, on_vertices.clone()), SNAP_M).unwrap();
        assert_eq!(mask.on_vertices.len(), 21);
        for point in &mask.attachment.points {
            let corner = point.weights.iter().position(|weight| *weight > 0.999).unwrap();
            assert_eq!(point.vertices[corner].to_string(), point.name);
        }
        let mut free: Vec<_> = (9..30).map(|vertex| rig.neutral[vertex] + Vec3::new(4e-3, 3e-3, 0.0)).collect();
        free[0] = on_vertices[0];
        let free = attach(&rig, free);
        let kept = snap_to_vertices(&rig, &free, SNAP_M).unwrap();
        assert_eq!(kept, Snapped { attachment: free, on_vertices: Vec::new() });
    }

    #[test]
    fn snapping_twice_changes_nothing_and_no_distance_snaps_nothing() {
        let rig = toy::rig(8, 3);
        let mask = attach(&rig, (9..30).map(|vertex| rig.neutral[vertex] + Vec3::splat(5e-5)).collect());
        let once = snap_to_vertices(&rig, &mask, SNAP_M).unwrap();
        assert_eq!(snap_to_vertices(&rig, &once.attachment, SNAP_M).unwrap(), once);
        assert_eq!(snap_to_vertices(&rig, &mask, 0.0).unwrap().attachment, mask);
    }

    #[test]
    fn an_attachment_of_another_rig_is_refused() {
        let (large, small) = (toy::rig(8, 3), toy::rig(4, 3));
        let mask = attach(&large, large.neutral[40..50].to_vec());
        assert!(snap_to_vertices(&small, &mask, SNAP_M).unwrap_err().to_string().contains("there are 16"));
    }
}
