//! Draws the map view: the survey from above, in layers.
//!
//! Input: the state. Output: a map with its layers, and commands.

mod controls;
mod dots;
mod grid_tiles;
mod isobaths;
mod lines;
mod measure;
mod objects;
mod overlay;
mod plan;
mod pointer;
mod stack;
mod stretches;
mod tiles;
mod track;
mod transform;

use super::legend;
use super::tool::Banner;
use crate::app::{App, Command, MapLayer, Reviewing, Tool, View, ViewOptions};
use crate::ui::{ViewContext, ViewRequest, flat, place, text, theme};
use bathyscope_bottom::calibration::PingRange;
use bathyscope_log::support::geo::LonLat;
use bathyscope_log::survey::Survey;
use bathyscope_products::pipeline::{Background, DepthMap, Products};
use dots::ResidualLayer;
use egui::{Color32, Pos2, Rect, Response, Role, Sense, Ui, WidgetInfo, vec2};
use isobaths::IsobathLayer;
use plan::PointerUse;
use stack::Layers;
use std::sync::Arc;
use track::{TrackKey, TrackLayer};
use transform::{GroundBounds, MapTransform};

/// State of the map view: the ground that it shows, and the layers computed for it.
#[derive(Default)]
pub struct MapView {
    transform: Option<MapTransform>,
    /// The transform that showed everything; while the user has not changed it, the view stays
    /// fitted.
    fitted: Option<MapTransform>,
    /// The layers that the view was fitted to: the fit follows them while they are being computed,
    /// but not layers that are shown later.
    fits: Vec<MapLayer>,
    request: Option<ViewRequest>,
    /// Bounds of the ground shown in the last frame.
    visible: Option<GroundBounds>,
    /// Bounds of the ground that the first frame is to show; `None` for everything.
    aim: Option<GroundBounds>,
    track: Background<TrackKey, Arc<TrackLayer>>,
    layers: Layers,
    pointer: pointer::MapPointer,
    measure: measure::MeasureTool,
    stretch: stretches::StretchTool,
    plan: plan::PlanTool,
    seen_plane: u64,
    seen_reveal: u64,
    /// Height that the plot of a depth profile takes of the view, points.
    plot_height: f32,
}

