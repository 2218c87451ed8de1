//! The bottom in 3D: what the GPU draws of it, what the window shows and the file holds.

use crate::cli::run;
use crate::map_tools::click;
use crate::review::mouse::drag;
use crate::window::{Window, app, demo_window, drawn_window, press, settle};
use bathyscope::app::{Action, ClipBox, Command, Measure};
use bathyscope::ui::render::{
    BOTTOM_TILE, BottomBuffers, BottomDraw, BottomPart, BottomRenderer, BottomVertex, Cut,
    OrbitCamera, RenderTarget, ScenePart, Uploader, towards_light,
};
use bathyscope_bottom::bathymetry::CellSource;
use bathyscope_log::support::progress::Progress;
use bathyscope_products::pipeline::{BottomColour, Derived, ProcessedLog, place_of};
use eframe::egui_wgpu::RendererOptions;
use egui::accesskit::Role;
use egui::{Key, Modifiers, Pos2, pos2, vec2};
use egui_kittest::kittest::Queryable as _;
use egui_kittest::wgpu::{create_render_state, default_wgpu_setup};
use glam::{Vec2, Vec3};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;

const SIDE_PX: u32 = 256;
const RED: [u8; 3] = [200, 40, 30];
const BLUE: [u8; 3] = [30, 60, 200];

/// Two tiles beside each other, 1 m squares: the western one red and 2 m deep, the eastern one blue
/// and 6 m deep, with a square hole of unknown depth in its middle.
fn tiles() -> Vec<Vec<BottomVertex>> {
    let side = BOTTOM_TILE + 1;
    let tile = |(rgb, up): ([u8; 3], f32)| {
        let first = if rgb == RED { 0 } else { BOTTOM_TILE };
        let corner = |cell: usize| {
            let (row, column) = (cell / side, cell % side);
            let is_hole = rgb == BLUE && (24..40).contains(&row) && (24..40).contains(&column);
            let place = Vec3::new((first + column) as f32, -(row as f32), up);
            let part = if is_hole { BottomPart::None } else { BottomPart::Lit };
            BottomVertex::new(place, [0.0, 0.0, 1.0], rgb, part)
        };
        (0..side * side).map(corner).collect()
    };
    vec![tile((RED, -2.0)), tile((BLUE, -6.0))]
}

/// Some tiles from a camera in light from above, as rows of RGBA.
fn drawn(
    tiles: Vec<Vec<BottomVertex>>,
    camera: OrbitCamera,
    isobaths_m: Option<[f32; 2]>,
    part: ScenePart,
) -> image::RgbaImage {
    drawn_in(tiles, camera, isobaths_m, part, towards_light(0.0, 90.0))
}

/// The same in another light.
fn drawn_in(
    tiles: Vec<Vec<BottomVertex>>,
    camera: OrbitCamera,
    isobaths_m: Option<[f32; 2]>,
    part: ScenePart,
    light: Vec3,
) -> image::RgbaImage {
    let state = create_render_state(default_wgpu_setup(), RendererOptions::PREDICTABLE);
    let (device, queue) = (&state.device, &state.queue);
    let uploader = Uploader::new(device, queue);
    let buffers = BottomBuffers::new(&uploader, 1.0, tiles.into_iter());
    let target = RenderTarget::new(device, [SIDE_PX; 2]);
    let draw = BottomDraw {
        projection: camera.projection(1.0),
        light,
        exaggeration: camera.exaggeration,
        isobaths_m,
        line_px: 1.5,
        darkest: 0.25,
        part,
    };
    let mut encoder = device.create_command_encoder(&Default::default());
    {
        let mut pass = target.begin(&mut encoder);
        BottomRenderer::new(device).draw(queue, &target, &mut pass, &buffers, &draw);
    }
    queue.submit([encoder.finish()]);
    read_back(device, queue, &target)
}

