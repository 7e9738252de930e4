//! Markers: named points over time, as a motion capture system tracks them.

use super::{DataError, check_size, check_unique, join_axes};
use glam::Vec3;
use std::ops::Range;
use std::sync::Arc;
use wire::{Data, DecodeError, Decoder, Encoder, FrameAxis, JoinError, Table, Value, ValueKind};

/// Named points over frames, in metres. A missing point is NaN in all three coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct Markers {
    axis: FrameAxis,
    names: Vec<String>,
    positions: Vec<Vec3>,
}

impl Markers {
    /// Makes markers from `axis.count × names.len()` positions in metres, frame after frame.
    ///
    /// # Errors
    /// Where the number of positions does not fit, or a name stands twice.
    pub fn new(axis: FrameAxis, names: Vec<String>, positions: Vec<Vec3>) -> Result<Self, DataError> {
        check_size("marker positions", axis.count * names.len(), positions.len())?;
        check_unique("marker", &names)?;
        Ok(Self { axis, names, positions })
    }

    /// Marker names, in the order of the columns.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The column of the marker `name`.
    pub fn index(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|own| own == name)
    }

    /// Number of frames.
    pub fn frames(&self) -> usize {
        self.axis.count
    }

    /// The frame axis.
    pub fn frame_axis(&self) -> FrameAxis {
        self.axis
    }

    /// All positions of one frame (metres), in the order of the names.
    pub fn frame(&self, frame: usize) -> &[Vec3] {
        &self.positions[frame * self.names.len()..(frame + 1) * self.names.len()]
    }

    /// All positions, frame after frame (metres).
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }

    /// The same names and frames with other positions.
    ///
    /// # Errors
    /// Where the number of positions differs.
    pub fn with_positions(&self, positions: Vec<Vec3>) -> Result<Self, DataError> {
        check_size("marker positions", self.positions.len(), positions.len())?;
        Ok(Self { axis: self.axis, names: self.names.clone(), positions })
    }

    /// Only the markers `names`, in that order.
    ///
    /// # Errors
    /// Where one of them is not there.
    pub fn pick(&self, names: &[String]) -> Result<Self, DataError> {
        let columns = names
            .iter()
            .map(|name| {
                self.index(name).ok_or_else(|| DataError::Missing {
                    what: "marker",
                    name: name.clone(),
                    near: super::nearest_name(name, self.names.iter().map(String::as_str)),
                })
            })
            .collect::<Result<Vec<_>, _>>()?;
        let positions =
            (0..self.frames()).flat_map(|t| columns.iter().map(move |column| self.frame(t)[*column])).collect();
        Self::new(self.axis, names.to_vec(), positions)
    }

    /// How many points are missing, over all frames.
    pub fn missing(&self) -> usize {
        self.positions.iter().filter(|point| point.is_nan()).count()
    }
}

impl Value for Markers {
    fn kind(&self) -> ValueKind {
        ValueKind::of::<Self>()
    }

    fn encode(&self, out: &mut Encoder) {
        out.record(&(self.axis, &self.names));
        out.points(&self.positions);
    }

    fn summary(&self) -> String {
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for point in self.positions.iter().filter(|point| !point.is_nan()) {
            low = low.min(*point);
            high = high.max(*point);
        }
        let missing = match self.missing() {
            0 => String::new(),
            some => format!(", {some} points missing"),
        };
        let span = if low.x <= high.x {
            let size = (high - low) * 1000.0;
            format!(", within {:.0} x {:.0} x {:.0} mm", size.x, size.y, size.z)
        } else {
            String::new()
        };
        format!("{} markers, {} frames at {} Hz{span}{missing}", self.names.len(), self.frames(), self.axis.rate_hz)
    }

    fn size(&self) -> usize {
        self.positions.len() * 12 + self.names.iter().map(|name| name.len() + 24).sum::<usize>()
    }

    fn axis(&self) -> Option<FrameAxis> {
        Some(self.axis)
    }

    fn slice(&self, frames: Range<usize>) -> Option<Arc<dyn Value>> {
        let width = self.names.len();
        Some(Arc::new(Self {
            axis: self.axis.slice(&frames),
            names: self.names.clone(),
            positions: self.positions[frames.start * width..frames.end * width].to_vec(),
        }))
    }

    fn tables(&self) -> Vec<Table<'_>> {
        super::tables::markers(self)
    }
}

impl Data for Markers {
    const NAME: &'static str = "Markers";
    const VERSION: u32 = 1;
    const FRAMED: bool = true;

    fn decode(input: &mut Decoder<'_>) -> Result<Self, DecodeError> {
        let (axis, names) = input.record()?;
        let positions = input.points()?;
        Self::new(axis, names, positions).map_err(|error| DecodeError::Invalid { what: error.to_string() })
    }

    fn join(slices: &[&Self]) -> Result<Self, JoinError> {
        let axis = join_axes(slices.iter().map(|slice| slice.axis), Self::NAME)?;
        if let Some(index) = slices.iter().position(|slice| slice.names != slices[0].names) {
            return Err(JoinError::Differs { kind: Self::NAME, index, what: "marker names" });
        }
        let positions = slices.iter().map(|slice| slice.positions.as_slice()).collect::<Vec<_>>().concat();
        Ok(Self { axis, names: slices[0].names.clone(), positions })
    }
}
