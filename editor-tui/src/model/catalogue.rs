//! The kinds of nodes that may be added: what they are called, take and give, and how they are found by a few letters.

use graph_core::node::{KindDescription, Kinds, PortFacts, describe};
use std::collections::BTreeMap;

/// A kind as the editor knows it.
#[derive(Debug, Clone)]
pub struct KindFacts {
    /// What its manual says.
    pub manual: KindDescription,
    /// Its inputs.
    pub inputs: Vec<PortFacts>,
    /// Its outputs.
    pub outputs: Vec<PortFacts>,
}

/// All kinds that can be had.
#[derive(Debug, Clone, Default)]
pub struct Catalogue(BTreeMap<String, KindFacts>);

impl Catalogue {
    /// The kinds linked into this program.
    pub fn of_program() -> Self {
        Self::of(&Kinds::default())
    }

    /// The kinds that a graph may name: those of the program and those of plugins.
    pub fn of(kinds: &Kinds) -> Self {
        let facts = kinds.all().into_iter().map(|(name, kind)| {
            let card = kind.card();
            (name.to_owned(), KindFacts { manual: describe(kind), inputs: card.inputs, outputs: card.outputs })
        });
        Self(facts.collect())
    }

    /// The kind called `name`.
    pub fn get(&self, name: &str) -> Option<&KindFacts> {
        self.0.get(name)
    }

    /// The names of the kinds that plugins brought: `plugin-id/node`.
    pub fn brought(&self) -> impl Iterator<Item = &str> {
        self.0.keys().map(String::as_str).filter(|name| name.contains('/'))
    }

    /// The kinds that `typed` may mean, the likeliest first; all where nothing is typed.
    pub fn find(&self, typed: &str, fits: impl Fn(&KindFacts) -> bool) -> Vec<&KindFacts> {
        let fitting = self.0.values().filter(|kind| fits(kind));
        let mut found: Vec<(u32, &KindFacts)> =
            fitting.filter_map(|kind| Some((closeness(typed, &kind.manual.name)?, kind))).collect();
        found.sort_by(|(a, one), (b, other)| a.cmp(b).then_with(|| one.manual.name.cmp(&other.manual.name)));
        found.into_iter().map(|(_, kind)| kind).collect()
    }
}

/// How far `typed` is from `name`, `None` where its letters do not stand in it in their order. The first letters of words come
/// before letters in a row, those before letters anywhere: `gf` finds `graph_features` first.
pub fn closeness(typed: &str, name: &str) -> Option<u32> {
    let typed: Vec<char> = typed.chars().filter(|c| !c.is_whitespace()).flat_map(char::to_lowercase).collect();
    let letters: Vec<char> = name.chars().flat_map(char::to_lowercase).collect();
    if typed.is_empty() {
        return Some(0);
    }
    let begins = |at: usize| at == 0 || matches!(letters[at - 1], '_' | '-' | '/' | ' ');
    // cost[t]: least cost with typed[..t] matched, and whether the last match was the letter before this one.
    let mut apart = vec![u32::MAX; typed.len() + 1];
    let mut joined = vec![u32::MAX; typed.len() + 1];
    apart[0] = 0;
    for (at, letter) in letters.iter().enumerate() {
        for t in (1..=typed.len()).rev() {
            let matched = if *letter == typed[t - 1] {
                let leap = if begins(at) { 1 } else { 12 };
                let from_apart = apart[t - 1].saturating_add(leap);
                let from_joined = joined[t - 1].saturating_add(if begins(at) { 1 } else { 2 });
                from_apart.min(from_joined)
            } else {
                u32::MAX
            };
            apart[t] = apart[t].min(joined[t]);
            joined[t] = matched;
        }
        apart[0] = 0;
        joined[0] = u32::MAX;
    }
    let cost = apart[typed.len()].min(joined[typed.len()]);
    (cost != u32::MAX).then(|| cost * 64 + (letters.len() as u32).min(63))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nodes as _;

    fn first(typed: &str) -> String {
        Catalogue::of_program().find(typed, |_| true)[0].manual.name.clone()
    }

    #[test]
    fn kinds_are_found_by_first_letters_and_by_parts() {
        assert_eq!(first("gf"), "graph_features");
        assert_eq!(first("smc"), "smooth_curves");
        assert_eq!(first("skinj"), "skin_jaw");
        assert_eq!(first("rom"), "range_of_motion");
        assert!(closeness("fg", "graph_features").is_none());
        assert!(closeness("sj", "solve_jaw") < closeness("sj", "measure_jitter"));
    }
}
