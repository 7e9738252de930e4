//! Features: what the region networks see of the markers (section 4.3 of FDLS).

use super::{DataError, check_size, join_axes};
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::sync::Arc;
use wire::{Data, DecodeError, Decoder, Encoder, FrameAxis, JoinError, Table, Value, ValueKind};

/// A kind of feature over the markers of one region.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FeatureSet {
    /// Distance of every pair of markers, metres.
    Distance,
    /// Unit direction from marker to marker, of every pair.
    Direction,
    /// Displacement of every marker from its neutral place, metres.
    Delta,
    /// The plain coordinates of every marker, metres: the baseline that the graph features are measured against.
    Coordinates,
}

/// The features of one region: which they are, and one row a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct RegionFeatures {
    /// Name of the region.
    pub region: String,
    /// Markers, in the order in which they entered the features.
    pub markers: Vec<String>,
    /// The sets, in the order in which they stand in a row.
    pub sets: Vec<FeatureSet>,
    /// Length of a row.
    pub width: usize,
    /// `frames × width` numbers, frame after frame.
    pub values: Vec<f32>,
}

/// Features of all regions over the same frames.
#[derive(Debug, Clone, PartialEq)]
pub struct Features {
    axis: FrameAxis,
    regions: Vec<RegionFeatures>,
}

impl Features {
    /// Makes features of regions that all have `axis.count` rows.
    ///
    /// # Errors
    /// Where a region has another number of rows.
    pub fn new(axis: FrameAxis, regions: Vec<RegionFeatures>) -> Result<Self, DataError> {
        for region in &regions {
            check_size("region features", axis.count * region.width, region.values.len())?;
        }
        Ok(Self { axis, regions })
    }

    /// The regions.
    pub fn regions(&self) -> &[RegionFeatures] {
        &self.regions
    }

    /// The features of the region `name`.
    pub fn region(&self, name: &str) -> Option<&RegionFeatures> {
        self.regions.iter().find(|region| region.region == name)
    }

    /// The frame axis.
    pub fn frame_axis(&self) -> FrameAxis {
        self.axis
    }

    fn heads(&self) -> Vec<(&str, &[String], &[FeatureSet], usize)> {
        self.regions.iter().map(|r| (r.region.as_str(), &*r.markers, &*r.sets, r.width)).collect()
    }
}

impl Value for Features {
    fn kind(&self) -> ValueKind {
        ValueKind::of::<Self>()
    }

    fn encode(&self, out: &mut Encoder) {
        out.record(&(self.axis, self.heads()));
        for region in &self.regions {
            out.f32s(&region.values);
        }
    }

    fn summary(&self) -> String {
        let parts: Vec<_> = self.regions.iter().map(|r| format!("{} {}", r.region, r.width)).collect();
        format!("{} frames, numbers a frame: {}", self.axis.count, parts.join(", "))
    }

    fn size(&self) -> usize {
        self.regions.iter().map(|region| region.values.len() * 4).sum()
    }

    fn axis(&self) -> Option<FrameAxis> {
        Some(self.axis)
    }

    fn slice(&self, frames: Range<usize>) -> Option<Arc<dyn Value>> {
        let regions = self
            .regions
            .iter()
            .map(|region| RegionFeatures {
                region: region.region.clone(),
                markers: region.markers.clone(),
                sets: region.sets.clone(),
                width: region.width,
                values: region.values[frames.start * region.width..frames.end * region.width].to_vec(),
            })
            .collect();
        Some(Arc::new(Self { axis: self.axis.slice(&frames), regions }))
    }

    fn tables(&self) -> Vec<Table<'_>> {
        super::tables::features(self)
    }
}

impl Data for Features {
    const NAME: &'static str = "Features";
    const VERSION: u32 = 1;
    const FRAMED: bool = true;

    fn decode(input: &mut Decoder<'_>) -> Result<Self, DecodeError> {
        type Head = (String, Vec<String>, Vec<FeatureSet>, usize);
        let (axis, heads): (FrameAxis, Vec<Head>) = input.record()?;
        let regions = heads
            .into_iter()
            .map(|(region, markers, sets, width)| {
                Ok(RegionFeatures { region, markers, sets, width, values: input.f32s()? })
            })
            .collect::<Result<_, DecodeError>>()?;
        Self::new(axis, regions).map_err(|error| DecodeError::Invalid { what: error.to_string() })
    }

    fn join(slices: &[&Self]) -> Result<Self, JoinError> {
        let axis = join_axes(slices.iter().map(|slice| slice.axis), Self::NAME)?;
        if let Some(index) = slices.iter().position(|slice| slice.heads() != slices[0].heads()) {
            return Err(JoinError::Differs { kind: Self::NAME, index, what: "regions" });
        }
        let mut regions = slices[0].regions.clone();
        for (index, region) in regions.iter_mut().enumerate() {
            for slice in &slices[1..] {
                region.values.extend_from_slice(&slice.regions[index].values);
            }
        }
        Ok(Self { axis, regions })
    }
}
