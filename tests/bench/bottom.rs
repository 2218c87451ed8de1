//! A frame of the bottom in 3D, until the GPU (or lavapipe) is done with it: for small and large
//! surveys, whole and from near.

use bathyscope::ui::render::{
    BOTTOM_TILE, BottomBuffers, BottomDraw, BottomPart, BottomRenderer, BottomVertex, OrbitCamera,
    RenderTarget, ScenePart, Uploader, towards_light,
};
use eframe::egui_wgpu::{RenderState, RendererOptions};
use egui_kittest::wgpu::{create_render_state, default_wgpu_setup};
use glam::Vec3;
use std::time::{Duration, Instant};

/// Frames timed of each; the fastest tenth is compared.
const FRAMES: usize = 60;
/// Corners along a side: 10 000, a million and four million in all.
const SIDES: [usize; 3] = [100, 1000, 2000];
const CELL_M: f32 = 0.25;
const SIZE_PX: [u32; 2] = [1280, 720];

/// Prints the time of a frame of each size of survey while the camera turns.
pub(super) fn run() {
    let state = create_render_state(default_wgpu_setup(), RendererOptions::PREDICTABLE);
    println!("adapter: {}", state.adapter.get_info().name);
    let scenes = SIDES.map(|side| (side, upload(&state, side)));
    let renderer = BottomRenderer::new(&state.device);
    let target = RenderTarget::new(&state.device, SIZE_PX);
    let mut times = SIDES.map(|_| [Vec::new(), Vec::new()]);
    // Turn by turn, so that a busy machine slows all alike.
    for frame in 0..FRAMES {
        for ((side, buffers), times) in scenes.iter().zip(&mut times) {
            for (share, times) in [1.0, 0.1].into_iter().zip(times) {
                let camera = camera(*side, frame, share);
                times.push(draw(&state, &renderer, &target, buffers, camera));
            }
        }
    }
    let ms = |times: &[Duration]| {
        let mut sorted = times.to_vec();
        sorted.sort();
        1e3 * sorted[sorted.len() / 10].as_secs_f64()
    };
    let first = ms(&times[0][0]);
    for ((side, _), [whole, near]) in scenes.iter().zip(&times) {
        let (whole, near) = (ms(whole), ms(near));
        println!(
            "{:8} corners: whole {whole:6.1} ms a frame, ratio to the smallest {:5.2}; a tenth of it {near:6.1} ms, ratio {:5.2}",
            side * side,
            whole / first,
            near / first
        );
    }
}

/// Rolling ground.
fn up_m(east_m: f32, north_m: f32) -> f32 {
    -4.0 + (0.11 * east_m).sin() * (0.07 * north_m).cos()
        + 0.2 * (1.3 * east_m + 0.9 * north_m).sin()
}

fn upload(state: &RenderState, side: usize) -> BottomBuffers {
    let across = (side - 1).div_ceil(BOTTOM_TILE);
    let tiles = (0..across * across).map(|tile| {
        let [row, column] = [tile / across, tile % across].map(|place| place * BOTTOM_TILE);
        let corners = 0..(BOTTOM_TILE + 1).pow(2);
        let vertices = corners.map(|corner| {
            let row = row + corner / (BOTTOM_TILE + 1);
            let column = column + corner % (BOTTOM_TILE + 1);
            let [east_m, north_m] = [column as f32 * CELL_M, -(row as f32 * CELL_M)];
            let place = Vec3::new(east_m, north_m, up_m(east_m, north_m));
            BottomVertex::new(
                place,
                [0.0, 0.0, 1.0],
                [90, 140, 170],
                if row < side && column < side { BottomPart::Lit } else { BottomPart::None },
            )
        });
        vertices.collect()
    });
    let uploader = Uploader::new(&state.device, &state.queue);
    BottomBuffers::new(&uploader, CELL_M, tiles)
}

/// Returns a camera over a share of the survey about its middle.
fn camera(side: usize, frame: usize, share: f32) -> OrbitCamera {
    let size_m = side as f32 * CELL_M;
    let middle = Vec3::new(0.5 * size_m, -0.5 * size_m, -4.0);
    let half = 0.5 * share * size_m;
    let mut camera = OrbitCamera {
        azimuth_rad: 0.1 * frame as f32,
        exaggeration: 5.0,
        ..OrbitCamera::default()
    };
    let offset = Vec3::new(half, half, 1.0);
    let aspect = SIZE_PX[0] as f32 / SIZE_PX[1] as f32;
    camera.fit([middle - offset, middle + offset], aspect, 1.0);
    camera
}

fn draw(
    state: &RenderState,
    renderer: &BottomRenderer,
    target: &RenderTarget,
    buffers: &BottomBuffers,
    camera: OrbitCamera,
) -> Duration {
    let aspect = SIZE_PX[0] as f32 / SIZE_PX[1] as f32;
    let draw = BottomDraw {
        projection: camera.projection(aspect),
        light: towards_light(315.0, 45.0),
        exaggeration: camera.exaggeration,
        isobaths_m: Some([1.0, 0.0]),
        line_px: 1.2,
        darkest: 0.25,
        part: ScenePart::WHOLE,
    };
    let began = Instant::now();
    let mut encoder = state.device.create_command_encoder(&Default::default());
    {
        let mut pass = target.begin(&mut encoder);
        renderer.draw(&state.queue, target, &mut pass, buffers, &draw);
    }
    state.queue.submit([encoder.finish()]);
    let waited = state.device.poll(wgpu::PollType::wait_indefinitely());
    waited.expect("the GPU is done");
    began.elapsed()
}
