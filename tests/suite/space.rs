//! Map and 3D cloud: gestures, names and pictures on a pond made here, and the depth map of the
//! real river.

use crate::support;
use bathyscope::app::{App, CloudColour, Command, Jobs, LogPlace, ThemeChoice, View, WorkStep};
use bathyscope::ui::views::{CloudView, MapView};
use bathyscope::ui::{ViewContext, ViewRequest};
use bathyscope_bottom::bathymetry::{SurfaceSettings, depth_points, surface};
use bathyscope_bottom::calibration::{Calibration, FlatSpot, PingRange, ScaleMode};
use bathyscope_bottom::cloud::{
    CloudPoint, Correction, Geometry, PointClass, PointCloud, PointSource, RecordIndex, ping_depths,
};
use bathyscope_log::formats;
use bathyscope_log::support::geo::LonLat;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::support::statistics::colour_ends;
use bathyscope_log::survey::{
    Fix, HeadingSettings, Navigation, PingNav, Projection, SidePing, SideScanState, Sounding,
    Survey, Track, navigate,
};
use bathyscope_products::pipeline::Products;
use eframe::egui_wgpu::{RenderState, RendererOptions};
use egui::{Pos2, Vec2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use egui_kittest::wgpu::{WgpuTestRenderer, create_render_state, default_wgpu_setup};
use std::sync::Arc;

const LINES: usize = 7;
const PINGS_A_LINE: usize = 101;
const SIZE: Vec2 = vec2(400.0, 300.0);

/// Depth of the pond's bed, metres: a slope with a trough.
fn bed_m(east_m: f64, north_m: f64) -> f64 {
    2.0 + 0.03 * east_m + 0.6 * (-((north_m - 20.0) / 8.0).powi(2)).exp()
}

/// Parallel lines of 40 m, 8 m apart, back and forth.
fn place(ping: usize) -> PingNav {
    let (line, along) = (ping / PINGS_A_LINE, ping % PINGS_A_LINE);
    let back = line % 2 == 1;
    let along_m = 0.4 * along as f64;
    PingNav {
        east_m: if back { 40.0 - along_m } else { along_m },
        north_m: 8.0 * line as f64,
        heading_rad: if back { 1.5 } else { 0.5 } * std::f64::consts::PI,
        speed_mps: 1.0,
    }
}

fn pond() -> (Survey, Products) {
    let count = LINES * PINGS_A_LINE;
    let nav: Vec<PingNav> = (0..count).map(place).collect();
    let depth_m = |nav: &PingNav| bed_m(nav.east_m, nav.north_m) as f32;
    let side_scan = nav.iter().enumerate().map(|(index, nav)| SidePing {
        time_s: 0.4 * index as f64,
        depth_m: depth_m(nav),
        depth_fault: None,
        port: None,
        starboard: None,
    });
    let soundings =
        nav.iter().enumerate().map(|(index, nav)| Sounding::new(0.4 * index as f64, depth_m(nav)));
    let survey = Survey {
        side_scan: std::sync::Arc::new(side_scan.collect()),
        side_scan_state: SideScanState::Usable,
        soundings: Arc::new(soundings.collect()),
        track: Track::new(vec![Fix {
            time_s: 0.0,
            position: LonLat { lon_deg: -82.11, lat_deg: 29.41 },
            cog_rad: f32::NAN,
            compass_rad: f32::NAN,
            speed_mps: f32::NAN,
        }]),
        ..Survey::default()
    };
    let (cloud, classes) = cloud(&nav);
    let products = products(&survey, nav, cloud, classes);
    (survey, products)
}

fn cloud(nav: &[PingNav]) -> (PointCloud, Vec<PointClass>) {
    let point = |source, ping: usize, across_m: f64, up_m: f64| {
        let boat = &nav[ping];
        let (sin, cos) = boat.heading_rad.sin_cos();
        let (east_m, north_m) = (boat.east_m + across_m * cos, boat.north_m - across_m * sin);
        CloudPoint {
            record: RecordIndex::new(ping).filter(|_| source == PointSource::DownScan),
            confidence: 1.0,
            sample: 100.0,
            ..CloudPoint::new(source, ping as u32, [east_m, north_m, up_m - bed_m(east_m, north_m)])
        }
    };
    let every = |source, across_m| (0..nav.len()).map(move |ping| (source, ping, across_m, 0.0));
    let outliers = (0..nav.len()).step_by(23);
    let points = every(PointSource::DownScan, 0.0)
        .chain(every(PointSource::Port, -0.8))
        .chain(every(PointSource::Starboard, 0.8))
        .chain(outliers.map(|ping| (PointSource::Port, ping, -2.5, 1.0 + 0.01 * ping as f64 % 0.7)))
        .map(|(source, ping, across_m, up_m)| (point(source, ping, across_m, up_m), up_m == 0.0));
    let mut flagged: Vec<(CloudPoint, bool)> = points.collect();
    flagged.sort_by_key(|(point, _)| (point.source, point.ping));
    let class = |is_bottom: bool| if is_bottom { PointClass::Bottom } else { PointClass::LowNoise };
    let classes = flagged.iter().map(|(_, is_bottom)| class(*is_bottom)).collect();
    let cloud = PointCloud {
        points: flagged.into_iter().map(|(point, _)| point).collect(),
        zero_heading: 0,
    };
    (cloud, classes)
}

fn products(
    survey: &Survey,
    nav: Vec<PingNav>,
    cloud: PointCloud,
    classes: Vec<PointClass>,
) -> Products {
    let correction = Correction::default();
    let depths = ping_depths(survey, &nav, (&cloud, Geometry::Slope), &classes, &correction);
    let spot = |start: usize, depth_m| FlatSpot {
        pings: start..start + 41,
        length_m: 10.2,
        depth_m,
        relief_m: 0.04,
        lost: 0,
        slope: 0.004,
        scatter_m: 0.012,
        picks: [38, 40],
        tilt: 0.0,
        ppd: None,
        factor: None,
    };
    let locked = survey.soundings.iter().filter(|sounding| sounding.is_good());
    let depth_range_m = colour_ends(locked.map(|sounding| sounding.depth_m));
    // The second one lies in the middle of the pond, so that the test finds it in the middle of the
    // map.
    let spots = vec![spot(520, 2.1), spot(3 * PINGS_A_LINE + 30, 2.9)];
    Products {
        settings: Arc::default(),
        exclusions: Arc::default(),
        relief: Arc::default(),
        navigation: Arc::new(Navigation {
            soundings: Arc::new(nav.clone()),
            ..Navigation::of_pings(nav)
        }),
        found: Arc::default(),
        judged: None,
        returns: Arc::default(),
        bottom_line: Arc::default(),
        calibration: Arc::new(Calibration {
            mode: ScaleMode::FlatSpot,
            flat_spot: Some(spots[0].clone()),
            ..Calibration::default()
        }),
        flat_spots: Arc::new(spots),
        correction: Arc::new(correction),
        cloud: Arc::new(cloud),
        classes: Arc::new(classes),
        depths: Arc::new(depths),
        depth_range_m,
        scales: Default::default(),
        latency: None,
        repeatability: None,
        clutter: None,
    }
}

/// One of the views alone in a window, with its state at hand.
struct Room {
    app: App,
    map: MapView,
    cloud: CloudView,
    shows_cloud: bool,
    pushed: Vec<Command>,
}

impl Room {
    fn new(filled: bool, shows_cloud: bool) -> Self {
        let mut app = App::new(Jobs::Inline);
        if filled {
            let (survey, products) = pond();
            app.show_survey(Arc::new(survey), Some(products));
        }
        Self {
            app,
            map: MapView::default(),
            cloud: CloudView::default(),
            shows_cloud,
            pushed: Vec::new(),
        }
    }

    fn map() -> Self {
        Self::new(true, false)
    }

    fn cloud() -> Self {
        Self::new(true, true)
    }

    fn ui(&mut self, ui: &mut egui::Ui, render_state: Option<&RenderState>) {
        self.app.poll();
        let mut commands = Vec::new();
        let mut context = ViewContext {
            app: &self.app,
            render_state,
            target: View::Cloud,
            commands: &mut commands,
        };
        if self.shows_cloud {
            self.cloud.ui(ui, &mut context)
        } else {
            self.map.ui(ui, &mut context)
        }
        for command in &commands {
            self.app.apply(command.clone());
        }
        self.pushed.extend(commands);
    }

    fn is_settled(&self) -> bool {
        self.map.is_settled() && self.cloud.is_settled()
    }
}

type Window = Harness<'static, Room>;

fn open(room: Room) -> Window {
    let state = create_render_state(default_wgpu_setup(), RendererOptions::PREDICTABLE);
    let for_view = state.clone();
    let dark = room.app.view.options.theme == ThemeChoice::Dark;
    let mut window = Harness::builder()
        .with_size(SIZE)
        .with_pixels_per_point(1.0)
        .with_theme(if dark { egui::Theme::Dark } else { egui::Theme::Light })
        .with_options(support::snapshot_options())
        .with_render_cursor(false)
        .renderer(WgpuTestRenderer::from_render_state(state))
        .build_ui_state(
            move |ui, room: &mut Room| {
                egui::Frame::NONE.show(ui, |ui| room.ui(ui, Some(&for_view)));
            },
            room,
        );
    window.run();
    assert!(window.state().is_settled());
    window
}

/// The middle of the view.
fn middle(window: &Window) -> Pos2 {
    let name = if window.state().shows_cloud { "3D point cloud" } else { "Map," };
    window.get_by_label_contains(name).rect().center()
}

/// The middle of the pond on the map that was fitted to it: the right edge is left to the legend.
fn pond_middle(window: &Window) -> Pos2 {
    middle(window) - vec2(0.5 * 76.0, 0.0)
}

fn click(window: &mut Window, at: Pos2) {
    window.hover_at(at);
    window.run();
    for pressed in [true, false] {
        window.event(egui::Event::PointerButton {
            pos: at,
            button: egui::PointerButton::Primary,
            pressed,
            modifiers: egui::Modifiers::NONE,
        });
    }
    window.run();
}

/// The ping nearest to a place, found the slow way.
fn nearest_ping(east_m: f64, north_m: f64) -> usize {
    let off = |ping: &usize| {
        let nav = place(*ping);
        (nav.east_m - east_m).hypot(nav.north_m - north_m)
    };
    (0..LINES * PINGS_A_LINE).min_by(|a, b| off(a).total_cmp(&off(b))).unwrap()
}

#[test]
fn every_shader_is_valid() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders");
    let mut seen = 0;
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let text = std::fs::read_to_string(entry.path()).unwrap();
        let module = wgpu::naga::front::wgsl::parse_str(&text)
            .unwrap_or_else(|error| panic!("{:?}: {}", entry.path(), error.emit_to_string(&text)));
        wgpu::naga::valid::Validator::new(
            wgpu::naga::valid::ValidationFlags::all(),
            wgpu::naga::valid::Capabilities::empty(),
        )
        .validate(&module)
        .unwrap_or_else(|error| panic!("{:?}: {error:?}", entry.path()));
        seen += 1;
    }
    assert!(seen >= 2, "{seen}");
}

