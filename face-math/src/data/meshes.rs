//! Meshes: the surface of a posed head over time, what `evaluate_rig` gives and mesh files hold.

use super::{DataError, Part, check_size, check_unique, join_axes};
use glam::Vec3;
use std::ops::Range;
use std::sync::Arc;
use wire::{Data, DecodeError, Decoder, Encoder, FrameAxis, JoinError, Table, Value, ValueKind};

/// The vertices of a head over frames, in metres. Its parts (names, triangles, texture coordinates) are the same in every
/// frame; slices share them.
#[derive(Debug, Clone, PartialEq)]
pub struct Meshes {
    axis: FrameAxis,
    parts: Arc<Vec<Part>>,
    vertices: usize,
    positions: Vec<Vec3>,
}

impl Meshes {
    /// Makes meshes from `axis.count × vertices` positions in metres, frame after frame.
    ///
    /// # Errors
    /// Where the number of positions does not fit, a part's name stands twice, or a part asks for a vertex that is not
    /// there.
    pub fn new(axis: FrameAxis, parts: Vec<Part>, vertices: usize, positions: Vec<Vec3>) -> Result<Self, DataError> {
        check_size("vertex positions", axis.count * vertices, positions.len())?;
        check_unique("part", &parts.iter().map(|part| part.name.clone()).collect::<Vec<_>>())?;
        for part in &parts {
            let last = part.triangles.iter().flatten().copied().max();
            let end = last.map_or(0, |last| last + 1).max(part.vertices.end);
            if end as usize > vertices {
                let what = format!("last vertex of part `{}`", part.name);
                return Err(DataError::Index { what, index: end as usize - 1, count: vertices });
            }
            if !part.uvs.is_empty() {
                check_size("texture coordinates", part.vertices.len(), part.uvs.len())?;
            }
        }
        Ok(Self { axis, parts: Arc::new(parts), vertices, positions })
    }

    /// The parts; their vertices and triangles are indices into a frame.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// The part called `name`.
    pub fn part(&self, name: &str) -> Option<&Part> {
        self.parts.iter().find(|part| part.name == name)
    }

    /// Number of vertices a frame.
    pub fn vertices(&self) -> usize {
        self.vertices
    }

    /// Number of frames.
    pub fn frames(&self) -> usize {
        self.axis.count
    }

    /// The frame axis.
    pub fn frame_axis(&self) -> FrameAxis {
        self.axis
    }

    /// The positions of one frame, in metres.
    pub fn frame(&self, frame: usize) -> &[Vec3] {
        &self.positions[frame * self.vertices..(frame + 1) * self.vertices]
    }

    /// All positions, frame after frame (metres).
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }
}

impl Value for Meshes {
    fn kind(&self) -> ValueKind {
        ValueKind::of::<Self>()
    }

    fn encode(&self, out: &mut Encoder) {
        out.record(&(self.axis, &*self.parts));
        out.count(self.vertices);
        out.points(&self.positions);
    }

    fn summary(&self) -> String {
        let names: Vec<_> = self.parts.iter().map(|part| part.name.as_str()).collect();
        let triangles: usize = self.parts.iter().map(|part| part.triangles.len()).sum();
        format!(
            "{} frames at {} Hz of {} vertices, {triangles} triangles: {}",
            self.frames(),
            self.axis.rate_hz,
            self.vertices,
            names.join(", ")
        )
    }

    fn size(&self) -> usize {
        self.positions.len() * 12
    }

    fn axis(&self) -> Option<FrameAxis> {
        Some(self.axis)
    }

    fn slice(&self, frames: Range<usize>) -> Option<Arc<dyn Value>> {
        Some(Arc::new(Self {
            axis: self.axis.slice(&frames),
            parts: Arc::clone(&self.parts),
            vertices: self.vertices,
            positions: self.positions[frames.start * self.vertices..frames.end * self.vertices].to_vec(),
        }))
    }

