//! `join_meshes`: meshes of one topology one after the other; a sequence of files as one value.

use face_math::data::Meshes;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use wire::FrameAxis;

const MESHES: Port<Meshes> =
    Port::new("meshes", "pieces of one topology, such as the files of a sequence (`load_meshes`)");
const JOINED: Port<Meshes> =
    Port::new("meshes", "all frames, in the order of the numbers in the items' names, counted from 0");

/// Lays meshes one after the other. `frame_2` comes before `frame_10`. Frames run at the rate of the first piece.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct JoinMeshes {}

graph_core::register!(JoinMeshes);

#[typetag::serde(name = "join_meshes")]
impl Node for JoinMeshes {
    fn card(&self) -> Card {
        Card::new("rig").gathers(&MESHES).gives(&JOINED)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let mut pieces = inputs.items(&MESHES)?;
        pieces.sort_by_key(|(name, _)| natural(name));
        let wrong = |problem: String| NodeError::input(MESHES.name(), problem);
        let (first, base) = *pieces.first().ok_or_else(|| wrong("there are no meshes to join".to_owned()))?;
        let mut positions = Vec::new();
        for (name, piece) in &pieces {
            if piece.vertices() != base.vertices() {
                let problem = format!("`{name}` has {} vertices, `{first}` has {}", piece.vertices(), base.vertices());
                return Err(wrong(format!("{problem}; export all from one topology, with the order of vertices kept")));
            }
            positions.extend_from_slice(piece.positions());
        }
        let count = pieces.iter().map(|(_, piece)| piece.frames()).sum();
        let axis = FrameAxis::new(count, base.frame_axis().rate_hz);
        let joined = Meshes::new(axis, base.parts().to_vec(), base.vertices(), positions).map_err(NodeError::failed)?;
        Ok(Outputs::default().with(&JOINED, joined))
    }
}

/// A name as words and numbers, by which names sort as people count.
fn natural(name: &str) -> Vec<(String, u64)> {
    let mut parts: Vec<(String, u64)> = vec![(String::new(), 0)];
    let mut in_number = false;
    for letter in name.chars() {
        if let Some(digit) = letter.to_digit(10) {
            if let Some((_, number)) = parts.last_mut() {
                *number = number.saturating_mul(10).saturating_add(u64::from(digit));
            }
            in_number = true;
        } else {
            if in_number {
                parts.push((String::new(), 0));
                in_number = false;
            }
            if let Some((word, _)) = parts.last_mut() {
                word.push(letter);
            }
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::compute;
    use glam::Vec3;

    fn piece(vertices: usize, at: f32) -> Meshes {
        Meshes::new(FrameAxis::new(1, 30.0), Vec::new(), vertices, vec![Vec3::splat(at); vertices]).unwrap()
    }

    #[test]
    fn pieces_are_counted_as_people_count() {
        let join = |list: Vec<(String, Meshes)>| compute(&JoinMeshes {}, &Inputs::default().with_list(&MESHES, list));
        let outputs = join(vec![("f.10".into(), piece(2, 10.0)), ("f.9".into(), piece(2, 9.0))]).unwrap();
        let joined = outputs.get(&JOINED).unwrap();
        assert_eq!((joined.frames(), joined.frame(0)[0].x, joined.frame(1)[0].x), (2, 9.0, 10.0));
        let error = join(vec![("a".into(), piece(2, 0.0)), ("b".into(), piece(3, 0.0))]).unwrap_err().to_string();
        assert!(error.contains("`b` has 3 vertices, `a` has 2"), "{error}");
    }
}
