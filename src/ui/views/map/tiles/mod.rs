//! Paints a layer of the map in tiles, in a background thread: the visible part, as finely as the
//! screen shows it.
//!
//! Input: the painter of the tiles, and the visible part of the map. Output: tiles on the screen.
//!
//! The work grows with the size of the screen, the memory is bounded, and until a tile is painted a
//! coarser one replaces it, or the same tile as painted before its settings changed.

mod key;

pub(crate) use key::{MapTileKey, SIDE, Warp};

use super::transform::{GroundBounds, MapTransform};
use crate::app::{Jobs, Task, TaskOutcome};
use bathyscope_bottom::waterfall::Lru;
use bathyscope_log::support::progress::Progress;
use egui::{
    Color32, ColorImage, Mesh, Painter, Pos2, Rect, Shape, TextureHandle, TextureOptions, lerp,
};
use std::sync::Arc;

/// Bytes of textures that a layer keeps besides those on the screen.
const BUDGET: usize = 48 << 20;
/// Number of tiles painted at once.
const WORKERS: usize = 2;
/// Bytes of an entry without a picture.
const EMPTY: usize = 64;
/// Number of blocks along a side of a picture.
const BLOCKS: usize = 8;

/// Painter of the tiles of a layer.
pub(super) trait TilePainter: Send + Sync {
    /// Returns west, south, east and north of everything that can be painted, metres.
    fn bounds(&self) -> GroundBounds;

    /// Returns the finest level worth painting: finer ones show nothing more.
    fn finest(&self) -> i8;

    /// Returns [`SIDE`] rows of as many colours, from the north-west corner of the tile with its
    /// border; `None` if the tile is empty or when cancelled.
    fn paint(&self, key: MapTileKey, progress: &Progress) -> Option<Vec<Color32>>;
}

/// A tile as it was last painted; without a texture if it is empty.
struct PaintedTile {
    texture: Option<(TextureHandle, Occupied)>,
    generation: u64,
}

struct Running {
    key: MapTileKey,
    generation: u64,
    task: Task<Option<(ColorImage, Occupied)>>,
}

/// The tiles of a layer, and the work in progress.
pub(super) struct TileLayer {
    name: &'static str,
    source: Option<Arc<dyn TilePainter>>,
    /// Number of the present source; grows with every new source.
    generation: u64,
    cache: Lru<MapTileKey, PaintedTile>,
    running: Vec<Running>,
    /// Number of visible tiles that are final, and of all visible tiles.
    ready: [usize; 2],
}

impl TileLayer {
    /// Creates an empty layer.
    pub(super) fn new(name: &'static str) -> Self {
        Self {
            name,
            source: None,
            generation: 0,
            cache: Lru::new(BUDGET),
            running: Vec::new(),
            ready: [0; 2],
        }
    }

    /// Makes `source` paint from now on; tiles of the former source stay on the screen until the
    /// new ones are painted. `None` empties the layer.
    pub(super) fn set_source(&mut self, source: Option<Arc<dyn TilePainter>>) {
        let same = match (&self.source, &source) {
            (Some(old), Some(new)) => std::ptr::addr_eq(Arc::as_ptr(old), Arc::as_ptr(new)),
            (None, None) => true,
            _ => false,
        };
        if !same {
            self.generation += 1;
            self.running.clear();
            if source.is_none() {
                self.cache = Lru::new(BUDGET);
            }
            self.source = source;
        }
    }

    /// Stops painting while the layer is not shown.
    pub(super) fn rest(&mut self) {
        self.running.clear();
        self.ready = [0; 2];
    }

    /// Returns true if every visible tile is final.
    pub(super) fn is_settled(&self) -> bool {
        self.running.is_empty() && self.ready[0] == self.ready[1]
    }

    /// Returns the number of visible tiles that are not final yet, and of all visible tiles.
    pub(super) fn missing(&self) -> [usize; 2] {
        [self.ready[1] - self.ready[0], self.ready[1]]
    }

    /// Returns the bounds of everything that can be painted, metres; `None` without a source.
    pub(super) fn bounds(&self) -> Option<GroundBounds> {
        self.source.as_ref().map(|source| source.bounds())
    }

