//! `grimace plugin test`: tries a plugin out, and says what it took.

use crate::arguments::PluginInspect;
use crate::exit::{Exit, Trouble};
use crate::output;
use console::style;
use plugin_host::trial::{Trial, trial};
use serde_json::json;
use std::fmt::Write;

/// Tries every node of a plugin.
pub fn test(arguments: &PluginInspect) -> Result<Exit, Trouble> {
    let plugin = super::load(&arguments.folder)?;
    let again = super::load(&arguments.folder)?;
    let trials = trial(&plugin);
    let same = plugin.nodes == again.nodes;
    let failed =
        trials.iter().flat_map(|trial| &trial.checks).filter(|check| check.found.is_err()).count() + usize::from(!same);
    if arguments.json {
        for trial in &trials {
            output::print_json(&as_json(trial))?;
        }
    } else {
        let mut text = String::new();
        for trial in &trials {
            page(&mut text, &plugin.manifest.id, trial);
        }
        if !same {
            text.push_str("it described its nodes differently when it was asked again\n");
        }
        let _ = writeln!(
            text,
            "{}",
            if failed == 0 { "all is well".to_owned() } else { format!("{failed} checks failed") }
        );
        output::print(&text)?;
    }
    Ok(if failed == 0 { Exit::Fine } else { Exit::NodesFailed })
}

fn page(text: &mut String, id: &str, trial: &Trial) {
    let (ms, mib) = (trial.seconds * 1e3, trial.memory_bytes as f64 / f64::from(1 << 20));
    let _ = writeln!(text, "{id}/{}  {ms:.2} ms, {mib:.1} MiB at most", trial.node);
    for check in &trial.checks {
        match &check.found {
            Ok(found) => drop(writeln!(text, "  {} {}: {found}", style("ok").green(), check.what)),
            Err(problem) => drop(writeln!(text, "  {} {}: {problem}", style("failed").red(), check.what)),
        }
    }
}

fn as_json(trial: &Trial) -> serde_json::Value {
    let checks = trial.checks.iter().map(|check| {
        let (ok, text) = match &check.found {
            Ok(found) => (true, found),
            Err(problem) => (false, problem),
        };
        json!({ "check": check.what, "ok": ok, "found": text })
    });
    json!({
        "node": trial.node, "seconds": trial.seconds, "memory_bytes": trial.memory_bytes,
        "checks": checks.collect::<Vec<_>>(),
    })
}
