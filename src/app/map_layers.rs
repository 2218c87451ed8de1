//! Defines the layers of the map: their visibility, order and opacity, and the divider that shows
//! them on one side of it, to compare them.
//!
//! Opens further files that the map is drawn with in background threads: the analyst's own picture
//! under the map, which stays from survey to survey, and the area at which isobaths end, which
//! becomes part of the settings only if its file holds an area.

use super::App;
use super::jobs::JobKey;
use bathyscope_log::formats::base_map::{self, BaseMap};
use bathyscope_log::formats::read_area;
use bathyscope_log::survey::{Survey, WaterArea};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::sync::Arc;

/// A layer of the map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum MapLayer {
    /// A picture of the analyst's own.
    BaseMap,
    /// Depths between the soundings, interpolated.
    DepthMap,
    /// The depth map lit from the side.
    HillShade,
    /// Side-scan echoes at their positions on the ground.
    Mosaic,
    /// Lines of equal depth.
    Isobaths,
    /// The points of the cloud from above.
    Points,
    /// The boat's track.
    Track,
    /// Differences of points from a reference.
    Residuals,
    /// Boxes of objects.
    Boxes,
}

bathyscope_log::named! {
    /// All layers in their initial order, bottom first.
    pub MapLayer {
        BaseMap: "Base map",
        DepthMap: "Depth map",
        HillShade: "Hill-shade",
        Mosaic: "Mosaic",
        Isobaths: "Isobaths",
        Points: "Points",
        Track: "Track",
        Residuals: "Residuals",
        Boxes: "Boxes",
    }
}

impl MapLayer {
    /// Returns a sentence that describes the layer.
    pub fn hint(self) -> &'static str {
        match self {
            MapLayer::BaseMap => "A GeoTIFF of your own: File > Open base map.",
            MapLayer::DepthMap => "Depths between the soundings, interpolated.",
            MapLayer::HillShade => "Relief of the depth map, lit from the north-west.",
            MapLayer::Mosaic => "Side-scan echoes at their positions on the ground.",
            MapLayer::Isobaths => "Lines of equal depth, with their depths.",
            MapLayer::Points => "Points of the cloud, coloured by side.",
            MapLayer::Residuals => {
                "How each point differs from a reference: red is shallower, blue deeper."
            }
            MapLayer::Track => "The boat's track, coloured by depth.",
            MapLayer::Boxes => "Objects on the bottom, marked by what was decided about them.",
        }
    }
}

/// Display state of a layer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LayerShown {
    /// The layer.
    pub layer: MapLayer,
    /// True if the layer is drawn.
    pub visible: bool,
    /// Opacity, 0 (invisible) to 1 (opaque).
    pub opacity: f32,
}

impl LayerShown {
    fn at_first(layer: MapLayer) -> Self {
        Self {
            layer,
            // A mosaic hides the depths below it; points and residuals are for a closer look.
            visible: !matches!(layer, MapLayer::Mosaic | MapLayer::Points | MapLayer::Residuals),
            opacity: 1.0,
        }
    }
}

/// The layers of the map, each once, bottom first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "Vec<LayerShown>", into = "Vec<LayerShown>")]
pub struct LayerStack {
    layers: Vec<LayerShown>,
}

impl Default for LayerStack {
    fn default() -> Self {
        Self { layers: MapLayer::ALL.map(LayerShown::at_first).to_vec() }
    }
}

impl From<LayerStack> for Vec<LayerShown> {
    fn from(stack: LayerStack) -> Self {
        stack.layers
    }
}

impl From<Vec<LayerShown>> for LayerStack {
    /// Drops repeated layers, and inserts missing layers above the layers that are below them in
    /// the initial order.
    fn from(saved: Vec<LayerShown>) -> Self {
        let mut layers: Vec<LayerShown> = Vec::with_capacity(MapLayer::ALL.len());
        for shown in saved {
            if layers.iter().all(|other| other.layer != shown.layer) {
                let opacity =
                    if shown.opacity.is_finite() { shown.opacity.clamp(0.0, 1.0) } else { 1.0 };
                layers.push(LayerShown { opacity, ..shown });
            }
        }
        let mut below = 0;
        for layer in MapLayer::ALL {
            match layers.iter().position(|shown| shown.layer == layer) {
                Some(place) => below = place + 1,
                None => {
                    layers.insert(below, LayerShown::at_first(layer));
                    below += 1;
                }
            }
        }
        Self { layers }
    }
}

impl LayerStack {
    /// Returns the layers, bottom first.
    pub fn bottom_up(&self) -> impl DoubleEndedIterator<Item = &LayerShown> {
        self.layers.iter()
    }

    /// Returns the display state of a layer.
    pub fn of(&self, layer: MapLayer) -> LayerShown {
        let found = self.layers.iter().find(|shown| shown.layer == layer);
        found.copied().unwrap_or(LayerShown::at_first(layer))
    }

    /// Returns true if a layer is drawn and not fully transparent.
    pub fn is_visible(&self, layer: MapLayer) -> bool {
        let shown = self.of(layer);
        shown.visible && shown.opacity > 0.0
    }