    /// Draws the tiles that are ready, and starts to paint the others.
    pub(super) fn show(
        &mut self,
        painter: &Painter,
        rect: Rect,
        transform: MapTransform,
        jobs: &Jobs,
    ) {
        let Some(source) = self.source.clone() else {
            return self.rest();
        };
        self.cache.begin_frame();
        self.collect(painter.ctx());
        let (all, view) = (source.bounds(), transform.visible(rect));
        let pixel_m = transform.metres_per_point / f64::from(painter.pixels_per_point());
        let level = key::level_for(pixel_m).max(source.finest());
        let seen = key::tiles(level, view, all);
        let overview = key::overview_level(all);
        let mut requested = Vec::new();
        if overview > level {
            // Shows something at once, wherever the view moves next.
            requested.extend(key::tiles(overview, view, all));
        }
        requested.extend(&seen);
        requested.retain(|key| !self.is_fresh(*key));
        self.order(&source, requested, painter.ctx(), jobs);
        let at = |east_m: f64, north_m: f64| transform.to_screen(rect, [east_m, north_m]);
        for key in &seen {
            self.draw(painter, *key, overview.max(level), at);
        }
        let ready = seen.iter().filter(|key| self.is_fresh(**key)).count();
        self.ready = [ready, seen.len()];
    }

    fn is_fresh(&self, key: MapTileKey) -> bool {
        let resident = self.cache.peek(&key);
        resident.is_some_and(|resident| resident.generation == self.generation)
    }

    /// Stores the tiles that are ready. A tile whose painting failed counts as empty: another
    /// attempt would fail, too.
    fn collect(&mut self, context: &egui::Context) {
        let mut index = 0;
        while index < self.running.len() {
            let painted = match self.running[index].task.poll() {
                TaskOutcome::Pending => {
                    index += 1;
                    continue;
                }
                TaskOutcome::Done(painted) => painted,
                TaskOutcome::Failed => None,
            };
            let done = self.running.swap_remove(index);
            self.keep(context, &done, painted);
        }
    }

    fn keep(
        &mut self,
        context: &egui::Context,
        done: &Running,
        painted: Option<(ColorImage, Occupied)>,
    ) {
        let texture = painted.map(|(image, occupied)| {
            let texture = context.load_texture(self.name, image, TextureOptions::LINEAR);
            (texture, occupied)
        });
        let bytes = match texture {
            Some(_) => SIDE * SIDE * size_of::<Color32>(),
            None => EMPTY,
        };
        let resident = PaintedTile { texture, generation: done.generation };
        self.cache.insert(done.key, resident, bytes);
    }

    /// Starts to paint the first of the requested tiles; cancels those that are no longer
    /// requested.
    fn order(
        &mut self,
        source: &Arc<dyn TilePainter>,
        requested: Vec<MapTileKey>,
        context: &egui::Context,
        jobs: &Jobs,
    ) {
        self.running.retain(|running| requested.contains(&running.key));
        for key in requested {
            if self.running.len() >= WORKERS {
                break;
            }
            if self.running.iter().any(|running| running.key == key) {
                continue;
            }
            let source = source.clone();
            let task = Task::start(jobs, move |progress| {
                let colours = source.paint(key, progress)?;
                (colours.len() == SIDE * SIDE).then(|| {
                    let image = ColorImage::new([SIDE, SIDE], colours);
                    let occupied = Occupied::of(&image);
                    (image, occupied)
                })
            });
            self.running.push(Running { key, generation: self.generation, task });
            // Jobs that run inside the call have already ended.
            self.collect(context);
        }
    }