fn read_back(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    target: &RenderTarget,
) -> image::RgbaImage {
    let bytes = u64::from(4 * SIDE_PX * SIDE_PX);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: bytes,
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    encoder.copy_texture_to_buffer(
        target.colour().texture().as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(4 * SIDE_PX),
                rows_per_image: None,
            },
        },
        wgpu::Extent3d { width: SIDE_PX, height: SIDE_PX, depth_or_array_layers: 1 },
    );
    queue.submit([encoder.finish()]);
    buffer.map_async(wgpu::MapMode::Read, .., |mapped| mapped.expect("mapped"));
    device.poll(wgpu::PollType::wait_indefinitely()).expect("the GPU is done");
    let bytes = buffer.get_mapped_range(..).expect("mapped").to_vec();
    image::RgbaImage::from_raw(SIDE_PX, SIDE_PX, bytes).expect("all pixels")
}

/// Returns a camera that looks down at the edge between the tiles.
fn overhead(distance_m: f32) -> OrbitCamera {
    OrbitCamera {
        target: Vec3::new(64.0, -32.0, -4.0),
        distance_m,
        azimuth_rad: 0.0,
        elevation_rad: std::f32::consts::FRAC_PI_2,
        exaggeration: 1.0,
    }
}

/// The pixel that a place is drawn at.
fn pixel(camera: OrbitCamera, place: Vec3) -> [u32; 2] {
    let ndc = camera.projection(1.0).project(place).expect("in front");
    let half = SIDE_PX as f32 / 2.0;
    [ndc.x, -ndc.y].map(|part| (half + half * part) as u32)
}

#[test]
fn tiles_lie_where_their_places_are_in_their_colours_and_holes_stay_open() {
    // From near, with the finest squares, and from so far that a pixel is some squares.
    for distance_m in [180.0, 900.0] {
        let camera = overhead(distance_m);
        let picture = drawn(tiles(), camera, None, ScenePart::WHOLE);
        let at = |east_m: f32, south_m: f32, up_m: f32| {
            let [x, y] = pixel(camera, Vec3::new(east_m, -south_m, up_m));
            picture.get_pixel(x, y).0
        };
        let opaque = |[r, g, b]: [u8; 3]| [r, g, b, 255];
        assert_eq!(at(20.0, 50.0, -2.0), opaque(RED), "{distance_m}");
        assert_eq!(at(110.0, 50.0, -6.0), opaque(BLUE), "{distance_m}");
        assert_eq!(at(96.0, 32.0, -6.0), [0; 4], "the hole, {distance_m}");
        assert_eq!(at(64.0, 80.0, -2.0), [0; 4], "beside, {distance_m}");
    }
}

#[test]
fn what_is_nearer_hides_what_is_behind() {
    // From the west and above: over the edge of the red tile, 4 m higher, the blue one is seen from
    // 42 m behind it on.
    let camera = OrbitCamera {
        target: Vec3::new(0.0, -32.0, -2.0),
        distance_m: 30.0,
        azimuth_rad: std::f32::consts::FRAC_PI_2,
        elevation_rad: 0.3,
        exaggeration: 1.0,
    };
    let picture = drawn(tiles(), camera, None, ScenePart::WHOLE);
    let at = |east_m: f32| {
        let [x, y] = pixel(camera, Vec3::new(east_m, -32.0, -6.0));
        picture.get_pixel(x, y).0[..3].to_vec()
    };
    assert_eq!(at(75.0), RED, "behind the red one");
    assert_eq!(at(120.0), BLUE, "over its edge");
}

#[test]
fn isobaths_are_drawn_at_their_depths_and_nowhere_else() {
    // A slope of 1 in 10: 0 m deep in the west, 6.4 m in the east.
    let corner = |cell: usize| {
        let (row, column) = (cell / (BOTTOM_TILE + 1), cell % (BOTTOM_TILE + 1));
        let place = Vec3::new(column as f32, -(row as f32), -0.1 * column as f32);
        BottomVertex::new(place, [0.0, 0.0, 1.0], RED, BottomPart::Lit)
    };
    let slope: Vec<BottomVertex> = (0..(BOTTOM_TILE + 1).pow(2)).map(corner).collect();
    let camera = OrbitCamera { target: Vec3::new(32.0, -32.0, -3.0), ..overhead(100.0) };
    let picture = drawn(vec![slope], camera, Some([2.0, 1.0]), ScenePart::WHOLE);
    let red_at = |east_m: f32| {
        let [x, y] = pixel(camera, Vec3::new(east_m, -32.0, -0.1 * east_m));
        // A line may lie between two pixels.
        let beside = [x - 1, x, x + 1].map(|x| picture.get_pixel(x, y).0[0]);
        beside.into_iter().min().expect("three pixels")
    };
    for depth_m in [1.0f32, 3.0, 5.0] {
        assert!(red_at(10.0 * depth_m) < 130, "{depth_m} m");
    }
    for depth_m in [0.5f32, 2.0, 4.0, 6.0] {
        assert_eq!(red_at(10.0 * depth_m), RED[0], "{depth_m} m");
    }
}

