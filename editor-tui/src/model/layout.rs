//! Where the cards of a board stand: in layers from left to right, each after those it takes from, near what it is wired to.
//!
//! The way is Sugiyama's: layers by the longest path, wires over several layers pass through places of their own, the order
//! within layers by means of neighbours, and heights by isotonic regression, which for a given order comes nearest to straight
//! wires. Everything is linear in cards and wires but for sorting.

use super::board::Board;

/// How much of a card is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Zoom {
    /// A box with its ports.
    #[default]
    Normal,
    /// One line.
    Compact,
}

/// A place on the board, in character cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Place {
    /// Column of the left edge.
    pub x: i32,
    /// Row of the upper edge.
    pub y: i32,
    /// Columns.
    pub width: i32,
    /// Rows.
    pub height: i32,
    /// The layer.
    pub layer: usize,
}

/// One output's wires between two neighbouring layers: from one height to several, along one column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Run {
    /// The card and output they come from, whatever they pass.
    pub from: (usize, usize),
    /// The height at which they come in.
    pub y: i32,
    /// The column in which they turn.
    pub turn: i32,
    /// Heights at which they go out, each with the card it leads to in the end.
    pub to: Vec<(i32, usize)>,
}

/// The space behind a layer, in which wires turn, and the wires that pass over the layer.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Gap {
    /// First column behind the layer's cards.
    pub left: i32,
    /// First column of the next layer.
    pub right: i32,
    /// The wires that turn here.
    pub runs: Vec<Run>,
    /// Heights at which wires pass the next layer, with what they come from and lead to.
    pub passing: Vec<(i32, (usize, usize), usize)>,
}

/// Where everything stands.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Layout {
    /// Places of the cards.
    pub places: Vec<Place>,
    /// What lies behind each layer.
    pub gaps: Vec<Gap>,
    /// Columns of everything.
    pub width: i32,
    /// Rows of everything.
    pub height: i32,
}

/// Columns of a card.
pub const NORMAL_WIDTH: i32 = 27;
/// Columns of a card of one line.
pub const COMPACT_WIDTH: i32 = 20;
/// Beyond so many places that wires pass, they pass straight.
const MOST_PASSES: usize = 40_000;
/// Most columns in which wires turn between two layers.
const MOST_TRACKS: i32 = 11;

/// A card, or a wire's way over a layer.
struct Item {
    card: Option<usize>,
    height: i32,
    /// Neighbours before and after, with the heights of the ports within them and within this one.
    before: Vec<(usize, i32, i32)>,
    after: Vec<(usize, i32, i32)>,
    y: i32,
}

impl Layout {
    /// Lays `board` out.
    pub fn of(board: &Board, zoom: Zoom) -> Self {
        if board.cards.is_empty() {
            return Self::default();
        }
        let layer_of = layers(board);
        let count = layer_of.iter().max().map_or(0, |last| last + 1);
        let mut items: Vec<Item> = (0..board.cards.len())
            .map(|card| Item {
                card: Some(card),
                height: card_height(board, card, zoom),
                before: Vec::new(),
                after: Vec::new(),
                y: 0,
            })
            .collect();
        let mut order: Vec<Vec<usize>> = vec![Vec::new(); count];
        for (card, layer) in layer_of.iter().enumerate() {
            order[*layer].push(card);
        }
        let passes: usize =
            board.wires.iter().map(|wire| layer_of[wire.to.0].saturating_sub(layer_of[wire.from.0] + 1)).sum();
        // The way of each wire: the items it goes through, ends included.
        let mut ways: Vec<Vec<usize>> = Vec::with_capacity(board.wires.len());
        // Wires of one output share their ways.
        let mut shared: std::collections::HashMap<((usize, usize), usize), usize> = std::collections::HashMap::new();
        for wire in &board.wires {
            let (first, last) = (layer_of[wire.from.0], layer_of[wire.to.0]);
            let mut way = vec![wire.from.0];
            if first < last && passes <= MOST_PASSES {
                for (layer, members) in order.iter_mut().enumerate().take(last).skip(first + 1) {
                    let item = *shared.entry((wire.from, layer)).or_insert_with(|| {
                        items.push(Item { card: None, height: 1, before: Vec::new(), after: Vec::new(), y: 0 });
                        members.push(items.len() - 1);
                        items.len() - 1
                    });
                    way.push(item);
                }
            }
            way.push(wire.to.0);
            for pair in way.windows(2) {
                let out = if pair[0] == wire.from.0 { port_row(board, wire.from, false, zoom) } else { 0 };
                let into = if pair[1] == wire.to.0 { port_row(board, wire.to, true, zoom) } else { 0 };
                if !items[pair[0]].after.contains(&(pair[1], into, out)) {
                    items[pair[0]].after.push((pair[1], into, out));
                    items[pair[1]].before.push((pair[0], out, into));
                }
            }
            ways.push(way);
        }
        arrange(&mut order, &items);
        heights(&order, &mut items, zoom);
        place(board, zoom, &layer_of, &order, &items, &ways)
    }
}

