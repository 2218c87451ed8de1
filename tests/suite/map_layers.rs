//! The layers of the map, chosen through the accessibility tree as a screen reader or an analyst
//! would.

use crate::window::{Window, app, demo_window};
use bathyscope::app::{Action, LayerShown, MapLayer};
use egui::accesskit::Role;
use egui_kittest::kittest::Queryable as _;

fn shown(window: &Window, layer: MapLayer) -> LayerShown {
    app(window).view.options.map.layers.of(layer)
}

fn order(window: &Window) -> Vec<MapLayer> {
    let layers = &app(window).view.options.map.layers;
    layers.bottom_up().map(|shown| shown.layer).collect()
}

#[test]
fn a_layer_is_hidden_faded_and_moved_from_the_view_s_title() {
    let mut window = demo_window();
    window.get_by_label("Layers").click();
    window.run();
    let track = window.get_by_role_and_label(Role::CheckBox, "Track");
    track.click();
    window.run();
    assert!(!shown(&window, MapLayer::Track).visible);
    let opacity = window.get_by_role_and_label(Role::Slider, "Depth map opacity");
    opacity.set_value_accesskit(40.0);
    window.run();
    assert_eq!(shown(&window, MapLayer::DepthMap).opacity, 0.4);
    window.get_by_label("Raise Depth map").click();
    window.run();
    let place = |layer| order(&window).iter().position(|other| *other == layer);
    assert!(place(MapLayer::DepthMap) > place(MapLayer::HillShade));
}

#[test]
fn a_command_shows_what_it_hid() {
    let mut window = demo_window();
    for visible in [false, true] {
        let hide = bathyscope::app::Command::Do(Action::DepthMapLayer);
        window.state_mut().app.apply(hide);
        window.run();
        assert_eq!(shown(&window, MapLayer::DepthMap).visible, visible);
    }
}
