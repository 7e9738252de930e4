//! Which names to keep, and under which names: what the loaders of markers and of curves have in common with retargeting.

use crate::patterns::{Patterns, listed};
use face_math::data::nearest_name;
use graph_core::node::NodeError;
use std::collections::{BTreeMap, BTreeSet};

/// The parameters `only`, `without` and `rename` of a loader.
pub(crate) struct Selection<'a> {
    /// What is named, for messages: `marker` or `channel`.
    pub what: &'static str,
    /// Patterns of names to keep; all where empty.
    pub only: &'a [String],
    /// Patterns of names to leave out.
    pub without: &'a [String],
    /// New names by old ones, or by patterns of them.
    pub rename: &'a BTreeMap<String, String>,
    /// How strictly they are held against the file.
    pub mapping: Mapping,
}

/// How strictly the names of a selection are held against those of a file.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Mapping {
    /// Whether names and patterns may fit nothing in the file.
    pub allow_absent: bool,
    /// Whether names that `rename` does not mention are left out.
    pub only_mapped: bool,
    /// Whether names that `rename` does not mention are an error.
    pub all_mapped: bool,
}

/// What a selection keeps.
#[derive(Debug, PartialEq)]
pub(crate) struct Chosen {
    /// Position in the file and new name of each kept name, in the order of the file.
    pub kept: Vec<(usize, String)>,
    /// Names of the file that `rename` does not mention, of those that `only` and `without` leave.
    pub unmapped: Vec<String>,
    /// Names and patterns of `rename` that the file lacks.
    pub absent: Vec<String>,
}

impl Selection<'_> {
    /// The kept names of `names`.
    ///
    /// # Errors
    /// Where a pattern or an old name fits nothing in the file, nothing is left, or two would have the same name.
    pub fn apply(&self, file: &str, names: &[String]) -> Result<Chosen, NodeError> {
        let fits = |parameter, texts: &[String]| {
            let patterns = Patterns { parameter, what: self.what, names };
            let fits = if self.mapping.allow_absent { patterns.may_fit(texts) } else { patterns.fits(texts) };
            fits.map_err(|error| in_file(file, error))
        };
        let (only, without) = (fits("only", self.only)?, fits("without", self.without)?);
        let kept = |index: usize| (self.only.is_empty() || only[index]) && !without[index];
        let left: Vec<usize> = (0..names.len()).filter(|index| kept(*index)).collect();
        if left.is_empty() {
            return Err(self.nothing_left(file, names, if without.contains(&true) { "without" } else { "only" }));
        }
        let absent = self.absent(file, names)?;
        let mut taken = BTreeSet::new();
        let mut chosen = Chosen { kept: Vec::with_capacity(left.len()), unmapped: Vec::new(), absent };
        for index in left {
            let new = self.new_name(&names[index])?;
            if new.is_none() {
                chosen.unmapped.push(names[index].clone());
                if self.mapping.only_mapped {
                    continue;
                }
            }
            let name = new.unwrap_or_else(|| names[index].clone());
            if name.is_empty() {
                return Err(NodeError::parameter("rename", format!("`{}` needs a new name", names[index])));
            }
            if !taken.insert(name.clone()) {
                let problem = format!("two {}s of {file} would be called `{name}`; names must differ", self.what);
                return Err(NodeError::parameter("rename", problem));
            }
            chosen.kept.push((index, name));
        }
        if self.mapping.all_mapped && !chosen.unmapped.is_empty() {
            let problem = format!("{file}: `rename` does not mention {}", listed(&chosen.unmapped, self.what));
            return Err(NodeError::parameter("all_mapped", problem));
        }
        if chosen.kept.is_empty() {
            return Err(self.nothing_left(file, names, "only_mapped"));
        }
        Ok(chosen)
    }

    fn nothing_left(&self, file: &str, names: &[String], parameter: &str) -> NodeError {
        NodeError::parameter(parameter, format!("no {} of {file} is left, of {}", self.what, names.len()))
    }

    /// Names and patterns of `rename` that no name fits.
    fn absent(&self, file: &str, names: &[String]) -> Result<Vec<String>, NodeError> {
        let fits = |old: &String| names.iter().any(|name| name == old || captures(old, name).is_some());
        let absent: Vec<String> = self.rename.keys().filter(|old| !fits(old)).cloned().collect();
        match absent.first() {
            Some(old) if !self.mapping.allow_absent => {
                let near = nearest_name(old, names.iter().map(String::as_str));
                let near = near.map_or(String::new(), |near| format!("; did you mean `{near}`?"));
                let more = match absent.len() - 1 {
                    0 => String::new(),
                    more => format!(" (nor are {more} others that it names)"),
                };
                let problem = format!("no {} of {file} is called `{old}`{near}{more}", self.what);
                Err(NodeError::parameter("rename", problem))
            }
            _ => Ok(absent),
        }
    }

    /// The new name of `name`: that which stands for the name itself, else that of the longest pattern that fits, of
    /// equally long ones the first.
    fn new_name(&self, name: &str) -> Result<Option<String>, NodeError> {
        if let Some(new) = self.rename.get(name) {
            return Ok(Some(new.clone()));
        }
        let fitting = self.rename.iter().filter_map(|(old, new)| captures(old, name).map(|parts| (old, new, parts)));
        let length = |old: &str| old.chars().count();
        let longest = fitting.reduce(|best, next| if length(next.0) > length(best.0) { next } else { best });
        let Some((old, new, parts)) = longest else { return Ok(None) };
        if new.matches('*').count() > parts.len() {
            let problem = format!("`{new}` has more `*` than `{old}`, which says what stands for them");
            return Err(NodeError::parameter("rename", problem));
        }
        let mut parts = parts.into_iter();
        let mut name = String::new();
        for (index, text) in new.split('*').enumerate() {
            if index > 0 {
                name += parts.next().unwrap_or_default();
            }
            name += text;
        }
        Ok(Some(name))
    }
}

