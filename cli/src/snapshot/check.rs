//! `grimace snapshot check`: holds what the graph gives now against what was accepted.

use super::cooked::{Again, Work};
use super::differing::{Checked, Fate};
use super::plots;
use crate::arguments::{Global, SnapshotOf};
use crate::exit::{Exit, Trouble};
use crate::output;
use crate::words::count;
use graph_core::cook::Engine;
use graph_core::snapshot::{Agreement, Golden, Hits, Taken, TakenOutput, compare};
use serde_json::json;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// Cooks the graph, and tells of every output whether it is as it was.
pub fn check(of: &SnapshotOf, global: &Global) -> Result<Exit, Trouble> {
    let golden = Golden::read(&Work::folder_of(of))?;
    let work = Work::new(of, global, &golden.set)?;
    let failed = work.folder.join("failed");
    clear(&failed)?;
    let (all, again) = match work.cook(|engine| checked(engine, &golden, &failed))? {
        Ok(done) => done,
        Err(exit) => return Ok(exit),
    };
    let kept = kept(&golden.second_cook, &again);
    let differing = all.iter().filter(|one| one.fails()).count();
    let within = all
        .iter()
        .filter(|one| matches!(one.fate, Fate::Compared(ref verdict) if verdict.agreement == Agreement::Within))
        .count();
    if of.json {
        all.iter().try_for_each(|one| output::print_json(&one.json()))?;
        output::print_json(&json!({
            "event": "second_cook", "ok": kept.is_none(), "expected": golden.second_cook, "found": again.hits, "cooked": again.cooked,
        }))?;
        output::print_json(&json!({
            "event": "checked", "values": all.len(), "equal": all.len() - within - differing, "within": within, "differing": differing,
            "second_cook": kept.is_none(),
        }))?;
    } else {
        all.iter().filter(|one| one.fails() || global.verbose).try_for_each(|one| output::print(&one.text()))?;
        if let Some(told) = &kept {
            output::print(&format!("{told}\n"))?;
        }
        let told = format!(
            "{}: {}, {} equal, {within} within tolerance, {differing} differing; second cook {}\n",
            work.folder.display(),
            count(all.len(), "value"),
            all.len() - within - differing,
            if kept.is_none() { "as accepted" } else { "not as accepted" }
        );
        output::print(&told)?;
    }
    Ok(if differing == 0 && kept.is_none() { Exit::Fine } else { Exit::Wrong })
}

/// What is wrong with a second cook; none where it did what was accepted.
fn kept(accepted: &Hits, again: &Again) -> Option<String> {
    let Hits { cooked, cached } = again.hits;
    if again.hits == *accepted {
        return None;
    }
    let nodes = if again.cooked.is_empty() { String::new() } else { format!(": {}", again.cooked.join(", ")) };
    Some(format!(
        "✗ the second cook computed {cooked} cells and found {cached}, where {} and {} were accepted{nodes}",
        accepted.cooked, accepted.cached
    ))
}

/// Empties the folder of plots of the last check.
fn clear(failed: &Path) -> Result<(), Trouble> {
    let Ok(entries) = fs::read_dir(failed) else { return Ok(()) };
    for path in entries
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "svg"))
    {
        fs::remove_file(&path).map_err(|problem| Trouble::File { path, problem })?;
    }
    Ok(())
}

fn checked(engine: &mut Engine, golden: &Golden, failed: &Path) -> Result<Vec<Checked>, Trouble> {
    let taken = Taken::after(engine)?;
    let mut all = Vec::new();
    for (name, held) in &golden.outputs {
        let found = taken.outputs.get(name);
        let items: BTreeSet<&String> =
            held.items.keys().chain(found.into_iter().flat_map(|found| found.items.keys())).collect();
        for item in items {
            let of = |fate: Fate| Checked {
                output: name.clone(),
                item: item.clone(),
                kind: held.kind.clone(),
                fate,
                first: None,
                plot: None,
            };
            let (expected, now) = (held.items.get(item), found.and_then(|found| found.items.get(item)));
            let (Some(expected), Some((cell, now))) = (expected, now) else {
                all.push(of(if expected.is_some() { Fate::Gone } else { Fate::New }));
                continue;
            };
            let found_kind = found.map_or((held.kind.as_str(), held.version), |found| (found.kind, found.version));
            if found_kind != (held.kind.as_str(), held.version) {
                all.push(of(Fate::OtherType(format!("{} v{}", found_kind.0, found_kind.1))));
                continue;
            }
            let own = found.map(own_tolerances).unwrap_or_default();
            let verdict = compare(expected, now, &own, &held.tolerances);
            let mut one = of(Fate::Compared(verdict.clone()));
            if verdict.agreement == Agreement::Differs {
                one.first = golden.trace.first(engine, *cell);
                one.plot = plots::draw((name, item), (expected, now), &verdict.differences, failed)?;
            }
            all.push(one);
        }
    }
    for (name, output) in taken.outputs.iter().filter(|(name, _)| !golden.outputs.contains_key(*name)) {
        let kind = output.kind.to_owned();
        let of = |item: &String| Checked {
            output: name.clone(),
            item: item.clone(),
            kind: kind.clone(),
            fate: Fate::New,
            first: None,
            plot: None,
        };
        all.extend(output.items.keys().map(of));
    }
    Ok(all)
}

fn own_tolerances(output: &TakenOutput) -> BTreeMap<String, wire::Tolerance> {
    output.tolerances.iter().map(|(table, (tolerance, _))| (table.clone(), *tolerance)).collect()
}