#[test]
fn what_is_plain_has_its_own_colour_and_no_isobaths_whatever_the_light() {
    // All of it falls 1 in 1 towards the east, away from a light in the west that stands on the
    // horizon; its northern half is plain.
    let falling = tiles().into_iter().map(|tile| {
        let corner = |vertex: BottomVertex| {
            let [east_m, north_m, _] = vertex.place;
            let is_plain = north_m > -0.5 * BOTTOM_TILE as f32;
            let part = if is_plain { BottomPart::Plain } else { BottomPart::Lit };
            let place = Vec3::new(east_m, north_m, -east_m);
            BottomVertex::new(place, [0.5_f32.sqrt(), 0.0, 0.5_f32.sqrt()], RED, part)
        };
        tile.into_iter().map(corner).collect()
    });
    let camera = overhead(180.0);
    let isobaths_m = Some([16.0, 0.0]);
    let picture = drawn_in(
        falling.collect(),
        camera,
        isobaths_m,
        ScenePart::WHOLE,
        towards_light(270.0, 5.0),
    );
    let at = |east_m: f32, south_m: f32| {
        let [x, y] = pixel(camera, Vec3::new(east_m, -south_m, -east_m));
        picture.get_pixel(x, y).0
    };
    let [r, g, b] = RED;
    for east_m in [8.0, 16.0, 24.0, 32.0] {
        assert_eq!(at(east_m, 16.0), [r, g, b, 255], "plain, {east_m} m");
        let [lit, ..] = at(east_m, 48.0);
        assert!(lit < r / 2, "{lit} in the shade, {east_m} m");
    }
    assert!(at(16.0, 48.0)[0] < at(24.0, 48.0)[0], "on an isobath");
}

#[test]
fn from_far_away_the_bottom_has_the_mean_colours_of_its_ground() {
    // Single corners are black or white; the mean is grey.
    let chequered = || {
        let tile = |tile: Vec<BottomVertex>| {
            let corner = |(number, vertex): (usize, BottomVertex)| {
                let [r, g, b] = if number % 3 == 0 { [255; 3] } else { [0; 3] };
                let colour = [r, g, b, vertex.colour[3]];
                BottomVertex { colour, ..vertex }.with_far_colour([85; 3])
            };
            tile.into_iter().enumerate().map(corner).collect()
        };
        tiles().into_iter().map(tile).collect()
    };
    let ends = |distance_m: f32| {
        let camera = overhead(distance_m);
        let picture = drawn(chequered(), camera, None, ScenePart::WHOLE);
        let levels = (0..40).map(|step| {
            let [x, y] = pixel(camera, Vec3::new(12.0 + step as f32, -30.0, -2.0));
            picture.get_pixel(x, y).0[0]
        });
        levels.fold([255, 0], |[least, most], level| [least.min(level), most.max(level)])
    };
    let [least, most] = ends(60.0);
    assert!(most - least > 150, "{least} to {most} from near");
    assert_eq!(ends(3000.0), [85, 85]);
}

#[test]
fn only_what_lies_in_the_clip_box_is_drawn() {
    let camera = overhead(180.0);
    // East of 10 m and down to 4 m: a part of the red tile, and nothing of the deeper blue one.
    let part = ScenePart { corners: [Vec3::new(10.0, f32::MIN, -4.0), Vec3::MAX], cut: None };
    let picture = drawn(tiles(), camera, None, part);
    let alpha_at = |east_m: f32, up_m: f32| {
        let [x, y] = pixel(camera, Vec3::new(east_m, -50.0, up_m));
        picture.get_pixel(x, y).0[3]
    };
    assert_eq!([8.0, 12.0, 60.0].map(|east_m| alpha_at(east_m, -2.0)), [0, 255, 255]);
    assert_eq!(alpha_at(110.0, -6.0), 0);
}

