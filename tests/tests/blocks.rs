//! Every kind of node that works per frame gives the same bits in blocks of any size as on the whole, and sees exactly as many
//! frames beside a block as it needs. The nodes, with their inputs, are those of `blocks/graph.ron`.

#![allow(clippy::unwrap_used, reason = "a failing unwrap is a failing test")]

use face_math::data::Markers;
use glam::DVec3;
use graph_core::node::{
    Context, Host, Inputs, Node, NodeError, Outputs, PortFacts, PortValue, SourceFile, Time, kinds,
};
use graph_core::plan::{Plan, load};
use nodes as _;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use wire::Value;

/// The engine's side of a context: the node's own file, and nothing else.
struct Bench(Option<PathBuf>);

impl Host for Bench {
    fn progress(&self, _: f64, _: &[(&str, f64)]) {}

    fn source(&self) -> Result<SourceFile, NodeError> {
        let path = self.0.as_ref().ok_or_else(|| NodeError::failed("this node has no source file"))?;
        Ok(SourceFile { name: path.display().to_string(), bytes: Arc::new(std::fs::read(path).unwrap()) })
    }

    fn sibling(&self, name: &str) -> Result<Arc<Vec<u8>>, NodeError> {
        Err(NodeError::file(name, "there is no such file"))
    }

    fn checkpoint(&self, _: &str) -> Option<Vec<u8>> {
        None
    }

    fn save_checkpoint(&self, _: &str, _: &[u8]) {}

    fn memory_bytes(&self) -> u64 {
        u64::MAX
    }
}

fn compute(node: &dyn Node, file: Option<&Path>, inputs: &Inputs) -> Result<Outputs, NodeError> {
    node.compute(&Context::new(&Bench(file.map(Path::to_owned)), &AtomicBool::new(false), ""), inputs)
}

/// The nodes of the plan with what stands on their inputs, found by computing one after the other. Of lists, the first item
/// goes on.
fn examples(plan: &Plan) -> Vec<Inputs> {
    let mut standing: Vec<BTreeMap<String, PortValue>> = Vec::new();
    let mut all = Vec::new();
    for node in &plan.nodes {
        let mut inputs = Inputs::default();
        for input in node.inputs.iter().filter(|input| !input.sources.is_empty()) {
            let values = input.sources.iter().map(|source| (&source.label, &standing[source.node][&source.port]));
            let first = |value: &PortValue| match value {
                PortValue::One(value) => Arc::clone(value),
                PortValue::List(items) => Arc::clone(items.values().next().unwrap()),
            };
            let mut ones = values.map(|(label, value)| (label.clone(), first(value)));
            let value =
                if input.port.list { PortValue::List(ones.collect()) } else { PortValue::One(ones.next().unwrap().1) };
            inputs.set(input.port.name, value);
        }
        let file = node.reads.as_ref().map(|pattern| pattern.path().to_owned());
        let outputs = compute(node.node.as_ref(), file.as_deref(), &inputs);
        let mut outputs = outputs.unwrap_or_else(|problem| panic!("{} ({}): {problem}", node.path, node.kind));
        let ports = node.card.outputs.iter();
        standing.push(ports.map(|port| (port.name.to_owned(), outputs.take(port.name).unwrap())).collect());
        all.push(inputs);
    }
    all
}

/// Whether an input is cut into blocks.
fn framed(port: &PortFacts) -> bool {
    port.kind.framed && !port.still
}

/// A node that works per frame, with its inputs.
struct Example<'a> {
    plan: &'a Plan,
    at: usize,
    inputs: &'a Inputs,
    frames: usize,
}

impl Example<'_> {
    /// The encodings of all outputs, computed from blocks of `block` frames with `halo` frames on either side and joined.
    fn in_blocks(&self, block: usize, halo: usize) -> Result<Vec<Vec<u8>>, NodeError> {
        let node = &self.plan.nodes[self.at];
        let mut parts: Vec<Vec<Arc<dyn Value>>> = vec![Vec::new(); node.card.outputs.len()];
        for start in (0..self.frames).step_by(block) {
            let own = start..(start + block).min(self.frames);
            let needed = own.start.saturating_sub(halo)..(own.end + halo).min(self.frames);
            let mut outputs = compute(node.node.as_ref(), None, &self.cut(&needed))?;
            for (port, parts) in node.card.outputs.iter().zip(&mut parts) {
                let Some(PortValue::One(value)) = outputs.take(port.name) else { panic!("{}", node.path) };
                let within = own.start - needed.start..own.end - needed.start;
                parts.push(value.slice(within).unwrap());
            }
        }
        let joined =
            node.card.outputs.iter().zip(&parts).map(|(port, parts)| (port.kind.join)(parts).unwrap().encoded());
        Ok(joined.collect())
    }

    fn cut(&self, frames: &Range<usize>) -> Inputs {
        let mut cut = Inputs::default();
        for (name, value) in self.inputs.ports() {
            let sliced = framed(self.plan.nodes[self.at].card.input(name).unwrap());
            let slice =
                |value: &Arc<dyn Value>| if sliced { value.slice(frames.clone()).unwrap() } else { Arc::clone(value) };
            let value = match value {
                PortValue::One(value) => PortValue::One(slice(value)),
                PortValue::List(items) => {
                    PortValue::List(items.iter().map(|(name, value)| (name.clone(), slice(value))).collect())
                }
            };
            cut.set(name.to_owned(), value);
        }
        cut
    }
}

fn first_axis(plan: &Plan, at: usize, inputs: &Inputs) -> Option<usize> {
    let values = inputs.ports().filter(|(name, _)| framed(plan.nodes[at].card.input(name).unwrap()));
    values
        .into_iter()
        .find_map(|(_, value)| match value {
            PortValue::One(value) => value.axis(),
            PortValue::List(items) => items.values().next()?.axis(),
        })
        .map(|axis| axis.count)
}

