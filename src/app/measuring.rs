//! Draws figures to measure, and writes them into files: a line, an area or the line of a depth
//! profile, whose depths are taken from the depth map, on the map and in the waterfall, and the
//! height of an object from its shadow in the waterfall.

use super::error::AppError;
use super::history::Figure;
use super::reviewing::Tool;
use super::{Action, App, OpenLog, OpenLogs};
use bathyscope_bottom::bathymetry::{Corner, TransectStation, transect};
use bathyscope_log::support::geo::LonLat;
use bathyscope_log::survey::{Identity, Side, Survey};
use bathyscope_objects::MeasuredShadow;
use bathyscope_objects::review::{BoxId, Edit, Reviewed};
use bathyscope_objects::targets::{ShadowError, ShadowHeight};
use bathyscope_products::export::{self, MeasuredFigure};
use bathyscope_products::pipeline::{DepthMap, ObjectLocator, Products};
use bathyscope_products::project::{Measurement, MeasurementKind, Pick};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

const NO_PLACE: &str =
    "nothing can be measured here: the track or the results of the log are missing";

const NO_LINE: &str = "there is no line to cut along: draw a depth profile on the map first";

/// Greatest number of places along a line at which depths are taken.
const MOST_STATIONS: usize = 2000;

/// A request about the figure.
#[derive(Clone, Debug, PartialEq)]
pub enum Measure {
    /// Add a corner at this position on the map.
    Corner(LonLat),
    /// Add a corner at this place of the waterfall.
    Pick(Pick),
    /// Set the position under the pointer, where the next corner would be; `None` without one.
    Next(Option<LonLat>),
}

/// The figure and the tool that draws it.
#[derive(Default)]
pub struct Measuring {
    /// Kind of figure that a click on the map or the waterfall draws; `None` without a measuring
    /// tool.
    pub tool: Option<MeasurementKind>,
    /// Figure that was drawn last; `None` if it was removed.
    pub figure: Option<Arc<Figure>>,
    /// Position of the next corner, under the pointer.
    pub(super) next: Option<LonLat>,
    /// Depths along the figure, if it is the line of a profile.
    pub(super) set: Option<Arc<ProfileLine>>,
    /// Depths along the line of a profile and on to the next corner, while it is drawn.
    pub(super) drawn: Option<Arc<ProfileLine>>,
}

/// The depths along a line, with the line and the depth map that they come from.
#[derive(Clone)]
pub struct ProfileLine {
    line: Measurement,
    map: Option<Arc<DepthMap>>,
    /// Places along the line with their depths.
    pub stations: Vec<TransectStation>,
    /// Distance from the start of the line to each corner, metres.
    pub corners_m: Vec<f64>,
}

impl ProfileLine {
    /// Returns true if there is no depth map to take depths from.
    pub(crate) fn lacks_map(&self) -> bool {
        self.map.is_none()
    }

    fn is_of(&self, line: &Measurement, map: Option<&Arc<DepthMap>>) -> bool {
        self.line == *line && self.map.as_ref().map(Arc::as_ptr) == map.map(Arc::as_ptr)
    }

    fn new(
        line: Measurement,
        map: Option<&Arc<DepthMap>>,
        place: impl Fn(LonLat) -> [f64; 2],
    ) -> Self {
        let corners_m = line.distances_m();
        let corners: Vec<Corner> = (line.corners.iter().zip(&corners_m))
            .map(|(at, distance_m)| Corner { place: place(*at), distance_m: *distance_m })
            .collect();
        // Two samples in each cell miss nothing that is drawn.
        let step_m = map.map_or(f64::INFINITY, |map| 0.5 * map.surface.grid.cell_m);
        let depth_at = |place| map?.depth_at(place);
        Self {
            stations: transect(&corners, step_m, MOST_STATIONS, depth_at),
            line,
            map: map.cloned(),
            corners_m,
        }
    }
}

impl Measuring {
    /// Returns a pick; one of a shadow's end is moved to the ping and side of the shadow's top.
    pub(crate) fn on_one_ping(&self, pick: Pick) -> Pick {
        let is_shadow = self.tool == Some(MeasurementKind::Height) && self.is_drawing();
        let top = self.picks().get(&0).filter(|_| is_shadow);
        match top {
            Some(top) => Pick { slant_m: pick.slant_m, ..top.clone() },
            None => pick,
        }
    }

    /// Returns a copy that holds only the drawn parts.
    pub(super) fn for_picture(&self) -> Self {
        Self { tool: None, figure: self.figure.clone(), ..Self::default() }
    }

    /// Returns the depths along the figure; none if it is not the line of a profile.
    pub fn stations(&self) -> &[TransectStation] {
        self.set.as_ref().map_or(&[], |set| &set.stations)
    }