#[test]
fn the_views_name_what_they_show_and_look_as_they_did() {
    let mut map = open(Room::map());
    map.get_by_label(
        "Map, track of 707 pings, depth 2.0 to 3.6 m below transducer, 2 flat stretches; layers: depth map, hill-shade, isobaths, track, boxes",
    );
    map.snapshot("map");

    let mut cloud = open(Room::cloud());
    cloud.get_by_label("3D point cloud, 2 121 points, 31 removed (2.1 %), bottom by depth");
    cloud.snapshot("cloud");

    let mut room = Room::cloud();
    room.app.view.options.theme = ThemeChoice::Light;
    room.app.view.options.cloud.colour = CloudColour::Depth;
    room.app.view.options.cloud.outlier_preview = true;
    room.app.view.selection = Some(LogPlace::ping(200));
    let mut light = open(room);
    light.snapshot("cloud_light_by_depth");

    let mut results = map.take_snapshot_results();
    results.extend_harness(&mut cloud);
    results.extend_harness(&mut light);
}

#[test]
fn the_pointer_on_the_map_finds_the_nearest_ping() {
    let mut window = open(Room::map());
    let at = pond_middle(&window);
    click(&mut window, at);
    // The map is fitted to the pond.
    let ping = nearest_ping(20.0, 24.0);
    assert_eq!(window.state().app.view.hover, Some(LogPlace::ping(ping)));
    assert_eq!(window.state().app.view.selection, Some(LogPlace::ping(ping)));
    let reveals = |command: &Command| matches!(command, Command::RevealIn(_, mark) if *mark == LogPlace::ping(ping));
    assert!(window.state().pushed.iter().any(reveals));
    window.remove_cursor();
    window.run();
    assert_eq!(window.state().app.view.hover, None);
}