#[test]
fn blocks_of_any_size_give_the_bits_of_the_whole_and_the_halo_is_just_wide_enough() {
    let folder = tempfile::tempdir().unwrap();
    let graph = folder.path().join("graph.ron");
    std::fs::copy(whole_system::root().join("tests/tests/blocks/graph.ron"), &graph).unwrap();
    film(folder.path());
    let muscles = whole_system::root().join("graphs/strain_train/muscles.ron");
    std::fs::copy(muscles, folder.path().join("muscles.ron")).unwrap();
    let plan = load(&graph, &[]).unwrap_or_else(|mistakes| panic!("{mistakes:#?}"));
    let all = examples(&plan);
    let (mut tried, mut tight, mut loose) = (BTreeSet::new(), BTreeSet::new(), BTreeMap::new());
    for (at, inputs) in all.iter().enumerate() {
        let node = &plan.nodes[at];
        let Time::PerFrame { halo } = node.card.time else { continue };
        let frames = first_axis(&plan, at, inputs).unwrap_or_else(|| panic!("{} is given no frames", node.path));
        assert!(frames > 32 + halo, "{} is given {frames} frames, too few for blocks of 32", node.path);
        let example = Example { plan: &plan, at, inputs, frames };
        let whole = example.in_blocks(frames, 0).unwrap();
        for block in [1, 7, 32] {
            let blocks = example.in_blocks(block, halo).unwrap();
            for (port, (blocks, whole)) in node.card.outputs.iter().zip(blocks.iter().zip(&whole)) {
                assert!(
                    blocks == whole,
                    "{} ({}): `{}` in blocks of {block} frames differs from the whole; is its halo of {halo} frames too small?",
                    node.path,
                    node.kind,
                    port.name
                );
            }
        }
        tried.insert(node.kind.as_str());
        // One frame less must be seen to be missing, or the halo is wider than needed.
        if halo > 0 {
            if example.in_blocks(1, halo - 1).is_ok_and(|blocks| blocks == whole) {
                loose.insert(node.kind.as_str(), (node.path.as_str(), halo));
            } else {
                tight.insert(node.kind.as_str());
            }
        }
    }
    loose.retain(|kind, _| !tight.contains(kind));
    assert!(loose.is_empty(), "a frame less on either side would do for these (kind, node, halo): {loose:?}");
    let missing: Vec<&str> = kinds()
        .filter(|(_, kind)| matches!(kind.card().time, Time::PerFrame { .. }))
        .map(|(name, _)| name)
        .filter(|name| !tried.contains(name))
        .collect();
    assert!(
        missing.is_empty(),
        "these kinds work per frame and are not tried: {missing:?}. Add a node of each to tests/tests/blocks/graph.ron, \
         with parameters and inputs under which all of its halo is needed"
    );
}

/// Writes three cameras, and the take of the graph's sample actor as they saw it: some markers are hidden for a while.
fn film(folder: &Path) {
    let actor = serde_json::json!({
        "sample_actor": { "density": 0.5, "rom_frames": 600, "takes": 1, "frames": 75 }
    });
    let actor: Box<dyn Node> = serde_json::from_value(actor).unwrap();
    let mut outputs = compute(actor.as_ref(), None, &Inputs::default()).unwrap();
    let Some(PortValue::List(takes)) = outputs.take("takes") else { panic!("no takes") };
    let take = takes.values().next().unwrap();
    let take = take.downcast_ref::<Markers>().unwrap();
    let middle = take.frame(0).iter().map(|place| place.as_dvec3()).sum::<DVec3>() / take.names().len() as f64;
    let mut cameras = Vec::new();
    let mut views = format!("# rate_hz: {}\ncamera,frame,marker,u_px,v_px\n", take.frame_axis().rate_hz);
    for (name, away) in [
        ("left", DVec3::new(-0.3, 0.1, 0.8)),
        ("front", DVec3::new(0.0, 0.0, 0.9)),
        ("right", DVec3::new(0.35, -0.1, 0.8)),
    ] {
        let eye = middle + away;
        // Axes of the camera: z forward, y down, x to the right.
        let z = (middle - eye).normalize();
        let x = z.cross(DVec3::Y).normalize();
        let y = z.cross(x);
        let t = [-x.dot(eye), -y.dot(eye), -z.dot(eye)];
        cameras.push(serde_json::json!({
            "name": name, "width": 1280, "height": 1280, "K": [[1800, 0, 640], [0, 1800, 640], [0, 0, 1]],
            "R": [x.to_array(), y.to_array(), z.to_array()], "t_m": t, "dist_k1k2p1p2": [0, 0, 0, 0],
        }));
        for frame in 0..take.frame_axis().count {
            for (index, place) in take.frame(frame).iter().enumerate() {
                // Gaps of 2, 6, 8 and 14 frames.
                let (gap, start) = ([2, 6, 8, 14][index % 4], 12 + index % 37);
                if index % 5 == 0 && (start..start + gap).contains(&frame) || !place.is_finite() {
                    continue;
                }
                let seen = place.as_dvec3() - eye;
                let (depth, marker) = (seen.dot(z), &take.names()[index]);
                let (u, v) = (1800.0 * seen.dot(x) / depth + 640.0, 1800.0 * seen.dot(y) / depth + 640.0);
                let frame = take.frame_axis().first + frame as i64;
                writeln!(views, "{name},{frame},{marker},{u},{v}").unwrap();
            }
        }
    }
    std::fs::write(folder.join("cameras.json"), serde_json::json!({ "cameras": cameras }).to_string()).unwrap();
    std::fs::write(folder.join("views.csv"), views).unwrap();
}