#[test]
fn nothing_is_drawn_in_front_of_a_cross_section() {
    let camera = overhead(180.0);
    // An upright plane through (40, -60) towards north-east: what lies south-east of it is left
    // out.
    let outward = Vec2::new(1.0, -1.0).normalize();
    let part = ScenePart {
        cut: Some(Cut { outward, at_m: outward.dot(Vec2::new(40.0, -60.0)) }),
        ..ScenePart::WHOLE
    };
    let picture = drawn(tiles(), camera, None, part);
    let alpha_at = |east_m: f32, north_m: f32| {
        let [x, y] = pixel(camera, Vec3::new(east_m, north_m, -2.0));
        picture.get_pixel(x, y).0[3]
    };
    assert_eq!([alpha_at(37.0, -60.0), alpha_at(43.0, -60.0)], [255, 0]);
    assert_eq!([alpha_at(60.0, -37.0), alpha_at(60.0, -43.0)], [255, 0]);
}

#[test]
fn faces_of_the_clip_box_are_dragged_and_what_lies_outside_goes() {
    let mut window = drawn_window([1000.0, 700.0]);
    window.state_mut().app.apply(Command::OpenDemo);
    press(&mut window, Modifiers::NONE, Key::Num3);
    press(&mut window, Modifiers::SHIFT, Key::F11);
    settle(&mut window);
    let clip = |window: &Window| app(window).view.options.cloud.clip;
    let points_seen = |window: &mut Window| {
        let seen = window.render().expect("a picture");
        let [r, g, b, _] = egui::Color32::from_rgb(235, 64, 52).to_array();
        let is_port = |pixel: &&image::Rgba<u8>| {
            (pixel[0].abs_diff(r) < 30) && pixel[1].abs_diff(g) < 30 && pixel[2].abs_diff(b) < 30
        };
        seen.pixels().filter(is_port).count()
    };
    let all = points_seen(&mut window);
    press(&mut window, Modifiers::SHIFT, Key::X);
    settle(&mut window);
    assert_eq!(clip(&window), Some(ClipBox::WHOLE));
    let name = "west end of the clip box";
    let from = window.get_by_role_and_label(Role::Slider, name).rect().center();
    let to = window.get_by_role_and_label(Role::Slider, "east end of the clip box").rect().center();
    let middle = from.lerp(to, 0.5);
    drag(&mut window, from, middle);
    settle(&mut window);
    let ends_m = clip(&window).expect("a clip box").ends_m;
    let [west_m, _] = ends_m[0];
    assert!(west_m.is_finite() && ends_m[0][1].is_infinite(), "{ends_m:?}");
    assert_eq!(ends_m[1..], ClipBox::WHOLE.ends_m[1..]);
    let half = points_seen(&mut window);
    assert!(half < all * 3 / 4 && half > all / 8, "{half} of {all}");
    window.snapshot("cloud_clip_box");
    // Back to where everything begins.
    let here = window.get_by_role_and_label(Role::Slider, name).rect().center();
    drag(&mut window, here, from + (from - to));
    assert_eq!(clip(&window), Some(ClipBox::WHOLE));
    press(&mut window, Modifiers::SHIFT, Key::X);
    assert_eq!(clip(&window), None);
    // Another survey is another box.
    press(&mut window, Modifiers::SHIFT, Key::X);
    window.state_mut().app.apply(Command::OpenDemo);
    settle(&mut window);
    assert_eq!(clip(&window), None);
}