fn proposals(window: &Window) -> Vec<PingRange> {
    let pushed = window.state().pushed.iter();
    let proposed = pushed.filter_map(|command| match command {
        Command::ProposeStretch(pings) => Some(*pings),
        _ => None,
    });
    proposed.collect()
}

#[test]
fn a_click_with_the_tool_proposes_the_stretch_around_it() {
    let mut window = open(Room::map());
    let at = pond_middle(&window) + vec2(10.0, 0.0);
    click(&mut window, at);
    assert_eq!(proposals(&window), [], "without the tool a click selects");
    window.state_mut().app.view.options.panels.step = WorkStep::Correct;
    window.run();
    window.get_by_label("Calibrate on a stretch").click();
    window.run();
    click(&mut window, at);
    let ping = window.state().app.view.hover.unwrap().ping;
    let [proposed] = proposals(&window)[..] else {
        panic!("one proposal: {:?}", window.state().pushed);
    };
    assert!((proposed.start..proposed.end).contains(&ping), "{proposed:?}");
}

#[test]
fn a_numbered_stretch_says_how_flat_it_is_and_is_proposed_by_a_click() {
    let mut room = Room::map();
    room.app.view.options.panels.step = WorkStep::Correct;
    let mut window = open(room);
    let badge = pond_middle(&window) - vec2(0.0, 15.5);
    click(&mut window, badge);
    let expected = PingRange { start: 333, end: 374 };
    assert_eq!(proposals(&window), [expected]);
    assert_eq!(window.state().app.logs.shown.proposed_stretch(), Some(expected));
}

