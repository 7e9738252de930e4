//! The page around its sections: head, style, the way through it.

use crate::{Heading, Told};
use plot::escaped;
use std::fmt::Write;

/// A section of the page.
pub(crate) struct Section {
    /// What links name it by.
    pub id: &'static str,
    /// Its heading.
    pub title: &'static str,
    /// Its content, as HTML.
    pub body: String,
}

const STYLE: &str = include_str!("style.css");

/// The whole page. `tiles` are the few numbers on top: what, how much, and what that means.
pub(crate) fn page(heading: &Heading, tiles: &[(String, String)], told: &Told, sections: Vec<Section>) -> String {
    let title = escaped(&heading.graph);
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<meta name=\"color-scheme\" content=\"light dark\">\n\
         <title>{title}</title>\n<link rel=\"icon\" href=\"data:,\">\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <a class=\"skip\" href=\"#content\">Skip to the content</a>\n<header>\n<h1>{title}</h1>\n"
    );
    if let Some(doc) = &heading.doc {
        let _ = writeln!(page, "<p class=\"doc\">{}</p>", escaped(doc));
    }
    let _ = writeln!(page, "<p class=\"made\">{}</p>", escaped(&heading.made));
    if !heading.set.is_empty() {
        let set: Vec<String> = heading.set.iter().map(|set| format!("<code>{}</code>", escaped(set))).collect();
        let _ = writeln!(page, "<p class=\"made\">Set: {}</p>", set.join(", "));
    }
    page += "<dl class=\"tiles\">\n";
    for (what, much) in tiles {
        let _ = writeln!(page, "<div><dt>{}</dt><dd>{}</dd></div>", escaped(what), escaped(much));
    }
    page += "</dl>\n<nav aria-label=\"Sections\"><ul>\n";
    for section in &sections {
        let _ = writeln!(page, "<li><a href=\"#{}\">{}</a></li>", section.id, section.title);
    }
    page += "</ul></nav>\n</header>\n<main id=\"content\">\n";
    if !told.failed.is_empty() || !told.notices.is_empty() {
        page += "<section aria-labelledby=\"troubles-title\"><h2 id=\"troubles-title\">What went wrong</h2><ul class=\"troubles\">\n";
        for (node, error, place) in &told.failed {
            let _ = writeln!(
                page,
                "<li><strong>{}</strong> failed: {} <span class=\"quiet\">{}</span></li>",
                escaped(node),
                escaped(error),
                escaped(place)
            );
        }
        for (about, message) in &told.notices {
            let _ = writeln!(page, "<li><strong>{}</strong>: {}</li>", escaped(about), escaped(message));
        }
        page += "</ul></section>\n";
    }
    for Section { id, title, body } in sections {
        let _ = writeln!(
            page,
            "<section id=\"{id}\" aria-labelledby=\"{id}-title\"><h2 id=\"{id}-title\">{title}</h2>\n{body}</section>"
        );
    }
    page + "</main>\n</body>\n</html>\n"
}

/// A figure with its caption. What is wider than the page can be scrolled, by the keyboard too.
pub(crate) fn figure(content: &str, caption: &str) -> String {
    let caption = escaped(caption);
    format!(
        "<figure><div class=\"wide\" tabindex=\"0\" role=\"group\" aria-label=\"{caption}\">{content}</div>\
         <figcaption>{caption}</figcaption></figure>\n"
    )
}

/// A table under column names; cells are HTML. Those of columns after the first `texts` are numbers.
pub(crate) fn table(caption: &str, names: &[&str], texts: usize, rows: &[(String, Vec<String>)]) -> String {
    let caption = escaped(caption);
    let mut out = format!(
        "<div class=\"wide\" tabindex=\"0\" role=\"group\" aria-label=\"{caption}\"><table><caption>{caption}</caption><thead><tr>"
    );
    let class = |at: usize| if at < texts { "" } else { " class=\"number\"" };
    for (at, name) in names.iter().enumerate() {
        let _ = write!(out, "<th scope=\"col\"{}>{}</th>", class(at), escaped(name));
    }
    out += "</tr></thead><tbody>\n";
    for (id, cells) in rows {
        let id = if id.is_empty() { String::new() } else { format!(" id=\"{}\"", escaped(id)) };
        let _ = write!(out, "<tr{id}>");
        for (at, cell) in cells.iter().enumerate() {
            let tag = if at == 0 { ("th scope=\"row\"", "th") } else { ("td", "td") };
            let _ = write!(out, "<{}{}>{cell}</{}>", tag.0, class(at), tag.1);
        }
        out += "</tr>\n";
    }
    out + "</tbody></table></div>\n"
}

/// A time as people read it.
pub(crate) fn seconds(seconds: f64) -> String {
    match seconds {
        s if s < 0.01 => format!("{:.1} ms", s * 1000.0),
        s if s < 60.0 => format!("{s:.2} s"),
        s => format!("{} min {:02} s", (s / 60.0) as u64, s as u64 % 60),
    }
}
