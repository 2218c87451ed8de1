//! `report.html`: every template is filled, for one log and for several, with and without boxes.

use crate::truth::{KnownSurvey, results};
use crate::written;
use bathyscope_log::survey::{Identity, Side};
use bathyscope_objects::Mark;
use bathyscope_objects::objects::{KeptReview, SurveyReview};
use bathyscope_objects::review::{BoxId, Certainty, Edit, Review};
use bathyscope_products::outputs::Product;
use bathyscope_products::pipeline::{ProcessedLog, Settings};
use bathyscope_simulation::Scene;
use std::fs;
use std::sync::Arc;

fn pond() -> ProcessedLog {
    let mut scene = Scene::gentle();
    scene.track.lines = 3;
    scene.track.length_m = 60.0;
    scene.artefacts.weed_m = 12.0;
    let survey = KnownSurvey::new(&scene, 6).survey;
    let mut settings = Settings::default();
    settings.report.proposals = true;
    settings.first_return.min_confidence = 0.79;
    let products = results(&survey, &settings);
    ProcessedLog { survey: Arc::new(survey), products }
}

/// A drawn box with a name, one with nothing but its class, and a point.
fn review(log: &ProcessedLog) -> SurveyReview {
    let mark = |ping: usize| Mark::new(Side::Port, ping..ping + 12, [4.0, 6.0]);
    let first = BoxId(1);
    let edits = [
        Edit::Add { mark: mark(40), class: 0 },
        Edit::Rename(first, "Anna <Maria>".to_owned()),
        Edit::Rate(first, Some(Certainty::Probable)),
        Edit::Note(first, "boiler & all".to_owned()),
        Edit::SetEdges { id: first, mark: mark(40), border_m: 5.0 },
        Edit::Add { mark: mark(80), class: 0 },
        Edit::AddPoint { side: Side::Starboard, ping: 120, range_m: 5.0, class: 0 },
    ];
    let empty = Review::new(Identity::of(&log.survey), vec!["rock".to_owned()]);
    let decided = edits.iter().fold(empty, |review, edit| review.apply(edit).expect("an edit"));
    let mut all = SurveyReview::default();
    all.add(Some(KeptReview::from(decided)));
    all
}

/// Returns the page of logs without the white space between its tags.
fn page(logs: &[ProcessedLog], review: &SurveyReview) -> String {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path().join("out");
    written(logs, &[Product::Report], review, &folder);
    let page = fs::read_to_string(folder.join("report.html")).expect("a page");
    let lines: Vec<&str> = page.lines().map(str::trim).collect();
    assert!(!page.contains("{{") && !page.contains("{%"), "a template that is not filled");
    lines.concat()
}

fn check(page: &str, texts: &[&str]) {
    for text in texts {
        assert!(page.contains(text), "{text} is not in the page");
    }
}

#[test]
fn html_report_of_one_log_has_every_section() {
    let log = pond();
    let review = review(&log);
    let logs = std::slice::from_ref(&log);
    let reviewed = page(logs, &review);
    let sections = [
        "<p class=\"lead\">Recorded on ",
        "<h2>Depths</h2><figure><svg ",
        "<h2>Area and volume below each level</h2><figure><svg ",
        "<h2>Side-scan mosaic</h2><figure><svg ",
        "<h2>The log at a glance</h2><figure><svg ",
        "<h2>How far to trust it</h2>",
        "<h2>How it was made</h2><p>Slant ranges are scaled ",
        "<h2>Files</h2><table>",
    ];
    check(&reviewed, &sections);
    check(
        &reviewed,
        &[
            "<h2>Objects</h2><p>Boxes of the review: ",
            "<tr><td>1</td><td class=\"text\"><img alt=\"rock 1\" ",
            "<section class=\"target\"><h3>1. Anna &lt;Maria&gt; (rock)</h3>",
            "across it, by edges drawn by hand</dd>",
            "<dd>a point: not known</dd>",
            "<dt>Certainty</dt><dd>probable</dd>",
            "<dt>Remarks</dt><dd>boiler &amp; all</dd>",
        ],
    );
    let plain = page(logs, &SurveyReview::default());
    check(&plain, &sections);
    assert!(!plain.contains("<h2>Objects</h2>") && !plain.contains("<h2>Targets</h2>"));
}

#[test]
fn html_report_of_several_logs_has_a_table_of_them() {
    let log = pond();
    let page = page(&[log.clone(), log], &SurveyReview::default());
    check(
        &page,
        &[
            "<p class=\"lead\">Recorded in 2 logs on ",
            "<h2>The logs</h2><table><tr><th class=\"text\">log</th>",
            "<h2>The logs at a glance</h2><p>All pings from left to right",
        ],
    );
}
