//! Anchors: poses at which an artist has said what the puppet should look like (Eq. 5 of FDLS). `set_anchors` makes them,
//! `align_anchors` moves a take by them.

use face_math::data::{DataError, Markers};
use glam::Vec3;
use wire::{Data, DecodeError, Decoder, Encoder, FrameAxis, Table, Value, ValueKind};

/// Anchor poses, in the order in which they apply.
#[derive(Debug, Clone, PartialEq)]
pub struct Anchors {
    frames: Vec<i64>,
    captured: Markers,
    puppet: Markers,
}

impl Anchors {
    /// Anchors at the take's frames `frames`: `captured` holds the take's markers there, x at a, one frame an anchor, and
    /// `puppet` the puppet's at the anchor's weights, g(w) at a. Metres.
    ///
    /// # Errors
    /// Where the three do not have one entry an anchor.
    pub fn new(frames: Vec<i64>, captured: Markers, puppet: Markers) -> Result<Self, DataError> {
        for (what, found) in [("captured anchors", captured.frames()), ("poses of the puppet", puppet.frames())] {
            if found != frames.len() {
                return Err(DataError::Size { what, expected: frames.len(), found });
            }
        }
        Ok(Self { frames, captured, puppet })
    }

    /// The numbers of the anchors' frames, as the take counts them.
    pub fn frames(&self) -> &[i64] {
        &self.frames
    }

    /// The take's markers at the anchors, one frame an anchor, in metres.
    pub fn captured(&self) -> &Markers {
        &self.captured
    }

    /// The puppet's markers at the anchors, one frame an anchor, in metres.
    pub fn puppet(&self) -> &Markers {
        &self.puppet
    }

    /// The offsets d = x − g(w) of one anchor, in metres, by the names of the markers seen in both (Eq. 5 of FDLS).
    ///
    /// # Panics
    /// Where there are not so many anchors.
    pub fn offsets(&self, anchor: usize) -> Vec<(&str, Vec3)> {
        let (captured, puppet) = (self.captured.frame(anchor), self.puppet.frame(anchor));
        let names = self.captured.names().iter().zip(captured);
        let offset = |(name, own): (&'_ String, &Vec3)| Some(*own - puppet[self.puppet.index(name)?]);
        names
            .filter_map(|pair| Some((pair.0.as_str(), offset(pair)?)))
            .filter(|(_, offset)| offset.is_finite())
            .collect()
    }

    /// An axis for `count` poses: they follow each other in no time, so the rate means nothing.
    pub(crate) fn axis(count: usize) -> FrameAxis {
        FrameAxis::new(count, 1.0)
    }
}

impl Value for Anchors {
    fn kind(&self) -> ValueKind {
        ValueKind::of::<Self>()
    }

    fn encode(&self, out: &mut Encoder) {
        out.record(&self.frames);
        self.captured.encode(out);
        self.puppet.encode(out);
    }

    fn summary(&self) -> String {
        let each = (0..self.frames.len()).map(|anchor| {
            let offsets = self.offsets(anchor);
            let mean =
                offsets.iter().map(|(_, offset)| f64::from(offset.length())).sum::<f64>() / offsets.len().max(1) as f64;
            let worst = offsets.iter().max_by(|a, b| a.1.length().total_cmp(&b.1.length()));
            let worst = worst.map_or(String::new(), |(name, offset)| {
                format!(", worst {:.2} mm ({name})", f64::from(offset.length()) * 1000.0)
            });
            format!("frame {}: {} offsets, mean {:.2} mm{worst}", self.frames[anchor], offsets.len(), mean * 1000.0)
        });
        format!("{} anchors; {}", self.frames.len(), each.collect::<Vec<_>>().join("; "))
    }

    fn size(&self) -> usize {
        self.captured.size() + self.puppet.size() + 8 * self.frames.len()
    }

    fn tables(&self) -> Vec<Table<'_>> {
        let named = |what, table| Table { what, ..table };
        let captured = self.captured.tables().into_iter().map(|table| named("captured", table));
        captured.chain(self.puppet.tables().into_iter().map(|table| named("puppet", table))).collect()
    }
}

impl Data for Anchors {
    const NAME: &'static str = "Anchors";
    const VERSION: u32 = 1;
    const FRAMED: bool = false;

    fn decode(input: &mut Decoder<'_>) -> Result<Self, DecodeError> {
        let frames = input.record()?;
        let (captured, puppet) = (Markers::decode(input)?, Markers::decode(input)?);
        Self::new(frames, captured, puppet).map_err(|error| DecodeError::Invalid { what: error.to_string() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn markers(names: &[&str], positions: Vec<Vec3>) -> Markers {
        let names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
        Markers::new(Anchors::axis(positions.len() / names.len()), names, positions).unwrap()
    }

    #[test]
    fn offsets_pair_markers_by_name_and_pass_over_missing_ones() {
        let captured = markers(&["a", "b", "head"], vec![Vec3::X, Vec3::NAN, Vec3::Y]);
        let puppet = markers(&["b", "a"], vec![Vec3::Z, Vec3::X * 0.998]);
        let anchors = Anchors::new(vec![12], captured, puppet.clone()).unwrap();
        let offsets = anchors.offsets(0);
        assert_eq!(offsets.len(), 1);
        assert!(offsets[0].0 == "a" && offsets[0].1.abs_diff_eq(Vec3::X * 0.002, 1e-7));
        assert_eq!(anchors.summary(), "1 anchors; frame 12: 1 offsets, mean 2.00 mm, worst 2.00 mm (a)");
        let encoded = (&anchors as &dyn Value).encoded();
        let decoded = (ValueKind::of::<Anchors>().decode)(&encoded).unwrap();
        assert_eq!(decoded.encoded(), encoded);
        assert!(Anchors::new(vec![1, 2], puppet.clone(), puppet).is_err());
    }
}
