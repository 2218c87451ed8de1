//! The waterfall and the profile in a window of their own: what they say, what gestures do, what
//! they look like.

mod levels;
mod profile;
mod read_out;
mod synthetic;
mod tone;

use crate::support;
use bathyscope::app::{App, Command, Jobs, LogPlace, Orientation, View};
use bathyscope::ui::views::{ProfileView, WaterfallView};
use bathyscope::ui::{ViewContext, ViewRequest};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Side, SideScanState, Survey};
use egui::accesskit::Role;
use egui::{Event, Modifiers, MouseWheelUnit, Pos2, Vec2, pos2, vec2};
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use egui_kittest::wgpu::{WgpuTestRenderer, create_render_state, default_wgpu_setup};
use egui_kittest::{Harness, Node};
use std::sync::Arc;
use std::time::{Duration, Instant};
use synthetic::{bed_m, even_bottom, pond, pond_returns, span, survey_of};

/// A waterfall or a profile alone in a window, with its state at hand.
struct Window {
    app: App,
    waterfall: WaterfallView,
    profile: ProfileView,
    shows_profile: bool,
    /// Commands that the view pushed, in order.
    pushed: Vec<Command>,
}

fn window(app: App, size: [f32; 2]) -> Harness<'static, Window> {
    let render_state =
        create_render_state(default_wgpu_setup(), eframe::egui_wgpu::RendererOptions::PREDICTABLE);
    let for_view = render_state.clone();
    let state = Window {
        app,
        waterfall: WaterfallView::default(),
        profile: ProfileView::default(),
        shows_profile: false,
        pushed: Vec::new(),
    };
    Harness::builder()
        .with_size(size)
        .with_pixels_per_point(1.0)
        .with_render_cursor(false)
        // Two clicks in a row are a double-click only within 0.3 s.
        .with_step_dt(0.02)
        .with_options(support::snapshot_options())
        .renderer(WgpuTestRenderer::from_render_state(render_state))
        .build_ui_state(
            move |ui, state: &mut Window| {
                let mut commands = Vec::new();
                let mut context = ViewContext {
                    app: &state.app,
                    render_state: Some(&for_view),
                    target: View::Waterfall,
                    commands: &mut commands,
                };
                // The margin of the harness's panel is no part of the view.
                let whole = ui.ctx().content_rect();
                let mut ui = ui.new_child(egui::UiBuilder::new().max_rect(whole));
                if state.shows_profile {
                    state.profile.ui(&mut ui, &mut context);
                } else {
                    state.waterfall.ui(&mut ui, &mut context);
                }
                for command in commands {
                    state.pushed.push(command.clone());
                    state.app.apply(command);
                }
            },
            state,
        )
}

/// Runs frames until all tiles are there.
fn settle(window: &mut Harness<'_, Window>) {
    let start = Instant::now();
    window.run_steps(2);
    while !window.state().waterfall.is_settled() {
        assert!(start.elapsed() < bathyscope_test_support::PATIENCE, "the waterfall never settles");
        std::thread::sleep(Duration::from_millis(2));
        window.run_steps(1);
    }
    window.run_steps(1);
}

fn name(window: &Harness<'_, Window>) -> String {
    let picture: Node<'_> = window.get_by_role(Role::Image);
    picture.accesskit_node().label().unwrap_or_default()
}

fn app_with(survey: Survey) -> App {
    let mut app = App::new(Jobs::Inline);
    app.show_survey(Arc::new(survey), None);
    app
}

fn pond_app() -> App {
    let survey = pond();
    let returns = pond_returns(&survey);
    let mut app = app_with(survey);
    app.logs.shown.preview = Some(Arc::new(returns));
    app
}

fn wheel(window: &mut Harness<'_, Window>, at: Pos2, delta: Vec2, modifiers: Modifiers) {
    window.hover_at(at);
    window.event_modifiers(
        Event::MouseWheel {
            unit: MouseWheelUnit::Point,
            delta,
            phase: egui::TouchPhase::Move,
            source: egui::MouseWheelSource::Unknown,
            modifiers,
        },
        modifiers,
    );
    // egui spreads a turn of the wheel over some frames.
    window.run_steps(30);
    window.event_modifiers(Event::PointerGone, Modifiers::NONE);
    window.run_steps(1);
}

