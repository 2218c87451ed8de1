//! Display options: saved between runs, never part of a result.

use super::{ClipBox, LayerStack, MapLayer, ObjectTable, PrintOptions, Swipe};
use bathyscope_bottom::picture::PictureGeometry;
use bathyscope_bottom::presentation::units::Units;
use bathyscope_log::support::geo::CoordinateFormat;
use bathyscope_log::survey::ChannelKind;
use bathyscope_products::outputs::Product;
use bathyscope_products::pipeline::BottomColour;
use serde::{Deserialize, Serialize};

/// A view of the centre.
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
}

impl View {
    /// All views in the order of their number keys.
    pub const ALL: [View; 4] = [View::Waterfall, View::Map, View::Cloud, View::Objects];
    /// The views that are pictures, and can be printed.
    pub(crate) const PICTURES: [View; 3] = [View::Waterfall, View::Map, View::Cloud];

    /// Title on the tab.
    pub fn title(self) -> &'static str {
        match self {
            View::Waterfall => "Waterfall",
            View::Map => "Map",
            View::Cloud => "3D cloud",
            View::Objects => "Objects",
        }
    }
}

/// An arrangement of the views to start from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum LayoutPreset {
    /// Waterfall above, map and cloud below.
    Survey,
    /// A large waterfall above, map and cloud below.
    Review,
    /// One view alone.
    Only(View),
}

/// Dark or light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ThemeChoice {
    /// Dark, as waterfalls are.
    #[default]
    Dark,
    /// Light.
    Light,
}

/// Colours of echo strength.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ColourMap {
    /// Black to copper: what fish-finders and their users are used to.
    #[default]
    Copper,
    /// Black to white.
    Grey,
    /// White to black.
    InverseGrey,
    /// Black over brown to yellow.
    Gold,
    /// Perceptually even (viridis).
    Viridis,
}

impl ColourMap {
    /// All maps in the order of the menu.
    pub const ALL: [ColourMap; 5] = [
        ColourMap::Copper,
        ColourMap::Grey,
        ColourMap::InverseGrey,
        ColourMap::Gold,
        ColourMap::Viridis,
    ];

    /// Name in the menu.
    pub fn name(self) -> &'static str {
        match self {
            ColourMap::Copper => "copper",
            ColourMap::Grey => "grey",
            ColourMap::InverseGrey => "inverse grey",
            ColourMap::Gold => "gold",
            ColourMap::Viridis => "viridis",
        }
    }
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
    #[default]
    Paper,
    /// Port red, starboard green, as at sea.
    Maritime,
}

/// A channel that looks down.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum EchogramChannel {
    /// None of them.
    #[default]
    None,
    /// Down-imaging sonar.
    DownScan,
    /// Traditional sonar.
    Primary,
    /// Traditional sonar, second frequency.
    Secondary,
}

impl EchogramChannel {
    /// All in the order of the menu.
    pub const ALL: [EchogramChannel; 4] = [
        EchogramChannel::None,
        EchogramChannel::DownScan,
        EchogramChannel::Primary,
        EchogramChannel::Secondary,
    ];

    /// The channel of a log; `None` without one.
    pub fn kind(self) -> Option<ChannelKind> {
        match self {
            EchogramChannel::None => None,
            EchogramChannel::DownScan => Some(ChannelKind::DownScan),
            EchogramChannel::Primary => Some(ChannelKind::Primary),
            EchogramChannel::Secondary => Some(ChannelKind::Secondary),
        }
    }

    /// Name in the menu.
    pub fn name(self) -> &'static str {
        match self {
            EchogramChannel::None => "side-scan alone",
            EchogramChannel::DownScan => "down-scan",
            EchogramChannel::Primary => "primary",
            EchogramChannel::Secondary => "secondary",
        }
    }
}

/// Waterfall display.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct WaterfallOptions {
    /// Colours of echo strength.
    pub colour_map: ColourMap,
    /// Direction of time.
    pub orientation: Orientation,
    /// Show distances on level ground instead of slant ranges.
    pub ground_range: bool,
    /// The channel that looks down and is shown with the side-scan, where the log has it.
    pub echogram: EchogramChannel,
    /// Show that channel in the place of the side-scan instead of beside it.
    pub echogram_alone: bool,
    /// Show what lies before the first return. On the ground there is none.
    pub water_column: bool,
    /// Draw the first return.
    pub first_return: bool,
    /// Draw range lines.
    pub range_lines: bool,
    /// Draw the recorded depth.
    pub depth_line: bool,
    /// Draw the ranked flat stretches along the nadir.
    pub flat_stretches: bool,
    /// Draw the boxes of objects.
    pub boxes: bool,
    /// A bottom edit on one side is made on the other too.
    pub bottom_both_sides: bool,
    /// The next box of the queue is shown one to one, with what lies around it.
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

