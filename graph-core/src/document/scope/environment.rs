//! The environment that a graph is read in: the variables that `${ENV:NAME}` and `~` refer to, what was asked of them (a
//! graph depends on these variables and on no others), and the kinds of nodes that it may name.

use crate::node::Kinds;
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

/// Variables, with a note of those that were asked for.
#[derive(Debug, Default)]
pub struct Environment {
    variables: BTreeMap<String, String>,
    asked: Mutex<BTreeMap<String, Option<String>>>,
    kinds: Kinds,
}

impl Environment {
    /// The environment of this process, as far as it is text.
    pub fn of_process() -> Self {
        let text = |(name, value): (OsString, OsString)| Some((name.into_string().ok()?, value.into_string().ok()?));
        std::env::vars_os().filter_map(text).collect()
    }

    /// The environment of this process for the graph at `graph`, with the kinds that there are for it.
    pub fn of_graph(graph: &Path) -> Self {
        let environment = Self::of_process();
        let kinds = Kinds::of_graph(graph, &|name| environment.get(name).map(str::to_owned));
        Self { kinds, ..environment }
    }

    /// The kinds of nodes that graphs may name.
    pub fn kinds(&self) -> &Kinds {
        &self.kinds
    }

    /// The value of a variable.
    pub(super) fn get(&self, name: &str) -> Option<&str> {
        let value = self.variables.get(name).map(String::as_str);
        let mut asked = self.asked.lock().unwrap_or_else(PoisonError::into_inner);
        if !asked.contains_key(name) {
            asked.insert(name.to_owned(), value.map(str::to_owned));
        }
        value
    }

    /// The names of all variables.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.variables.keys().map(String::as_str)
    }

    /// What was asked for so far, with what was found.
    pub fn asked(&self) -> BTreeMap<String, Option<String>> {
        self.asked.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

impl FromIterator<(String, String)> for Environment {
    fn from_iter<I: IntoIterator<Item = (String, String)>>(variables: I) -> Self {
        Self { variables: variables.into_iter().collect(), asked: Mutex::default(), kinds: Kinds::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::Environment;

    #[test]
    fn what_is_asked_is_noted_whether_it_is_set_or_not() {
        let environment: Environment = [("SHOW".to_owned(), "alpha".to_owned())].into_iter().collect();
        assert!(environment.asked().is_empty());
        assert_eq!((environment.get("SHOW"), environment.get("SHOT")), (Some("alpha"), None));
        let asked = [("SHOT".to_owned(), None), ("SHOW".to_owned(), Some("alpha".to_owned()))];
        assert_eq!(environment.asked(), asked.into_iter().collect());
    }
}
