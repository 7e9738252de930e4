//! `grimace report`: a page about a graph, for those who look at results and cook none.

use crate::arguments::{Global, GraphArguments, Report};
use crate::exit::{Exit, Trouble};
use crate::graph::{self, Asked};
use crate::tell::{People, Wanted};
use crate::words::size;
use crate::{cooking, output, signals};
use graph_core::cook::{Engine, Event, Summary, cook_and, session_name};
use report::{Heading, Told};
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{SystemTime, UNIX_EPOCH};

/// Cooks the graph as `run` does, and writes the page about it. Nodes that fail are told on the page too.
pub fn report(arguments: &Report, global: &Global) -> Result<Exit, Trouble> {
    let of = GraphArguments { graph: arguments.graph.clone(), set: arguments.set.clone(), out: None };
    let asked = Asked::read(&of)?;
    let options = cooking::options(&arguments.cook, false);
    let plan = asked.load_or_tell()?;
    let path =
        arguments.out.clone().unwrap_or_else(|| asked.path.parent().unwrap_or(Path::new("")).join("report.html"));
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new(".")).to_owned();
    std::fs::create_dir_all(&folder).map_err(|problem| Trouble::File { path: folder.clone(), problem })?;
    let heading = Heading {
        graph: asked.path.display().to_string(),
        doc: plan.nodes.iter().find(|node| !node.path.contains('/')).and_then(|node| node.template.graph.doc.clone()),
        set: asked.overrides.iter().map(|set| set.text.clone()).collect(),
        made: format!("grimace {}, {}", env!("CARGO_PKG_VERSION"), date(SystemTime::now())),
    };
    let store = Arc::new(graph::store(&arguments.store, &asked.path));
    let lease = store.lease(&session_name(&store, &asked.path))?;
    let told = Mutex::new(Told::default());
    let hear = |event: &Event| told.lock().unwrap_or_else(PoisonError::into_inner).take(event);
    let cancel = signals::cancelled_by_signals()?;
    let mut made = None;
    let wanted = Wanted { quiet: global.quiet, verbose: global.verbose, plain: false };
    let summary = People::new(wanted).during(|people| {
        let tell = |event: Event| {
            hear(&event);
            people.tell(event);
        };
        let look = |engine: &mut Engine, summary: &Summary| {
            let mut told = told.lock().unwrap_or_else(PoisonError::into_inner).clone();
            told.summary = summary.clone();
            (!summary.cancelled).then(|| report::page(engine, &told, &heading, &folder))
        };
        let (summary, page) =
            cook_and((plan, &asked.overrides), Arc::clone(&store), &options, Arc::clone(&cancel), &tell, look)?;
        made = page;
        Ok(summary)
    })?;
    drop(lease);
    if let Some(page) = made.transpose().map_err(|problem| Trouble::Report(Box::new(problem)))? {
        std::fs::write(&path, &page).map_err(|problem| Trouble::File { path: path.clone(), problem })?;
        output::print(&format!("{}  {}\n", path.display(), size(page.len() as u64)))?;
    }
    Ok(cooking::exit(&summary))
}

/// `2026-03-14 15:09 UTC`. Days are counted as the Gregorian calendar repeats: 146,097 in 400 years, which begin in March.
fn date(time: SystemTime) -> String {
    let seconds = time.duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    let (days, of_day) = (seconds / 86_400 + 719_468, seconds % 86_400);
    let (era, of_era) = (days / 146_097, days % 146_097);
    let year_of_era = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * of_year + 2) / 153;
    let day = of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    let year = 400 * era + year_of_era + u64::from(month <= 2);
    format!("{year:04}-{month:02}-{day:02} {:02}:{:02} UTC", of_day / 3600, of_day % 3600 / 60)
}

#[cfg(test)]
mod tests {
    use super::date;
    use std::time::{Duration, UNIX_EPOCH};

    #[test]
    fn dates_are_those_of_the_calendar() {
        let at = |seconds: u64| date(UNIX_EPOCH + Duration::from_secs(seconds));
        let found = [0, 951_782_399, 951_782_400, 951_868_800, 1_773_500_940].map(at);
        let known = [
            "1970-01-01 00:00 UTC",
            "2000-02-28 23:59 UTC",
            "2000-02-29 00:00 UTC",
            "2000-03-01 00:00 UTC",
            "2026-03-14 15:09 UTC",
        ];
        assert_eq!(found, known);
    }
}