impl MapView {
    /// Draws the view into all of `ui` and pushes the commands of the user.
    pub fn ui(&mut self, ui: &mut Ui, context: &mut ViewContext<'_>) {
        let whole = ui.available_rect_before_wrap();
        let (rect, plot) = measure::split(whole, context.app);
        self.make_room(whole.height() - rect.height());
        let response = ui.allocate_rect(rect, Sense::click_and_drag());
        let painter = ui.painter_at(rect);
        let canvas = theme::canvas_colour(context.options());
        flat::fill(&painter, rect, canvas, context.render_state);
        self.forget_other_plane(context);
        let name = self.content(ui, context, rect, &response);
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &name));
        if let Some(plot) = plot {
            self.measure.plot(ui, context, plot);
        }
    }

    /// Keeps the ground where it is on the screen when the plot appears in the lower part of the
    /// view or disappears: if the map moved, another place would be under the pointer that has just
    /// clicked.
    fn make_room(&mut self, plot_height: f32) {
        let before = std::mem::replace(&mut self.plot_height, plot_height);
        let growth = plot_height - before;
        let toggles = (before > 0.0) != (plot_height > 0.0);
        if let Some(transform) = self.transform.as_mut().filter(|_| toggles) {
            // A view whose lower edge moves up has its middle higher by half of that distance.
            transform.centre_m[1] += 0.5 * f64::from(growth) * transform.metres_per_point;
            // A fitted view would move in spite of this.
            self.fitted = None;
        }
    }

    /// Sets a corner of the figure at the pointer or at the cross.
    pub(crate) fn set_corner(&mut self) {
        self.measure.set_corner();
    }

    /// Carries out a request from menu, key or palette.
    pub fn request(&mut self, request: ViewRequest) {
        self.request = Some(request);
    }

    /// Returns true if everything on screen is drawn at its final quality.
    pub fn is_settled(&self) -> bool {
        !self.track.is_running() && self.layers.is_settled() && self.request.is_none()
    }

    /// Returns a view of the same ground, for a picture of any size.
    pub(crate) fn for_picture(&self, app: &App) -> Self {
        Self {
            aim: self.visible,
            // The survey that is open must not count as a new one.
            seen_plane: app.view.plane_serial,
            ..Self::default()
        }
    }

    /// Returns the metres that a point covers in a picture of this size that shows the same ground;
    /// `None` before the first frame.
    pub(crate) fn metres_per_point_on(&self, [width, height]: [f32; 2]) -> Option<f64> {
        let rect = Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(width, height));
        let shown = MapTransform::showing(self.visible?, rect);
        Some(shown.metres_per_point)
    }

    /// Returns the number of visible tiles that are not painted yet, and of all visible tiles.
    pub fn missing(&self) -> [usize; 2] {
        self.layers.missing()
    }

    fn forget_other_plane(&mut self, context: &ViewContext<'_>) {
        if self.seen_plane != context.app.view.plane_serial {
            self.seen_plane = context.app.view.plane_serial;
            self.transform = None;
            self.track = Background::default();
            self.layers.forget();
            self.pointer = pointer::MapPointer::default();
            self.measure = measure::MeasureTool::default();
            self.stretch = stretches::StretchTool::default();
            self.plan = plan::PlanTool::default();
        }
    }

    /// Draws the contents of the view; returns the view's accessible name.
    fn content(
        &mut self,
        ui: &mut Ui,
        context: &mut ViewContext<'_>,
        rect: Rect,
        response: &Response,
    ) -> String {
        let Some(survey) = context.app.logs.shown.survey.clone() else {
            return "Map, empty".to_owned();
        };
        let Some(products) = context.app.logs.shown.products.clone() else {
            let text = "The track is being computed.";
            legend::wait(ui, context, rect, text);
            return "Map, waiting for the track".to_owned();
        };
        if context.options().map.layers.is_visible(MapLayer::Residuals) {
            context.push(Command::CompareWithReference);
        }
        self.ask_for_layers(context, &survey, &products);
        let Some(track) = self.track.result().cloned() else {
            if !self.track.is_running() {
                legend::say(ui, context, rect, "This log has no positions to map.");
            }
            return "Map, no positions".to_owned();
        };
        let draws = self.transform.is_some_and(|transform| {
            let view = (rect, transform);
            self.stretch.follow(ui, response, view, &track, context)
        });
        let pointer_use = self.transform.map_or_else(PointerUse::default, |transform| {
            let place = plan::MapPlace { rect, transform, survey: &survey, products: &products };
            self.plan.follow(ui, response, &place, context)
        });
        let transform = self.navigate(ui, context, response, &track, !draws && !pointer_use.drag);
        let scene = MapScene {
            rect,
            transform,
            survey: &survey,
            products: &products,
            track: &track,
            depth_map: (context.app.depth_map()).filter(|_| context.app.needs_depth_map()),
            isobaths: self.layers.isobaths(&context.options().map.layers),
            residuals: self.layers.residuals(&context.options().map.layers),
            has_faults: (context.app.logs.shown.figures.as_ref())
                .is_some_and(|figures| figures.faults.all() > 0),
            made_of: (context.app.logs.shown.whole.as_ref())
                .map(|whole| whole.survey.side_scan.len()),
            has_excluded: stretches::ping_count(context.app) > 0,
            has_swath: context.app.logs.has_swath(),
            shows_flat_stretches: context.options().shows_flat_stretches(View::Map)
                || context.app.logs.shown.reviewing.tool == Tool::Calibrate,
            proposed: context.app.logs.shown.proposed_stretch(),
            options: context.options(),
        };
        paint(ui, context, &scene, &mut self.layers);
        let painter = ui.painter_at(rect);
        self.stretch.draw(&painter, &scene, context.app);
        if !pointer_use.click {
            self.pointer.handle(ui, context, &scene, response);
        }
        self.plan.ui(ui, context, &scene);
        self.measure.ui(ui, context, &scene, response);
        controls::swipe_ui(ui, context, &scene);
        if !context.app.view.is_picture {
            controls::show_buttons(ui, context, rect, &mut self.request);
            self.banner(ui, context.app, rect);
        }
        let name = name(context.app, &products, &track) + &track::mounting_name(context.app);
        name + &boxes(context) + &layers(context)
    }

    /// Draws the banner of the selected tool below the buttons; the read-out then is below the
    /// banner.
    fn banner(&mut self, ui: &mut Ui, app: &App, rect: Rect) {
        let banner = Banner::of(app, View::Map);
        // The north arrow is to the right of this area.
        let room = Rect::from_min_max(rect.min + vec2(4.0, 36.0), rect.max - vec2(56.0, 4.0));
        let shown = banner.filter(|_| legend::has_width(room));
        let placed = shown.map(|banner| banner.place(ui, room));
        if let Some(placed) = &placed {
            placed.draw(ui);
        }
        let height = placed.map_or(0.0, |placed| placed.plate.height() + 4.0);
        self.pointer.banner_height = height;
    }

    fn ask_for_layers(
        &mut self,
        context: &ViewContext<'_>,
        survey: &Arc<Survey>,
        products: &Products,
    ) {
        let uploader = context.uploader();
        let by_log = context.options().map.track_by_log;
        let logs = context.app.logs.with_results();
        let range_m = context.app.logs.depth_range_m();
        let key = track::key(&logs, range_m, by_log);
        let tracked = logs.clone();
        self.track.ask(key, context.app.jobs.workers(), move |progress| {
            let track = TrackLayer::new(&tracked, range_m, by_log, uploader.as_ref(), progress);
            track.map(Arc::new)
        });
        self.layers.ask(context, survey, products, &logs);
    }

    /// Moves the view as asked by keys, wheel, drag and reveals; returns the transform.
    fn navigate(
        &mut self,
        ui: &Ui,
        context: &ViewContext<'_>,
        response: &Response,
        track: &TrackLayer,
        drag_moves: bool,
    ) -> MapTransform {
        let rect = response.rect;
        // A double-click ends a measurement, so it fits the view only without a measuring tool.
        let fits = context.app.map.measuring.tool.is_none();
        let is_asked = self.request == Some(ViewRequest::Fit) || fits && response.double_clicked();
        if self.transform.is_none() || is_asked {
            let shown = context.options().map.layers.bottom_up();
            let shown = shown.filter(|shown| shown.visible).map(|shown| shown.layer);
            self.fits = shown.collect();
        }
        let bounds = self.layers.extent(&self.fits, track.bounds);
        let layers = &context.options().map.layers;
        let scales = 1 + usize::from(layers.is_visible(MapLayer::Residuals));
        let whole = || MapTransform::fit(bounds, rect, scales);
        let moved = self.transform.filter(|now| Some(*now) != self.fitted);
        let mut transform = moved.unwrap_or_else(whole);
        if let Some(ground) = self.aim.take() {
            transform = MapTransform::showing(ground, rect);
        }
        match self.request.take() {
            Some(ViewRequest::Fit) => transform = whole(),
            Some(ViewRequest::ZoomIn) => transform.zoom(rect, rect.center(), 1.5),
            Some(ViewRequest::ZoomOut) => transform.zoom(rect, rect.center(), 1.0 / 1.5),
            Some(ViewRequest::Top | ViewRequest::Side | ViewRequest::OneToOne) | None => {}
        }
        pointer::move_view(ui, response, &mut transform, drag_moves);
        if fits && response.double_clicked() {
            transform = whole();
        }
        if let Some(reveal) = context.app.view.reveal
            && reveal.serial != self.seen_reveal
        {
            self.seen_reveal = reveal.serial;
            if let Some(([east_m, north_m, _], size_m)) = place::enlarged(&reveal) {
                transform.close_up(rect, [east_m, north_m], size_m);
            } else if let Some(place) = place::east_north(context.app, reveal.mark) {
                transform.reveal(rect, place);
            }
        }
        self.visible = Some(transform.visible(rect));
        self.transform = Some(transform);
        self.fitted = Some(whole());
        transform
    }
}

