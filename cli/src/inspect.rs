//! `grimace inspect`: what files hold.

use crate::arguments::Inspect;
use crate::exit::{Exit, Trouble};
use crate::output;
use console::style;
use face_io::Inspection;
use serde::Serialize;
use std::io;
use std::path::Path;

/// What was found in one file, as JSON.
#[derive(Serialize)]
struct Found<'a> {
    file: String,
    #[serde(flatten)]
    inspection: &'a Inspection,
}

/// A file that cannot be read, as JSON.
#[derive(Serialize)]
struct Unreadable<'a> {
    file: &'a str,
    error: &'a str,
}

/// Says of each file what it holds. A file that cannot be read keeps no other from being shown.
pub fn inspect(arguments: &Inspect) -> Result<Exit, Trouble> {
    let mut exit = Exit::Fine;
    for (number, path) in arguments.files.iter().enumerate() {
        let file = path.display().to_string();
        match look(path) {
            Ok(inspection) if arguments.json => output::print_json(&Found { file, inspection: &inspection })?,
            Ok(inspection) => {
                let gap = if number > 0 { "\n" } else { "" };
                let told = inspection.to_string();
                output::print(&format!("{gap}{}: {told}\n", style(file).bold()))?;
            }
            Err(problem) => {
                exit = Exit::Wrong;
                if arguments.json {
                    output::print_json(&Unreadable { file: &file, error: &problem })?;
                }
                output::error(&format!("{file}: {problem}"), None);
            }
        }
    }
    Ok(exit)
}

fn look(path: &Path) -> Result<Inspection, String> {
    if path.is_dir() {
        return Err("is a folder; name the files in it".to_owned());
    }
    let bytes = std::fs::read(path).map_err(|problem| format!("cannot be read: {problem}"))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut sibling = |name: &str| {
        if Path::new(name).is_absolute() {
            let problem = format!("it refers to `{name}` by an absolute path, which is not followed");
            return Err(io::Error::new(io::ErrorKind::PermissionDenied, problem));
        }
        std::fs::read(folder.join(name))
    };
    face_io::inspect(&path.to_string_lossy(), &bytes, &mut sibling).map_err(|problem| problem.to_string())
}
