//! Computes the layers of the map in a background thread when they are shown, and draws them in the
//! order of the stack.

use super::MapScene;
use super::dots::{self, PointKey, ResidualLayer};
use super::grid_tiles::{BaseMapKey, DepthTiles, MosaicTiles, ShadeTiles, base_tiles};
use super::isobaths::{self, IsobathLabels, IsobathLayer};
use super::lines::LinePicture;
use super::objects;
use super::tiles::{TileLayer, TilePainter};
use super::track::{self, TrackLayer};
use super::transform::{GroundBounds, joined};
use crate::app::{DrawnIsobaths, JobKey, LayerStack, MapLayer, VisibleLog};
use crate::ui::ViewContext;
use bathyscope_bottom::mosaic::{Colours, MosaicSettings};
use bathyscope_bottom::presentation::units::Units;
use bathyscope_log::survey::Survey;
use bathyscope_products::pipeline::{Agreement, DepthMap, Mosaic, Products};
use bathyscope_products::pipeline::{Background, Same};
use egui::Painter;
use std::sync::Arc;

/// Duration above which work is announced, seconds.
const PATIENCE_S: f64 = 0.5;

/// Painter of the tiles of a layer.
type PaintedBy = Arc<dyn TilePainter>;
/// Painter of the tiles of a layer; `None` if there is nothing to paint.
type LayerSource = Option<PaintedBy>;

/// Sources of the layers of one map, where these are ready.
pub(super) struct Layers {
    base_map: Background<BaseMapKey, Arc<dyn TilePainter>>,
    /// Tiles of depths and of hill-shade, with the depth map that they are painted from.
    depths: Option<(Arc<DepthMap>, [PaintedBy; 2])>,
    /// Tiles of the mosaic, with the mosaic and the colours that they are painted from.
    mosaic: Option<(Arc<Mosaic>, Colours, PaintedBy)>,
    points: Background<PointKey, LayerSource>,
    residuals: Background<Same<Agreement>, Option<Arc<ResidualLayer>>>,
    /// True if residuals are shown and points are still being compared for them.
    comparing: bool,
    tiles: [(MapLayer, TileLayer); 6],
    isobaths: Background<(Same<DrawnIsobaths>, Units), Arc<IsobathLayer>>,
    /// Descriptions of the products of all logs that are being computed.
    deriving: Vec<&'static str>,
    labels: Background<(Same<IsobathLayer>, i32), IsobathLabels>,
    isobath_picture: LinePicture<IsobathLayer>,
    track: LinePicture<TrackLayer>,
    /// Start of the present work, in the window's seconds; `None` while there is no work.
    busy_since_s: Option<f64>,
}

impl Default for Layers {
    fn default() -> Self {
        let tiles = [
            MapLayer::BaseMap,
            MapLayer::DepthMap,
            MapLayer::HillShade,
            MapLayer::Mosaic,
            MapLayer::Points,
            MapLayer::Residuals,
        ];
        Self {
            base_map: Background::default(),
            depths: None,
            mosaic: None,
            points: Background::default(),
            residuals: Background::default(),
            comparing: false,
            tiles: tiles.map(|layer| (layer, TileLayer::new(layer.name()))),
            isobaths: Background::default(),
            deriving: Vec::new(),
            labels: Background::default(),
            isobath_picture: LinePicture::default(),
            track: LinePicture::default(),
            busy_since_s: None,
        }
    }
}

impl Layers {
    /// Starts the work for the visible layers, unless it is done or in progress.
    pub(super) fn ask(
        &mut self,
        context: &ViewContext<'_>,
        survey: &Arc<Survey>,
        products: &Products,
        logs: &[VisibleLog],
    ) {
        let stack = &context.options().map.layers;
        self.deriving = context.app.deriving().collect();
        self.take_depths(context.app.depth_map().flatten());
        let settings = logs.first().map(|shown| &shown.log.products.settings.mosaic);
        self.take_mosaic(context.app.pipeline.deriving.mosaic().flatten().zip(settings));
        if stack.is_visible(MapLayer::Isobaths) {
            self.ask_for_isobaths(context);
        }
        if stack.is_visible(MapLayer::Points) {
            let (logs, options) = (logs.to_vec(), context.options().clone());
            let key = dots::point_key(&logs, &options);
            self.points.ask(key, context.app.jobs.workers(), move |progress| {
                dots::point_source(&logs, &options, progress)
            });
        }
        self.ask_for_residuals(context);
        self.ask_for_base_map(context, survey, products);
        self.give_sources(stack);
    }

