//! What `render_faces` and reports draw: a rig posed frame by frame, with captured markers beside its own.

use face_math::data::{Attachment, Curves, Markers, Rig, SurfacePoint};
use face_math::rig::Puppet;
use glam::Vec3;
use wire::FrameAxis;

/// Why there is nothing to draw; the node says which input is to blame.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SceneError {
    /// The rig.
    #[error("rig: {0}")]
    Rig(String),
    /// The curves.
    #[error("curves: {0}")]
    Curves(String),
    /// The markers.
    #[error("markers: {0}")]
    Markers(String),
    /// The attachment.
    #[error("attachment: {0}")]
    Attachment(String),
}

/// A rig, what moves it, and markers on it, checked to fit together.
pub struct Scene<'a> {
    puppet: Puppet<'a>,
    curves: Curves,
    captured: Option<&'a Markers>,
    attachment: &'a [SurfacePoint],
}

/// A head in one frame.
pub struct Pose<'a> {
    /// Number of the frame.
    pub frame: i64,
    /// Vertices of the rig, in metres.
    pub vertices: Vec<Vec3>,
    /// Captured markers, in metres.
    pub captured: &'a [Vec3],
    /// The rig's own markers, in metres.
    pub own: Vec<Vec3>,
    /// Root mean square of the distances between captured markers and the rig's own of the same name, in metres.
    pub distance_m: Option<f64>,
}

impl<'a> Scene<'a> {
    /// Puts the inputs together.
    ///
    /// # Errors
    /// Where they do not fit, or there is no frame.
    pub fn new(
        rig: &'a Rig,
        curves: &Curves,
        captured: Option<&'a Markers>,
        attachment: Option<&'a Attachment>,
    ) -> Result<Self, SceneError> {
        let puppet = Puppet::new(rig).map_err(|error| SceneError::Rig(error.to_string()))?;
        if curves.frames() == 0 {
            return Err(SceneError::Curves("there is no frame to draw".to_owned()));
        }
        let curves = curves.arrange(&rig.channels, None).map_err(|error| SceneError::Curves(error.to_string()))?;
        if let Some(markers) = captured {
            let matched = curves.frame_axis().matches(&markers.frame_axis());
            matched.map_err(|error| SceneError::Markers(format!("beside the curves: {error}")))?;
        }
        let attachment = attachment.map_or(&[][..], |attachment| &attachment.points);
        let count = rig.neutral.len();
        let outside = |point: &&SurfacePoint| point.vertices.iter().any(|vertex| *vertex as usize >= count);
        if let Some(point) = attachment.iter().find(outside) {
            return Err(SceneError::Attachment(format!(
                "marker `{}` sits on vertices {:?}, but rig `{}` has {count}; attach the markers to this rig",
                point.name, point.vertices, rig.name
            )));
        }
        Ok(Self { puppet, curves, captured, attachment })
    }

    /// The frames.
    pub fn axis(&self) -> FrameAxis {
        self.curves.frame_axis()
    }

    /// The head in the frame at `position`, counted from 0.
    ///
    /// # Errors
    /// Where a weight is not finite.
    pub fn pose(&self, position: usize) -> Result<Pose<'_>, SceneError> {
        let frame = self.axis().slice(&(position..position + 1)).first;
        let weights = self.curves.frame(position);
        if let Some(at) = weights.iter().position(|weight| !weight.is_finite()) {
            let (channel, value) = (&self.curves.channels()[at], weights[at]);
            let problem = format!("channel `{channel}` is {value} in frame {frame}; mend the curve first");
            return Err(SceneError::Curves(problem));
        }
        let vertices = self.puppet.vertices(weights).map_err(|error| SceneError::Rig(error.to_string()))?;
        let place = |point: &SurfacePoint| {
            let corners = point.vertices.iter().zip(point.weights);
            corners.map(|(vertex, weight)| vertices[*vertex as usize] * weight).sum()
        };
        let own: Vec<Vec3> = self.attachment.iter().map(place).collect();
        let captured = self.captured.map_or(&[][..], |markers| markers.frame(position));
        let distance_m = self.captured.and_then(|markers| self.distance(markers, captured, &own));
        Ok(Pose { frame, vertices, captured, own, distance_m })
    }

    fn distance(&self, markers: &Markers, captured: &[Vec3], own: &[Vec3]) -> Option<f64> {
        let (mut sum, mut count) = (0.0, 0_u32);
        for (point, own) in self.attachment.iter().zip(own) {
            let seen = markers.index(&point.name).map(|column| captured[column]);
            if let Some(seen) = seen.filter(|seen| seen.is_finite()) {
                sum += f64::from(seen.distance_squared(*own));
                count += 1;
            }
        }
        (count > 0).then(|| (sum / f64::from(count)).sqrt())
    }
}

/// Neutral positions of the vertices that some shape moves by 4 mm or more, or that follow the jaw; all where none is.
pub fn moved(rig: &Rig) -> Vec<Vec3> {
    let mut moves = vec![false; rig.neutral.len()];
    for shape in &rig.shapes {
        for (vertex, delta) in shape.vertices.iter().zip(&shape.deltas) {
            moves[*vertex as usize] |= delta.length() >= 0.004;
        }
    }
    if let Some(jaw) = &rig.jaw {
        moves.iter_mut().zip(&jaw.weights).for_each(|(moves, share)| *moves |= *share >= 0.5);
    }
    if !moves.contains(&true) {
        moves.fill(true);
    }
    rig.neutral.iter().zip(moves).filter(|(_, moves)| *moves).map(|(point, _)| *point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::HEAD;
    use face_math::rig::{AttachOptions, MarkerRig, attach_markers};

    #[test]
    fn distances_are_those_of_markers_that_are_there() {
        let rom = &HEAD.range_of_motion;
        let attachment =
            attach_markers(&HEAD.rig, &HEAD.neutral_markers, &AttachOptions::default()).unwrap().attachment;
        let exact = MarkerRig::attached(&HEAD.rig, &attachment).unwrap().drive(rom).unwrap();
        let distance = |markers: &Markers| {
            Scene::new(&HEAD.rig, rom, Some(markers), Some(&attachment)).unwrap().pose(300).unwrap().distance_m
        };
        assert!(distance(&exact).unwrap() < 1e-6);
        let change = |change: &dyn Fn(usize, Vec3) -> Vec3| {
            let changed = exact.positions().iter().enumerate().map(|(place, point)| change(place, *point)).collect();
            distance(&exact.with_positions(changed).unwrap())
        };
        assert!((change(&|_, point| point + Vec3::Z * 0.003).unwrap() - 0.003).abs() < 1e-6);
        let half =
            |place: usize, point: Vec3| if place.is_multiple_of(2) { Vec3::NAN } else { point + Vec3::Y * 0.002 };
        assert!((change(&half).unwrap() - 0.002).abs() < 1e-6);
        assert_eq!(change(&|_, _| Vec3::NAN), None);
        let without = Scene::new(&HEAD.rig, rom, Some(&exact), None).unwrap();
        assert_eq!(without.pose(300).unwrap().distance_m, None);
    }

    #[test]
    fn what_moves_is_the_face_and_not_the_neck() {
        let points = moved(&HEAD.rig);
        let low = points.iter().map(|point| point.y).fold(f32::MAX, f32::min);
        let neck = HEAD.rig.neutral.iter().map(|point| point.y).fold(f32::MAX, f32::min);
        assert!(low > neck + 0.02 && points.len() < HEAD.rig.neutral.len());
        let mut still = HEAD.rig.clone();
        still.shapes.clear();
        assert_eq!(moved(&still), HEAD.rig.neutral);
    }
}
