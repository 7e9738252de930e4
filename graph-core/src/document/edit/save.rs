//! What was edited goes back to its file.

use std::fs;
use std::io::{self, Write};
use std::path::Path;

/// Writes `content` whole or not at all, through a file beside the one that it replaces. A link stays a link: what it leads to is
/// replaced. A file that stands there keeps its permissions.
///
/// # Errors
/// Where the folder or the file cannot be written.
pub fn save(path: &Path, content: impl AsRef<[u8]>) -> io::Result<()> {
    let path = match path.canonicalize() {
        Err(problem) if problem.kind() == io::ErrorKind::NotFound => path.to_owned(),
        found => found?,
    };
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let beside = path.with_file_name(format!(".{name}.{}.new", std::process::id()));
    let keep_permissions = || match fs::metadata(&path) {
        Ok(standing) => fs::set_permissions(&beside, standing.permissions()),
        Err(_) => Ok(()),
    };
    let written = fs::File::create(&beside)
        .and_then(|mut file| file.write_all(content.as_ref()).and_then(|()| file.sync_all()))
        .and_then(|()| keep_permissions())
        .and_then(|()| fs::rename(&beside, &path));
    if written.is_err() {
        drop(fs::remove_file(&beside));
    }
    written
}