    fn tables(&self) -> Vec<Table<'_>> {
        super::tables::meshes(self)
    }
}

impl Data for Meshes {
    const NAME: &'static str = "Meshes";
    const VERSION: u32 = 1;
    const FRAMED: bool = true;

    fn decode(input: &mut Decoder<'_>) -> Result<Self, DecodeError> {
        let (axis, parts) = input.record()?;
        let vertices = input.count()?;
        let positions = input.points()?;
        Self::new(axis, parts, vertices, positions).map_err(|error| DecodeError::Invalid { what: error.to_string() })
    }

    fn join(slices: &[&Self]) -> Result<Self, JoinError> {
        let axis = join_axes(slices.iter().map(|slice| slice.axis), Self::NAME)?;
        let first = slices[0];
        let alike = |slice: &&Self| {
            slice.vertices == first.vertices && (Arc::ptr_eq(&slice.parts, &first.parts) || slice.parts == first.parts)
        };
        if let Some(index) = slices.iter().position(|slice| !alike(slice)) {
            return Err(JoinError::Differs { kind: Self::NAME, index, what: "parts" });
        }
        let positions = slices.iter().map(|slice| slice.positions.as_slice()).collect::<Vec<_>>().concat();
        Ok(Self { axis, parts: Arc::clone(&first.parts), vertices: first.vertices, positions })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(name: &str, vertices: Range<u32>, triangles: Vec<[u32; 3]>) -> Part {
        Part { name: name.to_owned(), vertices, triangles, uvs: Vec::new(), colour: [1.0; 3] }
    }

    fn meshes(frames: usize) -> Meshes {
        let positions = (0..frames * 4).map(|index| Vec3::splat(index as f32)).collect();
        let axis = FrameAxis { first: 7, count: frames, rate_hz: 24.0 };
        Meshes::new(axis, vec![part("a", 0..3, vec![[0, 1, 2]]), part("b", 3..4, Vec::new())], 4, positions).unwrap()
    }

    #[test]
    fn slices_join_to_the_whole_and_round_trip() {
        let whole = meshes(5);
        let slices: Vec<_> = [0..2, 2..5].into_iter().map(|range| whole.slice(range).unwrap()).collect();
        let slices: Vec<&Meshes> = slices.iter().map(|slice| slice.downcast_ref().unwrap()).collect();
        assert_eq!(slices[1].frame(0), whole.frame(2));
        assert_eq!(slices[1].frame_axis().first, 9);
        assert_eq!(Meshes::join(&slices).unwrap(), whole);
        let encoded = (&whole as &dyn Value).encoded();
        let decoded = (ValueKind::of::<Meshes>().decode)(&encoded).unwrap();
        assert_eq!(decoded.downcast_ref::<Meshes>(), Some(&whole));
    }

    #[test]
    fn misfits_are_refused() {
        let axis = FrameAxis::new(1, 24.0);
        let made = |parts: Vec<Part>| Meshes::new(axis, parts, 3, vec![Vec3::ZERO; 3]).unwrap_err();
        assert!(matches!(made(vec![part("a", 0..4, Vec::new())]), DataError::Index { index: 3, count: 3, .. }));
        assert!(matches!(made(vec![part("a", 0..3, vec![[0, 1, 9]])]), DataError::Index { index: 9, .. }));
        assert!(matches!(made(vec![part("a", 0..3, Vec::new()); 2]), DataError::Twice { .. }));
        let other = Meshes::new(axis, Vec::new(), 4, vec![Vec3::ZERO; 4]).unwrap();
        let axis = FrameAxis { rate_hz: 24.0, ..other.frame_axis() };
        let same = Meshes::new(axis, vec![part("c", 0..4, Vec::new())], 4, vec![Vec3::ZERO; 4]).unwrap();
        assert!(matches!(Meshes::join(&[&other, &same]), Err(JoinError::Differs { index: 1, what: "parts", .. })));
    }
}