    fn ask_for_residuals(&mut self, context: &ViewContext<'_>) {
        let is_shown = (context.options().map.layers).is_visible(MapLayer::Residuals);
        self.comparing = is_shown && context.app.jobs.is_running(&JobKey::CompareReference);
        let agreement =
            context.app.findings.reference_comparison.agreement().filter(|_| is_shown).cloned();
        match agreement {
            Some(agreement) => {
                let key = Same(agreement.clone());
                self.residuals.ask(key, context.app.jobs.workers(), move |progress| {
                    let layer = ResidualLayer::new(agreement, progress)?;
                    Some(layer.map(Arc::new))
                });
            }
            None if is_shown => self.residuals = Background::default(),
            None => {}
        }
    }

    fn ask_for_base_map(
        &mut self,
        context: &ViewContext<'_>,
        survey: &Arc<Survey>,
        products: &Products,
    ) {
        let Some(map) = &context.app.map.base_map else {
            self.base_map = Background::default();
            return;
        };
        let navigation = products.navigation.clone();
        let key = (Same(map.clone()), Same(survey.clone()), Same(navigation));
        let asked = key.clone();
        let jobs = context.app.jobs.workers();
        self.base_map.ask(key, jobs, |_| Some(base_tiles(asked)));
    }

    /// Makes the depth map the source of depths and hill-shade, if it is another one than before.
    fn take_depths(&mut self, depth_map: Option<&Arc<DepthMap>>) {
        let same = |(of, _): &(Arc<DepthMap>, _)| depth_map.is_some_and(|now| Arc::ptr_eq(of, now));
        if !self.depths.as_ref().is_some_and(same) {
            self.depths = depth_map.map(|depth_map| {
                let depths: PaintedBy = Arc::new(DepthTiles(depth_map.clone()));
                let shade: PaintedBy = Arc::new(ShadeTiles(depth_map.clone()));
                (depth_map.clone(), [depths, shade])
            });
        }
    }

    /// Makes the mosaic, in the colours of its settings, the source of its tiles.
    fn take_mosaic(&mut self, mosaic: Option<(&Arc<Mosaic>, &MosaicSettings)>) {
        let same = |(of, colours, _): &(Arc<Mosaic>, Colours, _)| {
            mosaic
                .is_some_and(|(now, settings)| Arc::ptr_eq(of, now) && *colours == settings.colours)
        };
        if !self.mosaic.as_ref().is_some_and(same) {
            self.mosaic = mosaic.map(|(mosaic, settings)| {
                let tiles: PaintedBy = Arc::new(MosaicTiles::new(mosaic.clone(), settings));
                (mosaic.clone(), settings.colours, tiles)
            });
        }
    }

    /// Sets the sources of all tiles; layers that are not shown stop painting.
    fn give_sources(&mut self, stack: &LayerStack) {
        let [depth, shade] = match &self.depths {
            Some((_, tiles)) => tiles.clone().map(Some),
            None => [None, None],
        };
        for (layer, tiles) in &mut self.tiles {
            tiles.set_source(match layer {
                MapLayer::BaseMap => self.base_map.result().cloned(),
                MapLayer::DepthMap => depth.clone(),
                MapLayer::HillShade => shade.clone(),
                MapLayer::Mosaic => self.mosaic.as_ref().map(|(.., tiles)| tiles.clone()),
                MapLayer::Residuals => {
                    let layer = self.residuals.result().cloned().flatten();
                    layer.map(|layer| layer.tiles())
                }
                _ => self.points.result().cloned().flatten(),
            });
            if !stack.is_visible(*layer) {
                tiles.rest();
            }
        }
    }

    fn ask_for_isobaths(&mut self, context: &ViewContext<'_>) {
        let Some(drawn) = context.app.pipeline.deriving.isobaths().cloned() else {
            self.isobaths = Background::default();
            return;
        };
        let units = context.units();
        let key = (Same(drawn.clone()), units);
        let uploader = context.uploader();
        self.isobaths.ask(key, context.app.jobs.workers(), move |progress| {
            IsobathLayer::new(&drawn, units, uploader.as_ref(), progress).map(Arc::new)
        });
    }

    /// Returns the isobaths; `None` while they are not shown or not ready.
    pub(super) fn isobaths(&self, stack: &LayerStack) -> Option<Arc<IsobathLayer>> {
        let shown = stack.is_visible(MapLayer::Isobaths);
        self.isobaths.result().filter(|_| shown).cloned()
    }

    /// Returns the residuals; `None` while they are not shown or not ready.
    pub(super) fn residuals(&self, stack: &LayerStack) -> Option<Arc<ResidualLayer>> {
        let shown = stack.is_visible(MapLayer::Residuals);
        self.residuals.result().filter(|_| shown).cloned().flatten()
    }