#[test]
fn the_bottom_is_shown_coloured_lit_and_hidden_by_keys() {
    let mut window = demo_window();
    let shown = |window: &Window| app(window).bottom().map(|bottom| bottom.colour);
    assert_eq!(shown(&window), Some(BottomColour::Depth));
    press(&mut window, Modifiers::NONE, Key::Num3);
    press(&mut window, Modifiers::SHIFT, Key::M);
    assert_eq!(shown(&window), Some(BottomColour::Mosaic));
    press(&mut window, Modifiers::SHIFT, Key::L);
    assert_eq!(app(&window).view.options.cloud.light_deg, [0.0, 45.0]);
    press(&mut window, Modifiers::SHIFT, Key::V);
    assert_eq!(shown(&window), None);
    press(&mut window, Modifiers::SHIFT, Key::P);
    assert!(!app(&window).view.options.cloud.points);
    // The colours' key brings the bottom back as it was.
    press(&mut window, Modifiers::SHIFT, Key::M);
    assert_eq!(shown(&window), Some(BottomColour::Mosaic));
    let isobaths_m = app(&window).bottom_isobaths_m().expect("evenly apart");
    assert_eq!(isobaths_m[0], 0.2, "of a pond 1 m from shallow to deep");
}

#[test]
fn the_mosaic_goes_on_beside_the_depths_on_a_level_bed() {
    let window = demo_window();
    let shown = app(&window).logs.with_results();
    let logs: Vec<ProcessedLog> = shown.into_iter().map(|shown_log| shown_log.log).collect();
    let of = |colour: BottomColour, most_corners: usize| {
        let made = Derived::default().bottom(&logs, colour, most_corners, &Progress::new());
        made.expect("not cancelled").expect("depths")
    };
    let [by_depth, by_echo, coarse] = [
        of(BottomColour::Depth, 4_000_000),
        of(BottomColour::Mosaic, 4_000_000),
        of(BottomColour::Mosaic, 10_000),
    ];
    assert!(
        !by_depth.has_flat_extrapolation
            && by_echo.has_flat_extrapolation
            && coarse.has_flat_extrapolation
    );
    assert!(coarse.surface().grid.len() <= 10_000);
    let [least_m, most_m] = by_depth.range_m;
    let (depths, echoes) = (by_depth.surface(), by_echo.surface());
    let mut beyond = 0;
    for (cell, depth_m) in echoes.depth_m.iter().enumerate() {
        let grid = &echoes.grid;
        let [east_m, north_m] = grid.centre(cell / grid.columns, cell % grid.columns);
        let known = depths.at(east_m, north_m).map(|(depth_m, _)| depth_m);
        match (echoes.source[cell], known) {
            (CellSource::None, None) if depth_m.is_nan() => {}
            (CellSource::None, None) => {
                beyond += 1;
                let level_m = f64::from(*depth_m);
                assert!(level_m > least_m - 1e-3 && level_m < most_m + 1e-3);
            }
            (_, known) => {
                let known_m = known.expect("a cell of the depth map");
                // Between the middles of its cells; at its edge the bed beyond counts, too.
                assert!((known_m - depth_m).abs() < 0.3, "{known_m} {depth_m}");
            }
        }
    }
    assert!(echoes.grid.cell_m < 0.5 * depths.grid.cell_m, "as fine as the mosaic");
    // Ranges of 12 m about a pond of 45 m by 20 m: the picture covers some half as much ground
    // again.
    let known = depths.depth_m.iter().filter(|depth_m| !depth_m.is_nan());
    let known_m2 = known.count() as f64 * depths.grid.cell_m.powi(2);
    let beyond_m2 = f64::from(beyond) * echoes.grid.cell_m.powi(2);
    let share = beyond_m2 / known_m2;
    assert!((0.2..3.0).contains(&share), "{beyond_m2} beside {known_m2}");
}

