//! Tests that a decision changes few lines of a project's text, and no others.

use super::*;

/// Asserts that each change of the full project removes and adds this many lines, and that the
/// written text is read back unchanged.
fn assert_lines_changed<const N: usize>(changes: [(Change, [usize; 2]); N]) {
    let project = full();
    for (change, lines) in changes {
        let after = project.apply(&change).expect("a change");
        let differ = lines_that_differ(&project.to_text(folder()), &after.to_text(folder()));
        // Blank lines and headings are not counted.
        let count =
            differ.each_ref().map(|lines| lines.iter().filter(|line| line.contains(" = ")).count());
        assert_eq!(count, lines, "{change:?}: {differ:#?}");
        let back = read(&after.to_text(folder())).expect("a project");
        assert_eq!(back.to_text(folder()), after.to_text(folder()), "{change:?}");
    }
}

#[test]
fn one_decision_about_a_box_changes_one_line() {
    let key = full().logs()[0].key.clone();
    let id = BoxId(7);
    let add = Edit::Add { mark: mark(50), class: 1 };
    let set_edges = Edit::SetEdges { id, mark: mark(50), border_m: mark(50).near_m + 0.25 };
    let add_point = Edit::AddPoint { side: Side::Port, ping: 77, range_m: 6.5, class: 1 };
    let edits = [
        (Edit::Accept(id), [1, 1]),
        (Edit::Note(id, "a \"wreck\"\nor so".to_owned()), [1, 1]),
        (add, [0, 1]),
        (Edit::Rename(id, "Anna".to_owned()), [1, 1]),
        (Edit::Rate(id, Some(Certainty::Probable)), [1, 1]),
        (set_edges, [1, 1]),
        (add_point, [0, 1]),
        // The log has the new class from then on.
        (Edit::Classify(id, "steam tug".to_owned()), [2, 2]),
    ];
    let log = || key.clone();
    assert_lines_changed(edits.map(|(edit, lines)| (Change::Box { log: log(), edit }, lines)));
}

#[test]
fn one_decision_about_a_log_changes_one_line() {
    let key = full().logs()[0].key.clone();
    let move_down = Change::Move { log: key.clone(), to: 1 };
    let own = Change::Own { log: key.clone(), key: "outliers.min_neighbors".to_owned(), own: true };
    let draw = Change::Bottom { log: key.clone(), after: bottom(&[line(Side::Port, [10, 20])]) };
    assert_lines_changed([
        (Change::Rename(key.clone(), "Chart 2".to_owned()), [1, 1]),
        (Change::Show(key, false), [0, 1]),
        (move_down, [1, 1]),
        (own, [0, 1]),
        (draw, [1, 0]),
    ]);
}

#[test]
fn one_decision_about_the_survey_changes_one_line() {
    let project = full();
    let mut settings = project.settings.clone();
    settings.outliers.min_neighbors = 9;
    let set = Change::Settings { log: None, after: Box::new(settings) };
    let base_map = Some(PathBuf::from("/lake/b.tif"));
    assert_lines_changed([
        (Change::Measure(None, project.measurements[&1].clone()), [0, 1]),
        (Change::Forget(1), [1, 0]),
        (set, [1, 1]),
        (Change::File("base_map".to_owned(), base_map), [1, 1]),
    ]);
}