fn paint(ui: &Ui, context: &ViewContext<'_>, scene: &MapScene<'_>, layers: &mut Layers) {
    let painter = ui.painter_at(scene.rect);
    for shown in scene.options.map.layers.bottom_up() {
        if scene.options.map.layers.is_visible(shown.layer) {
            let mut painter = painter.clone();
            painter.multiply_opacity(shown.opacity);
            painter.shrink_clip_rect(controls::part(scene, shown.layer));
            layers.show(&painter, context, scene, shown.layer);
        }
    }
    stretches::paint_excluded(&painter, scene, context.app);
    track::paint_recorded(&painter, scene, context.app);
    if scene.options.map.graticule {
        overlay::graticule(&painter, scene);
    }
    stretches::paint_flat(&painter, scene);
    let covered = overlay::furniture(&painter, scene);
    stretches::name_calibrated(&painter, scene, &covered);
    overlay::marks(&painter, scene, context.app);
    track::paint_mounting(&painter, scene, context.app);
    let now_s = ui.input(|input| input.time);
    if let Some(text) = layers.under_way(now_s) {
        overlay::under_way(&painter, scene, &text);
        // A job that has just lasted long enough to be shown does not request a frame by itself.
        ui.ctx().request_repaint_after(std::time::Duration::from_millis(200));
    }
}

