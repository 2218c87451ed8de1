//! A frame of the waterfall must cost the window's thread the same for a short log and for a very
//! long one.

use bathyscope::app::{App, Jobs, LogPlace, View};
use bathyscope::ui::views::WaterfallView;
use bathyscope::ui::{ViewContext, ViewRequest};
use bathyscope_bottom::first_return::{FirstReturns, Pick};
use bathyscope_log::survey::{
    Bytes, Encoding, SampleOrder, SidePing, SideScanState, SideSpan, Survey,
};
use egui_kittest::Harness;
use egui_kittest::wgpu::{create_render_state, default_wgpu_setup};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Samples a side of every ping.
const SAMPLES: u32 = 1400;
/// Frames that a figure is the median of.
const FRAMES: usize = 200;

struct Window {
    app: App,
    view: WaterfallView,
}

/// Prints the cost of a frame for 1 000 and 1 000 000 pings: the whole log in view, and a stretch
/// of 500 pings.
pub(super) fn run() {
    println!("waterfall, 1200 x 500 points, first return shown, pointer moving");
    let (short, long) = (measure(1_000), measure(1_000_000));
    for (index, name) in ["whole log", "500 pings"].into_iter().enumerate() {
        println!(
            "  {name}: {:.2} ms at 1 000 pings, {:.2} ms at 1 000 000, ratio {:.2}",
            short[index],
            long[index],
            long[index] / short[index]
        );
    }
    let picture = Instant::now();
    let mut window = window(1_000_000);
    window.state_mut().view.request(ViewRequest::Fit);
    settle(&mut window);
    println!(
        "  overview of 1 000 000 pings (2.8 GB of samples) complete after {:.1} s",
        picture.elapsed().as_secs_f64()
    );
}

fn measure(pings: usize) -> [f64; 2] {
    let mut window = window(pings);
    window.state_mut().view.request(ViewRequest::Fit);
    settle(&mut window);
    let whole = frame_ms(&mut window);
    window.state_mut().view.show_pings(pings / 2..pings / 2 + 500);
    settle(&mut window);
    [whole, frame_ms(&mut window)]
}

/// Median time of a frame with the pointer moving over the picture, milliseconds.
fn frame_ms(window: &mut Harness<'_, Window>) -> f64 {
    let mut times: Vec<f64> = (0..FRAMES)
        .map(|frame| {
            window.hover_at(egui::pos2(100.0 + 5.0 * frame as f32, 250.0));
            let start = Instant::now();
            window.step();
            // Turning shapes into triangles is the other half of what the window's thread does.
            let shapes = window.output().shapes.clone();
            std::hint::black_box(window.ctx.tessellate(shapes, 1.0));
            start.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[FRAMES / 2]
}

fn window(pings: usize) -> Harness<'static, Window> {
    let render_state =
        create_render_state(default_wgpu_setup(), eframe::egui_wgpu::RendererOptions::PREDICTABLE);
    let mut app = App::new(Jobs::Inline);
    app.show_survey(Arc::new(survey(pings)), None);
    app.logs.shown.preview = Some(Arc::new(returns(pings)));
    app.view.selection = Some(LogPlace::ping(pings / 2));
    let state = Window { app, view: WaterfallView::default() };
    Harness::builder().with_size([1200.0, 500.0]).build_ui_state(
        move |ui, window: &mut Window| {
            let mut commands = Vec::new();
            let mut context = ViewContext {
                app: &window.app,
                render_state: Some(&render_state),
                target: View::Waterfall,
                commands: &mut commands,
            };
            window.view.ui(ui, &mut context);
            commands.into_iter().for_each(|command| window.app.apply(command));
        },
        state,
    )
}

fn settle(window: &mut Harness<'_, Window>) {
    window.run_steps(2);
    while !window.state().view.is_settled() {
        std::thread::sleep(Duration::from_millis(2));
        window.run_steps(1);
    }
}

/// Pings over one small buffer, each a little further on in it.
fn survey(pings: usize) -> Survey {
    let bytes: Vec<u8> =
        (0..1_u32 << 16).map(|index| (index.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    let span = |ping: usize, order| SideSpan {
        file: 0,
        encoding: Encoding::U8,
        order,
        offset: (ping % 60_000) as u64,
        count: SAMPLES,
        near_m: 0.0,
        far_m: 30.0,
    };
    let side_scan = (0..pings).map(|ping| SidePing {
        time_s: ping as f64 * 0.05,
        depth_m: 5.0,
        depth_fault: None,
        port: Some(span(ping, SampleOrder::FarToNear)),
        starboard: Some(span(ping, SampleOrder::NearToFar)),
    });
    Survey {
        side_scan: std::sync::Arc::new(side_scan.collect()),
        side_scan_state: SideScanState::Usable,
        bytes: vec![Bytes::Held(bytes.into())],
        ..Survey::default()
    }
}

fn returns(pings: usize) -> FirstReturns {
    let picks = |phase: f32| -> Vec<Pick> {
        (0..pings)
            .map(|ping| Pick {
                sample: 230.0 + 20.0 * (ping as f32 * 0.01 + phase).sin(),
                confidence: 0.9,
                above_bottom: ping % 100 < 10,
            })
            .collect()
    };
    FirstReturns {
        port: Arc::new(picks(0.0)),
        starboard: Arc::new(picks(1.0)),
        ..FirstReturns::default()
    }
}