/// The layer of each card: one more than the last of those it takes from. Cards in a circle stand where the circle is cut.
fn layers(board: &Board) -> Vec<usize> {
    let count = board.cards.len();
    let (mut waits, mut after) = (vec![0_usize; count], vec![Vec::new(); count]);
    for wire in board.wires.iter().filter(|wire| wire.from.0 != wire.to.0) {
        waits[wire.to.0] += 1;
        after[wire.from.0].push(wire.to.0);
    }
    let mut layer = vec![0; count];
    let mut done = vec![false; count];
    let mut open: Vec<usize> = (0..count).rev().filter(|card| waits[*card] == 0).collect();
    let mut next_cut = 0;
    loop {
        while let Some(card) = open.pop() {
            if std::mem::replace(&mut done[card], true) {
                continue;
            }
            for &other in &after[card] {
                waits[other] = waits[other].saturating_sub(1);
                if !done[other] {
                    layer[other] = layer[other].max(layer[card] + 1);
                    if waits[other] == 0 {
                        open.push(other);
                    }
                }
            }
        }
        while next_cut < count && done[next_cut] {
            next_cut += 1;
        }
        if next_cut == count {
            break;
        }
        open.push(next_cut);
    }
    // Sources stand right before those that need them, not all at the left edge.
    for card in (0..count).rev() {
        let takes_nothing = layer[card] == 0 && !after[card].is_empty();
        if takes_nothing {
            let nearest: usize = after[card].iter().map(|other| layer[*other]).min().unwrap_or(1);
            layer[card] = nearest.saturating_sub(1);
        }
    }
    if let Some(outputs) = board.cards.iter().position(|card| card.role == super::board::Role::Outputs) {
        layer[outputs] = layer.iter().copied().max().unwrap_or(0).max(1);
    }
    layer
}

fn card_height(board: &Board, card: usize, zoom: Zoom) -> i32 {
    let card = &board.cards[card];
    match zoom {
        Zoom::Compact => 1,
        Zoom::Normal => 2 + (card.inputs.len().max(card.outputs.len()).max(1)) as i32,
    }
}

/// The row of a port within its card.
pub fn port_row(_: &Board, port: (usize, usize), _: bool, zoom: Zoom) -> i32 {
    match zoom {
        Zoom::Compact => 0,
        Zoom::Normal => 1 + port.1 as i32,
    }
}

