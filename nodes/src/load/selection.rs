//! Which names of a file to keep, and under which names: what the loaders of markers and of curves have in common.

use crate::patterns::Patterns;
use face_math::data::nearest_name;
use graph_core::node::NodeError;
use std::collections::{BTreeMap, BTreeSet};

/// The parameters `only`, `without` and `rename` of a loader.
pub(super) struct Selection<'a> {
    /// What is named, for messages: `marker` or `channel`.
    pub what: &'static str,
    /// Patterns of names to keep; all where empty.
    pub only: &'a [String],
    /// Patterns of names to leave out.
    pub without: &'a [String],
    /// New names by old ones.
    pub rename: &'a BTreeMap<String, String>,
}

impl Selection<'_> {
    /// The kept names of `names`: position and new name of each, in the order of the file.
    ///
    /// # Errors
    /// Where a pattern or an old name fits nothing in the file, nothing is left, or two would have the same name.
    pub fn apply(&self, file: &str, names: &[String]) -> Result<Vec<(usize, String)>, NodeError> {
        let fits = |parameter, texts: &[String]| {
            Patterns { parameter, what: self.what, names }.fits(texts).map_err(|error| in_file(file, error))
        };
        let (only, without) = (fits("only", self.only)?, fits("without", self.without)?);
        let kept = |index: usize| (self.only.is_empty() || only[index]) && !without[index];
        let kept: Vec<usize> = (0..names.len()).filter(|index| kept(*index)).collect();
        if kept.is_empty() {
            let problem = format!("no {} of {file} is left, of {}", self.what, names.len());
            return Err(NodeError::parameter(if without.is_empty() { "only" } else { "without" }, problem));
        }
        for old in self.rename.keys() {
            if !names.contains(old) {
                let near = nearest_name(old, names.iter().map(String::as_str));
                let near = near.map_or(String::new(), |near| format!("; did you mean `{near}`?"));
                let problem = format!("no {} of {file} is called `{old}`{near}", self.what);
                return Err(NodeError::parameter("rename", problem));
            }
        }
        let mut taken = BTreeSet::new();
        let mut renamed = Vec::with_capacity(kept.len());
        for index in kept {
            let name = self.rename.get(&names[index]).unwrap_or(&names[index]);
            if name.is_empty() {
                return Err(NodeError::parameter("rename", format!("`{}` needs a new name", names[index])));
            }
            if !taken.insert(name) {
                let problem = format!("two {}s of {file} would be called `{name}`; names must differ", self.what);
                return Err(NodeError::parameter("rename", problem));
            }
            renamed.push((index, name.clone()));
        }
        Ok(renamed)
    }
}

/// The error of a pattern, with the file whose names it was held against.
fn in_file(file: &str, error: NodeError) -> NodeError {
    match error {
        NodeError::Parameter { parameter, problem } => {
            NodeError::Parameter { parameter, problem: format!("{file}: {problem}") }
        }
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names() -> Vec<String> {
        ["chin", "lip_1", "lip_2", "head_1"].map(str::to_owned).to_vec()
    }

    fn select(only: &[&str], without: &[&str], rename: &[(&str, &str)]) -> Result<Vec<(usize, String)>, String> {
        let own = |texts: &[&str]| texts.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>();
        let rename = rename.iter().map(|(old, new)| ((*old).to_owned(), (*new).to_owned())).collect();
        let selection = Selection { what: "marker", only: &own(only), without: &own(without), rename: &rename };
        selection.apply("a.c3d", &names()).map_err(|error| error.to_string())
    }

    #[test]
    fn patterns_keep_and_leave_out_in_the_order_of_the_file() {
        let all = select(&[], &[], &[]).unwrap();
        assert_eq!(all.into_iter().map(|(_, name)| name).collect::<Vec<_>>(), names());
        let some = select(&["lip_*", "chin"], &["*_2"], &[("chin", "mental")]).unwrap();
        assert_eq!(some, [(0, "mental".to_owned()), (1, "lip_1".to_owned())]);
    }

    #[test]
    fn what_fits_nothing_is_an_error_with_the_nearest_name() {
        let error = select(&["chinn"], &[], &[]).unwrap_err();
        assert_eq!(error, "parameter `only`: a.c3d: no marker fits `chinn`; did you mean `chin`?");
        let error = select(&[], &["brow_*"], &[]).unwrap_err();
        assert!(error.contains("`without`") && error.contains("there are 4 markers: `chin`, "), "{error}");
        let error = select(&[], &[], &[("lip_3", "a")]).unwrap_err();
        assert!(error.contains("is called `lip_3`; did you mean `lip_"), "{error}");
        assert!(select(&["["], &[], &[]).unwrap_err().contains("`only`"));
    }

    #[test]
    fn an_empty_selection_and_equal_names_are_refused() {
        assert!(select(&["chin"], &["chin"], &[]).unwrap_err().contains("no marker of a.c3d is left"));
        assert!(select(&[], &[], &[("chin", "lip_1")]).unwrap_err().contains("two markers"));
        assert!(select(&[], &[], &[("chin", "")]).unwrap_err().contains("needs a new name"));
    }
}
