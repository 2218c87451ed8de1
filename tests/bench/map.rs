//! A frame of the map on the window's thread: for a small and a large survey, and with every layer.

use crate::resources::processor_s;
use bathyscope::app::{App, Jobs, MapLayer, View};
use bathyscope::ui::ViewContext;
use bathyscope::ui::views::MapView;
use bathyscope_bottom::cloud::{Correction, Geometry, PointCloud, ping_depths};
use bathyscope_bottom::first_return;
use bathyscope_log::formats;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Navigation, PingNav, SidePing, SideScanState, Sounding, Survey};
use bathyscope_products::pipeline::{self, Products, Settings};
use bathyscope_simulation::{Scene, simulate};
use eframe::egui_wgpu::{RenderState, RendererOptions};
use egui_kittest::wgpu::{create_render_state, default_wgpu_setup};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Frames timed of each. The fastest tenth is compared: other programs, and lavapipe's own threads
/// where there is no GPU, can only make a frame slower.
const FRAMES: usize = 400;

/// Lines and pings of the survey that is shown with every layer.
const LINES: u32 = 10;
const PINGS_A_LINE: f64 = 3000.0;

/// Prints the time of a frame while the map is dragged, for 1 000 and for 1 000 000 pings, and with
/// the track alone and every layer of a survey of ten lines; and what it takes, in a background
/// thread, to paint those layers for the first time.
pub(super) fn run() {
    let state = create_render_state(default_wgpu_setup(), RendererOptions::PREDICTABLE);
    let [few, many] = frames(&state, [1_000, 1_000_000].map(|count| Window::new(app(count))));
    println!("map, 1 000 pings:      {few:8.1} us a frame");
    println!("map, 1 000 000 pings:  {many:8.1} us a frame");
    println!("ratio:                 {:8.2} (at most 1.5)", many / few);

    let (survey, products, tracked_s) = surveyed();
    let windows = [false, true].map(|every_layer| {
        let mut app = App::new(Jobs::Inline);
        app.show_survey(survey.clone(), Some(products.clone()));
        for layer in MapLayer::ALL {
            let shown = every_layer || layer == MapLayer::Track;
            app.view.options.map.layers.set_visible(layer, shown);
        }
        let mut window = Window::new(app);
        let before = processor_s();
        window.frame(&state, 0);
        if every_layer {
            let painted_s = processor_s() - before;
            println!("{} pings tracked:    {tracked_s:6.2} s of processor", survey.side_scan.len());
            println!(
                "every layer, first picture: {painted_s:6.2} s of processor, {:.2} of tracking",
                painted_s / tracked_s
            );
        }
        window
    });
    let [bare, full] = frames(&state, windows);
    println!("map, track alone:      {bare:8.1} us a frame");
    println!("map, every layer:      {full:8.1} us a frame");
    println!("ratio:                 {:8.2}", full / bare);
}

/// Microseconds of a typical frame of each window.
fn frames<const N: usize>(state: &RenderState, mut windows: [Window; N]) -> [f64; N] {
    // Turn by turn, so that a busy machine slows all alike.
    for frame in 0..FRAMES {
        for window in &mut windows {
            window.frame(state, frame);
        }
    }
    windows.map(|window| us(window.typical()))
}

/// A survey of lines side by side with its results, and the seconds of processor that tracking it
/// took.
fn surveyed() -> (Arc<Survey>, Products, f64) {
    let progress = Progress::new();
    let mut scene = Scene::with_pings(1);
    scene.track.lines = LINES;
    scene.track.spacing_m = 15.0;
    scene.track.length_m = PINGS_A_LINE * scene.track.speed_mps / scene.track.ping_rate_hz;
    let simulated = simulate(&scene, 1, &progress).expect("not cancelled");
    let survey = formats::open_bytes("lines.sl2", simulated.sl2_bytes(), &progress);
    let survey = Arc::new(survey.expect("a readable log"));
    let settings = Settings::default();
    let products = pipeline::run(&survey, &settings, None, &progress, |_| ());
    let products = products.expect("not cancelled");
    let before = processor_s();
    let returns = first_return::detect(&survey, &settings.image, &settings.first_return, &progress);
    std::hint::black_box(returns.expect("not cancelled"));
    (survey, products, processor_s() - before)
}

fn us(duration: Duration) -> f64 {
    duration.as_secs_f64() * 1e6
}

