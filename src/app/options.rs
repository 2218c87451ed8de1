//! Defines the display options, which are saved between runs and never affect a result.

use super::{LayerStack, MapLayer, ObjectTable, PrintOptions, Swipe};
use bathyscope_bottom::calibration::ScaleMode;
use bathyscope_bottom::picture::PictureGeometry;
use bathyscope_bottom::presentation::colours::ColourMap;
use bathyscope_bottom::presentation::units::Units;
use bathyscope_log::support::geo::CoordinateFormat;
use bathyscope_log::survey::{ChannelKind, Side, Survey};
use bathyscope_products::outputs::Product;
use bathyscope_products::pipeline::BottomColour;
use serde::{Deserialize, Serialize};

bathyscope_log::listed! {
    /// All views in the order of their number keys.
    const ALL;

    /// A view in the centre of the window.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
    pub enum View {
        /// Side-scan picture over ping and range.
        Waterfall,
        /// Track, depth map and flat stretches from above.
        Map,
        /// Point cloud.
        Cloud,
        /// Table of the objects.
        Objects,
        /// Echoes of one ping as a curve.
        Profile,
    }
}

bathyscope_log::listed! {
    /// All steps, in working order.
    const ALL;

    /// Step of the work on a survey.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
    pub enum WorkStep {
        /// The open logs, and what they contain.
        #[default]
        Logs,
        /// First return of the bottom.
        Bottom,
        /// Scale, draft, water level, sound speed, positions, mounting and exclusions.
        Correct,
        /// Outliers, depth map, isobaths, mosaic and planned lines.
        Map,
        /// Objects on the bottom.
        Objects,
        /// Residuals, comparison and files.
        Export,
    }
}

impl View {
    /// The views that are pictures, and can be printed.
    pub(crate) const PICTURES: [View; 3] = [View::Waterfall, View::Map, View::Cloud];

    /// Returns the title on the tab.
    pub fn title(self) -> &'static str {
        match self {
            View::Waterfall => "Waterfall",
            View::Map => "Map",
            View::Cloud => "3D cloud",
            View::Objects => "Objects",
            View::Profile => "Profile",
        }
    }
}

/// An initial arrangement of the views.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum LayoutPreset {
    /// Waterfall above, map and cloud below.
    Survey,
    /// A large waterfall above, profile and map below.
    Review,
    /// A large map, with cloud and waterfall beside it.
    Map,
    /// A waterfall above, table of objects and map below.
    Objects,
    /// One view alone.
    Only(View),
}

/// Theme of the window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ThemeChoice {
    /// Dark, as waterfalls usually are.
    #[default]
    Dark,
    /// Light.
    Light,
}

/// Direction of time in the waterfall.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Orientation {
    /// Time runs to the right; port is up, starboard down.
    #[default]
    Horizontal,
    /// Time runs down the screen; port is left, starboard right.
    Vertical,
}

/// Colours of the two sides.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum SideColours {
    /// Starboard red, port blue, as in the paper.
    Paper,
    /// Port red, starboard green, as at sea.
    #[default]
    Maritime,
}

/// A channel that looks down.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum EchogramChannel {
    /// No down-looking channel.
    #[default]
    None,
    /// Down-imaging sonar.
    DownScan,
    /// Traditional sonar.
    Primary,
    /// Traditional sonar, second frequency.
    Secondary,
}

bathyscope_log::named! {
    /// All channels in the order of the menu.
    pub EchogramChannel {
        None: "side-scan alone",
        DownScan: "down-scan",
        Primary: "primary",
        Secondary: "secondary",
    }
}

impl EchogramChannel {
    /// Returns the channel of a log; `None` for no down-looking channel.
    pub fn kind(self) -> Option<ChannelKind> {
        match self {
            EchogramChannel::None => None,
            EchogramChannel::DownScan => Some(ChannelKind::DownScan),
            EchogramChannel::Primary => Some(ChannelKind::Primary),
            EchogramChannel::Secondary => Some(ChannelKind::Secondary),
        }
    }
}

/// Options of the waterfall.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct WaterfallOptions {
    /// Colours of echo strength.
    pub colour_map: ColourMap,
    /// Direction of time.
    pub orientation: Orientation,
    /// True to show distances on level ground instead of slant ranges.
    pub ground_range: bool,
    /// The down-looking channel that is shown with the side-scan, if the log has it.
    pub echogram: EchogramChannel,
    /// True to show that channel instead of the side-scan, false to show it beside the side-scan.
    pub echogram_alone: bool,
    /// True to show echoes before the first return. In the ground range there are none.
    pub water_column: bool,
    /// True to draw the first return.
    pub first_return: bool,
    /// True to draw range lines.
    pub range_lines: bool,
    /// True to draw the recorded depth.
    pub depth_line: bool,
    /// True to draw the ranked flat stretches along the nadir.
    pub flat_stretches: bool,
    /// True to draw the boxes of objects.
    pub boxes: bool,
    /// True if a bottom edit on one side is made on the other side, too.
    pub bottom_both_sides: bool,
    /// True if the next box of the queue is shown one to one, with its surroundings.
    pub zooms_to_boxes: bool,
}

