//! The nearest valid name to one that was not found, for "did you mean" in diagnostics.

/// The candidate that was most likely meant by `wanted`, or `None` where none is near.
///
/// Near means few edits (insertions, removals, replacements, swaps of neighbours) without regard to case and to
/// `-` or `_`, one name beginning with the other (`cutoff` for `cutoff_hz`), or the same words in another order.
pub fn did_you_mean<'a>(wanted: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let wanted_letters = letters(wanted);
    if wanted_letters.is_empty() {
        return None;
    }
    candidates
        .into_iter()
        .filter(|candidate| *candidate != wanted)
        .filter_map(|candidate| Some((cost(&wanted_letters, &letters(candidate))?, candidate)))
        .min()
        .map(|(_, candidate)| candidate.to_owned())
}

/// "did you mean `x`?" where a name is near, otherwise the list of what there is.
pub fn nearest_or_all<'a>(what: &str, wanted: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<String> {
    const LISTED: usize = 24;
    let candidates: Vec<&str> = candidates.into_iter().collect();
    let list = |names: &[&str]| names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    let all = match candidates.len() {
        0 => None,
        count if count <= LISTED => Some(format!("{what}: {}", list(&candidates))),
        count => Some(format!("{what}: {} and {} more", list(&candidates[..LISTED]), count - LISTED)),
    };
    match (did_you_mean(wanted, candidates.iter().copied()), all) {
        (Some(near), Some(_)) if candidates.len() == 1 => Some(format!("did you mean `{near}`?")),
        (Some(near), Some(all)) => Some(format!("did you mean `{near}`? {all}")),
        (None, all) => all,
        (near, None) => near,
    }
}

/// Lower-case letters with `-` and blanks as `_`, so that spelling habits cost nothing.
fn letters(name: &str) -> Vec<char> {
    name.chars().flat_map(char::to_lowercase).map(|c| if matches!(c, '-' | ' ') { '_' } else { c }).collect()
}

/// How far `candidate` is from `wanted`, in tenths of an edit; `None` where it is too far to be meant.
fn cost(wanted: &[char], candidate: &[char]) -> Option<usize> {
    let longest = wanted.len().max(candidate.len());
    let shortest = wanted.len().min(candidate.len());
    let shared = wanted.iter().zip(candidate).take_while(|(a, b)| a == b).count();
    if shortest >= 3 && shared == shortest {
        return Some(5 + longest - shortest);
    }
    if sorted_words(wanted) == sorted_words(candidate) {
        return Some(8);
    }
    // Names longer than this are no typing mistakes of one another unless nearly equal in length.
    if longest - shortest > longest / 3 + 1 || longest > 256 {
        return None;
    }
    let edits = edit_distance(wanted, candidate);
    let allowed = if longest <= 2 { usize::from(shared > 0 || edits == 0) } else { (longest / 3).max(1) };
    (edits <= allowed).then(|| (10 * edits).saturating_sub(shared.min(4)) + 1)
}

fn sorted_words(name: &[char]) -> Vec<&[char]> {
    let mut words: Vec<&[char]> = name.split(|c| *c == '_').collect();
    words.sort_unstable();
    words
}

/// Optimal string alignment distance: the fewest insertions, removals, replacements and swaps of neighbours, where
/// no part is edited twice. d(i, j) over prefixes of `a` and `b`, three rows kept (Damerau 1964, Levenshtein 1966).
fn edit_distance(a: &[char], b: &[char]) -> usize {
    let mut before: Vec<usize> = Vec::new();
    let mut above: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut row = vec![i];
        for j in 1..=b.len() {
            let replaced = above[j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut least = replaced.min(above[j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                least = least.min(before[j - 2] + 1);
            }
            row.push(least);
        }
        before = std::mem::replace(&mut above, row);
    }
    above[b.len()]
}

#[cfg(test)]
mod tests {
    use super::{did_you_mean, edit_distance, nearest_or_all};

    fn distance(a: &str, b: &str) -> usize {
        edit_distance(&a.chars().collect::<Vec<_>>(), &b.chars().collect::<Vec<_>>())
    }

    #[test]
    fn distances() {
        assert_eq!(distance("", ""), 0);
        assert_eq!(distance("", "abc"), 3);
        assert_eq!(distance("kitten", "sitting"), 3);
        assert_eq!(distance("hodl", "hold"), 1);
        assert_eq!(distance("ca", "abc"), 3);
    }

    #[test]
    fn what_was_meant() {
        let kinds = ["load_markers", "load_rig", "save_curves", "smooth_curves", "solve_jaw"];
        let meant = |wanted| did_you_mean(wanted, kinds);
        assert_eq!(meant("smoth_curves").as_deref(), Some("smooth_curves"));
        assert_eq!(meant("Smooth-Curves").as_deref(), Some("smooth_curves"));
        assert_eq!(meant("curves_smooth").as_deref(), Some("smooth_curves"));
        assert_eq!(meant("load_rgi").as_deref(), Some("load_rig"));
        assert_eq!(meant("smooth").as_deref(), Some("smooth_curves"));
        assert_eq!(meant("render_turntable"), None);
        assert_eq!(meant(""), None);
        assert_eq!(did_you_mean("cutoff", ["order", "cutoff_hz"]).as_deref(), Some("cutoff_hz"));
        assert_eq!(did_you_mean("x", ["y", "z"]), None);
    }

    #[test]
    fn all_names_stand_where_none_is_near() {
        assert_eq!(nearest_or_all("fields", "zzz", ["kind", "with"]).as_deref(), Some("fields: `kind`, `with`"));
        assert_eq!(
            nearest_or_all("fields", "knid", ["kind", "with"]).as_deref(),
            Some("did you mean `kind`? fields: `kind`, `with`")
        );
        assert_eq!(nearest_or_all("fields", "knid", ["kind"]).as_deref(), Some("did you mean `kind`?"));
        assert_eq!(nearest_or_all("fields", "x", []), None);
    }
}
