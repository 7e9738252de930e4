//! Draws the graph in layers: every node stands right of all that it needs.

use crate::html::{Section, figure};
use graph_core::cook::Engine;
use graph_core::plan::Plan;
use plot::escaped;
use std::collections::BTreeMap;
use std::fmt::Write;

const WIDTH_PX: f64 = 168.0;
const HEIGHT_PX: f64 = 40.0;
/// Between layers, and between the nodes of one.
const GAPS_PX: [f64; 2] = [44.0, 14.0];
/// How often layers are put in the order that their neighbours suggest.
const SWEEPS: usize = 6;
/// Letters of a name that are shown.
const LETTERS: usize = 22;

/// What became of the cells of a node.
#[derive(Clone, Copy, Default)]
struct Fate {
    cells: usize,
    cooked: usize,
    failed: usize,
}

/// The section that shows the graph.
pub(crate) fn section(engine: &Engine) -> Section {
    let mut fates = vec![Fate::default(); engine.plan().nodes.len()];
    for cell in engine.cells() {
        let fate = &mut fates[cell.node];
        fate.cells += 1;
        fate.cooked += usize::from(cell.cooked.is_some_and(|(now, _)| now));
        fate.failed += usize::from(cell.failed.is_some());
    }
    let caption =
        "Filled: computed in this cook. Outlined: up to date. Dashed: failed or skipped. ×n: cooked once an item.";
    Section { id: "graph", title: "The graph", body: figure(&svg(engine.plan(), &fates), caption) }
}

fn svg(plan: &Plan, fates: &[Fate]) -> String {
    let edges: Vec<(usize, usize)> = plan
        .nodes
        .iter()
        .enumerate()
        .flat_map(|(at, node)| node.inputs.iter().flat_map(|input| &input.sources).map(move |source| (source.node, at)))
        .collect();
    let layers = layers(plan.nodes.len(), &edges);
    let mut place = BTreeMap::new();
    let tallest = layers.iter().map(Vec::len).max().unwrap_or(0) as f64;
    for (layer, members) in layers.iter().enumerate() {
        let top = (tallest - members.len() as f64) / 2.0;
        for (row, node) in members.iter().enumerate() {
            let x = 10.0 + layer as f64 * (WIDTH_PX + GAPS_PX[0]);
            place.insert(*node, (x, 10.0 + (top + row as f64) * (HEIGHT_PX + GAPS_PX[1])));
        }
    }
    let width = 20.0 + layers.len() as f64 * (WIDTH_PX + GAPS_PX[0]) - GAPS_PX[0];
    let height = 20.0 + tallest * (HEIGHT_PX + GAPS_PX[1]) - GAPS_PX[1];
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{height:.0}\" viewBox=\"0 0 {width:.0} {height:.0}\" \
         role=\"group\" aria-label=\"The graph: {} nodes in {} layers\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <g fill=\"none\" stroke=\"var(--line)\" stroke-width=\"1.4\" aria-hidden=\"true\">\n",
        plan.nodes.len(),
        layers.len()
    );
    for (from, to) in &edges {
        let (Some((x0, y0)), Some((x1, y1))) = (place.get(from), place.get(to)) else { continue };
        let (x0, y0, y1) = (x0 + WIDTH_PX, y0 + HEIGHT_PX / 2.0, y1 + HEIGHT_PX / 2.0);
        let bend = ((x1 - x0) / 2.0).min(60.0);
        let _ = writeln!(
            out,
            "<path d=\"M{x0:.0} {y0:.0}C{:.0} {y0:.0} {:.0} {y1:.0} {x1:.0} {y1:.0}\"/>",
            x0 + bend,
            x1 - bend
        );
    }
    out += "</g>\n";
    for (node, (x, y)) in &place {
        out += &boxed(plan, *node, (*x, *y), fates[*node]);
    }
    out + "</svg>"
}

