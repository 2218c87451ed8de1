//! A frame of the map on the window's thread, for a small and a large survey.

use bathyscope::app::{App, Jobs};
use bathyscope::calibration::{Calibration, PpdReach, ScaleMode};
use bathyscope::cloud::PointCloud;
use bathyscope::first_return::FirstReturns;
use bathyscope::pipeline::{Products, Settings};
use bathyscope::survey::{
    Navigation, PingNav, Projection, SidePing, SideScanState, Sounding, Survey,
};
use bathyscope::ui::ViewContext;
use bathyscope::ui::views::MapView;
use eframe::egui_wgpu::{RenderState, RendererOptions};
use egui_kittest::wgpu::{create_render_state, default_wgpu_setup};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Frames timed of each. The fastest tenth is compared: other programs, and lavapipe's own threads where there is no GPU, can
/// only make a frame slower.
const FRAMES: usize = 400;

/// Prints the time of a frame while the map is dragged, for 1 000 and for 1 000 000 pings, and their ratio.
pub fn run() {
    let state = create_render_state(default_wgpu_setup(), RendererOptions::PREDICTABLE);
    let mut windows = [1_000, 1_000_000].map(Window::new);
    // Turn by turn, so that a busy machine slows both alike.
    for frame in 0..FRAMES {
        for window in &mut windows {
            window.frame(&state, frame);
        }
    }
    let [few, many] = windows.map(|window| us(window.typical()));
    println!("map, 1 000 pings:      {few:8.1} us a frame");
    println!("map, 1 000 000 pings:  {many:8.1} us a frame");
    println!("ratio:                 {:8.2} (at most 1.5)", many / few);
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
        depth_locked: true,
        port: None,
        starboard: None,
    });
    let soundings = (0..count).map(|ping| Sounding {
        time_s: ping as f64 * 0.1,
        depth_m: depth_m(ping),
        locked: true,
    });
    let mut app = App::new(Jobs::Inline);
    app.survey_serial = 1;
    app.survey = Some(Arc::new(Survey {
        side_scan: side_scan.collect(),
        side_scan_state: SideScanState::Usable,
        soundings: soundings.collect(),
        ..Survey::default()
    }));
    app.products = Some(products(nav));
    app
}

fn products(nav: Vec<PingNav>) -> Products {
    Products {
        settings: Settings::default(),
        navigation: Arc::new(Navigation {
            pings: nav.clone(),
            soundings: nav,
            projection: Projection::Enu,
            zero_heading: 0,
            moving: 0,
        }),
        flat_spots: Arc::new(Vec::new()),
        returns: Arc::new(FirstReturns::default()),
        calibration: Arc::new(Calibration {
            mode: ScaleMode::Header,
            reach: PpdReach::Factor,
            flat_spot: None,
            header: None,
            fit: None,
            offset_m: 0.0,
            warnings: Vec::new(),
        }),
        correction: Arc::default(),
        cloud: Arc::new(PointCloud::default()),
        kept: Arc::new(Vec::new()),
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
    fn new(count: usize) -> Self {
        Self {
            app: app(count),
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
        let output = self.context.run_ui(input, |ui| {
            let mut context = ViewContext {
                app: &self.app,
                render_state: Some(state),
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