    /// Draws the tile itself, of any generation, or else the finest of the coarser tiles that cover
    /// it.
    fn draw(
        &mut self,
        painter: &Painter,
        key: MapTileKey,
        coarsest: i8,
        at: impl Fn(f64, f64) -> Pos2,
    ) {
        let mut shown = key;
        while self.cache.peek(&shown).is_none() {
            if shown.level >= coarsest {
                return;
            }
            shown = shown.parent();
        }
        let Some((texture, occupied)) =
            self.cache.use_now(&shown).and_then(|tile| tile.texture.as_ref())
        else {
            return;
        };
        let [west, south, east, north] = key.bounds();
        let [left, top, right, bottom] = key.part_of(shown);
        let whole = Rect::from_min_max(at(west, north), at(east, south));
        let on_screen = |x: f32, y: f32| {
            let across = (x - left) / (right - left);
            let down = (y - top) / (bottom - top);
            Pos2::new(lerp(whole.x_range(), across), lerp(whole.y_range(), down))
        };
        let mut mesh = Mesh::with_texture(texture.id());
        for [left, top, right, bottom] in occupied.parts_in([left, top, right, bottom]) {
            mesh.add_rect_with_uv(
                Rect::from_min_max(on_screen(left, top), on_screen(right, bottom)),
                Rect::from_min_max(Pos2::new(left, top), Pos2::new(right, bottom)),
                Color32::WHITE,
            );
        }
        painter.add(Shape::mesh(mesh));
    }
}

/// A part of a picture: left, top, right and bottom as shares.
type PicturePart = [f32; 4];

/// The blocks of a tile's picture that are not empty, a bit each, row by row: most of a tile along
/// a track is empty, and empty blocks are not drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Occupied(u64);

impl Occupied {
    /// Returns the blocks of a picture that are not transparent, or that a texel of a neighbouring
    /// block reaches into when the picture is magnified.
    fn of(image: &ColorImage) -> Self {
        let [width, height] = image.size;
        let mut bits = 0;
        for (y, row) in image.pixels.chunks(width.max(1)).enumerate() {
            for (x, texel) in row.iter().enumerate() {
                if texel.a() == 0 {
                    continue;
                }
                let block = |place: usize, side: usize| place.min(side - 1) * BLOCKS / side;
                for y in [y.saturating_sub(1), y + 1] {
                    for x in [x.saturating_sub(1), x + 1] {
                        bits |= 1 << (BLOCKS * block(y, height) + block(x, width));
                    }
                }
            }
        }
        Self(bits)
    }

    /// Returns the rectangles to draw in a part of the picture: one for each run of blocks in a
    /// row.
    fn parts_in(self, [left, top, right, bottom]: PicturePart) -> Vec<PicturePart> {
        let mut parts = Vec::new();
        if self.0 == u64::MAX {
            parts.push([left, top, right, bottom]);
            return parts;
        }
        let share = |block: usize| block as f32 / BLOCKS as f32;
        for row in 0..BLOCKS {
            let [top, bottom] = [top.max(share(row)), bottom.min(share(row + 1))];
            let mut column = 0;
            while column < BLOCKS {
                let end = (column..BLOCKS).find(|column| !self.holds(row, *column));
                let end = end.unwrap_or(BLOCKS);
                let [from, to] = [left.max(share(column)), right.min(share(end))];
                if from < to && top < bottom {
                    parts.push([from, top, to, bottom]);
                }
                column = end + 1;
            }
        }
        parts
    }