    /// Returns the line of the profile with its depths, including the next corner while it is
    /// drawn.
    pub fn profile(&self) -> Option<&ProfileLine> {
        self.drawn.as_deref()
    }

    /// Returns true if the plot of a depth profile is shown.
    pub fn shows_profile(&self) -> bool {
        let drawn = self.figure.as_ref().map(|figure| figure.measurement.kind);
        self.tool.or(drawn) == Some(MeasurementKind::Profile)
    }

    /// Returns the places in the side-scan where corners of the figure were set, by corner number.
    pub fn picks(&self) -> &BTreeMap<usize, Pick> {
        static NONE: BTreeMap<usize, Pick> = BTreeMap::new();
        let figure = self.figure.as_deref();
        figure.map_or(&NONE, |figure| &figure.measurement.picks)
    }

    /// Returns true if another corner would continue the present figure.
    pub(crate) fn is_drawing(&self) -> bool {
        let open = self.figure.as_ref().filter(|figure| !figure.done);
        open.is_some_and(|figure| Some(figure.measurement.kind) == self.tool)
    }

    /// Assigns the picks of the figure to a longer state of their log.
    pub(super) fn carry(&mut self, survey: &Survey, identity: &Identity) {
        let Some(figure) = &mut self.figure else {
            return;
        };
        let mut picks = figure.measurement.picks.values();
        if picks.any(|pick| survey.is_or_was(&pick.log)) {
            for pick in Arc::make_mut(figure).measurement.picks.values_mut() {
                if survey.is_or_was(&pick.log) {
                    pick.log = identity.clone();
                }
            }
        }
    }
}

impl OpenLogs {
    /// Returns the height of the object that casts the shadow between two slant ranges of a pick's
    /// ping, by the recorder's scale; `None` if the log of the pick is closed or not processed.
    pub(crate) fn shadow_height(
        &self,
        on: &Pick,
        recorded_m: [f64; 2],
    ) -> Option<Result<ShadowHeight, ShadowError>> {
        let (locator, _) = self.locator(on)?;
        let side = on.side_in(locator.survey);
        Some(locator.placer.shadow_height(side, on.ping, recorded_m))
    }

    /// Returns the position of a pick on the bottom.
    fn ground_at(&self, pick: &Pick) -> Option<LonLat> {
        let (locator, products) = self.locator(pick)?;
        let side = pick.side_in(locator.survey);
        let [east_m, north_m] = locator.placer.ground(side, pick.ping, pick.slant_m)?;
        Some(products.navigation.to_lon_lat(&locator.survey.track, east_m, north_m))
    }

    /// Returns the object locator of a pick's log, and the results of that log; `None` if the log
    /// is closed or not processed.
    fn locator(&self, pick: &Pick) -> Option<(ObjectLocator<'_>, &Products)> {
        let is_of = |log: &&OpenLog| {
            let own = log.survey.as_ref().map(|survey| Identity::of(survey));
            own.is_some_and(|own| own.is_same_log(&pick.log))
        };
        let (survey, products) = self.all().find(is_of)?.results()?;
        Some((ObjectLocator::new(survey, products), products))
    }
}

impl OpenLog {
    /// Returns the box that should get the height of a measured shadow, and that shadow, or `None`
    /// for the shadow if the box has it already.
    fn box_of_shadow(
        &self,
        shadow: Option<(Side, MeasuredShadow)>,
    ) -> Option<(BoxId, Option<MeasuredShadow>)> {
        let reviewing = &self.reviewing;
        let selected = reviewing.selected_box();
        let Some((side, shadow)) = shadow else {
            let measured = selected.filter(|review_box| review_box.shadow.is_some())?;
            return Some((measured.id, None));
        };
        let fits =
            |review_box: &&Reviewed| review_box.mark.side == side && shadow.fits(&review_box.mark);
        let around = |review_box: &&Reviewed| {
            fits(review_box)
                && review_box.mark.near_m < shadow.end_m
                && shadow.top_m < review_box.mark.far_m
        };
        let review_box = selected.filter(fits).or_else(|| reviewing.review.boxes().find(around))?;
        Some((review_box.id, (review_box.shadow != Some(shadow)).then_some(shadow)))
    }
}

impl App {
    /// Toggles a measuring tool.
    pub(super) fn take_measuring_tool(&mut self, kind: MeasurementKind) {
        let again = self.map.measuring.tool == Some(kind);
        self.end_figure();
        self.map.measuring.tool = (!again && self.logs.shown.survey.is_some()).then_some(kind);
        self.logs.shown.reviewing.tool = Tool::Look;
    }