/// Orders the layers: each item by the mean position of its neighbours, there and back a few times.
fn arrange(order: &mut [Vec<usize>], items: &[Item]) {
    let mut at = vec![0.0_f64; items.len()];
    let note = |layer: &[usize], at: &mut [f64]| {
        let middle = layer.len() as f64 / 2.0;
        layer.iter().enumerate().for_each(|(position, item)| at[*item] = position as f64 - middle);
    };
    for layer in order.iter() {
        note(layer, &mut at);
    }
    let mean = |neighbours: &[(usize, i32, i32)], own: f64, at: &[f64]| {
        let sum: f64 = neighbours.iter().map(|(item, row, _)| at[*item] + f64::from(*row) * 0.05).sum();
        if neighbours.is_empty() { own } else { sum / neighbours.len() as f64 }
    };
    for round in 0..6 {
        let forwards = round % 2 == 0;
        let count = order.len();
        for step in 0..count {
            let layer = if forwards { step } else { count - 1 - step };
            let mut keyed: Vec<(f64, usize)> = order[layer]
                .iter()
                .map(|item| {
                    let neighbours = if forwards { &items[*item].before } else { &items[*item].after };
                    (mean(neighbours, at[*item], &at), *item)
                })
                .collect();
            keyed.sort_by(|a, b| a.0.total_cmp(&b.0));
            order[layer] = keyed.into_iter().map(|(_, item)| item).collect();
            note(&order[layer], &mut at);
        }
    }
}

/// Heights within the order: as near as can be to the mean of what each item is wired to.
fn heights(order: &[Vec<usize>], items: &mut [Item], zoom: Zoom) {
    let gap = match zoom {
        Zoom::Normal => 1,
        Zoom::Compact => 0,
    };
    for round in 0..5 {
        let forwards = round % 2 == 0;
        for step in 0..order.len() {
            let layer = &order[if forwards { step } else { order.len() - 1 - step }];
            let mut offset = 0;
            let mut wanted: Vec<(f64, f64)> = Vec::with_capacity(layer.len());
            let mut offsets = Vec::with_capacity(layer.len());
            for (position, item) in layer.iter().enumerate() {
                let item = &items[*item];
                let neighbours = if forwards { &item.before } else { &item.after };
                let wishes = neighbours.iter().map(|(other, theirs, own)| f64::from(items[*other].y + theirs - own));
                let (sum, count) = wishes.fold((0.0, 0.0), |(sum, count), wish| (sum + wish, count + 1.0));
                // What is wired to nothing on that side stays near where it is.
                let (wish, weight) = if count > 0.0 { (sum / count, 1.0) } else { (f64::from(item.y), 0.1) };
                let wish = if round == 0 && count == 0.0 { f64::from(offset) } else { wish };
                wanted.push((wish - f64::from(offset), weight));
                offsets.push(offset);
                let next_is_pass = layer.get(position + 1).is_some_and(|next| items[*next].card.is_none());
                let between_passes = item.card.is_none() && next_is_pass;
                offset += item.height + if between_passes { 0 } else { gap };
            }
            for ((item, level), offset) in layer.iter().zip(isotonic(&wanted)).zip(offsets) {
                items[*item].y = level.round() as i32 + offset;
            }
        }
    }
}

/// The rising sequence nearest to the wanted values: least sum of weight × (x − wanted)² with x₁ ≤ x₂ ≤ …, by pooling
/// adjacent violators.
fn isotonic(wanted: &[(f64, f64)]) -> Vec<f64> {
    let mut pools: Vec<(f64, f64, usize)> = Vec::new();
    for (value, weight) in wanted {
        let mut pool = (*value, *weight, 1);
        while let Some(last) = pools.last() {
            if last.0 <= pool.0 {
                break;
            }
            let weight = last.1 + pool.1;
            pool = ((last.0 * last.1 + pool.0 * pool.1) / weight, weight, last.2 + pool.2);
            pools.pop();
        }
        pools.push(pool);
    }
    pools.into_iter().flat_map(|(value, _, count)| std::iter::repeat_n(value, count)).collect()
}

