//! Draws a picture of a box, enlarged: the bottom around it in square pixels, in the orientation of
//! the waterfall.

use super::waterfall::outline;
use crate::app::{App, LogBox, OpenLog, Orientation, PIXEL_M, WaterfallOptions};
use bathyscope_bottom::presentation::colours::ColourMap;
use bathyscope_bottom::presentation::units::Units;
use bathyscope_log::survey::{Navigation, Side, Survey};
use bathyscope_objects::review::{Review, Reviewed};
use bathyscope_objects::{Mark, ObjectExtent, Raster, Rect as BoxRect, TILE_PX, level};
use bathyscope_products::pipeline::{Background, Same};
use egui::{ColorImage, Pos2, Rect, Response, Role, Sense, TextureHandle, Ui, Vec2, WidgetInfo};
use egui::{pos2, vec2};

/// Surroundings on each side of a box, as a share of its longer side, and the least width of the
/// surroundings, pixels of the raster.
const SURROUNDINGS: f32 = 0.35;
const LEAST_AROUND_PX: f32 = 14.0;
/// Least side of a picture, pixels: a box without surroundings cannot be judged.
const LEAST_PX: f32 = 64.0;
/// Longer side of a picture over its shorter one, at most.
const LONGEST: f32 = 2.6;

/// Inputs of a picture.
#[derive(Clone, PartialEq)]
pub(crate) struct ChipKey {
    pub survey: Same<Survey>,
    pub navigation: Same<Navigation>,
    pub mark: Mark,
    pub map: ColourMap,
    pub orientation: Orientation,
    /// True if later pings are to the left or above.
    pub flip: bool,
    /// True if starboard is the upper or left side.
    pub starboard_first: bool,
}

impl ChipKey {
    /// Creates the key of a box of a log; `None` while the log has no results.
    pub(crate) fn of(log: &OpenLog, mark: &Mark, shown: &WaterfallOptions) -> Option<Self> {
        Some(Self {
            survey: Same(log.survey.clone()?),
            navigation: Same(log.products.as_ref()?.navigation.clone()),
            mark: mark.clone(),
            map: shown.colour_map,
            orientation: shown.orientation,
            flip: log.settings.picture.flip,
            starboard_first: log.settings.picture.starboard_first,
        })
    }

    fn turned(&self) -> Turned {
        Turned {
            orientation: self.orientation,
            flip: self.flip,
            is_first: (self.mark.side == Side::Port) != self.starboard_first,
        }
    }
}

/// Rotation of a raster's picture (range to the right, time downward) into the orientation in which
/// the waterfall shows its side.
#[derive(Clone, Copy)]
struct Turned {
    orientation: Orientation,
    /// True if later pings are to the left or above.
    flip: bool,
    /// True if the side is the upper or left one: range then grows upward or to the left.
    is_first: bool,
}

impl Turned {
    /// Returns the place of a point of the raster in the turned picture; both as shares of the
    /// picture.
    fn share(self, range: f32, time: f32) -> Pos2 {
        let across = if self.is_first { 1.0 - range } else { range };
        let time = if self.flip { 1.0 - time } else { time };
        match self.orientation {
            Orientation::Horizontal => pos2(time, across),
            Orientation::Vertical => pos2(across, time),
        }
    }

    /// Describes the directions in which range grows and time runs.
    fn words(self) -> String {
        let sideways = |to_left: bool| {
            if to_left { "to the left" } else { "to the right" }
        };
        let upright = |up: bool| if up { "up" } else { "down" };
        let (range, time) = match self.orientation {
            Orientation::Horizontal => (upright(self.is_first), sideways(self.flip)),
            Orientation::Vertical => (sideways(self.is_first), upright(self.flip)),
        };
        format!("range {range}, time {time}")
    }
}

/// Columns and rows of the raster that a picture shows.
struct ChipWindow {
    column: usize,
    row: usize,
    columns: usize,
    rows: usize,
}

impl ChipWindow {
    /// Returns width and height of the box with its surroundings, pixels; neither side is more than
    /// [`LONGEST`] times the other.
    fn around(rect: &BoxRect) -> [f32; 2] {
        let [width, height] = [rect.x1 - rect.x0, rect.y1 - rect.y0];
        let around = (SURROUNDINGS * width.max(height)).max(LEAST_AROUND_PX);
        let [width, height] = [width, height].map(|side| (side + 2.0 * around).max(LEAST_PX));
        let least = width.max(height) / LONGEST;
        [width.max(least), height.max(least)]
    }

