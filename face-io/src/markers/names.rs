//! Names of points that differ, whatever a file calls them.

use std::collections::{BTreeMap, BTreeSet};

/// Gives each point a name of its own, and says which names are not those of the file.
///
/// A point without a label is called `point_N`, N counted from 1; a label that stands twice is made to differ by `#2`,
/// `#3` ….
pub(crate) fn unique(labels: Vec<String>) -> (Vec<String>, Vec<String>) {
    let mut taken: BTreeSet<String> = labels.iter().filter(|label| !label.is_empty()).cloned().collect();
    let mut seen = BTreeSet::new();
    // Where counting stands for each label: from the start each time, it would take a time that grows with the square.
    let mut numbers: BTreeMap<String, usize> = BTreeMap::new();
    let mut renamed = Vec::new();
    let mut names = Vec::with_capacity(labels.len());
    for (index, label) in labels.into_iter().enumerate() {
        if !label.is_empty() && seen.insert(label.clone()) {
            names.push(label);
            continue;
        }
        let bare = label.is_empty();
        let stem = if bare { format!("point_{}", index + 1) } else { label };
        let mut name = stem.clone();
        if !(bare && taken.insert(name.clone())) {
            let number = numbers.entry(stem.clone()).or_insert(1);
            loop {
                *number += 1;
                name = format!("{stem}#{number}");
                if taken.insert(name.clone()) {
                    break;
                }
            }
        }
        renamed.push(name.clone());
        names.push(name);
    }
    (names, renamed)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unique_of(labels: &[&str]) -> Vec<String> {
        unique(labels.iter().map(|label| (*label).to_owned()).collect()).0
    }

    #[test]
    fn labels_that_are_absent_or_stand_twice_are_made_to_differ() {
        assert_eq!(unique_of(&["a", "", "a", "a#2", "a"]), ["a", "point_2", "a#3", "a#2", "a#4"]);
        assert_eq!(unique_of(&["point_2", ""]), ["point_2", "point_2#2"]);
        let (_, renamed) = unique(vec!["a".to_owned(), "a".to_owned()]);
        assert_eq!(renamed, ["a#2"]);
    }

    #[test]
    fn a_label_that_stands_everywhere_costs_no_more_than_others() {
        let (names, renamed) = unique(vec!["x".to_owned(); 60_000]);
        assert_eq!((names[59_999].as_str(), renamed.len()), ("x#60000", 59_999));
    }
}