impl WaterfallOptions {
    /// Returns the quantity across the track: distance on level ground, or slant range with or
    /// without the water column.
    pub fn geometry(&self) -> PictureGeometry {
        match (self.ground_range, self.water_column) {
            (true, _) => PictureGeometry::Ground,
            (false, true) => PictureGeometry::Slant,
            (false, false) => PictureGeometry::SlantBeyondWater,
        }
    }

    /// Returns the sides on which a bottom edit on `side` is made.
    pub(super) fn sides_of(&self, side: Side) -> impl Iterator<Item = Side> + use<> {
        let both = self.bottom_both_sides;
        (Side::BOTH.into_iter()).filter(move |&candidate| both || candidate == side)
    }

    /// Shows side-scan, then each down-looking channel of the log, beside the side-scan and alone.
    pub(crate) fn next_channel(&mut self, survey: Option<&Survey>) {
        let has = |channel: &EchogramChannel| {
            let has = |kind| survey.is_some_and(|survey| survey.has_echogram(kind));
            channel.kind().is_some_and(has)
        };
        let there = EchogramChannel::ALL.into_iter().filter(has);
        let each = there.flat_map(|channel| [(channel, false), (channel, true)]);
        let all: Vec<_> = [(EchogramChannel::None, false)].into_iter().chain(each).collect();
        let now = match self.echogram {
            EchogramChannel::None => (EchogramChannel::None, false),
            channel => (channel, self.echogram_alone),
        };
        let place = all.iter().position(|choice| *choice == now).unwrap_or(0);
        (self.echogram, self.echogram_alone) = all[(place + 1) % all.len()];
    }
}

impl Default for WaterfallOptions {
    fn default() -> Self {
        Self {
            colour_map: ColourMap::default(),
            orientation: Orientation::default(),
            ground_range: false,
            echogram: EchogramChannel::default(),
            echogram_alone: false,
            water_column: true,
            first_return: true,
            range_lines: true,
            depth_line: false,
            flat_stretches: true,
            boxes: true,
            bottom_both_sides: false,
            zooms_to_boxes: true,
        }
    }
}

/// Options of the map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct MapOptions {
    /// Layers, in drawing order.
    pub layers: LayerStack,
    /// True to colour the tracks by log instead of by depth.
    pub track_by_log: bool,
    /// True to draw the ranked flat stretches.
    pub flat_spots: bool,
    /// True to draw lines of round coordinates.
    pub graticule: bool,
    /// Division of the map, and the side of it on which each layer is drawn.
    pub swipe: Swipe,
}

impl Default for MapOptions {
    fn default() -> Self {
        Self {
            layers: LayerStack::default(),
            track_by_log: false,
            flat_spots: true,
            graticule: true,
            swipe: Swipe::default(),
        }
    }
}

/// Property that the colour of a point shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
pub enum CloudColour {
    /// Down-scan, port or starboard.
    #[default]
    #[value(name = "side")]
    Source,
    /// Depth.
    Depth,
    /// Strength of the echo of the first return.
    Level,
    /// Slant range.
    Range,
    /// The log that the point belongs to.
    Log,
}

bathyscope_log::named! {
    /// All properties in the order of the menu.
    pub CloudColour {
        Source: "side",
        Depth: "depth",
        Level: "echo level",
        Range: "slant range",
        Log: "log",
    }
}

impl CloudColour {
    /// Returns the next property in the menu; the log is included only if there are several logs.
    #[must_use]
    pub fn next(self, has_several_logs: bool) -> Self {
        let all = if has_several_logs { &Self::ALL[..] } else { &Self::ALL[..4] };
        let here = all.iter().position(|property| *property == self);
        here.map_or(all[0], |here| all[(here + 1) % all.len()])
    }
}

/// A box along the axes of the survey's plane: the 3D view draws nothing outside it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipBox {
    /// Ends in east, north and elevation, metres in the plane of the survey; infinite where the box
    /// has no end.
    pub ends_m: [[f64; 2]; 3],
}

impl ClipBox {
    /// The box without ends, which clips nothing.
    pub const WHOLE: Self = Self { ends_m: [[f64::NEG_INFINITY, f64::INFINITY]; 3] };
}

/// Options of the cloud.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct CloudOptions {
    /// Property that the colour of a point shows.
    pub colour: CloudColour,
    /// Factor on elevations.
    pub vertical_exaggeration: f32,
    /// Diameter of a point, screen points.
    pub point_size: f32,
    /// True to draw the points that do not count for the map, in a colour of their own; otherwise
    /// they are not drawn.
    pub outlier_preview: bool,
    /// True to draw the boxes of objects.
    pub boxes: bool,
    /// True to draw the points.
    pub points: bool,
    /// True to draw the bottom: the depth map as a body.
    pub bottom: bool,
    /// Property that the colours of the bottom show.
    pub bottom_colour: BottomColour,
    /// True to draw lines of equal depth on the bottom.
    pub isobaths: bool,
    /// Direction of the light on the bottom: degrees clockwise from north, and above the horizon.
    pub light_deg: [f32; 2],
    /// True to draw the water surface, with the boat's track on it.
    pub water: bool,
    /// True to draw only what lies behind the line of the depth profile, if there is one. The cut
    /// belongs to a survey, and is not kept for the next one.
    #[serde(skip)]
    pub cut: bool,
    /// Box outside which nothing is drawn; `None` draws everything. It belongs to a survey, and is
    /// not kept for the next one.
    #[serde(skip)]
    pub clip: Option<ClipBox>,
}