/// What each `*` of `pattern` stands for in `name`, where the pattern has one and fits; each stands for as little as it
/// can.
fn captures<'a>(pattern: &str, name: &'a str) -> Option<Vec<&'a str>> {
    let (first, rest) = pattern.split_once('*')?;
    let mut name = name.strip_prefix(first)?;
    let mut parts = Vec::new();
    let mut texts = rest.split('*').peekable();
    while let Some(text) = texts.next() {
        let at = if texts.peek().is_some() {
            name.find(text)?
        } else {
            name.ends_with(text).then(|| name.len() - text.len())?
        };
        parts.push(&name[..at]);
        name = &name[at + text.len()..];
    }
    Some(parts)
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

    fn chosen(only: &[&str], without: &[&str], rename: &[(&str, &str)], mapping: Mapping) -> Result<Chosen, String> {
        let own = |texts: &[&str]| texts.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>();
        let rename = rename.iter().map(|(old, new)| ((*old).to_owned(), (*new).to_owned())).collect();
        let (only, without) = (own(only), own(without));
        let selection = Selection { what: "marker", only: &only, without: &without, rename: &rename, mapping };
        selection.apply("a.c3d", &names()).map_err(|error| error.to_string())
    }

    fn select(only: &[&str], without: &[&str], rename: &[(&str, &str)]) -> Result<Vec<(usize, String)>, String> {
        chosen(only, without, rename, Mapping::default()).map(|chosen| chosen.kept)
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
        let error = select(&[], &[], &[("lip_3", "a"), ("nose", "b")]).unwrap_err();
        assert!(error.contains("is called `lip_3`; did you mean `lip_") && error.contains("1 others"), "{error}");
        assert!(select(&["["], &[], &[]).unwrap_err().contains("`only`"));
    }

    #[test]
    fn an_empty_selection_and_equal_names_are_refused() {
        assert!(select(&["chin"], &["chin"], &[]).unwrap_err().contains("no marker of a.c3d is left"));
        assert!(select(&[], &[], &[("chin", "lip_1")]).unwrap_err().contains("two markers"));
        assert!(select(&[], &[], &[("chin", "")]).unwrap_err().contains("needs a new name"));
    }

    #[test]
    fn patterns_rename_what_they_fit_and_names_go_before_them() {
        let new = |rename: &[(&str, &str)]| {
            select(&[], &[], rename).map(|kept| kept.into_iter().map(|(_, name)| name).collect::<Vec<_>>())
        };
        let map = [("*_*", "*.*"), ("lip_*", "mouth_*_L"), ("lip_2", "mouth_up")];
        assert_eq!(new(&map).unwrap(), ["chin", "mouth_1_L", "mouth_up", "head.1"]);
        assert_eq!(new(&[("*", "face_*")]).unwrap()[0], "face_chin");
        assert!(new(&[("lip_*", "*_*")]).unwrap_err().contains("more `*` than `lip_*`"));
        assert!(new(&[("lip_*", "lip")]).unwrap_err().contains("two markers"));
        assert!(new(&[("nose_*", "*")]).unwrap_err().contains("is called `nose_*`"));
        assert_eq!(captures("a*b*c", "a1b2bc"), Some(vec!["1", "2b"]));
        assert_eq!(captures("a*a", "a"), None);
    }

    #[test]
    fn what_the_map_and_the_file_do_not_share_is_told_both_ways() {
        let map = [("chin", "mental"), ("nose", "nasal")];
        let lenient = Mapping { allow_absent: true, ..Mapping::default() };
        let some = chosen(&[], &["brow_*"], &map, lenient).unwrap();
        assert_eq!((some.kept.len(), some.unmapped.len(), some.absent), (4, 3, vec!["nose".to_owned()]));
        let mapped = chosen(&[], &[], &map, Mapping { only_mapped: true, ..lenient }).unwrap();
        assert_eq!((mapped.kept, mapped.unmapped.len()), (vec![(0, "mental".to_owned())], 3));
        let error = chosen(&[], &[], &map, Mapping { all_mapped: true, ..lenient }).unwrap_err();
        assert!(error.contains("does not mention 3 markers: `lip_1`, `lip_2`, `head_1`"), "{error}");
        let error = chosen(&[], &[], &[], Mapping { only_mapped: true, ..lenient }).unwrap_err();
        assert!(error.contains("`only_mapped`"), "{error}");
    }
}
