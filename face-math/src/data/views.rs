//! Views: where cameras saw markers, in pixels over time. What is tracked in footage, before it is triangulated.

use super::{DataError, check_size, check_unique, join_axes};
use glam::Vec2;
use std::ops::Range;
use std::sync::Arc;
use wire::{Data, DecodeError, Decoder, Encoder, FrameAxis, JoinError, Table, Value, ValueKind};

/// 2D markers of several cameras over frames, in pixels from the top left of each picture. A marker that a camera did not
/// see is NaN in both coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct Views {
    axis: FrameAxis,
    cameras: Vec<String>,
    markers: Vec<String>,
    points_px: Vec<Vec2>,
}

impl Views {
    /// Makes views from `axis.count × cameras.len() × markers.len()` points in pixels: frame after frame, in it camera
    /// after camera.
    ///
    /// # Errors
    /// Where the number of points does not fit, or a name stands twice.
    pub fn new(
        axis: FrameAxis,
        cameras: Vec<String>,
        markers: Vec<String>,
        points_px: Vec<Vec2>,
    ) -> Result<Self, DataError> {
        check_size("views of markers", axis.count * cameras.len() * markers.len(), points_px.len())?;
        check_unique("camera", &cameras)?;
        check_unique("marker", &markers)?;
        Ok(Self { axis, cameras, markers, points_px })
    }

    /// Camera names, in the order of the points.
    pub fn cameras(&self) -> &[String] {
        &self.cameras
    }

    /// Marker names, in the order of the points.
    pub fn markers(&self) -> &[String] {
        &self.markers
    }

    /// Number of frames.
    pub fn frames(&self) -> usize {
        self.axis.count
    }

    /// The frame axis.
    pub fn frame_axis(&self) -> FrameAxis {
        self.axis
    }

    /// Where a camera saw a marker in a frame (pixels), by their places; none where it did not.
    pub fn at(&self, frame: usize, camera: usize, marker: usize) -> Option<Vec2> {
        let point = self.points_px[(frame * self.cameras.len() + camera) * self.markers.len() + marker];
        (!point.is_nan()).then_some(point)
    }

    /// All points (pixels).
    pub fn points_px(&self) -> &[Vec2] {
        &self.points_px
    }

    /// The same cameras, markers and frames with other points.
    ///
    /// # Errors
    /// Where the number of points differs.
    pub fn with_points(&self, points_px: Vec<Vec2>) -> Result<Self, DataError> {
        check_size("views of markers", self.points_px.len(), points_px.len())?;
        Ok(Self { points_px, ..self.clone() })
    }

    /// How many points are missing, over all frames.
    pub fn missing(&self) -> usize {
        self.points_px.iter().filter(|point| point.is_nan()).count()
    }

    fn a_frame(&self) -> usize {
        self.cameras.len() * self.markers.len()
    }
}

impl Value for Views {
    fn kind(&self) -> ValueKind {
        ValueKind::of::<Self>()
    }

    fn encode(&self, out: &mut Encoder) {
        out.record(&(self.axis, &self.cameras, &self.markers));
        out.f32s(&self.points_px.iter().flat_map(Vec2::to_array).collect::<Vec<_>>());
    }

    fn summary(&self) -> String {
        format!(
            "{} markers in {} cameras, {} frames at {} Hz, {} of {} points missing",
            self.markers.len(),
            self.cameras.len(),
            self.frames(),
            self.axis.rate_hz,
            self.missing(),
            self.points_px.len()
        )
    }

    fn size(&self) -> usize {
        self.points_px.len() * 8
    }

    fn axis(&self) -> Option<FrameAxis> {
        Some(self.axis)
    }

    fn slice(&self, frames: Range<usize>) -> Option<Arc<dyn Value>> {
        let points_px = self.points_px[frames.start * self.a_frame()..frames.end * self.a_frame()].to_vec();
        let (cameras, markers) = (self.cameras.clone(), self.markers.clone());
        Some(Arc::new(Self { axis: self.axis.slice(&frames), cameras, markers, points_px }))
    }

    fn tables(&self) -> Vec<Table<'_>> {
        super::tables::views(self)
    }
}

impl Data for Views {
    const NAME: &'static str = "Views";
    const VERSION: u32 = 1;
    const FRAMED: bool = true;

    fn decode(input: &mut Decoder<'_>) -> Result<Self, DecodeError> {
        let (axis, cameras, markers) = input.record()?;
        let numbers = input.f32s()?;
        if numbers.len() % 2 == 1 {
            return Err(DecodeError::Invalid { what: "a point of views has one coordinate".to_owned() });
        }
        let points = numbers.chunks_exact(2).map(|point| Vec2::new(point[0], point[1])).collect();
        Self::new(axis, cameras, markers, points).map_err(|error| DecodeError::Invalid { what: error.to_string() })
    }

    fn join(slices: &[&Self]) -> Result<Self, JoinError> {
        let axis = join_axes(slices.iter().map(|slice| slice.axis), Self::NAME)?;
        let first = slices[0];
        let differs = |slice: &&Self| slice.cameras != first.cameras || slice.markers != first.markers;
        if let Some(index) = slices.iter().position(differs) {
            return Err(JoinError::Differs { kind: Self::NAME, index, what: "cameras or markers" });
        }
        let points_px = slices.iter().map(|slice| slice.points_px.as_slice()).collect::<Vec<_>>().concat();
        Ok(Self { axis, cameras: first.cameras.clone(), markers: first.markers.clone(), points_px })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn views(frames: usize) -> Views {
        let mut points: Vec<Vec2> = (0..frames * 6).map(|index| Vec2::new(index as f32, 0.5)).collect();
        points[4] = Vec2::NAN;
        let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
        let axis = FrameAxis { first: 5, count: frames, rate_hz: 60.0 };
        Views::new(axis, names(&["left", "right"]), names(&["a", "b", "c"]), points).unwrap()
    }

    #[test]
    fn points_are_found_by_frame_camera_and_marker() {
        let views = views(2);
        assert_eq!(views.at(0, 1, 2), Some(Vec2::new(5.0, 0.5)));
        assert_eq!(views.at(1, 0, 1), Some(Vec2::new(7.0, 0.5)));
        assert_eq!((views.at(0, 1, 1), views.missing()), (None, 1));
    }

    #[test]
    fn slices_join_to_the_whole_and_round_trip() {
        let whole = views(5);
        let slices: Vec<_> = [0..2, 2..5].into_iter().map(|range| whole.slice(range).unwrap()).collect();
        let slices: Vec<&Views> = slices.iter().map(|slice| slice.downcast_ref().unwrap()).collect();
        assert_eq!((slices[1].at(0, 0, 0), slices[1].frame_axis().first), (whole.at(2, 0, 0), 7));
        let joined = Views::join(&slices).unwrap();
        assert_eq!((&joined as &dyn Value).encoded(), (&whole as &dyn Value).encoded());
        let decoded = (ValueKind::of::<Views>().decode)(&(&whole as &dyn Value).encoded()).unwrap();
        assert_eq!(decoded.encoded(), (&whole as &dyn Value).encoded());
        assert!(views(2).with_points(vec![Vec2::ZERO; 3]).is_err());
    }
}