#[test]
fn a_click_on_the_mosaic_in_3d_shows_the_place_in_the_waterfall() {
    let mut window = drawn_window([1000.0, 700.0]);
    window.state_mut().app.apply(Command::OpenDemo);
    press(&mut window, Modifiers::NONE, Key::Num3);
    press(&mut window, Modifiers::SHIFT, Key::F11);
    settle(&mut window);
    press(&mut window, Modifiers::SHIFT, Key::M);
    press(&mut window, Modifiers::SHIFT, Key::P);
    settle(&mut window);
    window.snapshot("cloud_mosaic");
    // Seen from above; the eye looks down on the middle.
    press(&mut window, Modifiers::NONE, Key::Num7);
    settle(&mut window);
    let log = app(&window).logs.with_results().remove(0).log;
    let layout = Derived::default().layout(&log, &Progress::new());
    let layout = layout.expect("nobody cancels");
    let place = |window: &mut Window, at: Pos2| {
        click(window, at);
        settle(window);
        let mark = app(window).view.selection.expect("a place");
        let (side, sample) = mark.side.zip(mark.sample).expect("beside the track");
        place_of(&layout, mark.ping, side, f64::from(sample)).expect("on the ground")
    };
    // South of the southernmost line, where no depth is known.
    let from = pos2(560.0, 510.0);
    let step = vec2(40.0, 0.0);
    let [a, b, c] = [0.0, 1.0, 2.0].map(|steps| place(&mut window, from + steps * step));
    let step_m = 0.5 * (c[0] - a[0]);
    assert!(step_m > 1.0, "{a:?} {c:?}");
    for (found, steps) in [(a, 0.0), (b, 1.0), (c, 2.0)] {
        let off_m = (found[0] - a[0] - steps * step_m).hypot(found[1] - a[1]);
        assert!(off_m < 0.6, "{a:?} {b:?} {c:?}");
    }
    // The wheel comes nearer to that place, although no point is there.
    let wheel = |window: &mut Window, notches: f32| {
        window.event(egui::Event::PointerMoved(from));
        window.event(egui::Event::MouseWheel {
            unit: egui::MouseWheelUnit::Point,
            delta: vec2(0.0, 120.0 * notches),
            phase: egui::TouchPhase::Move,
            modifiers: Modifiers::NONE,
            source: egui::MouseWheelSource::Unknown,
        });
        settle(window);
    };
    wheel(&mut window, 2.0);
    let again = place(&mut window, from);
    assert!((again[0] - a[0]).hypot(again[1] - a[1]) < 0.6, "{a:?} {again:?}");
    let nearer = place(&mut window, from + step);
    assert!((nearer[0] - a[0]).abs() < 0.6 * step_m, "{a:?} {nearer:?}");
}

#[test]
fn a_picture_is_drawn_of_the_bottom_in_each_of_its_colours() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    let pictures = ["depth", "mosaic", "uncertainty", "distance", "source", "none", "no points"]
        .map(|colours| {
            let name = format!("{colours}.png");
            let snapshot = ["snapshot", "-o", &name, "--view", "cloud", "--size", "400x300"];
            let options = match colours {
                "no points" => vec!["--bottom", "mosaic", "--no-points"],
                _ => vec!["--bottom", colours],
            };
            run(folder, &[&snapshot[..], &options].concat());
            image::open(folder.join(&name)).expect("a picture").to_rgb8()
        });
    for (index, picture) in pictures.iter().enumerate() {
        for other in &pictures[index + 1..] {
            let pairs = picture.pixels().zip(other.pixels());
            let differing = pairs.filter(|(a, b)| a != b).count();
            assert!(differing > 5000, "picture {index}: {differing}");
        }
    }
}