    /// Shows or hides a layer.
    pub fn set_visible(&mut self, layer: MapLayer, visible: bool) {
        self.change(layer, |shown| shown.visible = visible);
    }

    /// Shows a hidden layer, or hides a shown one.
    pub fn toggle(&mut self, layer: MapLayer) {
        self.change(layer, |shown| shown.visible = !shown.visible);
    }

    /// Sets the opacity of a layer, 0 to 1.
    pub fn set_opacity(&mut self, layer: MapLayer, opacity: f32) {
        self.change(layer, |shown| shown.opacity = opacity.clamp(0.0, 1.0));
    }

    /// Moves a layer above the layer that covers it.
    pub fn raise(&mut self, layer: MapLayer) {
        if let Some(place) = self.place(layer)
            && place + 1 < self.layers.len()
        {
            self.layers.swap(place, place + 1);
        }
    }

    /// Moves a layer below the layer under it.
    pub fn lower(&mut self, layer: MapLayer) {
        if let Some(place) = self.place(layer)
            && place > 0
        {
            self.layers.swap(place, place - 1);
        }
    }

    fn place(&self, layer: MapLayer) -> Option<usize> {
        self.layers.iter().position(|shown| shown.layer == layer)
    }

    fn change(&mut self, layer: MapLayer, change: impl FnOnce(&mut LayerShown)) {
        if let Some(shown) = self.layers.iter_mut().find(|shown| shown.layer == layer) {
            change(shown);
        }
    }
}

/// Side of the divider on which a layer is drawn while the map is divided.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SwipeSide {
    /// Both sides.
    #[default]
    Both,
    /// Left of the divider only.
    Left,
    /// Right of the divider only.
    Right,
}

bathyscope_log::named! {
    /// All sides in the order of the menu.
    pub SwipeSide {
        Left: "left",
        Both: "both",
        Right: "right",
    }
}

/// The division of the map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Swipe {
    /// True if the map is divided.
    pub on: bool,
    /// Position of the divider, as a share of the map's width.
    pub share: f32,
    /// Layers that are drawn on one side only.
    sides: Vec<(MapLayer, SwipeSide)>,
}

impl Default for Swipe {
    /// Creates an undivided map, whose division shows the mosaic on the left and the depths on the
    /// right.
    fn default() -> Self {
        Self {
            on: false,
            share: 0.5,
            sides: vec![
                (MapLayer::Mosaic, SwipeSide::Left),
                (MapLayer::DepthMap, SwipeSide::Right),
                (MapLayer::HillShade, SwipeSide::Right),
            ],
        }
    }
}

impl Swipe {
    /// Returns the side of the divider on which a layer is drawn.
    pub fn side(&self, layer: MapLayer) -> SwipeSide {
        let found = self.sides.iter().find(|(other, _)| *other == layer);
        found.map_or(SwipeSide::Both, |(_, side)| *side)
    }

    /// Draws a layer on `side` from now on.
    pub(crate) fn set_side(&mut self, layer: MapLayer, side: SwipeSide) {
        self.sides.retain(|(other, _)| *other != layer);
        if side != SwipeSide::Both {
            self.sides.push((layer, side));
        }
    }

    /// Moves the divider by a share of the map's width, within the map.
    pub fn shift(&mut self, by: f32) {
        self.share = if self.share.is_finite() { (self.share + by).clamp(0.02, 0.98) } else { 0.5 };
    }

    /// Divides the map, or makes it whole. If no layer of a side is visible, the first layer of
    /// that side is shown.
    pub fn toggle(&mut self, stack: &mut LayerStack) {
        self.on = !self.on;
        for side in [SwipeSide::Left, SwipeSide::Right] {
            let own = || self.sides.iter().filter(|(_, other)| *other == side);
            let seen = own().any(|(layer, _)| stack.is_visible(*layer));
            if let (true, false, Some((layer, _))) = (self.on, seen, own().next()) {
                stack.set_visible(*layer, true);
            }
        }
    }
}

impl App {
    /// Opens the base map that was open when the window was last closed; notifies the analyst if
    /// its file is missing.
    pub(crate) fn reopen_base_map(&mut self, path: PathBuf) {
        if path.is_file() {
            self.open_base_map(path, true);
        } else {
            let text = format!("The base map that was open last is missing: {}", path.display());
            self.notices.notify(text);
        }
    }

    /// Starts opening a base map, which the analyst asked for now or in the last session; the
    /// opening of an earlier one is dropped.
    pub(super) fn open_base_map(&mut self, path: PathBuf, is_of_last_time: bool) {
        // The file must be found again in whatever folder the next run starts.
        let path = std::path::absolute(&path).unwrap_or(path);
        self.jobs.run(
            JobKey::OpenBaseMap,
            move |progress| base_map::open(&path, progress),
            move |app, opened| match opened {
                // A base map of the last session stays shown or hidden, without a notice.
                Ok(map) if is_of_last_time => app.map.base_map = Some(Arc::new(map)),
                Ok(map) => {
                    app.notices.notify(words_about(&map, app.logs.shown.survey.as_deref()));
                    app.view.options.map.layers.set_visible(MapLayer::BaseMap, true);
                    app.map.base_map = Some(Arc::new(map));
                }
                Err(error) if is_of_last_time => app.notices.notify(error),
                Err(error) => app.notices.warn(error),
            },
        );
    }

