//! Graph files from disk: the text, or why it cannot be read.

use super::nearest::did_you_mean;
use super::{Diagnostic, Source, Span};
use std::io::ErrorKind;
use std::path::Path;
use std::sync::Arc;

impl Source {
    /// Reads the file at `path`.
    ///
    /// # Errors
    /// A diagnostic with code `unreadable-file` where there is none, where it cannot be read, or where it is not
    /// UTF-8.
    #[allow(clippy::result_large_err, reason = "it fails at most once a file or argument")]
    pub fn load(path: &Path) -> Result<Self, Diagnostic> {
        let shown = path.display();
        let unreadable = |message: String| Diagnostic::new("unreadable-file", message);
        let bytes = std::fs::read(path).map_err(|error| match error.kind() {
            ErrorKind::NotFound => unreadable(format!("there is no file `{shown}`")).may_help(near_file(path)),
            _ if path.is_dir() => {
                unreadable(format!("`{shown}` is a folder, not a graph file")).may_help(graph_within(path))
            }
            _ => unreadable(format!("`{shown}` cannot be read: {error}")),
        })?;
        match String::from_utf8(bytes) {
            Ok(text) => Ok(Self::new(path, text)),
            Err(error) => Err(not_utf8(path, &error)),
        }
    }
}

/// The place is given in the text up to the wrong byte.
fn not_utf8(path: &Path, error: &std::string::FromUtf8Error) -> Diagnostic {
    let offset = error.utf8_error().valid_up_to();
    let text = String::from_utf8_lossy(&error.as_bytes()[..offset]).into_owned();
    let byte = error.as_bytes().get(offset).copied().unwrap_or_default();
    let source = Arc::new(Source::new(path, text));
    let message = format!("`{}` is not UTF-8 text: byte {offset} is 0x{byte:02X}", path.display());
    Diagnostic::at("unreadable-file", &source, Span { start: offset, end: offset }, message)
        .label("the text ends being UTF-8 here")
        .help("save the file as UTF-8")
}

/// The nearest name in the folder where `path` was looked for, or how far the path exists.
fn near_file(path: &Path) -> Option<String> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.is_dir() {
        let deepest = folder.ancestors().find(|ancestor| ancestor.is_dir()).unwrap_or(Path::new(""));
        let missing = folder.strip_prefix(deepest).ok()?.components().next()?;
        let near = near_name(deepest, &missing.as_os_str().to_string_lossy(), true);
        let missing = deepest.join(missing);
        let near = near.map_or(String::new(), |near| format!("; did you mean `{}`?", deepest.join(near).display()));
        return Some(format!("there is no folder `{}`{near}", missing.display()));
    }
    let near = near_name(folder, &path.file_name()?.to_string_lossy(), false)?;
    Some(format!("did you mean `{}`?", path.with_file_name(near).display()))
}

/// Where `folder` holds a graph, how to name it.
fn graph_within(folder: &Path) -> Option<String> {
    let graph = folder.join("graph.ron");
    graph.is_file().then(|| format!("did you mean `{}`?", graph.display()))
}

fn near_name(folder: &Path, wanted: &str, folders: bool) -> Option<String> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let entries = std::fs::read_dir(folder).ok()?.filter_map(Result::ok);
    let fitting = entries.filter(|entry| entry.path().is_dir() == folders);
    let names: Vec<String> = fitting.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    did_you_mean(wanted, names.iter().map(String::as_str))
}

#[cfg(test)]
mod tests {
    use super::Source;
    use std::fs;

    #[test]
    fn missing_files_name_the_nearest() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("graphs")).unwrap();
        fs::write(folder.path().join("graphs/solve_take.ron"), "()").unwrap();
        let path = |name: &str| folder.path().join(name);
        let error = Source::load(&path("graphs/solve_tkae.ron")).unwrap_err();
        assert_eq!(error.code, "unreadable-file");
        assert_eq!(error.help.unwrap(), format!("did you mean `{}`?", path("graphs/solve_take.ron").display()));
        let error = Source::load(&path("graph/solve_take.ron")).unwrap_err();
        let (missing, near) = (path("graph"), path("graphs"));
        let expected = format!("there is no folder `{}`; did you mean `{}`?", missing.display(), near.display());
        assert_eq!(error.help.unwrap(), expected);
        let error = Source::load(&path("graphs")).unwrap_err();
        assert!(error.message.ends_with("is a folder, not a graph file"), "{}", error.message);
        assert_eq!(Source::load(&path("graphs/solve_take.ron")).unwrap().text, "()");
    }

    #[test]
    fn bytes_that_are_no_text_are_placed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("graph.ron");
        fs::write(&path, b"(\n  doc: \"caf\xe9\")").unwrap();
        let error = Source::load(&path).unwrap_err();
        assert!(error.message.ends_with("is not UTF-8 text: byte 13 is 0xE9"), "{}", error.message);
        assert_eq!(error.place.unwrap().0.text(), format!("{}:2:12", path.display()));
    }
}