    /// Deselects the measuring tool; returns true if one was selected.
    pub(super) fn leave_measuring(&mut self) -> bool {
        let had_tool = self.map.measuring.tool.take().is_some();
        if had_tool {
            self.end_figure();
        }
        had_tool
    }

    /// Removes the figure, and deselects the tool.
    pub(super) fn remove_figure(&mut self) {
        self.map.measuring.tool = None;
        if self.map.measuring.figure.is_some() {
            self.draw(None);
        }
    }

    /// Carries out a request about the figure.
    pub(super) fn measure(&mut self, request: Measure) {
        match request {
            Measure::Corner(at) => {
                // A shadow can be measured in the waterfall only.
                if self.map.measuring.tool != Some(MeasurementKind::Height) {
                    self.add_corner(at, None);
                }
            }
            Measure::Pick(pick) => {
                let pick = self.map.measuring.on_one_ping(pick);
                match self.logs.ground_at(&pick) {
                    Some(at) => self.add_corner(at, Some(pick)),
                    None => self.notices.warn(NO_PLACE),
                }
            }
            Measure::Next(place) => self.map.measuring.next = place,
        }
    }

    /// Adds a corner to the figure, or begins a figure with it.
    fn add_corner(&mut self, at: LonLat, pick: Option<Pick>) {
        let Some(kind) = self.map.measuring.tool else {
            return;
        };
        let open = self.map.measuring.figure.as_ref();
        let open = open.filter(|_| self.map.measuring.is_drawing());
        let begun =
            open.map_or_else(|| Measurement::new(kind), |figure| figure.measurement.clone());
        let measurement = begun.with(at, pick);
        self.draw(Some(Figure { measurement, done: false }));
        // The height is complete with both ends of the shadow.
        if kind == MeasurementKind::Height && self.map.measuring.picks().len() == 2 {
            self.end_figure();
        }
    }

    /// Returns the measured height; `None` until both ends of the shadow are set.
    pub fn measured_height(&self) -> Option<Result<ShadowHeight, ShadowError>> {
        let figure = self.map.measuring.figure.as_deref()?;
        let (top, recorded_m) = figure.measurement.shadow()?;
        self.logs.shadow_height(top, recorded_m)
    }

    /// Gives the height of the measured shadow to the selected box, or to the box in which it was
    /// measured. If no other shadow is measured, the height of a box that has one is again that of
    /// the box's own shadow.
    pub(super) fn use_shadow(&mut self) {
        let figure = self.map.measuring.figure.as_deref();
        let shadow = figure.and_then(|figure| figure.measurement.shadow());
        let own = self.logs.shown.survey.as_ref().map(|survey| Identity::of(survey));
        let is_of_log = |pick: &Pick| own.as_ref().is_some_and(|own| own.is_same_log(&pick.log));
        let shadow = shadow.filter(|(pick, _)| is_of_log(pick)).map(|(pick, [one, other])| {
            let shadow =
                MeasuredShadow { ping: pick.ping, top_m: one.min(other), end_m: one.max(other) };
            (pick.side, shadow)
        });
        match self.logs.shown.box_of_shadow(shadow) {
            Some((id, shadow)) => self.edit(&Edit::SetShadow(id, shadow), false),
            None => self.notices.warn(format!(
                "no height is measured on a box: measure a shadow ({}) on the pings of a box, and select that box",
                Action::HeightFromShadow.key()
            )),
        }
    }

    /// Removes the last corner; a finished figure can be continued.
    pub(super) fn take_corner_back(&mut self) {
        if let Some(figure) = &self.map.measuring.figure {
            let mut figure = (**figure).clone();
            figure.measurement = figure.measurement.without_last();
            let is_left = !figure.measurement.corners.is_empty();
            figure.done = false;
            self.draw(is_left.then_some(figure));
        }
    }

    /// Ends the figure, so that the next corner begins another one. A figure that cannot be
    /// measured is removed.
    pub(super) fn end_figure(&mut self) {
        match &self.map.measuring.figure {
            Some(figure) if !figure.measurement.is_measurable() => self.draw(None),
            Some(figure) if !figure.done => {
                self.map.measuring.figure =
                    Some(Arc::new(Figure { done: true, ..(**figure).clone() }));
                self.keep_decision("measurement");
            }
            _ => {}
        }
    }

    /// Replaces the figure on the map by `figure`, as an undo step.
    fn draw(&mut self, figure: Option<Figure>) {
        let before = self.step_now();
        let label = if figure.is_some() { "corner" } else { "measurement" };
        self.map.measuring.figure = figure.map(Arc::new);
        self.record_step(&before, label, false);
    }