fn boxes(context: &ViewContext<'_>) -> String {
    let logs = || context.app.logs.visible().map(|log| &log.reviewing);
    let placed = logs().flat_map(|reviewing| {
        let boxes = reviewing.in_line();
        boxes.filter(|review_box| reviewing.placed(review_box.id).is_some())
    });
    if logs().any(Reviewing::has_boxes) {
        format!(", {}", text::plural(placed.count(), "box", "boxes"))
    } else {
        String::new()
    }
}

/// Returns the names of the layers that are drawn, bottom first, for screen readers and tests.
fn layers(context: &ViewContext<'_>) -> String {
    let stack = &context.options().map.layers;
    let shown = stack.bottom_up().map(|shown| shown.layer);
    let has_base_map = context.app.map.base_map.is_some();
    let is_there = |layer: &MapLayer| *layer != MapLayer::BaseMap || has_base_map;
    let shown = shown.filter(|layer| stack.is_visible(*layer) && is_there(layer));
    let names: Vec<String> = shown.map(|layer| layer.name().to_lowercase()).collect();
    if names.is_empty() { String::new() } else { format!("; layers: {}", names.join(", ")) }
}

fn name(app: &App, products: &Products, track: &TrackLayer) -> String {
    let reference = products.reduction().reference_name();
    let surveys = app.logs.visible().filter_map(|log| log.survey.as_ref());
    let pings = surveys.map(|survey| survey.side_scan.len()).sum();
    let excluded = match stretches::ping_count(app) {
        0 => String::new(),
        count => format!(" of which {} excluded", text::count(count)),
    };
    let depths = track.range_m.map_or_else(String::new, |[shallow, deep]| {
        let depths = [shallow, deep].map(f64::from);
        let depths = app.view.options.units.span(depths, 1);
        format!(", depth {depths} {reference}")
    });
    let pings = text::count(pings);
    let spots = products.flat_spots.len();
    format!("Map, track of {pings} pings{excluded}{depths}, {spots} flat stretches")
}

/// Contents of a frame of the map.
struct MapScene<'a> {
    pub rect: Rect,
    pub transform: MapTransform,
    pub survey: &'a Survey,
    pub products: &'a Products,
    pub track: &'a Arc<TrackLayer>,
    /// The depth map; outer `None` while it is not needed or not ready, inner `None` if the depths
    /// do not span an area.
    pub depth_map: Option<Option<&'a Arc<DepthMap>>>,
    /// The isobaths; `None` while they are not shown or not ready.
    pub isobaths: Option<Arc<IsobathLayer>>,
    /// The residuals; `None` while they are not shown or not ready.
    pub residuals: Option<Arc<ResidualLayer>>,
    /// True if soundings have a fault, because of which the track is grey there.
    pub has_faults: bool,
    /// Number of pings of the shown log that depth map, isobaths and mosaic are made of; `None` if
    /// these are made of all pings. A log that is being followed has more pings.
    pub made_of: Option<usize>,
    /// True if some of the pings are excluded.
    pub has_excluded: bool,
    /// True if a log has depths across the track.
    pub has_swath: bool,
    /// True if the numbered flat stretches are drawn.
    pub shows_flat_stretches: bool,
    /// The stretch that is proposed for the scale; `None` if no stretch is.
    pub proposed: Option<PingRange>,
    pub options: &'a ViewOptions,
}

impl MapScene<'_> {
    /// Returns a place on the screen.
    fn at(&self, place: [f64; 2]) -> Pos2 {
        self.transform.to_screen(self.rect, place)
    }

    /// Returns the place of a WGS84 position on the screen.
    fn at_position(&self, position: LonLat) -> Pos2 {
        self.at(self.products.navigation.to_plane(&self.survey.track, position))
    }

    /// Returns the WGS84 position of a place on the screen.
    fn position(&self, at: Pos2) -> LonLat {
        let [east_m, north_m] = self.transform.to_ground(self.rect, at);
        let navigation = &self.products.navigation;
        navigation.to_lon_lat(&self.survey.track, east_m, north_m)
    }

    /// Returns the ends of the colour scale of depth, metres; `None` without depths.
    fn range_m(&self) -> Option<[f32; 2]> {
        let of_surface = || Some(self.depth_map.flatten()?.colour_range_m);
        self.track.range_m.or_else(of_surface)
    }

    /// Returns true if a layer is drawn.
    fn shows(&self, layer: MapLayer) -> bool {
        self.options.map.layers.is_visible(layer)
    }

    /// Returns the colour of words on the map.
    fn text_colour(&self) -> Color32 {
        theme::canvas_text_colour(self.options)
    }
}