    /// Removes the base map.
    pub(super) fn close_base_map(&mut self) {
        self.map.base_map = None;
        self.jobs.stop(&JobKey::OpenBaseMap);
    }

    /// Starts reading an area; the reading of an earlier one is dropped.
    pub(super) fn open_isobath_area(&mut self, path: PathBuf) {
        // The settings must hold a path that is valid in whatever folder the next run starts.
        let path = std::path::absolute(&path).unwrap_or(path);
        self.jobs.run(
            JobKey::ReadArea,
            move |_| read_area(&path),
            |app, read| match read {
                Ok(area) => app.set_isobath_area(Some(area)),
                Err(error) => app.notices.warn(error),
            },
        );
    }

    /// Removes the area, so that isobaths are shown wherever there are depths.
    pub(super) fn remove_isobath_area(&mut self) {
        self.jobs.stop(&JobKey::ReadArea);
        self.set_isobath_area(None);
    }

    fn set_isobath_area(&mut self, area: Option<WaterArea>) {
        self.edit_settings("isobath area", |settings| {
            settings.isobaths.clip = area.as_ref().map(|area| area.path.clone());
            settings.isobaths.area = area.map(Arc::new);
        });
    }
}

/// Returns the notice about an opened base map: its size, its coordinate system, its path, and
/// a remark if it does not reach the start of `survey`.
fn words_about(map: &BaseMap, survey: Option<&Survey>) -> String {
    let [columns, rows] = map.size;
    let pixel_m = map.pixel_m();
    let mut text = format!(
        "Opened the base map of {columns} by {rows} pixels of {pixel_m:.2} m, {}",
        map.place.crs
    );
    let start = survey.map(|survey| survey.track.frame.origin());
    if start.is_some_and(|start| !map.covers(start)) {
        text += ", which does not reach the start of this survey";
    }
    format!("{text}: {}", map.path.display())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn order(stack: &LayerStack) -> Vec<MapLayer> {
        stack.bottom_up().map(|shown| shown.layer).collect()
    }

    #[test]
    fn layers_move_past_each_other_and_not_out_of_the_stack() {
        let mut stack = LayerStack::default();
        let [bottom, next, ..] = MapLayer::ALL;
        stack.raise(bottom);
        assert_eq!(order(&stack)[..2], [next, bottom], "one up");
        stack.lower(bottom);
        stack.lower(bottom);
        assert_eq!(order(&stack), MapLayer::ALL, "and down to the bottom");
    }

    #[test]
    fn a_saved_stack_comes_back_and_an_odd_one_is_put_right() {
        let mut stack = LayerStack::default();
        stack.raise(MapLayer::DepthMap);
        stack.set_opacity(MapLayer::Track, 0.25);
        stack.toggle(MapLayer::Boxes);
        let text = serde_json::to_string(&stack).unwrap();
        assert_eq!(serde_json::from_str::<LayerStack>(&text).unwrap(), stack);
        let odd = r#"[{"layer":"track","visible":false,"opacity":7.0},
                      {"layer":"track","visible":true,"opacity":1.0}]"#;
        let stack: LayerStack = serde_json::from_str(odd).unwrap();
        assert_eq!(order(&stack).len(), MapLayer::ALL.len());
        let track = stack.of(MapLayer::Track);
        assert_eq!((track.visible, track.opacity), (false, 1.0));
        assert_eq!(order(&stack)[0], MapLayer::ALL[0]);
    }

    #[test]
    fn a_divided_map_shows_something_else_on_either_side() {
        let mut stack = LayerStack::default();
        for layer in MapLayer::ALL {
            stack.set_visible(layer, false);
        }
        let mut swipe = Swipe::default();
        swipe.toggle(&mut stack);
        assert!(
            swipe.on && stack.is_visible(MapLayer::Mosaic) && stack.is_visible(MapLayer::DepthMap)
        );
        assert!(!stack.is_visible(MapLayer::HillShade), "one of them is enough");
        swipe.toggle(&mut stack);
        assert!(!swipe.on);
    }

    #[test]
    fn a_layer_lies_on_the_side_it_was_put_on() {
        let mut swipe = Swipe::default();
        assert_eq!(swipe.side(MapLayer::Track), SwipeSide::Both);
        swipe.set_side(MapLayer::Track, SwipeSide::Right);
        swipe.set_side(MapLayer::Track, SwipeSide::Left);
        assert_eq!(swipe.side(MapLayer::Track), SwipeSide::Left);
        swipe.set_side(MapLayer::Track, SwipeSide::Both);
        assert_eq!(swipe.side(MapLayer::Track), SwipeSide::Both);
        for by in [5.0, -9.0] {
            swipe.shift(by);
            assert!((0.0..=1.0).contains(&swipe.share));
        }
        let text = serde_json::to_string(&swipe).unwrap();
        assert_eq!(serde_json::from_str::<Swipe>(&text).unwrap(), swipe);
    }
}
