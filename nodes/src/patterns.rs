//! Names of markers, channels and parts in parameters, as patterns: `lip_*`, `brow_[LR]_1`, `{chin,jaw*}`.

use face_math::data::{Part, Rig, nearest_name};
use globset::{GlobBuilder, GlobMatcher};
use graph_core::node::NodeError;
use std::collections::BTreeMap;

/// Where patterns stand and what they are held against.
#[derive(Clone, Copy)]
pub(crate) struct Patterns<'a> {
    /// The parameter, for messages.
    pub parameter: &'a str,
    /// What is named, for messages: `marker`, `channel` or `part`.
    pub what: &'static str,
    /// The names there are.
    pub names: &'a [String],
}

impl Patterns<'_> {
    /// For each name, whether one of `patterns` fits it.
    ///
    /// # Errors
    /// Where a pattern is malformed or fits no name.
    pub fn fits(&self, patterns: &[String]) -> Result<Vec<bool>, NodeError> {
        let mut fits = vec![false; self.names.len()];
        for pattern in patterns {
            let glob = self.compile(pattern)?;
            for (fit, name) in fits.iter_mut().zip(self.names) {
                *fit |= glob.is_match(name);
            }
        }
        Ok(fits)
    }

    /// For each name, whether one of `patterns` fits it; patterns that fit no name are let be.
    ///
    /// # Errors
    /// Where a pattern is malformed.
    pub fn may_fit(&self, patterns: &[String]) -> Result<Vec<bool>, NodeError> {
        let globs = patterns.iter().map(|pattern| self.parse(pattern)).collect::<Result<Vec<_>, _>>()?;
        Ok(self.names.iter().map(|name| globs.iter().any(|glob| glob.is_match(name))).collect())
    }

    /// The names that `patterns` fit, in their own order; all names where there is no pattern.
    ///
    /// # Errors
    /// As [`Self::fits`].
    pub fn chosen(&self, patterns: &[String]) -> Result<Vec<String>, NodeError> {
        let fits = self.fits(patterns)?;
        let kept = self.names.iter().zip(fits).filter(|(_, fit)| *fit || patterns.is_empty());
        Ok(kept.map(|(name, _)| name.clone()).collect())
    }

    /// For each name, the number that `by_pattern` has for it: that of the name itself, else of the longest pattern that
    /// fits, of equally long ones the first.
    ///
    /// # Errors
    /// As [`Self::fits`].
    pub fn numbers(&self, by_pattern: &BTreeMap<String, f64>) -> Result<Vec<Option<f64>>, NodeError> {
        let mut patterns = Vec::with_capacity(by_pattern.len());
        for (pattern, number) in by_pattern {
            patterns.push((pattern, self.compile(pattern)?, *number));
        }
        patterns.sort_by_key(|(pattern, _, _)| std::cmp::Reverse(pattern.chars().count()));
        let number = |name: &String| {
            let own = by_pattern.get(name).copied();
            own.or_else(|| patterns.iter().find(|(_, glob, _)| glob.is_match(name)).map(|(_, _, number)| *number))
        };
        Ok(self.names.iter().map(number).collect())
    }

    fn parse(&self, pattern: &str) -> Result<GlobMatcher, NodeError> {
        let glob = GlobBuilder::new(pattern).backslash_escape(true).build();
        Ok(glob.map_err(|error| NodeError::parameter(self.parameter, error))?.compile_matcher())
    }

    fn compile(&self, pattern: &str) -> Result<GlobMatcher, NodeError> {
        let glob = self.parse(pattern)?;
        if self.names.iter().any(|name| glob.is_match(name)) {
            return Ok(glob);
        }
        let near = match nearest_name(pattern, self.names.iter().map(String::as_str)) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("there are {}", listed(self.names, self.what)),
        };
        Err(NodeError::parameter(self.parameter, format!("no {} fits `{pattern}`; {near}", self.what)))
    }
}

/// The part of `rig` that the parameter names.
///
/// # Errors
/// Where the rig has no such part.
pub(crate) fn part<'r>(rig: &'r Rig, parameter: &str, name: &str) -> Result<&'r Part, NodeError> {
    rig.part(name).ok_or_else(|| {
        let names: Vec<String> = rig.parts.iter().map(|part| part.name.clone()).collect();
        let near = match nearest_name(name, names.iter().map(String::as_str)) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("there are {}", listed(&names, "part")),
        };
        NodeError::parameter(parameter, format!("rig `{}` has no part `{name}`; {near}", rig.name))
    })
}

/// How many names there are, and the first of them.
pub(crate) fn listed(names: &[String], what: &str) -> String {
    let first: Vec<_> = names.iter().take(6).map(|name| format!("`{name}`")).collect();
    let more = if names.len() > first.len() { " …" } else { "" };
    format!("{} {what}s: {}{more}", names.len(), first.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names() -> Vec<String> {
        ["chin", "lip_1", "lip_2", "brow"].map(str::to_owned).to_vec()
    }

    fn patterns(names: &[String]) -> Patterns<'_> {
        Patterns { parameter: "markers", what: "marker", names }
    }

    fn texts(texts: &[&str]) -> Vec<String> {
        texts.iter().map(|text| (*text).to_owned()).collect()
    }

    #[test]
    fn patterns_choose_in_the_order_of_the_names() {
        let names = names();
        assert_eq!(patterns(&names).chosen(&texts(&["lip_*", "chin"])).unwrap(), ["chin", "lip_1", "lip_2"]);
        assert_eq!(patterns(&names).chosen(&[]).unwrap(), names);
        assert_eq!(patterns(&names).fits(&[]).unwrap(), [false; 4]);
        assert_eq!(patterns(&names).may_fit(&texts(&["nose", "br*"])).unwrap(), [false, false, false, true]);
    }

    #[test]
    fn a_name_goes_before_a_pattern_and_a_long_pattern_before_a_short_one() {
        let names = names();
        let numbers = BTreeMap::from([("*", 1.0), ("lip_*", 2.0), ("lip_2", 3.0)]);
        let numbers = numbers.into_iter().map(|(name, number)| (name.to_owned(), number)).collect();
        let found = patterns(&names).numbers(&numbers).unwrap();
        assert_eq!(found, [Some(1.0), Some(2.0), Some(3.0), Some(1.0)]);
        assert_eq!(patterns(&names).numbers(&BTreeMap::new()).unwrap(), [None; 4]);
    }

    #[test]
    fn what_fits_nothing_is_an_error_with_the_nearest_name() {
        let names = names();
        let error = |pattern: &str| patterns(&names).fits(&texts(&[pattern])).unwrap_err().to_string();
        assert_eq!(error("chinn"), "parameter `markers`: no marker fits `chinn`; did you mean `chin`?");
        assert!(error("nose_*").contains("there are 4 markers: `chin`, "), "{}", error("nose_*"));
        assert!(error("[").contains("`markers`"));
    }
}