    /// Returns the depth profile as a table; `None` if there is none.
    pub fn profile_csv(&self) -> Option<String> {
        let (survey, products) = self.logs.shown.results()?;
        let stations = self.map.measuring.stations();
        let drawn = self.map.measuring.shows_profile() && !stations.is_empty();
        drawn.then(|| export::profile_csv(survey, &products.navigation, stations))
    }

    /// Writes the depth profile into a file.
    pub(super) fn save_profile(&mut self, path: PathBuf) {
        let Some(text) = self.profile_csv() else {
            return;
        };
        if self.refuses_log(self.logs.shown.id, &path) {
            return;
        }
        let written = export::write_bytes(&path, text);
        let written = written.map(|()| format!("Wrote the depth profile to {}", path.display()));
        self.notices.tell(written);
    }

    /// Returns the measured figure; `None` without results, or before it has enough corners to
    /// measure.
    pub fn measured(&self) -> Option<MeasuredFigure> {
        let (survey, products) = self.logs.shown.results()?;
        let figure = &self.map.measuring.figure.as_deref()?.measurement;
        if !figure.is_measurable() {
            return None;
        }
        let (area_m2, stations) = match figure.kind {
            MeasurementKind::Distance | MeasurementKind::Height => (None, &[][..]),
            MeasurementKind::Area => (Some(figure.area_m2()), &[][..]),
            MeasurementKind::Profile => (None, self.map.measuring.stations()),
        };
        let shadow = self.measured_height().and_then(Result::ok);
        let stations = stations.iter().map(|station| {
            let [east_m, north_m] = station.place;
            let at = products.navigation.to_lon_lat(&survey.track, east_m, north_m);
            (at, station.distance_m, station.depth_m)
        });
        Some(MeasuredFigure {
            log: survey.name(),
            kind: figure.kind.name(),
            corners: figure.corners.clone(),
            distances_m: figure.distances_m(),
            length_m: figure.length_m(),
            area_m2,
            shadow,
            stations: stations.collect(),
        })
    }

    /// Writes the measured figure into a file.
    pub(super) fn save_figure(&mut self, path: PathBuf) {
        let Some(figure) = self.measured() else {
            return;
        };
        if self.refuses_log(self.logs.shown.id, &path) {
            return;
        }
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        let written = match ending.as_str() {
            "geojson" | "json" => export::figure_geojson(&path, &figure),
            // The depths along a profile are more useful than its corners.
            "csv" => match self.profile_csv() {
                Some(text) => export::write_bytes(&path, text),
                None => export::figure_csv(&path, &figure),
            },
            _ => return self.notices.warn(AppError::FigureFormat(path)),
        };
        let written = written.map(|()| format!("Wrote the measurement to {}", path.display()));
        self.notices.tell(written);
    }

    /// Turns the cut of the 3D view along the line of the profile on or off.
    pub(super) fn toggle_cut(&mut self) {
        if self.map.measuring.stations().is_empty() {
            return self.notices.warn(NO_LINE);
        }
        self.view.options.cloud.cut = !self.view.options.cloud.cut;
    }

    /// Takes the depths along the line again if the line or the depth map has changed.
    pub(super) fn follow_profile(&mut self) {
        let is_profile = |line: &Measurement| line.kind == MeasurementKind::Profile;
        let figure = self.map.measuring.figure.as_deref();
        let set = figure.map(|figure| figure.measurement.clone());
        let set = set.filter(is_profile);
        let next = self.map.measuring.next.filter(|_| self.map.measuring.is_drawing());
        let drawn = set.clone().map(|line| match next {
            Some(next) => line.with(next, None),
            None => line,
        });
        self.map.measuring.set = self.profile_line(set, self.map.measuring.set.as_ref());
        self.map.measuring.drawn = match drawn {
            // The finished and the drawn line are the same, so the depths are shared.
            Some(drawn) if self.map.measuring.set.as_ref().is_some_and(|set| set.line == drawn) => {
                self.map.measuring.set.clone()
            }
            drawn => self.profile_line(drawn, self.map.measuring.drawn.as_ref()),
        };
    }

    fn profile_line(
        &self,
        line: Option<Measurement>,
        before: Option<&Arc<ProfileLine>>,
    ) -> Option<Arc<ProfileLine>> {
        let (survey, products) = self.logs.shown.results()?;
        let (line, map) = (line?, self.depth_map().flatten());
        if let Some(before) = before.filter(|before| before.is_of(&line, map)) {
            return Some(before.clone());
        }
        let place = |at| products.navigation.to_plane(&survey.track, at);
        Some(Arc::new(ProfileLine::new(line, map, place)))
    }
}
