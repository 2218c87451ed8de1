//! The window before anything is open: what to do, and the logs that a card holds.

use crate::window::empty_window;
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use std::fs::{self, File};
use std::path::PathBuf;
use std::sync::OnceLock;
use std::time::{Duration, SystemTime};

static CARD: OnceLock<tempfile::TempDir> = OnceLock::new();

/// A card with one log of a Lowrance that opens, an older one, and what else lies on cards.
fn cards() -> Vec<PathBuf> {
    let card = CARD.get_or_init(|| {
        let card = tempfile::tempdir().expect("a card");
        let write = |name: &str, bytes: &[u8], day: u64| {
            let path = card.path().join(name);
            fs::write(&path, bytes).expect("a file");
            let written = SystemTime::UNIX_EPOCH + Duration::from_secs(day * 86_400 + 43_200);
            let file = File::options().append(true).open(&path);
            file.and_then(|file| file.set_modified(written)).expect("a time");
        };
        write("Sonar0002.sl2", include_bytes!("../../assets/demo.sl2"), 20_000);
        write("Sonar0001.sl2", b"older", 19_000);
        write("WAYPOINTS.GPX", b"", 20_500);
        card
    });
    vec![card.path().to_owned()]
}

#[test]
fn the_newest_log_of_a_card_is_offered_and_opens_with_a_click() {
    let mut window = empty_window();
    window.state_mut().app.card_search.look_on(cards);
    // One frame lists the drives, one has them searched, one shows what was found.
    for _ in 0..3 {
        window.step();
    }
    let step = window.query_by_label_contains("Open the log that your recorder wrote");
    assert!(step.is_some(), "what to do first is said");
    assert!(window.query_by_label("All 2 logs").is_some());
    assert!(window.query_by_label_contains("WAYPOINTS").is_none());
    let offered = window.get_all_by_label_contains("Sonar000");
    let offered: Vec<String> = offered.filter_map(|node| node.accesskit_node().label()).collect();
    assert_eq!(offered, ["Sonar0002.sl2  ·  2024-10-04", "Sonar0001.sl2  ·  2022-01-08"]);
    window.get_by_label_contains("Sonar0002.sl2").click();
    window.run();
    let app = &window.state().app;
    let survey = app.logs.shown.survey.as_ref().expect("a log is open");
    assert_eq!(survey.source.files, [cards()[0].join("Sonar0002.sl2")]);
    assert!(app.card_search.folders().is_empty());
}
