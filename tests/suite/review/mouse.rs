//! Boxes drawn, moved and picked with the mouse.

use super::*;

/// Where a place is on the screen of a waterfall that shows all of the demo, time to the right.
pub(crate) fn at(window: &Window, ping: f64, across_m: f64) -> Pos2 {
    let view = window.get_by_label_contains("Waterfall, pings").rect();
    let seen = &app(window).visible;
    let share = (ping - seen.start as f64) / seen.len() as f64;
    // The range that is shown is the demo's longest.
    let far_m = farthest_m(window);
    pos2(
        view.left() + view.width() * share as f32,
        view.center().y + 0.5 * view.height() * (across_m / far_m) as f32,
    )
}

fn farthest_m(window: &Window) -> f64 {
    let survey = app(window).log.survey.as_ref().expect("a survey");
    let sides = survey
        .side_scan
        .iter()
        .flat_map(|ping| [ping.port, ping.starboard]);
    sides
        .flatten()
        .fold(0.0, |far_m, side| f64::max(far_m, f64::from(side.far_m)))
}

pub(crate) fn drag(window: &mut Window, from: Pos2, to: Pos2) {
    pull(window, from, to);
    window.drop_at(to);
    window.run();
}

/// A drag that has not ended.
pub(crate) fn pull(window: &mut Window, from: Pos2, to: Pos2) {
    window.hover_at(from);
    window.step();
    window.drag_at(from);
    window.step();
    for share in [0.3, 0.7, 1.0] {
        window.hover_at(from.lerp(to, share));
        window.step();
        window.step();
    }
}

#[test]
fn a_missed_object_is_drawn_with_the_mouse_and_moved() {
    let mut window = demo_window();
    press(&mut window, Modifiers::NONE, Key::F);
    press(&mut window, Modifiers::NONE, Key::N);
    let (from, to) = (at(&window, 300.0, -8.0), at(&window, 400.0, -5.0));
    drag(&mut window, from, to);
    let one = review_of(&window).boxes().next().cloned().expect("a box");
    assert_eq!((one.state, one.mark.side), (State::Added, Side::Port));
    let near = |value: f64, expected: f64, by: f64| (value - expected).abs() < by;
    let mark = &one.mark;
    assert!(near(mark.pings.start as f64, 300.0, 4.0), "{mark:?}");
    assert!(near(mark.pings.end as f64, 400.0, 4.0), "{mark:?}");
    assert!(
        near(mark.near_m, 5.0, 0.1) && near(mark.far_m, 8.0, 0.1),
        "{mark:?}"
    );
    assert_eq!(selected(&window), one.id);
    assert_eq!(app(&window).log.reviewing.tool, Tool::Look);
    assert!(
        window
            .query_by_label_contains("box 1 selected: object, added")
            .is_some()
    );

    // Without the tool a drag moves the picture, with it the box, and its far edge alone.
    press(&mut window, Modifiers::NONE, Key::E);
    let (from, to) = (at(&window, 350.0, -6.5), at(&window, 450.0, -7.5));
    drag(&mut window, from, to);
    let moved = review_of(&window)
        .get(one.id)
        .expect("the box")
        .mark
        .clone();
    assert!(near(moved.pings.start as f64, 400.0, 8.0), "{moved:?}");
    assert!(
        near(moved.near_m, 6.0, 0.2) && near(moved.far_m, 9.0, 0.2),
        "{moved:?}"
    );
    let (from, to) = (at(&window, 450.0, -moved.far_m), at(&window, 470.0, -10.0));
    drag(&mut window, from, to);
    let sized = review_of(&window)
        .get(one.id)
        .expect("the box")
        .mark
        .clone();
    assert_eq!(
        (sized.pings.clone(), sized.near_m),
        (moved.pings.clone(), moved.near_m)
    );
    assert!(near(sized.far_m, 10.0, 0.2), "{sized:?}");
    press(&mut window, Modifiers::COMMAND, Key::Z);
    let back = review_of(&window)
        .get(one.id)
        .expect("the box")
        .mark
        .clone();
    assert_eq!(back, moved, "a drag is one step");
    press(&mut window, Modifiers::COMMAND, Key::Z);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(review_of(&window).boxes().len(), 0);
}

#[test]
fn a_click_selects_the_box_under_it_and_beside_it_a_ping() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = demo_window();
    let found = detections(&window, 8);
    propose(&mut window, &found, folder.path());
    press(&mut window, Modifiers::NONE, Key::F);
    let mark = &found[3].mark;
    let middle = mark.pings.start as f64 + 6.0;
    let place = at(&window, middle, 5.0);
    window.drag_at(place);
    window.drop_at(place);
    window.run();
    let one = app(&window)
        .log
        .reviewing
        .selected_box()
        .cloned()
        .expect("a box");
    assert_eq!(one.mark, *mark);
    assert!(window.query_by_label_contains("Picture of box").is_some());
    window.get_by_label("Accept box").click();
    window.run();
    assert_eq!(
        review_of(&window).get(one.id).map(|one| one.state),
        Some(State::Accepted)
    );
    let beside = at(&window, middle, -5.0);
    window.drag_at(beside);
    window.drop_at(beside);
    window.run();
    assert_eq!(app(&window).log.reviewing.selected, None);
    assert!(app(&window).selection.is_some());
}