fn boxed(plan: &Plan, at: usize, (x, y): (f64, f64), fate: Fate) -> String {
    let node = &plan.nodes[at];
    let (colour, fill, dash, told) = match fate {
        Fate { failed: 1.., .. } => ("var(--failed)", "none", " stroke-dasharray=\"5 3\"", "failed"),
        Fate { cooked: 1.., .. } => ("var(--cooked)", "var(--cooked)", "", "computed"),
        _ => ("var(--cached)", "none", "", "up to date"),
    };
    let ground = if fill == "none" { ("var(--ground)", 1.0) } else { (fill, 0.25) };
    let times = if node.scope.is_empty() { String::new() } else { format!(" ×{}", fate.cells) };
    let path = escaped(&node.path);
    format!(
        "<a href=\"#node-{at}\" aria-label=\"{path}, {}, {told}\"><title>{path}</title>\
         <rect x=\"{x:.0}\" y=\"{y:.0}\" width=\"{WIDTH_PX}\" height=\"{HEIGHT_PX}\" rx=\"6\" fill=\"var(--ground)\"/>\
         <rect x=\"{x:.0}\" y=\"{y:.0}\" width=\"{WIDTH_PX}\" height=\"{HEIGHT_PX}\" rx=\"6\" fill=\"{}\" fill-opacity=\"{}\" \
         stroke=\"{colour}\" stroke-width=\"1.6\"{dash}/>\
         <text x=\"{:.0}\" y=\"{:.0}\" fill=\"var(--text)\" font-weight=\"600\">{}</text>\
         <text x=\"{:.0}\" y=\"{:.0}\" fill=\"var(--quiet)\">{}{times}</text></a>\n",
        escaped(&node.kind),
        ground.0,
        ground.1,
        x + 8.0,
        y + 17.0,
        escaped(&ending(&node.path)),
        x + 8.0,
        y + 33.0,
        escaped(&ending(&node.kind)),
    )
}

/// The end of a name that is too long for its box.
fn ending(name: &str) -> String {
    let count = name.chars().count();
    if count <= LETTERS {
        name.to_owned()
    } else {
        format!("…{}", name.chars().skip(count - LETTERS + 1).collect::<String>())
    }
}

/// Nodes by layer: each one right of all that it needs, ordered so that few edges cross (each node at the mean of its neighbours,
/// to and fro, as Sugiyama, Tagawa and Toda 1981 do it).
fn layers(count: usize, edges: &[(usize, usize)]) -> Vec<Vec<usize>> {
    let mut depth = vec![0; count];
    // Nodes stand in an order in which each comes after those it needs.
    for node in 0..count {
        for (from, _) in edges.iter().filter(|(_, to)| *to == node) {
            depth[node] = depth[node].max(depth[*from] + 1);
        }
    }
    let mut layers = vec![Vec::new(); depth.iter().max().map_or(0, |deepest| deepest + 1)];
    (0..count).for_each(|node| layers[depth[node]].push(node));
    let mut row = vec![0.0; count];
    for sweep in 0..=SWEEPS {
        for members in &mut layers {
            if sweep > 0 {
                let mean = |node: usize| {
                    let near = edges.iter().filter_map(|(from, to)| match (from, to) {
                        (from, to) if *to == node => Some(row[*from]),
                        (from, to) if *from == node => Some(row[*to]),
                        _ => None,
                    });
                    let near: Vec<f64> = near.collect();
                    if near.is_empty() { row[node] } else { near.iter().sum::<f64>() / near.len() as f64 }
                };
                let wanted: BTreeMap<usize, f64> = members.iter().map(|node| (*node, mean(*node))).collect();
                members.sort_by(|a, b| wanted[a].total_cmp(&wanted[b]).then(a.cmp(b)));
            }
            let middle = members.len() as f64 / 2.0;
            members.iter().enumerate().for_each(|(at, node)| row[*node] = at as f64 - middle);
        }
    }
    layers
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_node_stands_right_of_what_it_needs_and_straight_where_that_is_possible() {
        let edges = [(0, 2), (1, 3), (2, 4), (3, 4), (0, 4)];
        let found = layers(5, &edges);
        assert_eq!(found, [vec![0, 1], vec![2, 3], vec![4]]);
        let crossed = layers(4, &[(0, 3), (1, 2)]);
        let row = |node: usize| crossed.iter().find_map(|layer| layer.iter().position(|own| *own == node)).unwrap();
        assert_eq!((row(0), row(1)), (row(3), row(2)), "the two edges do not cross");
        assert_eq!(layers(0, &[]), Vec::<Vec<usize>>::new());
    }

    #[test]
    fn long_names_keep_their_end() {
        assert_eq!(ending("solve/fine"), "solve/fine");
        assert_eq!(ending("a/very/deeply/nested/solve/fine").chars().count(), LETTERS);
    }
}