    fn new(raster: &Raster, mark: &Mark) -> Self {
        let rect = raster.rect_of(mark);
        let [width, height] = Self::around(&rect).map(|side| side.min(TILE_PX as f32));
        let start = |from: f32, to: f32, size: f32| (0.5 * (from + to - size)).max(0.0) as usize;
        Self {
            column: start(rect.x0, rect.x1, width),
            row: start(rect.y0, rect.y1, height),
            columns: width as usize,
            rows: height as usize,
        }
    }
}

/// A picture of a box with its surroundings. Copies share the texture.
#[derive(Clone)]
pub(crate) struct BoxChip {
    texture: TextureHandle,
    /// Width and height, pixels.
    size: Vec2,
    /// The box as shares of the picture of the raster: range and time.
    share: Rect,
    turned: Turned,
    /// Width and height that the picture covers on the bottom, metres.
    size_m: [f64; 2],
}

impl BoxChip {
    /// Draws the picture of a box; a box too large for a tile is drawn in coarser pixels, so that a
    /// hull is shown as a whole. `None` if no pixel is in the picture.
    pub(crate) fn new(of: &ChipKey, ctx: &egui::Context) -> Option<Self> {
        let (survey, navigation, mark) = (&of.survey.0, &of.navigation.0, &of.mark);
        let fine = Raster::new(survey, navigation, PIXEL_M);
        let [width, height] = ChipWindow::around(&fine.rect_of(mark));
        let coarser = f64::from(width.max(height) / TILE_PX as f32);
        let raster = if coarser > 1.0 { fine.coarser(coarser) } else { fine };
        let window = ChipWindow::new(&raster, mark);
        if window.rows == 0 || window.columns == 0 {
            return None;
        }
        let mut tile = raster.tile(survey, mark.side, window.row, window.column);
        level(&mut tile.pixels);
        let rect = raster.rect_of(mark);
        let share = |x: f32, y: f32| {
            let x = (x - window.column as f32) / window.columns as f32;
            pos2(x, (y - window.row as f32) / window.rows as f32)
        };
        let image = image(&tile.pixels, &window, of);
        let [width, height] = image.size;
        Some(Self {
            texture: ctx.load_texture("box", image, egui::TextureOptions::LINEAR),
            size: vec2(width as f32, height as f32),
            share: Rect::from_min_max(share(rect.x0, rect.y0), share(rect.x1, rect.y1)),
            turned: of.turned(),
            size_m: [width, height].map(|side| side as f64 * raster.pixel_m),
        })
    }

    /// Shows the picture as large as the available width allows.
    pub(crate) fn ui(&self, ui: &mut Ui, review_box: &Reviewed, review: &Review, units: Units) {
        let width = ui.available_width();
        let room = vec2(width, width / 1.2);
        let response = self.draw(ui, review_box, room, Sense::hover());
        let [width, height] = self.size_m.map(|side_m| units.measure(side_m, 1));
        let (id, class, turned) =
            (review_box.id.0, review.class_name(review_box.class), self.turned.words());
        let name = format!("Picture of box {id}, {class}, {width} wide, {height} high, {turned}");
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &name));
        let hint = format!("As in the waterfall: {turned}; equal scales.");
        response.on_hover_text(hint);
    }

    /// Draws the picture as large as fits into `room`, without distortion, and the box in the
    /// outline of its state.
    pub(crate) fn draw(
        &self,
        ui: &mut Ui,
        review_box: &Reviewed,
        room: Vec2,
        sense: Sense,
    ) -> Response {
        let scale = (room / self.size).min_elem();
        let size = self.size * scale;
        let (whole, response) = ui.allocate_exact_size(vec2(room.x, size.y), sense);
        let area = Rect::from_center_size(whole.center(), size);
        let painter = ui.painter_at(area);
        let all = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        painter.image(self.texture.id(), area, all, egui::Color32::WHITE);
        let at = |x: f32, y: f32| area.lerp_inside(self.turned.share(x, y).to_vec2());
        let (min, max) = (self.share.min, self.share.max);
        let frame = Rect::from_two_pos(at(min.x, min.y), at(max.x, max.y));
        // The outline is the same as in the waterfall.
        let style = outline::Style::of(review_box.state);
        match review_box.extent {
            ObjectExtent::Point => outline::point(&painter, frame.center(), style, false),
            ObjectExtent::Found => outline::draw(&painter, frame, style, false),
            ObjectExtent::Drawn { border_m } => {
                outline::draw(&painter, frame, style, false);
                let range_m = review_box.mark.far_m - review_box.mark.near_m;
                let share = ((border_m - review_box.mark.near_m) / range_m) as f32;
                let x = min.x + share * (max.x - min.x);
                let line = [at(x, min.y), at(x, max.y)];
                outline::border(&painter, line, style.colour, false);
            }
        }
        response
    }
}

