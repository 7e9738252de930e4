//! Curves: channel weights over time, the animation that drives a rig.

use super::{DataError, check_size, check_unique, join_axes};
use std::ops::Range;
use std::sync::Arc;
use wire::{Data, DecodeError, Decoder, Encoder, FrameAxis, JoinError, Table, Value, ValueKind};

/// One value per channel and frame: unitless weights, normally 0 to 1, or whatever unit the channel names.
#[derive(Debug, Clone, PartialEq)]
pub struct Curves {
    axis: FrameAxis,
    channels: Vec<String>,
    values: Vec<f32>,
}

impl Curves {
    /// Makes curves from `axis.count × channels.len()` values, frame after frame.
    ///
    /// # Errors
    /// Where the number of values does not fit, or a channel stands twice.
    pub fn new(axis: FrameAxis, channels: Vec<String>, values: Vec<f32>) -> Result<Self, DataError> {
        check_size("curve values", axis.count * channels.len(), values.len())?;
        check_unique("channel", &channels)?;
        Ok(Self { axis, channels, values })
    }

    /// Channel names, in the order of the columns.
    pub fn channels(&self) -> &[String] {
        &self.channels
    }

    /// The column of the channel `name`.
    pub fn index(&self, name: &str) -> Option<usize> {
        self.channels.iter().position(|own| own == name)
    }

    /// Number of frames.
    pub fn frames(&self) -> usize {
        self.axis.count
    }

    /// The frame axis.
    pub fn frame_axis(&self) -> FrameAxis {
        self.axis
    }

    /// The values of one frame, in the order of the channels.
    pub fn frame(&self, frame: usize) -> &[f32] {
        &self.values[frame * self.channels.len()..(frame + 1) * self.channels.len()]
    }

    /// All values, frame after frame.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// The channels `names` in that order; the values of channels that are not there are `fill`, where given.
    ///
    /// # Errors
    /// Where a channel is not there and no fill is given.
    pub fn arrange(&self, names: &[String], fill: Option<f32>) -> Result<Self, DataError> {
        let columns = names
            .iter()
            .map(|name| match (self.index(name), fill) {
                (Some(column), _) => Ok(Some(column)),
                (None, Some(_)) => Ok(None),
                (None, None) => Err(DataError::Missing {
                    what: "channel",
                    name: name.clone(),
                    near: super::nearest_name(name, self.channels.iter().map(String::as_str)),
                }),
            })
            .collect::<Result<Vec<_>, _>>()?;
        let fill = fill.unwrap_or_default();
        let values = (0..self.frames())
            .flat_map(|t| columns.iter().map(move |column| column.map_or(fill, |column| self.frame(t)[column])))
            .collect();
        Self::new(self.axis, names.to_vec(), values)
    }
}

impl Value for Curves {
    fn kind(&self) -> ValueKind {
        ValueKind::of::<Self>()
    }

    fn encode(&self, out: &mut Encoder) {
        out.record(&(self.axis, &self.channels));
        out.f32s(&self.values);
    }

    fn summary(&self) -> String {
        let low = self.values.iter().copied().fold(f32::INFINITY, f32::min);
        let high = self.values.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        let range = if low <= high { format!(", {low:.3} to {high:.3}") } else { String::new() };
        format!("{} channels, {} frames at {} Hz{range}", self.channels.len(), self.frames(), self.axis.rate_hz)
    }

    fn size(&self) -> usize {
        self.values.len() * 4 + self.channels.iter().map(|name| name.len() + 24).sum::<usize>()
    }

    fn axis(&self) -> Option<FrameAxis> {
        Some(self.axis)
    }

    fn slice(&self, frames: Range<usize>) -> Option<Arc<dyn Value>> {
        let width = self.channels.len();
        Some(Arc::new(Self {
            axis: self.axis.slice(&frames),
            channels: self.channels.clone(),
            values: self.values[frames.start * width..frames.end * width].to_vec(),
        }))
    }

    fn tables(&self) -> Vec<Table<'_>> {
        super::tables::curves(self)
    }
}

impl Data for Curves {
    const NAME: &'static str = "Curves";
    const VERSION: u32 = 1;
    const FRAMED: bool = true;

    fn decode(input: &mut Decoder<'_>) -> Result<Self, DecodeError> {
        let (axis, channels) = input.record()?;
        let values = input.f32s()?;
        Self::new(axis, channels, values).map_err(|error| DecodeError::Invalid { what: error.to_string() })
    }

    fn join(slices: &[&Self]) -> Result<Self, JoinError> {
        let axis = join_axes(slices.iter().map(|slice| slice.axis), Self::NAME)?;
        if let Some(index) = slices.iter().position(|slice| slice.channels != slices[0].channels) {
            return Err(JoinError::Differs { kind: Self::NAME, index, what: "channels" });
        }
        let values = slices.iter().map(|slice| slice.values.as_slice()).collect::<Vec<_>>().concat();
        Ok(Self { axis, channels: slices[0].channels.clone(), values })
    }
}