/// Map display.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct MapOptions {
    /// Layers, in drawing order.
    pub layers: LayerStack,
    /// Colour the tracks by the log that they are of, instead of by depth.
    pub track_by_log: bool,
    /// Draw the ranked flat stretches.
    pub flat_spots: bool,
    /// Draw lines of round coordinates.
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
    /// The log that it is of.
    Log,
}

impl CloudColour {
    /// All of them in the order of the menu.
    pub const ALL: [CloudColour; 5] = [
        CloudColour::Source,
        CloudColour::Depth,
        CloudColour::Level,
        CloudColour::Range,
        CloudColour::Log,
    ];

    /// Name in the menu.
    pub fn name(self) -> &'static str {
        match self {
            CloudColour::Source => "side",
            CloudColour::Depth => "depth",
            CloudColour::Level => "echo level",
            CloudColour::Range => "slant range",
            CloudColour::Log => "log",
        }
    }

    /// The next one in the menu; logs are told apart only where there are several.
    #[must_use]
    pub fn next(self, has_several_logs: bool) -> Self {
        let all = if has_several_logs { &Self::ALL[..] } else { &Self::ALL[..4] };
        let here = all.iter().position(|one| *one == self);
        here.map_or(all[0], |here| all[(here + 1) % all.len()])
    }
}

/// Cloud display.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct CloudOptions {
    /// Property that the colour of a point shows.
    pub colour: CloudColour,
    /// Factor on z.
    pub vertical_exaggeration: f32,
    /// Diameter of a point, screen points.
    pub point_size: f32,
    /// Draw the points that do not count for the map, in a third colour; otherwise they are left
    /// out.
    pub outlier_preview: bool,
    /// Draw the boxes of objects.
    pub boxes: bool,
    /// Draw the points.
    pub points: bool,
    /// Draw the bottom: the depth map as a body.
    pub bottom: bool,
    /// Property that the colours of the bottom show.
    pub bottom_colour: BottomColour,
    /// Draw lines of equal depth on the bottom.
    pub isobaths: bool,
    /// Direction of the light on the bottom: degrees clockwise from north, and above the horizon.
    pub light_deg: [f32; 2],
    /// Draw where the water's surface is, with the boat's track on it.
    pub water: bool,
    /// Draw what lies behind the line of the depth profile alone, where there is one. It belongs to
    /// a survey, and is not kept for the next one.
    #[serde(skip)]
    pub cut: bool,
    /// Draw what lies in this box alone. It belongs to a survey, and is not kept for the next one.
    #[serde(skip)]
    pub clip: Option<ClipBox>,
}

impl CloudOptions {
    /// Turns the clip box on, around everything, or off.
    pub(crate) fn toggle_clip(&mut self) {
        self.clip = match self.clip {
            Some(_) => None,
            None => Some(ClipBox::WHOLE),
        };
    }

    /// The light comes from an eighth of a turn farther clockwise.
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
            // As the hill-shade of the map: from below, hills would be taken for hollows.
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
    /// Shown where the window is wide enough for it and the views.
    #[default]
    WithRoom,
    /// Always.
    Always,
    /// Never.
    Never,
}

/// The panels beside the views.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct PanelOptions {
    /// The paper's steps, left.
    pub steps: PanelShown,
    /// The selection, right.
    pub details: PanelShown,
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
    /// Dark or light.
    pub theme: ThemeChoice,
    /// The panels beside the views.
    pub panels: PanelOptions,
    /// Colours of the two sides.
    pub side_colours: SideColours,
    /// Format of positions.
    pub coordinates: CoordinateFormat,
    /// Units of lengths, depths, areas and speeds.
    pub units: Units,
    /// Waterfall.
    pub waterfall: WaterfallOptions,
    /// Map.
    pub map: MapOptions,
    /// Cloud.
    pub cloud: CloudOptions,
    /// Visibility of the points of a swath, on the map and in 3D.
    pub swath: SwathShown,
    /// Products that an export leaves out. Earlier versions called them `left_out`.
    #[serde(alias = "left_out")]
    pub excluded_products: Vec<Product>,
    /// Print options of a view.
    pub print: PrintOptions,
    /// Order and filter of the table of objects.
    pub objects: ObjectTable,
}

impl ViewOptions {
    /// Returns the options for a survey that is opened anew: those that hide or transform a part of
    /// the previous survey take their defaults, the others stay.
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
        options.swath = SwathShown::default();
        options.show_boxes(true);
        options.objects.state = None;
        options
    }

    /// Returns true if boxes are drawn in any view.
    pub(crate) fn shows_boxes(&self) -> bool {
        self.waterfall.boxes || self.cloud.boxes || self.map.layers.is_visible(MapLayer::Boxes)
    }

    /// Draws the boxes in all views, or in none.
    pub fn show_boxes(&mut self, shown: bool) {
        self.waterfall.boxes = shown;
        self.cloud.boxes = shown;
        self.map.layers.set_visible(MapLayer::Boxes, shown);
    }
}
