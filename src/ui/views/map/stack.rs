//! The layers of the map: made off the window's thread when they are shown, and drawn in the order of the stack.

use super::isobaths::{self, IsobathKey, IsobathLayer, Labels};
use super::layers::TrackLayer;
use super::lines::LinePicture;
use super::mosaic::{self, MosaicKey};
use super::objects;
use super::overlay::Scene;
use super::relief::{Relief, ReliefKey};
use super::tiles::{TileLayer, TileSource};
use super::track_picture;
use crate::app::{LayerStack, MapLayer};
use crate::pipeline::Products;
use crate::render::Uploader;
use crate::survey::Survey;
use crate::ui::ViewContext;
use crate::ui::views::background::{Background, Same};
use egui::Painter;
use std::sync::Arc;

/// What the layers of one map are drawn from.
pub struct Layers {
    relief: Background<ReliefKey, Arc<Relief>>,
    /// Whether something on the map is drawn or measured from `relief`; otherwise it may be older than its settings.
    relief_shown: bool,
    depth: TileLayer,
    shade: TileLayer,
    mosaic: Background<MosaicKey, Option<Arc<dyn TileSource>>>,
    mosaic_tiles: TileLayer,
    isobaths: Background<IsobathKey, Arc<IsobathLayer>>,
    labels: Background<(Same<IsobathLayer>, i32), Labels>,
    isobath_picture: LinePicture<IsobathLayer>,
    track: LinePicture<TrackLayer>,
    /// When something began to be under way, in the window's seconds.
    busy_since_s: Option<f64>,
}

/// Work that takes longer than this is told.
const PATIENCE_S: f64 = 0.5;

impl Default for Layers {
    fn default() -> Self {
        Self {
            relief: Background::default(),
            relief_shown: false,
            depth: TileLayer::new("depth map"),
            shade: TileLayer::new("hill-shade"),
            mosaic: Background::default(),
            mosaic_tiles: TileLayer::new("mosaic"),
            isobaths: Background::default(),
            labels: Background::default(),
            isobath_picture: LinePicture::default(),
            track: LinePicture::default(),
            busy_since_s: None,
        }
    }
}

impl Layers {
    /// Makes sure that what the visible layers need is there or under way.
    pub fn ask(&mut self, context: &ViewContext<'_>, survey: &Arc<Survey>, products: &Products) {
        let stack = &context.app.options.map.layers;
        let shows = |layers: &[MapLayer]| layers.iter().any(|layer| stack.is_visible(*layer));
        self.relief_shown = shows(&[MapLayer::DepthMap, MapLayer::HillShade, MapLayer::Isobaths])
            || context.app.measuring.shows_profile();
        if self.relief_shown {
            let key = ReliefKey::of(survey, products);
            let (survey, products) = (survey.clone(), products.clone());
            self.relief.ask(key, context.app.jobs(), move |progress| {
                Relief::new(&survey, &products, progress).map(Arc::new)
            });
        }
        let [depth, shade] = match self.relief.result() {
            Some(relief) => relief.tiles(),
            None => [None, None],
        };
        self.depth.set_source(depth);
        self.shade.set_source(shade);
        if shows(&[MapLayer::Mosaic]) {
            let key = MosaicKey::of(survey, products);
            let (survey, products) = (survey.clone(), products.clone());
            self.mosaic.ask(key, context.app.jobs(), move |progress| {
                mosaic::source(&survey, &products, progress)
            });
        }
        let made = self.mosaic.result().cloned().flatten();
        self.mosaic_tiles.set_source(made);
        if shows(&[MapLayer::Isobaths]) {
            self.ask_for_isobaths(context, products);
        }
        for (layer, tiles) in self.tiles() {
            if !stack.is_visible(layer) {
                tiles.rest();
            }
        }
    }

    fn ask_for_isobaths(&mut self, context: &ViewContext<'_>, products: &Products) {
        let made = self.relief.result().and_then(|relief| relief.made.clone());
        let Some(made) = made else {
            self.isobaths = Background::default();
            return;
        };
        let settings = products.settings.isobaths.clone();
        let key = IsobathKey {
            relief: Same(made.clone()),
            settings: settings.clone(),
        };
        let uploader = context
            .render_state
            .map(|state| Uploader::new(&state.device, &state.queue));
        self.isobaths.ask(key, context.app.jobs(), move |progress| {
            IsobathLayer::new(&made, &settings, uploader.as_ref(), progress).map(Arc::new)
        });
    }