fn visible(window: &Harness<'_, Window>) -> std::ops::Range<usize> {
    window.state().app.view.visible.clone()
}

#[test]
fn the_waterfall_says_what_it_shows() {
    let mut window = window(app_with(even_bottom(3000)), [400.0, 300.0]);
    settle(&mut window);
    assert_eq!(name(&window), "Waterfall, pings 0 to 799 of 3000, first return not yet found");
    window.state_mut().waterfall.show_pings(1000..1600);
    window.state_mut().app.view.options.waterfall.first_return = false;
    settle(&mut window);
    assert_eq!(name(&window), "Waterfall, pings 1000 to 1599 of 3000, first return hidden");
    assert_eq!(visible(&window), 1000..1600);
}

#[test]
fn without_a_survey_or_a_picture_it_says_why() {
    let mut empty = window(App::new(Jobs::Inline), [400.0, 300.0]);
    settle(&mut empty);
    assert!(name(&empty).contains("open a survey"), "{}", name(&empty));

    let mut absent = survey_of(Vec::new(), std::iter::empty());
    absent.side_scan_state = SideScanState::Absent;
    let mut absent = window(app_with(absent), [400.0, 300.0]);
    settle(&mut absent);
    assert!(name(&absent).contains("no side-scan"), "{}", name(&absent));

    let mut noise = even_bottom(100);
    noise.side_scan_state = SideScanState::Noise { range_m: 1.5 };
    let mut noise = window(app_with(noise), [400.0, 300.0]);
    settle(&mut noise);
    let said = name(&noise);
    assert!(said.contains("no side-scan: range stuck at ±1.5 m"), "{said}");
}

#[test]
fn wheel_drag_and_double_click_move_the_picture() {
    let mut window = window(app_with(even_bottom(1200)), [400.0, 300.0]);
    settle(&mut window);
    assert_eq!(visible(&window), 0..1200);
    // A quarter along: the ping there stays while the wheel enlarges.
    wheel(&mut window, pos2(100.0, 150.0), vec2(0.0, 200.0), Modifiers::NONE);
    let near = visible(&window);
    assert!(near.len() < 700, "{near:?}");
    let under_pointer = near.start as f64 + near.len() as f64 / 4.0;
    assert!((under_pointer - 300.0).abs() < 3.0, "{near:?}");
    // Shift: along the track, no enlargement.
    wheel(&mut window, pos2(100.0, 150.0), vec2(0.0, -100.0), Modifiers::SHIFT);
    let along = visible(&window);
    assert!(along.start > near.start + 50, "{near:?} {along:?}");
    assert!(along.len().abs_diff(near.len()) <= 1);
    // Dragged 60 points to the right, it shows earlier pings.
    window.drag_at(pos2(200.0, 150.0));
    window.run_steps(1);
    window.hover_at(pos2(230.0, 150.0));
    window.run_steps(1);
    window.hover_at(pos2(260.0, 150.0));
    window.run_steps(1);
    window.drop_at(pos2(260.0, 150.0));
    window.run_steps(1);
    let dragged = visible(&window);
    let moved = along.start - dragged.start;
    let expected = 60.0 * along.len() as f64 / 400.0;
    assert!((moved as f64 - expected).abs() <= 2.0, "{moved} pings, not {expected}");
    for _ in 0..2 {
        window.drag_at(pos2(200.0, 150.0));
        window.drop_at(pos2(200.0, 150.0));
        window.run_steps(1);
    }
    window.run_steps(1);
    assert_eq!(visible(&window), 0..1200, "a double-click shows everything");
}

#[test]
fn keys_zoom_about_the_middle_and_fit() {
    let mut window = window(app_with(even_bottom(1000)), [400.0, 300.0]);
    settle(&mut window);
    window.state_mut().waterfall.request(ViewRequest::ZoomIn);
    assert!(!window.state().waterfall.is_settled(), "a request is still to be carried out");
    settle(&mut window);
    assert_eq!(visible(&window), 100..900);
    window.state_mut().waterfall.request(ViewRequest::Fit);
    settle(&mut window);
    assert_eq!(visible(&window), 0..1000);
}