    fn holds(self, row: usize, column: usize) -> bool {
        self.0 >> (BLOCKS * row + column) & 1 == 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// A painter of one colour everywhere, over 100 by 100 m, that counts the painted tiles.
    struct Plain {
        colour: Color32,
        painted: AtomicUsize,
    }

    impl Plain {
        fn new(colour: Color32) -> Arc<Self> {
            Arc::new(Self { colour, painted: AtomicUsize::new(0) })
        }

        fn painted(&self) -> usize {
            self.painted.load(Ordering::Relaxed)
        }
    }

    impl TilePainter for Plain {
        fn bounds(&self) -> GroundBounds {
            [0.0, 0.0, 100.0, 100.0]
        }

        fn finest(&self) -> i8 {
            -6
        }

        fn paint(&self, _key: MapTileKey, _progress: &Progress) -> Option<Vec<Color32>> {
            self.painted.fetch_add(1, Ordering::Relaxed);
            Some(vec![self.colour; SIDE * SIDE])
        }
    }

    /// Shows a layer in a view of 400 by 300 points; returns the number of textured meshes drawn.
    fn show(layer: &mut TileLayer, centre_m: [f64; 2], metres_per_point: f64) -> usize {
        let context = egui::Context::default();
        let rect = Rect::from_min_size(Pos2::ZERO, egui::vec2(400.0, 300.0));
        let transform = MapTransform { centre_m, metres_per_point };
        let input = egui::RawInput { screen_rect: Some(rect), ..Default::default() };
        let output = context.run_ui(input, |ui| {
            layer.show(&ui.painter_at(rect), rect, transform, &Jobs::Inline);
        });
        let is_tile =
            |shape: &Shape| matches!(shape, Shape::Mesh(mesh) if mesh.vertices.len() == 4);
        let shapes = output.shapes.iter();
        shapes.filter(|clipped| is_tile(&clipped.shape)).count()
    }

    #[test]
    fn only_what_is_in_view_is_painted_and_only_once() {
        let source = Plain::new(Color32::RED);
        let mut layer = TileLayer::new("plain");
        layer.set_source(Some(source.clone()));
        // Tiles of 4 m at 1/64 m a texel; the view of 6.25 m by 4.7 m has at most 3 by 3 of them,
        // and the overview is one tile.
        let drawn = show(&mut layer, [50.0, 50.0], 1.0 / 64.0);
        let painted = source.painted();
        assert!((4..=9).contains(&drawn) && painted == drawn + 1, "{drawn} {painted}");
        assert!(layer.is_settled());
        assert_eq!(show(&mut layer, [50.0, 50.0], 1.0 / 64.0), drawn);
        assert_eq!(source.painted(), painted, "nothing is painted again");
        assert_eq!(show(&mut layer, [500.0, 50.0], 1.0 / 64.0), 0, "nothing is there");
        assert_eq!(source.painted(), painted);
    }

    #[test]
    fn another_source_paints_anew_and_none_empties_the_layer() {
        let (red, blue) = (Plain::new(Color32::RED), Plain::new(Color32::BLUE));
        let mut layer = TileLayer::new("plain");
        layer.set_source(Some(red.clone()));
        let drawn = show(&mut layer, [50.0, 50.0], 0.25);
        layer.set_source(Some(blue.clone()));
        assert_eq!(show(&mut layer, [50.0, 50.0], 0.25), drawn);
        assert_eq!(blue.painted(), red.painted());
        layer.set_source(None);
        assert_eq!(show(&mut layer, [50.0, 50.0], 0.25), 0);
        assert!(layer.is_settled());
    }

    fn with(texels: &[[usize; 2]]) -> Occupied {
        let mut image = ColorImage::filled([80, 80], Color32::TRANSPARENT);
        for [x, y] in texels {
            image.pixels[80 * y + x] = Color32::WHITE;
        }
        Occupied::of(&image)
    }

    #[test]
    fn nothing_is_drawn_of_an_empty_picture_and_all_of_a_full_one_at_once() {
        let whole = [0.0, 0.0, 1.0, 1.0];
        assert_eq!(with(&[]).parts_in(whole), Vec::<PicturePart>::new());
        let full = Occupied::of(&ColorImage::filled([80, 80], Color32::WHITE));
        assert_eq!(full.parts_in(whole), [whole]);
    }

    #[test]
    fn blocks_in_a_row_are_one_part_and_a_part_is_cut_to_what_is_asked_for() {
        // Texels in blocks 2 and 3 of row 1, and on the lower edge of block 7 of row 7.
        let some = with(&[[25, 15], [35, 15], [75, 79]]);
        let whole = some.parts_in([0.0, 0.0, 1.0, 1.0]);
        assert_eq!(whole, [[0.25, 0.125, 0.5, 0.25], [0.875, 0.875, 1.0, 1.0]]);
        let quarter = some.parts_in([0.3, 0.0, 0.4, 0.2]);
        assert_eq!(quarter, [[0.3, 0.125, 0.4, 0.2]]);
    }

    #[test]
    fn a_texel_at_the_edge_of_a_block_occupies_its_neighbour_too() {
        let whole = [0.0, 0.0, 1.0, 1.0];
        assert_eq!(with(&[[9, 15]]).parts_in(whole), [[0.0, 0.125, 0.25, 0.25]]);
    }
}
