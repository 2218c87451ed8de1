//! Boxes drawn, moved and picked with the mouse.

use super::*;

/// Returns the position of a place on the screen of a waterfall that shows all of the demo, time to
/// the right.
pub(crate) fn at(window: &Window, ping: f64, across_m: f64) -> Pos2 {
    let view = window.get_by_label_contains("Waterfall, pings").rect();
    let seen = &app(window).view.visible;
    let share = (ping - seen.start as f64) / seen.len() as f64;
    // The range that is shown is the demo's longest.
    let far_m = farthest_m(window);
    pos2(
        view.left() + view.width() * share as f32,
        view.center().y + 0.5 * view.height() * (across_m / far_m) as f32,
    )
}

fn farthest_m(window: &Window) -> f64 {
    let survey = app(window).logs.shown.survey.as_ref().expect("a survey");
    let sides = survey.side_scan.iter().flat_map(|ping| [ping.port, ping.starboard]);
    sides.flatten().fold(0.0, |far_m, side| f64::max(far_m, f64::from(side.far_m)))
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
    let review_box = review_of(&window).boxes().next().cloned().expect("a box");
    assert_eq!((review_box.state, review_box.mark.side), (State::Added, Side::Port));
    let near = |value: f64, expected: f64, by: f64| (value - expected).abs() < by;
    let mark = &review_box.mark;
    assert!(near(mark.pings.start as f64, 300.0, 4.0), "{mark:?}");
    assert!(near(mark.pings.end as f64, 400.0, 4.0), "{mark:?}");
    assert!(near(mark.near_m, 5.0, 0.1) && near(mark.far_m, 8.0, 0.1), "{mark:?}");
    assert_eq!(selected(&window), review_box.id);
    assert_eq!(app(&window).logs.shown.reviewing.tool, Tool::Look);
    assert!(window.query_by_label_contains("box 1 selected: object, added").is_some());

    // Without the tool a drag moves the picture, with it the box, and its far edge alone.
    press(&mut window, Modifiers::NONE, Key::E);
    let (from, to) = (at(&window, 350.0, -6.5), at(&window, 450.0, -7.5));
    drag(&mut window, from, to);
    let moved = review_of(&window).get(review_box.id).expect("the box").mark.clone();
    assert!(near(moved.pings.start as f64, 400.0, 8.0), "{moved:?}");
    assert!(near(moved.near_m, 6.0, 0.2) && near(moved.far_m, 9.0, 0.2), "{moved:?}");
    let (from, to) = (at(&window, 450.0, -moved.far_m), at(&window, 470.0, -10.0));
    drag(&mut window, from, to);
    let sized = review_of(&window).get(review_box.id).expect("the box").mark.clone();
    assert_eq!((sized.pings.clone(), sized.near_m), (moved.pings.clone(), moved.near_m));
    assert!(near(sized.far_m, 10.0, 0.2), "{sized:?}");
    press(&mut window, Modifiers::COMMAND, Key::Z);
    let back = review_of(&window).get(review_box.id).expect("the box").mark.clone();
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
    let review_box = app(&window).logs.shown.reviewing.selected_box().cloned().expect("a box");
    assert_eq!(review_box.mark, *mark);
    assert!(window.query_by_label_contains("Picture of box").is_some());
    window.get_by_label("Accept box").click();
    window.run();
    assert_eq!(
        review_of(&window).get(review_box.id).map(|review_box| review_box.state),
        Some(State::Accepted)
    );
    // The next box has come one to one.
    press(&mut window, Modifiers::NONE, Key::F);
    let beside = at(&window, middle, -5.0);
    window.drag_at(beside);
    window.drop_at(beside);
    window.run();
    assert_eq!(app(&window).logs.shown.reviewing.selected, None);
    assert!(app(&window).view.selection.is_some());
}

