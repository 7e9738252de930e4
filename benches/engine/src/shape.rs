//! The graphs that both sides compute: layers of nodes, each over one or two nodes of the layer before.

/// A graph of `layers` x `width` nodes.
pub struct Shape {
    pub name: &'static str,
    pub layers: usize,
    pub width: usize,
}

impl Shape {
    /// The nodes that a node takes from; the node at (layer, column) has the number layer * width + column.
    pub fn sources(&self, node: usize) -> Vec<usize> {
        let (layer, column) = (node / self.width, node % self.width);
        if layer == 0 {
            return Vec::new();
        }
        let before = (layer - 1) * self.width;
        if self.width == 1 { vec![before] } else { vec![before + column, before + (column + 1) % self.width] }
    }

    pub fn nodes(&self) -> usize {
        self.layers * self.width
    }

    /// The node whose cone is about a hundredth of all nodes: a cone grows by a column a layer until it is as wide as the
    /// graph.
    pub fn hundredth(&self) -> usize {
        let wanted = self.nodes() / 100;
        let cone = |layer: usize| (layer..self.layers).map(|below| (below - layer + 1).min(self.width)).sum::<usize>();
        let layer = (0..self.layers).rev().find(|layer| cone(*layer) >= wanted).unwrap_or(0);
        layer * self.width
    }
}

/// The work of a node: one mix of whole numbers. The lowest bit of `salt` changes nothing.
pub fn mix(salt: u64, inputs: impl Iterator<Item = u64>) -> u64 {
    inputs.fold(salt >> 1, |sum, input| (sum ^ input).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(17))
}
