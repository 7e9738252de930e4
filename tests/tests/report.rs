//! A report as a supervisor opens it: in a browser, offline, in light and dark, and by the keyboard.

#![allow(clippy::unwrap_used, reason = "a failing unwrap is a failing test")]

use std::collections::BTreeSet;
use std::path::PathBuf;
use whole_system::{Browser, Project};

const PROGRAM: &str = env!("CARGO_BIN_EXE_grimace-under-test");

/// Two takes whose curves are calmed too much, so that there are errors to be seen; a take that is not there fails.
const GRAPH: &str = r#"(
    grimace: 1,
    doc: "Errors & pictures of <two> takes.",
    params: { "out": "out" },
    nodes: {
        "actor":  (kind: "sample_actor", with: (density: 0.5, rom_frames: 600, takes: 2, frames: 90)),
        "rig":    (kind: "skin_jaw", in: {"rig": "actor.rig"}),
        "attach": (kind: "attach_markers", in: {"rig": "rig", "neutral": "actor.neutral"}),
        "calm":   (kind: "smooth_curves", in: {"curves": "actor.truth"}, with: (filter: gaussian(sigma_frames: 12.0))),
        "error":  (
            kind: "marker_error",
            in: {"curves": "calm", "markers": "actor.takes", "rig": "rig", "attachment": "attach", "regions": "actor.regions"},
        ),
        "score":  (kind: "curve_error", in: {"curves": "calm", "truth": "actor.truth"}),
        "truth":  (kind: "evaluate_rig", in: {"rig": "rig", "curves": "actor.truth"}),
        "meshes": (kind: "evaluate_rig", in: {"rig": "rig", "curves": "calm"}),
        "off":    (kind: "mesh_error", in: {"truth": "truth", "meshes": "meshes"}),
        "where":  (kind: "render_errors", in: {"truth": "truth", "meshes": "meshes"}, with: (count: 1, size_px: 96)),
        "sheet":  (kind: "render_faces", in: {"rig": "rig", "curves": "calm"}, with: (count: 2, size_px: 96, supersampling: 1)),
        "image":  (kind: "save_images", in: {"image": "sheet"}, with: (path: "${out}/a picture of {take}.png")),
    },
)"#;

fn reported() -> (Project, PathBuf) {
    let project = Project::new(PROGRAM);
    project.write("show/graph.ron", GRAPH);
    let run = project.run(&["report", "show", "--set", "out=solved", "--out", "pages/day.html", "-q"]).ended_with(0);
    assert!(run.stdout.starts_with("pages/day.html"), "{}", run.stdout);
    let page = project.path("pages/day.html");
    (project, page)
}

#[test]
fn the_page_holds_everything_and_needs_nothing_from_elsewhere() {
    let (project, _) = reported();
    let page = project.read("pages/day.html");
    assert!(page.contains("Errors &amp; pictures of &lt;two&gt; takes."), "the page is escaped");
    for section in ["graph", "errors", "worst", "scores", "sheets", "meshes", "cells", "files"] {
        assert!(page.contains(&format!("<section id=\"{section}\"")), "{section}");
    }
    for outside in ["<script", "http-equiv", "@import", "url(", "src=\"http"] {
        assert!(!page.contains(outside), "{outside}");
    }
    let addresses = page.matches("http").count();
    assert_eq!(
        addresses,
        page.matches("xmlns=\"http://www.w3.org/2000/svg\"").count(),
        "no address but the name of SVG"
    );
    assert!(page.contains("href=\"../solved/a%20picture%20of%20take_00.png\""));
    assert!(page.contains("it is new (show/graph.ron:"), "why a node was cooked");
    // Two takes, three frames each, from two sides, two contact sheets, and two pictures of meshes.
    assert_eq!(page.matches("data:image/png;base64,").count(), 2 * 3 * 2 + 2 + 2);
    assert!(page.contains("all markers") && page.contains("all vertices"), "errors of both are plotted");
}

#[test]
fn a_page_tells_of_what_failed() {
    let project = Project::new(PROGRAM);
    let broken = GRAPH.replace("nodes: {", "nodes: { \"bad\": (kind: \"load_curves\", with: (path: \"bad.csv\")),");
    project.write("show/graph.ron", broken);
    project.write("show/bad.csv", "frame,jawOpen\n0,x\n");
    project.run(&["report", "show", "-q"]).ended_with(3);
    let page = project.read("show/report.html");
    assert!(page.contains("What went wrong") && page.contains("<strong>bad</strong> failed: "), "the failure is told");
}

#[test]
fn a_browser_shows_it_all_in_light_and_dark_and_by_the_keyboard() {
    let Some(mut browser) = Browser::start() else { return };
    let (_project, page) = reported();
    for scheme in ["light", "dark"] {
        browser.open(&page, scheme);
        let small = browser.value(
            "[...document.querySelectorAll('figure, img, figure svg')].filter(one => { const box = one.getBoundingClientRect(); \
             return box.width < 60 || box.height < 60 || (one.tagName === 'IMG' && !one.naturalWidth) }).map(one => one.outerHTML.slice(0, 120))",
        );
        assert_eq!(small, serde_json::json!([]), "every figure is to be seen");
        assert_eq!(
            browser.value("document.documentElement.scrollWidth <= window.innerWidth"),
            true,
            "the page itself never scrolls sideways"
        );
        // WCAG 2.2, 1.4.3: contrast = (L1 + 0.05) / (L2 + 0.05) of relative luminances, at least 4.5 for text.
        let contrast = browser.value(
            "(() => { const light = of => { const c = of.match(/[\\d.]+/g).slice(0, 3).map(v => v / 255).map(v => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4); \
             return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2] }; const ground = light(getComputedStyle(document.body).backgroundColor); \
             return Math.min(...[...document.querySelectorAll('p, a, h1, h2, td, th, figcaption, dt, dd')].map(one => { const text = light(getComputedStyle(one).color); \
             return (Math.max(text, ground) + 0.05) / (Math.min(text, ground) + 0.05) })) })()",
        );
        assert!(contrast.as_f64().unwrap() >= 4.5, "{scheme}: {contrast}");
    }
    let unnamed = browser.value(
        "[...document.querySelectorAll('img:not([alt]), img[alt=\"\"], svg:not([aria-label]), [tabindex]:not([aria-label]), table:not(:has(caption))')].length",
    );
    assert_eq!(unnamed, 0, "everything has a name");
    let links = browser.value("[...document.querySelectorAll('a[href]')].map(one => one.getAttribute('href'))");
    let links: BTreeSet<String> =
        links.as_array().unwrap().iter().map(|link| link.as_str().unwrap().to_owned()).collect();
    let mut reached = BTreeSet::new();
    for _ in 0..400 {
        browser.tab();
        let at = browser.value("document.activeElement.getAttribute('href')");
        reached.extend(at.as_str().map(str::to_owned));
        if links.iter().all(|link| reached.contains(link)) {
            break;
        }
    }
    assert_eq!(
        links.difference(&reached).collect::<Vec<_>>(),
        Vec::<&String>::new(),
        "every link is reached by the tabulator"
    );
    let broken = browser.value("[...document.querySelectorAll('a[href^=\"#\"]')].filter(one => !document.querySelector(one.getAttribute('href'))).length");
    assert_eq!(broken, 0, "every link within the page leads somewhere");
    assert_eq!(browser.complaints, Vec::<String>::new());
}