#[test]
fn a_click_on_a_point_leads_to_its_ping_and_sample() {
    let mut room = Room::cloud();
    room.cloud.request(ViewRequest::Top);
    let mut window = open(room);
    let at = middle(&window);
    click(&mut window, at);
    let mark = window.state().app.view.selection.expect("a point near the middle");
    let products = window.state().app.logs.shown.products.clone().unwrap();
    let point = products.cloud.points[mark.point.unwrap()];
    assert_eq!(mark.ping, point.ping as usize);
    // From above the middle of the picture is the middle of the pond; a point lies there or a few
    // pixels beside.
    let off_m = (point.east_m - 20.0).hypot(point.north_m - 24.0);
    assert!(off_m < 2.0, "{off_m}");
}

#[test]
fn outliers_are_shown_only_on_request() {
    let amber = |room: Room| {
        let mut window = open(room);
        let picture = window.render().unwrap();
        let is_amber = |pixel: &&image::Rgba<u8>| pixel.0 == [255, 190, 40, 255];
        picture.pixels().filter(is_amber).count()
    };
    let without = amber(Room::cloud());
    let mut room = Room::cloud();
    room.app.view.options.cloud.outlier_preview = true;
    let with = amber(room);
    assert!(with > without + 31, "{without} {with}");
}

