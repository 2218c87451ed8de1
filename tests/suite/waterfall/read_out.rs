//! Tests the read-out of the place under the pointer.

use super::{settle, window};
use bathyscope::app::{App, Command, Jobs};
use egui::accesskit::Role;
use egui_kittest::kittest::{NodeT as _, Queryable as _};

fn demo() -> App {
    let mut app = App::new(Jobs::Inline);
    app.apply(Command::OpenDemo);
    while !app.is_idle() {
        app.poll();
    }
    app
}

/// The number in front of `unit`.
fn before(text: &str, unit: &str) -> Option<f64> {
    text.split_once(unit)?.0.split_whitespace().last()?.parse().ok()
}

#[test]
fn the_range_is_that_of_the_range_lines_with_the_recorded_one_beside_it() {
    let app = demo();
    let offset_m = app.logs.shown.products.as_ref().expect("results").calibration.offset_m;
    assert!(offset_m.abs() > 0.02, "the demo has an offset: {offset_m}");
    let mut window = window(app, [600.0, 400.0]);
    settle(&mut window);
    window.hover_at(egui::pos2(300.0, 300.0));
    window.run_steps(2);
    let said = window.get_by_role(Role::Image).accesskit_node().value();
    let said = said.expect("a read-out");
    let recorded = before(&said, " m as recorded").expect("the recorded range");
    let (_, range) = said.split_once("range ").expect("a range");
    let calibrated = before(range, " m").expect("the range");
    // The recorder's own scale is in force, less the fitted offset; both are rounded to
    // centimetres.
    assert!((recorded - offset_m - calibrated).abs() < 0.0101, "{said}");
}

#[test]
fn a_dashed_first_return_is_explained() {
    // By a margin of a centimetre the pulse's lead alone flags a pick; by ten metres nothing does.
    for (margin_m, dashed) in [("0.01", true), ("10", false)] {
        let mut app = demo();
        let assignment = format!("first_return.above_bottom_margin_m={margin_m}");
        let settings = app.logs.shown.settings.with_assignment(&assignment).expect("a setting");
        app.apply(Command::Change {
            settings: Box::new(settings),
            label: "above-bottom margin",
            live: false,
        });
        while !app.is_idle() {
            app.poll();
        }
        let mut window = window(app, [600.0, 400.0]);
        settle(&mut window);
        window.hover_at(egui::pos2(300.0, 300.0));
        window.run_steps(2);
        let said = window.get_by_role(Role::Image).accesskit_node().value();
        let said = said.expect("a read-out");
        assert_eq!(said.contains("first return above bottom"), dashed, "{said}");
    }
}
