//! What is known of the water, entered in the window as an analyst would, and taken back.

use crate::window::{app, demo_window};
use bathyscope::app::{Action, Command};
use egui::accesskit::Role;
use egui_kittest::kittest::Queryable as _;

#[test]
fn draft_and_sound_speed_move_the_cloud_and_can_be_undone() {
    let mut window = demo_window();
    let depth_m = |window: &crate::window::Window| {
        let products = app(window).products.as_ref().expect("a result");
        -products.cloud.points[100].z_m
    };
    let before_m = depth_m(&window);
    window
        .get_by_role_and_label(Role::Slider, "Draft")
        .set_value_accesskit(0.4);
    window.run();
    assert!((depth_m(&window) - before_m - 0.4).abs() < 1e-6);
    window
        .get_by_label("Correct the speed of sound")
        .click_accesskit();
    window.run();
    let speed = app(&window).settings.sound_speed.clone();
    assert_eq!(speed.temperature_c, Some(12.0));
    let factor = speed.water_m_s().expect("a speed") / 1500.0;
    assert!((depth_m(&window) - 0.4 - factor * before_m).abs() < 1e-6);
    let statement = app(&window)
        .products
        .as_ref()
        .unwrap()
        .correction
        .statement();
    assert!(window.query_by_label(&statement).is_some(), "{statement}");
    for _ in 0..2 {
        window.state_mut().app.apply(Command::Do(Action::Undo));
        window.run();
    }
    assert_eq!(depth_m(&window), before_m);
}