/// Lines of 500 m, 10 m apart, back and forth, however many it takes.
fn place(ping: usize, count: usize) -> PingNav {
    let a_line = (count / 40).max(1);
    let (line, share) = (ping / a_line, (ping % a_line) as f64 / a_line as f64);
    let along = if line % 2 == 1 { 1.0 - share } else { share };
    PingNav {
        east_m: 500.0 * along,
        north_m: 10.0 * line as f64 + 0.3 * (ping as f64 * 0.01).sin(),
        heading_rad: 0.0,
        speed_mps: 2.0,
    }
}

fn app(count: usize) -> App {
    let nav: Vec<PingNav> = (0..count).map(|ping| place(ping, count)).collect();
    let depth_m = |ping: usize| 3.0 + (ping as f32 * 1e-4).sin();
    let side_scan = (0..count).map(|ping| SidePing {
        time_s: ping as f64 * 0.1,
        depth_m: depth_m(ping),
        depth_fault: None,
        port: None,
        starboard: None,
    });
    let soundings = (0..count).map(|ping| Sounding::new(ping as f64 * 0.1, depth_m(ping)));
    let mut app = App::new(Jobs::Inline);
    let survey = Arc::new(Survey {
        side_scan: std::sync::Arc::new(side_scan.collect()),
        side_scan_state: SideScanState::Usable,
        soundings: Arc::new(soundings.collect()),
        ..Survey::default()
    });
    let products = products(&survey, nav);
    app.show_survey(survey, Some(products));
    app
}

fn products(survey: &Survey, nav: Vec<PingNav>) -> Products {
    let (cloud, correction) = (PointCloud::default(), Correction::default());
    let depths = ping_depths(survey, &nav, (&cloud, Geometry::Slope), &[], &correction);
    Products {
        settings: Arc::default(),
        exclusions: Arc::default(),
        relief: Arc::default(),
        navigation: Arc::new(Navigation {
            soundings: Arc::new(nav.clone()),
            ..Navigation::of_pings(nav)
        }),
        flat_spots: Arc::new(Vec::new()),
        judged: None,
        latency: None,
        repeatability: None,
        clutter: None,
        found: Arc::default(),
        returns: Arc::default(),
        bottom_line: Arc::default(),
        calibration: Arc::default(),
        correction: Arc::new(correction),
        cloud: Arc::new(cloud),
        classes: Arc::new(Vec::new()),
        depths: Arc::new(depths),
        depth_range_m: Some([2.0, 4.0]),
        scales: Default::default(),
    }
}

/// A map alone in a window.
struct Window {
    app: App,
    view: MapView,
    context: egui::Context,
    times: Vec<Duration>,
}

impl Window {
    fn new(app: App) -> Self {
        Self {
            app,
            view: MapView::default(),
            context: egui::Context::default(),
            times: Vec::with_capacity(FRAMES),
        }
    }

    /// Builds a frame in which the map moves, so that nothing can be taken from the frame before.
    fn frame(&mut self, state: &RenderState, frame: usize) {
        let input = egui::RawInput {
            screen_rect: Some(egui::Rect::from_min_size(
                egui::Pos2::ZERO,
                egui::vec2(900.0, 700.0),
            )),
            time: Some(frame as f64 / 60.0),
            events: drag(frame),
            ..Default::default()
        };
        let started = Instant::now();
        self.app.poll();
        let output = self.context.run_ui(input, |ui| {
            let mut context = ViewContext {
                app: &self.app,
                render_state: Some(state),
                target: View::Map,
                commands: &mut Vec::new(),
            };
            self.view.ui(ui, &mut context);
        });
        let context = &self.context;
        let shapes = context.tessellate(output.shapes, output.pixels_per_point);
        self.times.push(started.elapsed());
        std::hint::black_box(shapes);
        // What the GPU does with the frame is not the window's thread's time.
        state.device.poll(wgpu::PollType::wait_indefinitely()).ok();
    }

    fn typical(mut self) -> Duration {
        self.times.sort();
        self.times[FRAMES / 10]
    }
}

/// The pointer goes down on the map and then circles.
fn drag(frame: usize) -> Vec<egui::Event> {
    let (sin, cos) = (frame as f32 * 0.1).sin_cos();
    let at = egui::pos2(450.0 + 60.0 * cos, 350.0 + 60.0 * sin);
    let mut events = vec![egui::Event::PointerMoved(at)];
    if frame == 5 {
        events.push(egui::Event::PointerButton {
            pos: at,
            button: egui::PointerButton::Primary,
            pressed: true,
            modifiers: egui::Modifiers::NONE,
        });
    }
    events
}
