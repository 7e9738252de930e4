//! Merging two edits of one text, line by line: both are kept where they do not touch.

use std::ops::Range;

/// What two edits of a text make together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Merged {
    /// Both edits in one text.
    Clean(String),
    /// They touch the same or neighbouring lines.
    Touching,
}

/// Merges `mine` and `theirs`, two edits of `base`.
pub fn merge(base: &str, mine: &str, theirs: &str) -> Merged {
    let [base, mine, theirs] = [base, mine, theirs].map(|text| text.split_inclusive('\n').collect::<Vec<_>>());
    let (ours, others) = (hunks(&base, &mine), hunks(&base, &theirs));
    let mut all: Vec<(&Hunk, &[&str])> = ours.iter().map(|hunk| (hunk, &mine[hunk.to.clone()])).collect();
    for hunk in &others {
        let new = &theirs[hunk.to.clone()];
        let equal = ours.iter().any(|own| own.from == hunk.from && mine[own.to.clone()] == *new);
        if !equal {
            all.push((hunk, new));
        }
    }
    all.sort_by_key(|(hunk, _)| (hunk.from.start, hunk.from.end));
    if all.windows(2).any(|pair| pair[0].0.from.end >= pair[1].0.from.start) {
        return Merged::Touching;
    }
    let (mut out, mut at) = (String::new(), 0);
    for (hunk, new) in all {
        out.extend(base[at..hunk.from.start].iter().copied().chain(new.iter().copied()));
        at = hunk.from.end;
    }
    out.extend(base[at..].iter().copied());
    Merged::Clean(out)
}

/// Lines `from` of one text that became lines `to` of another.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Hunk {
    from: Range<usize>,
    to: Range<usize>,
}

/// What differs between two texts, by a longest common subsequence of the lines between their common ends.
fn hunks(a: &[&str], b: &[&str]) -> Vec<Hunk> {
    let head = a.iter().zip(b).take_while(|(x, y)| x == y).count();
    let most = a.len().min(b.len()) - head;
    let tail = a.iter().rev().zip(b.iter().rev()).take(most).take_while(|(x, y)| x == y).count();
    let (inner_a, inner_b) = (&a[head..a.len() - tail], &b[head..b.len() - tail]);
    // A table of this size is made in an instant; beyond it, all that differs counts as one.
    if inner_a.len() * inner_b.len() > 4_000_000 || inner_a.is_empty() || inner_b.is_empty() {
        let whole = Hunk { from: head..a.len() - tail, to: head..b.len() - tail };
        return if whole.from.is_empty() && whole.to.is_empty() { Vec::new() } else { vec![whole] };
    }
    // length[i][j]: lines that inner_a[i..] and inner_b[j..] have in common in their order.
    let width = inner_b.len() + 1;
    let mut length = vec![0_u32; (inner_a.len() + 1) * width];
    for i in (0..inner_a.len()).rev() {
        for j in (0..inner_b.len()).rev() {
            length[i * width + j] = if inner_a[i] == inner_b[j] {
                length[(i + 1) * width + j + 1] + 1
            } else {
                length[(i + 1) * width + j].max(length[i * width + j + 1])
            };
        }
    }
    let (mut found, mut i, mut j): (Vec<Hunk>, _, _) = (Vec::new(), 0, 0);
    while i < inner_a.len() || j < inner_b.len() {
        if i < inner_a.len() && j < inner_b.len() && inner_a[i] == inner_b[j] {
            (i, j) = (i + 1, j + 1);
            continue;
        }
        let down =
            i < inner_a.len() && (j == inner_b.len() || length[(i + 1) * width + j] >= length[i * width + j + 1]);
        let (from, to) = (head + i, head + j);
        (i, j) = if down { (i + 1, j) } else { (i, j + 1) };
        let (next_from, next_to) = (head + i, head + j);
        match found.last_mut() {
            Some(last) if last.from.end == from && last.to.end == to => {
                (last.from.end, last.to.end) = (next_from, next_to);
            }
            _ => found.push(Hunk { from: from..next_from, to: to..next_to }),
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn edits_apart_stand_together() {
        let base = "a\nb\nc\nd\ne\nf\n";
        let merged = merge(base, "A\nb\nc\nd\ne\nf\n", "a\nb\nc\nx\ny\ne\n");
        assert_eq!(merged, Merged::Clean("A\nb\nc\nx\ny\ne\n".into()));
        assert_eq!(merge(base, "A\nb\nc\nd\ne\nf\n", "a\nB\nc\nd\ne\nf\n"), Merged::Touching);
        assert_eq!(merge(base, "a\nc\nd\ne\nf\n", "a\nc\nd\ne\nf\ng\n"), Merged::Clean("a\nc\nd\ne\nf\ng\n".into()));
    }

    proptest! {
        /// With one text unchanged, the other is the result; the order of the two does not matter.
        #[test]
        fn merging_with_nothing_gives_the_edit(
            base in prop::collection::vec("[a-c]\n", 0..12),
            mine in prop::collection::vec("[a-d]\n", 0..12),
            theirs in prop::collection::vec("[a-d]\n", 0..12),
        ) {
            let [base, mine, theirs] = [base, mine, theirs].map(|lines| lines.concat());
            prop_assert_eq!(merge(&base, &mine, &base), Merged::Clean(mine.clone()));
            prop_assert_eq!(merge(&base, &base, &theirs), Merged::Clean(theirs.clone()));
            prop_assert_eq!(merge(&base, &mine, &theirs), merge(&base, &theirs, &mine));
        }
    }
}
