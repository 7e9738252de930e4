//! Some parts of a rig as a rig of their own, with vertices counted anew; points that ride on it go along.

use crate::data::{Attachment, Part, Rig, Shape, SurfacePoint};

/// Parts whose vertices follow each other without a gap, in the order given.
pub fn renumbered(parts: Vec<Part>) -> Vec<Part> {
    let mut next = 0;
    parts
        .into_iter()
        .map(|mut part| {
            let (old, new) = (part.vertices.start, next);
            next += part.vertices.len() as u32;
            for index in part.triangles.iter_mut().flatten() {
                *index = *index - old + new;
            }
            part.vertices = new..next;
            part
        })
        .collect()
}

/// The parts of `rig` that `keep` chooses, as a rig; channels and shapes stay, also those that move nothing any more.
pub fn keep_parts(rig: &Rig, keep: impl Fn(&Part) -> bool) -> Rig {
    let kept: Vec<&Part> = rig.parts.iter().filter(|part| keep(part)).collect();
    let place = new_places(rig, &kept);
    let chosen: Vec<usize> =
        kept.iter().flat_map(|part| part.vertices.start as usize..part.vertices.end as usize).collect();
    let pick = |numbers: &[f32]| -> Vec<f32> {
        if numbers.is_empty() { Vec::new() } else { chosen.iter().map(|vertex| numbers[*vertex]).collect() }
    };
    let shape = |shape: &Shape| {
        let moved = shape.vertices.iter().zip(&shape.deltas);
        let mut moved: Vec<_> = moved.filter_map(|(vertex, delta)| Some((place[*vertex as usize]?, *delta))).collect();
        moved.sort_by_key(|(vertex, _)| *vertex);
        let (vertices, deltas) = moved.into_iter().unzip();
        Shape { name: shape.name.clone(), driver: shape.driver.clone(), vertices, deltas }
    };
    let mut out = rig.clone();
    out.jaw
        .iter_mut()
        .chain(out.joints.iter_mut().map(|joint| &mut joint.skin))
        .for_each(|joint| joint.weights = pick(&joint.weights));
    Rig {
        parts: renumbered(kept.into_iter().cloned().collect()),
        neutral: chosen.iter().map(|vertex| rig.neutral[*vertex]).collect(),
        shapes: rig.shapes.iter().map(shape).collect(),
        skin: pick(&rig.skin),
        ..out
    }
}

/// The points of an attachment on `rig` that lie on the parts `keep` chooses, on the rig that [`keep_parts`] makes.
pub fn keep_points(rig: &Rig, attachment: &Attachment, keep: impl Fn(&Part) -> bool) -> Attachment {
    let kept: Vec<&Part> = rig.parts.iter().filter(|part| keep(part)).collect();
    let place = new_places(rig, &kept);
    let moved = |point: &SurfacePoint| {
        let [a, b, c] = point.vertices.map(|vertex| place.get(vertex as usize).copied().flatten());
        Some(SurfacePoint { vertices: [a?, b?, c?], ..point.clone() })
    };
    Attachment { points: attachment.points.iter().filter_map(moved).collect() }
}

fn new_places(rig: &Rig, kept: &[&Part]) -> Vec<Option<u32>> {
    let mut place = vec![None; rig.neutral.len()];
    for (new, old) in (0..).zip(kept.iter().flat_map(|part| part.vertices.clone())) {
        place[old as usize] = Some(new);
    }
    place
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::Puppet;
    use crate::strain::toy;

    #[test]
    fn what_is_left_moves_as_before() {
        let rig = toy::with_shapes(&toy::jointed_head(), 3, 0.01);
        let some = keep_parts(&rig, |part| part.name != "teeth").checked().unwrap();
        assert_eq!((some.parts.len(), some.neutral.len(), some.parts[1].vertices.clone()), (2, 84, 64..84));
        let weights: Vec<f32> = (0..12).map(|at| at as f32 * 0.01).collect();
        let whole = Puppet::new(&rig).unwrap().vertices(&weights).unwrap();
        let own = Puppet::new(&some).unwrap().vertices(&weights).unwrap();
        assert_eq!(own[..64], whole[..64]);
        assert_eq!(own[64..], whole[76..]);
        let point = |name: &str, vertices| SurfacePoint {
            name: name.into(),
            vertices,
            weights: [0.2, 0.3, 0.5],
            distance_m: 0.0,
        };
        let attachment = Attachment { points: vec![point("a", [77, 78, 79]), point("b", [64, 65, 66])] };
        let kept = keep_points(&rig, &attachment, |part| part.name != "teeth");
        assert_eq!(kept.points, [point("a", [65, 66, 67])]);
    }
}
