//! Files of nothing but named fields, such as settings: the same text, places and mistakes as in graphs.

use super::read::fields_of;
use super::{Diagnostic, Diagnostics, Resolved, Scope, Source, Span, resolve};
use std::sync::Arc;

/// A field of such a file.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedField {
    /// Its name.
    pub name: String,
    /// Where the name stands.
    pub name_span: Span,
    /// Its value, with `~` and `${ENV:NAME}` filled in.
    pub value: Resolved,
    /// Where the value stands.
    pub span: Span,
}

/// The fields of the file `source`, in the order of `known`, whose names alone may stand there; `what` is what the file is.
///
/// # Errors
/// Every mistake in it.
pub fn named_fields(source: &Arc<Source>, what: &str, known: &[&str]) -> Result<Vec<NamedField>, Diagnostics> {
    let (fields, mut mistakes) = fields_of(source, what, known);
    let scope = Scope::file(source);
    let mut found = Vec::with_capacity(fields.len());
    for (name, name_span, value) in fields {
        match resolve(&value, &scope) {
            Ok(resolved) => found.push(NamedField { name, name_span, value: resolved, span: value.span }),
            Err(more) => mistakes.extend(more),
        }
    }
    mistakes.sort_by_key(|mistake: &Diagnostic| mistake.place.as_ref().map(|(place, _)| place.span));
    if mistakes.is_empty() { Ok(found) } else { Err(Diagnostics(mistakes)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Vec<NamedField>, Diagnostics> {
        let source = Source::new("show/grimace.ron", text);
        named_fields(&Arc::new(source), "the settings", &["jobs", "store"])
    }

    #[test]
    fn fields_have_values_and_places() {
        let fields = read("// ours\n( store: \"cache\", jobs: 4 )").unwrap();
        assert_eq!((fields[0].name.as_str(), &fields[0].value), ("jobs", &Resolved::Integer(4)));
        assert_eq!(fields[1].value.path(), Some("show/cache".into()));
        assert_eq!(fields[1].name_span.start, 10);
        assert_eq!(read("()").unwrap(), []);
    }

    #[test]
    fn every_mistake_is_told_at_once() {
        let mistakes = read("( stor: \"x\", jobs: \"${ENV:NO_SUCH_VARIABLE_HERE}\" )").unwrap_err().0;
        let told: Vec<_> = mistakes.iter().map(|mistake| mistake.code).collect();
        assert_eq!(told, ["unknown-field", "unset-variable"]);
        assert!(mistakes[0].help.as_ref().unwrap().contains("did you mean `store`?"));
        assert_eq!(read("[1]").unwrap_err().0[0].code, "wrong-type");
        assert_eq!(read("( jobs: ").unwrap_err().0[0].code, "syntax");
    }
}