    /// Returns the bounds of some layers and of the track, without the base map, which may show a
    /// country.
    pub(super) fn extent(&self, layers: &[MapLayer], track: GroundBounds) -> GroundBounds {
        let counts = |layer: &MapLayer| *layer != MapLayer::BaseMap && layers.contains(layer);
        let tiles = self.tiles.iter().filter(|(layer, _)| counts(layer));
        let bounds = tiles.filter_map(|(_, tiles)| tiles.bounds());
        bounds.fold(track, joined)
    }

    /// Returns the number of visible tiles that are not painted yet, and of all visible tiles.
    pub(super) fn missing(&self) -> [usize; 2] {
        let tiles = self.tiles.iter().map(|(_, tiles)| tiles.missing());
        tiles.fold([0; 2], |[missing, all], [m, a]| [missing + m, all + a])
    }

    /// Returns true if everything visible is ready.
    pub(super) fn is_settled(&self) -> bool {
        self.making().is_empty()
            && !self.labels.is_running()
            && self.tiles.iter().all(|(_, tiles)| tiles.is_settled())
    }

    /// Drops the data of another survey.
    pub(super) fn forget(&mut self) {
        *self = Self {
            track: std::mem::take(&mut self.track),
            isobath_picture: std::mem::take(&mut self.isobath_picture),
            ..Self::default()
        };
    }

    /// Draws one layer, with the clip area and the opacity of the painter.
    pub(super) fn show(
        &mut self,
        painter: &Painter,
        context: &ViewContext<'_>,
        scene: &MapScene<'_>,
        layer: MapLayer,
    ) {
        match layer {
            MapLayer::Isobaths => self.show_isobaths(painter, context, scene),
            MapLayer::Track => {
                track::show(&mut self.track, painter, context.render_state, scene);
            }
            MapLayer::Boxes => objects::paint(painter, scene, context.app),
            MapLayer::BaseMap
            | MapLayer::DepthMap
            | MapLayer::HillShade
            | MapLayer::Mosaic
            | MapLayer::Points
            | MapLayer::Residuals => {
                let jobs = context.app.jobs.workers();
                for (_, tiles) in self.tiles.iter_mut().filter(|(of, _)| *of == layer) {
                    tiles.show(painter, scene.rect, scene.transform, jobs);
                }
            }
        }
    }

    fn show_isobaths(
        &mut self,
        painter: &Painter,
        context: &ViewContext<'_>,
        scene: &MapScene<'_>,
    ) {
        let Some(layer) = self.isobaths.result().cloned() else {
            return;
        };
        let octave = isobaths::octave(scene.transform.metres_per_point);
        let lines = layer.clone();
        let key = (Same(layer.clone()), octave);
        self.labels.ask(key, context.app.jobs.workers(), move |progress| {
            IsobathLabels::place(lines, octave, progress)
        });
        let (picture, labels) = (&mut self.isobath_picture, self.labels.result());
        let state = context.render_state;
        isobaths::show(picture, painter, state, scene, &layer, labels);
    }

    /// Describes the work that precedes the drawing.
    fn making(&self) -> Vec<&'static str> {
        let jobs = [
            (self.base_map.is_running(), "placing the base map"),
            (self.isobaths.is_running(), "drawing isobaths"),
            (self.points.is_running(), "sorting points"),
            (self.comparing, "comparing points"),
            (self.residuals.is_running(), "placing residuals"),
        ];
        let running = jobs.into_iter().filter(|(is_running, _)| *is_running);
        let derived = self.deriving.iter().copied();
        derived.chain(running.map(|(_, what)| what)).collect()
    }

    /// Describes the work in progress; `None` if there is none, or if it has lasted less than
    /// [`PATIENCE_S`].
    pub(super) fn under_way(&mut self, now_s: f64) -> Option<String> {
        if self.is_settled() {
            self.busy_since_s = None;
            return None;
        }
        let since_s = *self.busy_since_s.get_or_insert(now_s);
        if now_s - since_s < PATIENCE_S {
            return None;
        }
        let making = self.making().into_iter().map(str::to_owned);
        let painting = self.tiles.iter().filter_map(|(layer, tiles)| {
            let [missing, all] = tiles.missing();
            let name = layer.name().to_lowercase();
            (missing > 0).then(|| format!("{name}: {} of {all} tiles", all - missing))
        });
        let lines: Vec<String> = making.chain(painting).collect();
        (!lines.is_empty()).then(|| lines.join("\n"))
    }
}