    /// The isobaths, once they are drawn, while they are shown.
    pub fn isobaths(&self, stack: &LayerStack) -> Option<Arc<IsobathLayer>> {
        let shown = stack.is_visible(MapLayer::Isobaths);
        self.isobaths.result().filter(|_| shown).cloned()
    }

    fn show_isobaths(&mut self, painter: &Painter, context: &ViewContext<'_>, scene: &Scene<'_>) {
        let Some(layer) = self.isobaths.result().cloned() else {
            return;
        };
        let octave = isobaths::octave(scene.transform.metres_per_point);
        let lines = layer.clone();
        let key = (Same(layer.clone()), octave);
        self.labels.ask(key, context.app.jobs(), move |progress| {
            Labels::place(lines, octave, progress)
        });
        let (picture, labels) = (&mut self.isobath_picture, self.labels.result());
        isobaths::show(
            picture,
            painter,
            context.render_state,
            scene,
            &layer,
            labels,
        );
    }

    fn tiles(&mut self) -> [(MapLayer, &mut TileLayer); 3] {
        [
            (MapLayer::DepthMap, &mut self.depth),
            (MapLayer::HillShade, &mut self.shade),
            (MapLayer::Mosaic, &mut self.mosaic_tiles),
        ]
    }

    /// Whether everything visible is there.
    pub fn is_settled(&self) -> bool {
        let making =
            self.relief.is_running() || self.isobaths.is_running() || self.mosaic.is_running();
        !making && !self.labels.is_running() && self.depth.is_settled() && self.shade.is_settled()
    }

    /// Drops what belongs to another survey.
    pub fn forget(&mut self) {
        *self = Self {
            track: std::mem::take(&mut self.track),
            ..Self::default()
        };
    }

    /// Draws one layer, clipped and faded as the painter is.
    pub fn show(
        &mut self,
        painter: &Painter,
        context: &ViewContext<'_>,
        scene: &Scene<'_>,
        layer: MapLayer,
    ) {
        let jobs = context.app.jobs();
        match layer {
            MapLayer::DepthMap => self.depth.show(painter, scene.rect, scene.transform, jobs),
            MapLayer::HillShade => self.shade.show(painter, scene.rect, scene.transform, jobs),
            MapLayer::Mosaic => {
                let (rect, transform) = (scene.rect, scene.transform);
                self.mosaic_tiles.show(painter, rect, transform, jobs);
            }
            MapLayer::Isobaths => self.show_isobaths(painter, context, scene),
            MapLayer::Track => {
                track_picture::show(&mut self.track, painter, context.render_state, scene);
            }
            MapLayer::Boxes => objects::paint(painter, scene, context.app),
        }
    }

    /// The depth map, once it is made, while something of it is shown.
    pub fn relief(&self) -> Option<Arc<Relief>> {
        self.relief.result().filter(|_| self.relief_shown).cloned()
    }

    /// What is under way, in words, once it has taken longer than a moment.
    pub fn under_way(&mut self, now_s: f64) -> Option<String> {
        if self.is_settled() {
            self.busy_since_s = None;
            return None;
        }
        let since_s = *self.busy_since_s.get_or_insert(now_s);
        if now_s - since_s < PATIENCE_S {
            return None;
        }
        let mut lines = Vec::new();
        if self.relief.is_running() {
            lines.push("making the depth map".to_owned());
        }
        if self.mosaic.is_running() {
            lines.push("evening the mosaic's gain".to_owned());
        }
        if self.isobaths.is_running() {
            lines.push("drawing isobaths".to_owned());
        }
        for (layer, tiles) in self.tiles() {
            let [missing, all] = tiles.missing();
            if missing > 0 {
                let name = layer.name().to_lowercase();
                lines.push(format!("{name}: {} of {all} tiles", all - missing));
            }
        }
        (!lines.is_empty()).then(|| lines.join("\n"))
    }
}