impl CloudOptions {
    /// Turns the clip box on, at first without limits, or off.
    pub(crate) fn toggle_clip(&mut self) {
        self.clip = match self.clip {
            Some(_) => None,
            None => Some(ClipBox::WHOLE),
        };
    }

    /// Turns the direction of the light clockwise by an eighth of a turn.
    pub(crate) fn turn_light(&mut self) {
        self.light_deg[0] = (self.light_deg[0] + 45.0).rem_euclid(360.0);
    }
}

impl Default for CloudOptions {
    fn default() -> Self {
        Self {
            colour: CloudColour::default(),
            vertical_exaggeration: 5.0,
            point_size: 3.0,
            outlier_preview: false,
            boxes: true,
            points: true,
            bottom: true,
            bottom_colour: BottomColour::default(),
            isobaths: true,
            // The light is that of the map's hill-shade: with light from below, hills would look
            // like hollows.
            light_deg: [315.0, 45.0],
            water: false,
            cut: false,
            clip: None,
        }
    }
}

/// Visibility of a panel beside the views.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum PanelShown {
    /// Shown if the window is wide enough for the panel and the views.
    #[default]
    WithRoom,
    /// Always shown.
    Always,
    /// Never shown.
    Never,
}

/// Visibility of the panels beside the views, and what the left one contains.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct PanelOptions {
    /// Panel of the processing steps, on the left.
    pub steps: PanelShown,
    /// Panel of the selection, on the right.
    pub details: PanelShown,
    /// The step of the work that is open in the panel of steps.
    pub step: WorkStep,
}

/// Visibility of the points of a swath.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct SwathShown(pub bool);

impl Default for SwathShown {
    fn default() -> Self {
        Self(true)
    }
}

/// All display options.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ViewOptions {
    /// Theme of the window.
    pub theme: ThemeChoice,
    /// Visibility of the panels beside the views.
    pub panels: PanelOptions,
    /// Colours of the two sides.
    pub side_colours: SideColours,
    /// Format of positions.
    pub coordinates: CoordinateFormat,
    /// Units of lengths, depths, areas and speeds.
    pub units: Units,
    /// Options of the waterfall.
    pub waterfall: WaterfallOptions,
    /// Options of the map.
    pub map: MapOptions,
    /// Options of the cloud.
    pub cloud: CloudOptions,
    /// Visibility of the points of a swath, on the map and in 3D.
    pub swath: SwathShown,
    /// Products that an export does not write. Earlier versions called this option `left_out`.
    #[serde(alias = "left_out")]
    pub excluded_products: Vec<Product>,
    /// Print options of a view.
    pub print: PrintOptions,
    /// Order and filter of the table of objects.
    pub objects: ObjectTable,
}

impl ViewOptions {
    /// Returns the options for a new survey: those that hide or transform a part of the previous
    /// survey get their defaults, the others stay.
    #[must_use]
    pub(crate) fn for_new_survey(&self) -> Self {
        let usual = WaterfallOptions::default();
        let mut options = self.clone();
        options.waterfall = WaterfallOptions {
            ground_range: usual.ground_range,
            echogram: usual.echogram,
            echogram_alone: usual.echogram_alone,
            water_column: usual.water_column,
            bottom_both_sides: usual.bottom_both_sides,
            ..options.waterfall
        };
        options.map.swipe = Swipe::default();
        options.panels.step = WorkStep::default();
        options.swath = SwathShown::default();
        options.show_boxes(true);
        options.objects.state = None;
        options
    }

    /// Returns true if boxes are drawn in any view.
    pub(crate) fn shows_boxes(&self) -> bool {
        self.waterfall.boxes || self.cloud.boxes || self.map.layers.is_visible(MapLayer::Boxes)
    }

    /// Returns true if the numbered flat stretches are drawn in a view: only in the step that they
    /// serve.
    pub(crate) fn shows_flat_stretches(&self, view: View) -> bool {
        let is_on = match view {
            View::Waterfall => self.waterfall.flat_stretches,
            View::Map => self.map.flat_spots,
            View::Cloud | View::Objects | View::Profile => false,
        };
        is_on && self.panels.step == WorkStep::Correct
    }

    /// Returns true if the stretch that the calibration measured is drawn: where its scale is in
    /// use, and in the step of the calibration.
    pub(crate) fn shows_measured_stretch(&self, in_use: ScaleMode) -> bool {
        in_use == ScaleMode::FlatSpot || self.panels.step == WorkStep::Correct
    }

    /// Sets whether boxes are drawn, in all views.
    pub fn show_boxes(&mut self, shown: bool) {
        self.waterfall.boxes = shown;
        self.cloud.boxes = shown;
        self.map.layers.set_visible(MapLayer::Boxes, shown);
    }
}