#[test]
fn hover_and_click_name_ping_side_and_sample() {
    for orientation in [Orientation::Horizontal, Orientation::Vertical] {
        let mut app = app_with(even_bottom(400));
        app.view.options.waterfall.orientation = orientation;
        let mut window = window(app, [400.0, 400.0]);
        settle(&mut window);
        // 100.5 points along: ping 100. 5 m of 20 to port: a quarter of half the window, sample 100
        // of 400.
        let at = match orientation {
            Orientation::Horizontal => pos2(100.5, 150.0),
            Orientation::Vertical => pos2(150.0, 100.5),
        };
        window.hover_at(at);
        window.run_steps(1);
        let mark = window.state().app.view.hover.expect("the pointer is over a ping");
        assert_eq!((mark.ping, mark.side), (100, Some(Side::Port)));
        assert!((mark.sample.expect("a sample") - 100.0).abs() < 1.5, "{mark:?}");
        window.drag_at(at);
        window.drop_at(at);
        window.run_steps(1);
        assert_eq!(window.state().app.view.selection, Some(mark));
        window.event(Event::PointerGone);
        window.run_steps(1);
        assert_eq!(window.state().app.view.hover, None);
    }
}

#[test]
fn the_menu_proposes_a_stretch_and_reveals_where_it_was_opened() {
    let mut window = window(app_with(even_bottom(1000)), [400.0, 300.0]);
    settle(&mut window);
    for (label, index) in [("Propose for the scale", 0), ("Show in map and 3D", 1)] {
        let at = pos2(200.5, 200.0);
        window.hover_at(at);
        for pressed in [true, false] {
            window.event(Event::PointerButton {
                pos: at,
                button: egui::PointerButton::Secondary,
                pressed,
                modifiers: Modifiers::NONE,
            });
            window.run_steps(2);
        }
        // The menu finds its size and then its place.
        window.run_steps(5);
        window.get_by_label(label).click();
        window.run_steps(2);
        let pushed = &window.state().pushed;
        let found = pushed.iter().find(|command| match command {
            Command::ProposeStretch(pings) => index == 0 && (pings.start..pings.end).contains(&501),
            Command::Reveal(mark) => index == 1 && mark.ping == 501,
            _ => false,
        });
        assert!(found.is_some(), "{label}: {pushed:?}");
    }
}

#[test]
fn a_revealed_ping_comes_into_view() {
    let mut window = window(app_with(even_bottom(5000)), [400.0, 300.0]);
    settle(&mut window);
    assert!(!visible(&window).contains(&4000));
    window.state_mut().app.apply(Command::Reveal(LogPlace::ping(4000)));
    settle(&mut window);
    assert!(visible(&window).contains(&4000));
    let before = visible(&window);
    window.state_mut().app.apply(Command::Reveal(LogPlace::ping(3950)));
    settle(&mut window);
    assert_eq!(visible(&window), before, "what is in view does not jump");
}

#[test]
fn a_bright_sample_survives_in_the_overview() {
    // One sample in 20 000 pings of even bottom, of which 50 share a pixel column.
    let mut bytes: Vec<u8> = vec![60; 1200];
    bytes[400 + 200] = 255;
    let even = [Some(span(0, 400, 20.0)), Some(span(0, 400, 20.0))];
    let marked = [even[0], Some(span(400, 400, 20.0))];
    let spans = (0..20_000).map(|ping| if ping == 10_025 { marked } else { even });
    let mut app = app_with(survey_of(bytes, spans));
    app.view.options.waterfall.range_lines = false;
    app.view.options.waterfall.colour_map =
        bathyscope_bottom::presentation::colours::ColourMap::Grey;
    let mut window = window(app, [400.0, 300.0]);
    window.state_mut().waterfall.request(ViewRequest::Fit);
    settle(&mut window);
    assert_eq!(visible(&window), 0..20_000);
    let picture = window.render().expect("a picture");
    // 10 m to starboard: three quarters down.
    let column = |x: u32| (220..230).map(|y| picture.get_pixel(x, y).0[0]).max();
    assert!(column(200) > column(190).map(|level| level + 30), "{:?}", column(200));
}