#[test]
fn the_border_of_echo_and_shadow_has_a_handle_of_its_own() {
    let mut window = demo_window();
    press(&mut window, Modifiers::NONE, Key::F);
    press(&mut window, Modifiers::NONE, Key::N);
    let (from, to) = (at(&window, 300.0, -9.0), at(&window, 400.0, -4.0));
    drag(&mut window, from, to);
    let id = selected(&window);
    let box_now = |window: &Window| review_of(window).get(id).expect("the box").clone();
    let drawn = box_now(&window);
    assert_eq!(drawn.extent, ObjectExtent::Found);
    let border_m = border_m(&app(&window).logs.shown.reviewing, &drawn);
    assert!((drawn.mark.near_m..=drawn.mark.far_m).contains(&border_m));

    press(&mut window, Modifiers::NONE, Key::E);
    // Off the middle of the box along the track, so that nothing else is near.
    let (from, to) = (at(&window, 350.0, -border_m), at(&window, 350.0, -7.6));
    drag(&mut window, from, to);
    let set = box_now(&window);
    assert_eq!(set.mark, drawn.mark, "the outer edges stay");
    let moved_m = set.extent.border_m().expect("a border that was drawn");
    assert!((moved_m - 7.6).abs() < 0.2, "{moved_m}");
    let label = format!("edges of box {}", id.0);
    assert_eq!(app(&window).document.history.undo_label(), Some(&*label));

    // By keys: the border is the second edge. To port, up on the screen is outward.
    press(&mut window, Modifiers::SHIFT, Key::E);
    press(&mut window, Modifiers::SHIFT, Key::E);
    assert_eq!(app(&window).logs.shown.reviewing.edge, BoxEdge::Border);
    window.get_by_label_contains("editing its border of echo and shadow");
    press(&mut window, Modifiers::NONE, Key::ArrowUp);
    let nudged_m = box_now(&window).extent.border_m().expect("a border");
    assert!((nudged_m - moved_m - 0.04).abs() < 1e-9, "{nudged_m}");
    press(&mut window, Modifiers::SHIFT, Key::E);
    press(&mut window, Modifiers::SHIFT, Key::ArrowUp);
    let longer = box_now(&window);
    assert!((longer.mark.far_m - drawn.mark.far_m - 0.4).abs() < 1e-9);
    assert_eq!(longer.extent.border_m(), Some(nudged_m), "the border stays");

    // Each was one step.
    for _ in 0..2 {
        press(&mut window, Modifiers::COMMAND, Key::Z);
    }
    assert_eq!(box_now(&window).extent.border_m(), Some(moved_m));
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(box_now(&window).extent, ObjectExtent::Found);
    press(&mut window, Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    app_mut(&mut window).apply(Command::Do(Action::FindEdges));
    window.run();
    assert_eq!(box_now(&window).extent, ObjectExtent::Found);
}

#[test]
fn a_target_is_marked_by_a_click_or_at_the_pointer() {
    let mut window = demo_window();
    press(&mut window, Modifiers::NONE, Key::F);
    press(&mut window, Modifiers::NONE, Key::T);
    assert_eq!(app(&window).logs.shown.reviewing.tool, Tool::Point);
    let place = at(&window, 300.0, -6.0);
    window.drag_at(place);
    window.drop_at(place);
    window.run();
    let points = |window: &Window| -> Vec<Mark> {
        let is_point = |review_box: &Reviewed| review_box.extent == ObjectExtent::Point;
        assert!(review_of(window).boxes().all(is_point));
        let boxes = review_of(window).boxes();
        boxes.map(|review_box| review_box.mark.clone()).collect()
    };
    let [point] = &points(&window)[..] else { panic!("{:?}", points(&window)) };
    let range_m = 0.5 * (point.near_m + point.far_m);
    assert!((range_m - 6.0).abs() < 0.1 && point.side == Side::Port, "{point:?}");
    assert!((point.pings.start as f64 - 300.0).abs() < 4.0, "{point:?}");
    assert_eq!(app(&window).logs.shown.reviewing.tool, Tool::Look);
    let id = selected(&window);
    let placed = app(&window).logs.shown.reviewing.placed(id).expect("a place");
    let target = &placed.target;
    assert!(target.length_m.is_nan() && target.width_m.is_nan() && target.height_m.is_nan());
    assert!(target.east_m.is_finite() && target.sigma_m > 0.0);

    // By keys: once for the tool, once more at the pointer.
    window.hover_at(at(&window, 500.0, 5.0));
    window.run();
    press(&mut window, Modifiers::NONE, Key::T);
    press(&mut window, Modifiers::NONE, Key::T);
    assert_eq!(points(&window).len(), 2);
    assert_eq!(points(&window)[1].side, Side::Starboard);
    assert_eq!(app(&window).document.history.undo_label(), Some("new point 2"));
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(points(&window).len(), 1);
    // A point is deleted as a box that was drawn.
    app_mut(&mut window).apply(Command::SelectBox(Some(id)));
    window.run();
    press(&mut window, Modifiers::NONE, Key::Delete);
    assert!(points(&window).is_empty());
}