/// Columns of layers and of the turns between them.
fn place(
    board: &Board,
    zoom: Zoom,
    layer_of: &[usize],
    order: &[Vec<usize>],
    items: &[Item],
    ways: &[Vec<usize>],
) -> Layout {
    let top = items.iter().map(|item| item.y).min().unwrap_or(0);
    let mut layout = Layout { gaps: vec![Gap::default(); order.len()], ..Layout::default() };
    let mut run_of: std::collections::HashMap<((usize, usize), usize, i32), usize> = std::collections::HashMap::new();
    for (wire, way) in board.wires.iter().zip(ways) {
        let first = layer_of[wire.from.0];
        for (step, pair) in way.windows(2).enumerate() {
            let gap = &mut layout.gaps[first + step];
            let out = if step == 0 { port_row(board, wire.from, false, zoom) } else { 0 };
            let into = if step + 2 == way.len() { port_row(board, wire.to, true, zoom) } else { 0 };
            let (y, to) = (items[pair[0]].y + out - top, items[pair[1]].y + into - top);
            let run = *run_of.entry((wire.from, first + step, y)).or_insert_with(|| {
                gap.runs.push(Run { from: wire.from, y, turn: 0, to: Vec::new() });
                gap.runs.len() - 1
            });
            if !gap.runs[run].to.contains(&(to, wire.to.0)) {
                gap.runs[run].to.push((to, wire.to.0));
            }
            if items[pair[1]].card.is_none() {
                gap.passing.push((to, wire.from, wire.to.0));
            }
        }
    }
    let width = if zoom == Zoom::Normal { NORMAL_WIDTH } else { COMPACT_WIDTH };
    let (mut x, mut left_of) = (0, Vec::with_capacity(order.len()));
    for gap in &mut layout.gaps {
        left_of.push(x);
        gap.left = x + width;
        let tracks = tracks(&mut gap.runs);
        gap.right = gap.left + if gap.runs.is_empty() { 4 } else { 3 + tracks };
        for run in &mut gap.runs {
            run.turn += gap.left + 1;
        }
        x = gap.right;
    }
    layout.places = (0..board.cards.len())
        .map(|card| {
            let (layer, y) = (layer_of[card], items[card].y - top);
            Place { x: left_of[layer], y, width, height: items[card].height, layer }
        })
        .collect();
    layout.width = layout.gaps.last().map_or(0, |gap| gap.left);
    layout.height = items.iter().map(|item| item.y + item.height - top).max().unwrap_or(0);
    layout
}

/// Gives each run a column, so that runs that share one do not overlap while there are columns enough. Gives their number.
fn tracks(runs: &mut [Run]) -> i32 {
    let mut turning: Vec<usize> =
        (0..runs.len()).filter(|run| runs[*run].to.iter().any(|to| to.0 != runs[*run].y)).collect();
    let ends = |run: &Run| {
        let heights = || run.to.iter().map(|to| to.0).chain([run.y]);
        (heights().min().unwrap_or(run.y), heights().max().unwrap_or(run.y))
    };
    turning.sort_by_key(|run| ends(&runs[*run]));
    let mut last_of: Vec<i32> = Vec::new();
    for run in turning {
        let (low, high) = ends(&runs[run]);
        let free = last_of.iter().position(|last| *last < low);
        let track = free.unwrap_or_else(|| {
            if (last_of.len() as i32) < MOST_TRACKS {
                last_of.push(i32::MIN);
                last_of.len() - 1
            } else {
                run % MOST_TRACKS as usize
            }
        });
        last_of[track] = last_of[track].max(high);
        runs[run].turn = track as i32;
    }
    (last_of.len() as i32).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// For every order-keeping sequence the sum of squares is no less than that of the result.
        #[test]
        fn isotonic_is_the_nearest_rising_sequence(
            wanted in prop::collection::vec(-9.0..9.0_f64, 1..7),
            other in prop::collection::vec(0.0..4.0_f64, 7),
            start in -9.0..9.0_f64,
        ) {
            let pairs: Vec<_> = wanted.iter().map(|value| (*value, 1.0)).collect();
            let found = isotonic(&pairs);
            prop_assert!(found.windows(2).all(|pair| pair[0] <= pair[1] + 1e-12));
            let cost = |x: &[f64]| x.iter().zip(&wanted).map(|(x, w)| (x - w).powi(2)).sum::<f64>();
            let mut level = start;
            let rising: Vec<f64> = other.iter().take(wanted.len()).map(|step| { level += step; level }).collect();
            prop_assert!(cost(&found) <= cost(&rising) + 1e-9);
        }
    }
}
