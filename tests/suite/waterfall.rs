//! The waterfall: tiles against a brute-force picture, gestures, names, and what it looks like.

use crate::support;
use bathyscope::app::{App, Command, Jobs, Mark, Orientation};
use bathyscope::survey::{
    Bytes, Encoding, Order, SidePing, SideScanState, SideSpan, Source, Survey, Track,
};
use bathyscope::ui::views::{ProfileView, WaterfallView};
use bathyscope::ui::{ViewContext, ViewRequest};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use egui_kittest::wgpu::{WgpuTestRenderer, create_render_state, default_wgpu_setup};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A waterfall alone in a window, with its state at hand.
struct Window {
    app: App,
    view: WaterfallView,
    profile: ProfileView,
    /// Which of the two is in the window.
    shows_profile: bool,
    /// Commands that the view pushed, in order.
    pushed: Vec<Command>,
}

fn app_with(survey: Survey) -> App {
    let mut app = App::new(Jobs::Inline);
    app.survey = Some(Arc::new(survey));
    app.survey_serial = 1;
    app
}

fn window(app: App, size: [f32; 2]) -> Harness<'static, Window> {
    let render_state = create_render_state(
        default_wgpu_setup(),
        eframe::egui_wgpu::RendererOptions::PREDICTABLE,
    );
    let for_view = render_state.clone();
    let state = Window {
        app,
        view: WaterfallView::default(),
        profile: ProfileView::default(),
        shows_profile: false,
        pushed: Vec::new(),
    };
    Harness::builder()
        .with_size(size)
        .with_pixels_per_point(1.0)
        .renderer(WgpuTestRenderer::from_render_state(render_state))
        .build_ui_state(
            move |ui, state: &mut Window| {
                let mut commands = Vec::new();
                let mut context = ViewContext {
                    app: &state.app,
                    render_state: Some(&for_view),
                    commands: &mut commands,
                };
                if state.shows_profile {
                    state.profile.ui(ui, &mut context);
                } else {
                    state.view.ui(ui, &mut context);
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
fn settle(harness: &mut Harness<'_, Window>) {
    let start = Instant::now();
    harness.run_steps(2);
    while !harness.state().view.is_settled() {
        assert!(
            start.elapsed() < Duration::from_secs(30),
            "the waterfall never settles"
        );
        std::thread::sleep(Duration::from_millis(2));
        harness.run_steps(1);
    }
    harness.run_steps(1);
}

/// Pings that share one small buffer: `spans` says where port and starboard of each lie.
fn survey_of(
    bytes: Vec<u8>,
    pings: usize,
    spans: impl Fn(usize) -> [Option<SideSpan>; 2],
) -> Survey {
    let side_scan = (0..pings).map(|ping| {
        let [port, starboard] = spans(ping);
        SidePing {
            time_s: ping as f64 * 0.05,
            depth_m: 4.0,
            depth_locked: true,
            port,
            starboard,
        }
    });
    Survey {
        source: Source {
            files: vec!["synthetic.sl2".into()],
            format: "synthetic".into(),
            byte_count: bytes.len() as u64,
        },
        start_unix_s: None,
        channels: Vec::new(),
        side_scan: side_scan.collect(),
        side_scan_state: SideScanState::Usable,
        soundings: Vec::new(),
        track: Track::new(Vec::new()),
        warnings: Vec::new(),
        bytes: vec![Bytes::Held(bytes.into())],
    }
}

fn span(offset: u64, count: u32, far_m: f32) -> SideSpan {
    SideSpan {
        file: 0,
        encoding: Encoding::U8,
        order: Order::NearToFar,
        offset,
        count,
        near_m: 0.0,
        far_m,
    }
}

/// A bottom at 4 m under a dark water column, brighter to starboard, every ping the same.
fn even_bottom(pings: usize) -> Survey {
    let side = |gain: usize| {
        (0..400).map(move |sample| {
            if sample < 80 {
                8
            } else {
                (gain * (480 - sample) / 400) as u8
            }
        })
    };
    let bytes: Vec<u8> = side(150).chain(side(220)).collect();
    survey_of(bytes, pings, |_| {
        [Some(span(0, 400, 20.0)), Some(span(400, 400, 20.0))]
    })
}

#[test]
fn the_view_says_what_it_shows() {
    let mut harness = window(app_with(even_bottom(3000)), [400.0, 300.0]);
    settle(&mut harness);
    harness.get_by_label("Waterfall, pings 0 to 767 of 3000, first return not yet found");
    assert_eq!(harness.state().app.visible, 0..768);
    harness.state_mut().view.show_pings(1000..1600);
    settle(&mut harness);
    harness.get_by_label_contains("pings 1000 to 1599 of 3000");
}

#[test]
fn look_at_the_real_river() {
    let Some(data) = support::real_data() else {
        return;
    };
    let Ok(folder) = std::env::var("BATHYSCOPE_LOOK") else {
        return;
    };
    let mut app = App::new(Jobs::Inline);
    app.apply(Command::Open(
        data.join("humminbird-glen-canyon/Rec00001.DAT"),
    ));
    while !app.is_idle() || app.products.is_none() {
        app.poll();
    }
    let mut harness = window(app, [1200.0, 500.0]);
    let save = |harness: &mut Harness<'_, Window>, name: &str| {
        settle(harness);
        let picture = harness.render().expect("a picture");
        picture
            .save(format!("{folder}/{name}.png"))
            .expect("a file");
    };
    save(&mut harness, "river");
    harness.state_mut().view.show_pings(1000..1300);
    harness.hover_at(egui::pos2(420.0, 330.0));
    save(&mut harness, "river-near");
    harness.state_mut().view.show_pings(1000..1060);
    harness.state_mut().app.options.waterfall.depth_line = true;
    save(&mut harness, "river-nearer");
    harness.state_mut().app.options.waterfall.orientation = Orientation::Vertical;
    harness.state_mut().view.request(ViewRequest::Fit);
    harness.set_size(egui::vec2(500.0, 900.0));
    save(&mut harness, "river-down");
    harness.state_mut().shows_profile = true;
    harness.state_mut().app.hover = None;
    harness
        .state_mut()
        .app
        .apply(Command::Select(Some(Mark::ping(1800))));
    harness.remove_cursor();
    harness.set_size(egui::vec2(316.0, 196.0));
    save(&mut harness, "profile-small");
    harness.set_size(egui::vec2(700.0, 340.0));
    save(&mut harness, "profile");
}