/// A box whose picture is to be drawn, and the inputs of the picture.
pub(crate) type WantedChip = (LogBox, ChipKey);

/// Pictures of boxes, drawn in the background.
pub(crate) type Chips = Background<Vec<WantedChip>, Vec<(WantedChip, BoxChip)>>;

/// Returns a box with the inputs of its picture; `None` while its log has no results.
pub(crate) fn wanted(app: &App, id: LogBox) -> Option<WantedChip> {
    let mark = &app.logs.log_box(id)?.mark;
    let key = ChipKey::of(app.logs.get(id.log)?, mark, &app.view.options.waterfall)?;
    Some((id, key))
}

/// Starts to draw the pictures of boxes, unless they are drawn or being drawn.
pub(crate) fn ask(chips: &mut Chips, wanted: Vec<WantedChip>, app: &App, ctx: &egui::Context) {
    let (of, ctx) = (wanted.clone(), ctx.clone());
    chips.ask(wanted, app.jobs.workers(), move |progress| {
        let mut drawn = Vec::with_capacity(of.len());
        for wanted in of {
            progress.check().ok()?;
            drawn.extend(BoxChip::new(&wanted.1, &ctx).map(|chip| (wanted, chip)));
        }
        Some(drawn)
    });
}

/// Returns the pixels of a window in colour, in the orientation of the waterfall.
fn image(pixels: &[u8], window: &ChipWindow, of: &ChipKey) -> ColorImage {
    let colours = of.map.palette();
    let [width, height] = match of.orientation {
        Orientation::Horizontal => [window.rows, window.columns],
        Orientation::Vertical => [window.columns, window.rows],
    };
    let turned = of.turned();
    let colour = |x: usize, y: usize| {
        let (across, row) = match of.orientation {
            Orientation::Horizontal => (y, x),
            Orientation::Vertical => (x, y),
        };
        let column = if turned.is_first { window.columns - 1 - across } else { across };
        let row = if turned.flip { window.rows - 1 - row } else { row };
        let level = pixels[row * TILE_PX + column];
        let [r, g, b] = colours[usize::from(level)];
        egui::Color32::from_rgb(r, g, b)
    };
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    ColorImage::new([width, height], places.map(|(x, y)| colour(x, y)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_is_turned_as_the_waterfall_is() {
        let turned = |orientation, flip, is_first| Turned { orientation, flip, is_first };
        let share =
            |orientation, flip, is_first| turned(orientation, flip, is_first).share(0.25, 0.1);
        let [h, v] = [Orientation::Horizontal, Orientation::Vertical];
        assert_eq!(share(v, false, false), pos2(0.25, 0.1));
        assert_eq!(share(v, false, true), pos2(0.75, 0.1));
        assert_eq!(share(h, false, false), pos2(0.1, 0.25));
        assert_eq!(share(h, false, true), pos2(0.1, 0.75));
        assert_eq!(share(h, true, true), pos2(0.9, 0.75));
        assert_eq!(turned(h, false, true).words(), "range up, time to the right");
        assert_eq!(turned(v, true, false).words(), "range to the right, time up");
    }

    #[test]
    fn a_long_box_is_shown_whole_and_a_small_one_with_what_is_around() {
        let rect = |width: f32, height: f32| BoxRect {
            x0: 100.0,
            y0: 200.0,
            x1: 100.0 + width,
            y1: 200.0 + height,
        };
        let [width, height] = ChipWindow::around(&rect(150.0, 750.0));
        assert!(height > 1000.0 && width > 400.0 && height / width <= LONGEST + 1e-3);
        let [width, height] = ChipWindow::around(&rect(10.0, 8.0));
        assert_eq!([width, height], [LEAST_PX, LEAST_PX]);
    }
}