#[test]
fn the_first_return_lies_where_its_pick_is() {
    let mut window = window(pond_app(), [600.0, 300.0]);
    settle(&mut window);
    let picture = window.render().expect("a picture");
    for ping in [40_usize, 330, 520] {
        let offset = bed_m(ping) / 20.0 * 150.0;
        let pixel = |y: f32| picture.get_pixel(ping as u32, y.round() as u32).0;
        let [r, g, b, _] = pixel(150.0 - offset - 0.5);
        assert!(r > 180 && g < 110 && b < 110, "port is red at ping {ping}: {r} {g} {b}");
        let [r, g, b, _] = pixel(150.0 + offset - 0.5);
        assert!(g > 150 && r < 110 && b < 130, "starboard is green at ping {ping}: {r} {g} {b}");
    }
}

#[test]
fn the_line_follows_new_picks_in_the_next_frame() {
    let mut window = window(pond_app(), [600.0, 300.0]);
    settle(&mut window);
    // As if the threshold were dragged: all picks 100 samples (5 m, then 2.5 m) farther out.
    let mut moved = pond_returns(&pond());
    for side in [&mut moved.port, &mut moved.starboard] {
        for pick in Arc::make_mut(side) {
            pick.sample += 100.0;
        }
    }
    window.state_mut().app.logs.shown.preview = Some(Arc::new(moved));
    window.run_steps(1);
    let picture = window.render().expect("a picture");
    let y = 150.0 + (bed_m(330) + 5.0) / 20.0 * 150.0 - 0.5;
    let [r, g, b, _] = picture.get_pixel(330, y.round() as u32).0;
    assert!(g > 150 && r < 110 && b < 130, "starboard is green at its new place: {r} {g} {b}");
}

#[test]
fn looks_as_it_did_along_the_screen() {
    let mut app = pond_app();
    app.view.selection =
        Some(LogPlace { side: Some(Side::Starboard), sample: Some(186.0), ..LogPlace::ping(202) });
    let mut window = window(app, [400.0, 240.0]);
    settle(&mut window);
    window.snapshot("waterfall_horizontal");
}

#[test]
fn looks_as_it_did_down_the_screen_and_near() {
    let mut app = pond_app();
    app.view.options.waterfall.orientation = Orientation::Vertical;
    app.view.options.waterfall.colour_map =
        bathyscope_bottom::presentation::colours::ColourMap::Viridis;
    app.view.options.waterfall.depth_line = true;
    let mut window = window(app, [240.0, 300.0]);
    window.state_mut().waterfall.show_pings(385..415);
    settle(&mut window);
    window.snapshot("waterfall_vertical_near");
}

#[test]
fn the_real_river_is_drawn_whole() {
    let Some(data) = support::real_data() else {
        return;
    };
    let path = data.join("humminbird-glen-canyon/Rec00001.DAT");
    let progress = Progress::new();
    let survey = bathyscope_log::formats::open(&path, &progress).expect("the river opens");
    let mut window = window(app_with(survey), [1200.0, 500.0]);
    window.state_mut().waterfall.show_pings(0..3453);
    settle(&mut window);
    let name = name(&window);
    assert!(name.starts_with("Waterfall, pings 0 to 3452 of 3453"), "{name}");
    let picture = window.render().expect("a picture");
    // Copper everywhere but in the labels: the far third of both sides is drawn, not left as
    // canvas.
    let drawn = |y: u32| {
        let copper = |x: &u32| {
            let [r, _, b, _] = picture.get_pixel(*x, y).0;
            r > b
        };
        (150..1150).filter(copper).count()
    };
    assert!(drawn(40) > 950 && drawn(440) > 950, "{} {}", drawn(40), drawn(440));
}