#[test]
fn without_a_gpu_the_views_say_so() {
    for (shows_cloud, name) in [(false, "Map, track"), (true, "3D point cloud, 2 121")] {
        let mut window = Harness::builder()
            .with_size(SIZE)
            .build_ui_state(|ui, room: &mut Room| room.ui(ui, None), Room::new(true, shows_cloud));
        window.run();
        window.get_by_label_contains(name);
    }
}

#[test]
fn wheel_and_drag_move_the_map_and_a_reveal_brings_a_ping_back() {
    let mut window = open(Room::map());
    let before = window.render().unwrap();
    let at = middle(&window);
    for request in [ViewRequest::ZoomIn; 4] {
        window.state_mut().map.request(request);
        window.run();
    }
    assert_ne!(window.render().unwrap(), before);
    // The first ping is out of sight now; a reveal from another view brings it to the middle.
    window.state_mut().app.apply(Command::Reveal(LogPlace::ping(0)));
    window.run();
    window.hover_at(at);
    window.run();
    assert_eq!(window.state().app.view.hover, Some(LogPlace::ping(0)));
    window.remove_cursor();
    window.state_mut().app.apply(Command::Select(None));
    window.state_mut().map.request(ViewRequest::Fit);
    window.run();
    assert_eq!(window.render().unwrap(), before);
}

#[test]
fn an_untouched_view_stays_fitted_to_its_frame() {
    for room in [Room::map, Room::cloud] {
        let mut window = open(room());
        let before = window.render().unwrap();
        for size in [vec2(700.0, 320.0), SIZE] {
            window.set_size(size);
            window.run();
        }
        assert_eq!(window.render().unwrap(), before);
        let zoom = |window: &mut Window| {
            if window.state().shows_cloud {
                window.state_mut().cloud.request(ViewRequest::ZoomIn);
            } else {
                window.state_mut().map.request(ViewRequest::ZoomIn);
            }
            window.run();
        };
        zoom(&mut window);
        let near = window.render().unwrap();
        for size in [vec2(700.0, 320.0), SIZE] {
            window.set_size(size);
            window.run();
        }
        assert_eq!(window.render().unwrap(), near, "a moved one stays as it is");
    }
}

#[test]
fn the_depth_map_of_the_real_river_stays_by_its_soundings() {
    let Some(data) = support::real_data() else {
        return;
    };
    let progress = Progress::new();
    let survey = formats::open(&data.join("humminbird-glen-canyon"), &progress).unwrap();
    let settings = HeadingSettings::default();
    let navigation = navigate(&survey, &settings, Projection::Enu, &progress).unwrap();
    let points = depth_points(&survey, &navigation);
    let settings = SurfaceSettings { max_side: 512, ..SurfaceSettings::default() };
    let map = surface(points.clone(), &settings, &progress).unwrap().unwrap();
    let depths = points.iter().map(|point| point.depth_m as f32);
    let [least, most] = depths.fold([f32::MAX, f32::MIN], |[l, m], d| [l.min(d), m.max(d)]);
    let known: Vec<f32> = map.depth_m.iter().copied().filter(|d| !d.is_nan()).collect();
    assert!(known.len() > 100, "{}", known.len());
    assert!(known.iter().all(|depth| (least..=most).contains(depth)));
    let farthest = map.distance_m.iter().copied().fold(0.0, f32::max);
    assert!(f64::from(farthest) <= settings.max_gap_m, "{farthest}");
    assert!(map.at(points[0].east_m + 500.0, points[0].north_m).is_none());
}