/// JSON and bytes of a binary glTF, its lengths checked.
fn parts(glb: &[u8]) -> (Value, &[u8]) {
    let number = |at: usize| u32::from_le_bytes(glb[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!((&glb[..4], number(4), number(8)), (&b"glTF"[..], 2, glb.len()));
    let json = number(12);
    assert_eq!(&glb[16..20], b"JSON");
    let bytes = number(20 + json);
    assert_eq!(&glb[24 + json..28 + json], b"BIN\0");
    assert_eq!(28 + json + bytes, glb.len());
    let document = serde_json::from_slice(&glb[20..20 + json]).expect("JSON");
    (document, &glb[28 + json..])
}

#[test]
fn the_file_for_3d_programs_holds_every_cell_of_the_depth_map_at_its_place() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    run(folder, &["simulate", "-o", "pond", "--seed", "5"]);
    let process = ["process", "pond.sl2", "-o", "out", "--no-objects"];
    run(folder, &[&process[..], &["--products", "bottom,xyz"]].concat());
    let glb = fs::read(folder.join("out/depth/bottom.glb")).expect("the bottom");
    let (document, bytes) = parts(&glb);
    let origin = &document["asset"]["extras"]["origin"];
    let [easting, northing] = ["easting", "northing"].map(|name| origin[name].as_f64().unwrap());
    let accessor = &document["accessors"][0];
    let view = &document["bufferViews"][0];
    let count = accessor["count"].as_u64().unwrap() as usize;
    let start = view["byteOffset"].as_u64().unwrap() as usize;
    let millimetres = |metres: f64| (1000.0 * metres).round() as i64;
    let corners = bytes[start..][..12 * count].chunks_exact(12).map(|corner| {
        let part =
            |at: usize| f64::from(f32::from_le_bytes(corner[at..at + 4].try_into().unwrap()));
        let [x, y, z] = [part(0), part(4), part(8)];
        ([easting + x, northing - z].map(millimetres), -y)
    });
    let corners: BTreeMap<[i64; 2], f64> = corners.collect();
    let text = fs::read_to_string(folder.join("out/depth/depth.xyz")).expect("the cells");
    let cells: Vec<Vec<f64>> = (text.lines())
        .filter_map(|line| line.split([' ', ',']).map(|part| part.parse().ok()).collect())
        .collect();
    assert!(count > 500 && cells.len() == count, "{} {count}", cells.len());
    for cell in cells {
        let [east, north, depth_m] = cell[..] else {
            panic!("{cell:?}");
        };
        let place = [east, north].map(millimetres);
        // The file rounds to the millimetre what is a float there.
        let near = (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| [place[0] + dx, place[1] + dy]));
        let found = near.into_iter().find_map(|place| corners.get(&place));
        let found = *found.unwrap_or_else(|| panic!("no corner at {place:?}"));
        assert!((found - depth_m).abs() < 0.002, "{found} {depth_m}");
    }
    let names: Vec<&str> = (document["materials"].as_array().unwrap().iter())
        .filter_map(|material| material["name"].as_str())
        .collect();
    assert_eq!(names, ["depth", "mosaic"]);
}

#[test]
fn the_3d_view_is_cut_along_the_profile_and_shows_the_water_surface() {
    let mut window = drawn_window([1000.0, 700.0]);
    window.state_mut().app.apply(Command::OpenDemo);
    press(&mut window, Modifiers::NONE, Key::Num3);
    press(&mut window, Modifiers::SHIFT, Key::F11);
    settle(&mut window);
    press(&mut window, Modifiers::SHIFT, Key::Q);
    assert!(!app(&window).view.options.cloud.cut, "there is no line yet");
    assert!(window.query_by_label_contains("draw a depth profile on the map first").is_some());
    window.get_by_label("Dismiss").click();
    window.run();
    let survey = app(&window).logs.shown.survey.clone().expect("a survey");
    let products = app(&window).logs.shown.products.clone().expect("results");
    let pings = &products.navigation.pings;
    let middle = &pings[pings.len() / 2];
    let app_mut = &mut window.state_mut().app;
    app_mut.apply(Command::Do(Action::DepthProfile));
    // Across the pond through the middle of the track.
    for [east_m, north_m] in [[-30.0, -12.0], [30.0, 12.0]] {
        let (east_m, north_m) = (middle.east_m + east_m, middle.north_m + north_m);
        let corner = products.navigation.to_lon_lat(&survey.track, east_m, north_m);
        app_mut.apply(Command::Measure(Measure::Corner(corner)));
    }
    app_mut.apply(Command::Do(Action::EndFigure));
    press(&mut window, Modifiers::SHIFT, Key::Q);
    press(&mut window, Modifiers::SHIFT, Key::W);
    settle(&mut window);
    let cloud = &app(&window).view.options.cloud;
    assert!(cloud.cut && cloud.water);
    window.snapshot("cloud_cross_section");
    // Another survey has another section.
    window.state_mut().app.apply(Command::OpenDemo);
    settle(&mut window);
    assert!(!app(&window).view.options.cloud.cut);
}
