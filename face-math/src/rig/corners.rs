//! Which markers sit on which vertices of a rig: asked once for every vertex that a shape moves, hence by a table.

use std::collections::BTreeMap;

const NOWHERE: u32 = u32::MAX;

/// The markers on each vertex, and the vertex's weight in them.
pub(super) struct Corners {
    /// For each vertex its place in `carrying`, or [`NOWHERE`].
    places: Vec<u32>,
    /// The vertices that carry markers, in rising order.
    carrying: Vec<(u32, Vec<(u32, f64)>)>,
}

impl Corners {
    /// From the markers on each vertex of a rig of so many.
    pub fn new(markers_of: BTreeMap<u32, Vec<(u32, f64)>>, vertices: usize) -> Self {
        let carrying: Vec<_> = markers_of.into_iter().collect();
        let mut places = vec![NOWHERE; vertices];
        for (place, (vertex, _)) in carrying.iter().enumerate() {
            places[*vertex as usize] = place as u32;
        }
        Self { places, carrying }
    }

    /// The markers on a vertex, and its weight in each.
    pub fn of(&self, vertex: u32) -> &[(u32, f64)] {
        match self.places.get(vertex as usize) {
            Some(place) if *place != NOWHERE => &self.carrying[*place as usize].1,
            _ => &[],
        }
    }

    /// The vertices that carry markers, in rising order.
    pub fn iter(&self) -> impl Iterator<Item = &(u32, Vec<(u32, f64)>)> {
        self.carrying.iter()
    }
}
