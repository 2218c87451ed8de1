//! The selected box enlarged: the bottom around it in square pixels, as a detector sees it.

use crate::app::{ColourMap, OpenLog, PIXEL_M};
use crate::detection::review::{Review, Reviewed};
use crate::detection::{Mark, Raster, TILE_PX, level};
use crate::pipeline::Same;
use crate::presentation::units::Units;
use crate::survey::{Navigation, Survey};
use crate::ui::views::waterfall::{outline, palette};
use egui::{ColorImage, Rect, Response, Role, Sense, TextureHandle, Ui, WidgetInfo, pos2, vec2};

/// Width over height.
const ASPECT: f32 = 1.5;
/// Height of the picture over that of the box.
const SURROUNDINGS: f32 = 2.2;
/// Least height, pixels of the raster: a box alone tells nothing.
const LEAST_PX: f32 = 64.0;

/// What a picture was made of.
#[derive(Clone, PartialEq)]
pub struct Key {
    pub survey: Same<Survey>,
    pub navigation: Same<Navigation>,
    pub mark: Mark,
    pub map: ColourMap,
}

impl Key {
    /// Of a box of a log; `None` while the log has no results.
    pub fn of(log: &OpenLog, mark: &Mark, map: ColourMap) -> Option<Self> {
        Some(Self {
            survey: Same(log.survey.clone()?),
            navigation: Same(log.products.as_ref()?.navigation.clone()),
            mark: mark.clone(),
            map,
        })
    }
}

/// A picture of a box with what lies around it.
pub struct Chip {
    texture: TextureHandle,
    /// The box as shares of the picture.
    share: Rect,
    height_m: f64,
}

impl Chip {
    /// Draws it; a box too large for a tile in coarser pixels.
    pub fn new(of: &Key, ctx: &egui::Context) -> Option<Self> {
        let (survey, navigation, mark) = (&of.survey.0, &of.navigation.0, &of.mark);
        let fine = Raster::new(survey, navigation, PIXEL_M);
        let height = chip_height(&fine, mark);
        let largest = TILE_PX as f32 / ASPECT;
        let pixel_m = PIXEL_M * f64::from((height / largest).max(1.0));
        let raster = match pixel_m > PIXEL_M {
            true => Raster::new(survey, navigation, pixel_m),
            false => fine,
        };
        let height = chip_height(&raster, mark).min(largest);
        let rect = raster.rect_of(mark);
        let [cx, cy] = [0.5 * (rect.x0 + rect.x1), 0.5 * (rect.y0 + rect.y1)];
        let (rows, columns) = (height as usize, (height * ASPECT) as usize);
        let column = (cx - 0.5 * columns as f32).max(0.0) as usize;
        let row = (cy - 0.5 * rows as f32).max(0.0) as usize;
        if rows == 0 || columns == 0 {
            return None;
        }
        let mut tile = raster.tile(survey, mark.side, row, column);
        level(&mut tile.pixels);
        let colours = palette(of.map);
        let pixels = tile.pixels.chunks_exact(TILE_PX).take(rows);
        let pixels = pixels.flat_map(|line| line.iter().take(columns));
        let pixels = pixels.map(|&level| {
            let [r, g, b] = colours[usize::from(level)];
            egui::Color32::from_rgb(r, g, b)
        });
        let image = ColorImage::new([columns, rows], pixels.collect());
        let rect = rect.shifted(-(column as f32), -(row as f32));
        let share = |x: f32, y: f32| pos2(x / columns as f32, y / rows as f32);
        Some(Self {
            texture: ctx.load_texture("box", image, egui::TextureOptions::LINEAR),
            share: Rect::from_min_max(share(rect.x0, rect.y0), share(rect.x1, rect.y1)),
            height_m: rows as f64 * raster.pixel_m(),
        })
    }

    /// Shows it as wide as there is room.
    pub fn ui(&self, ui: &mut Ui, one: &Reviewed, review: &Review, units: Units) {
        let response = self.draw(ui, one, ui.available_width(), Sense::hover());
        let name = format!(
            "Picture of box {}, {}, {} high, range to the right",
            one.id.0,
            review.class_name(one.class),
            units.measure(self.height_m, 1)
        );
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &name));
        response.on_hover_text("Slant range grows to the right, time runs down; square pixels.");
    }

    /// Draws it as wide as it is told, with the line of the box's state.
    pub fn draw(&self, ui: &mut Ui, one: &Reviewed, width: f32, sense: Sense) -> Response {
        let (area, response) = ui.allocate_exact_size(vec2(width, width / ASPECT), sense);
        let painter = ui.painter_at(area);
        let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        painter.image(self.texture.id(), area, whole, egui::Color32::WHITE);
        let frame = Rect::from_min_max(
            area.lerp_inside(self.share.min.to_vec2()),
            area.lerp_inside(self.share.max.to_vec2()),
        );
        // With the line of its state, as in the waterfall.
        outline::draw(&painter, frame, outline::Style::of(one.state), false);
        response
    }
}

/// Rows around a box so that its surroundings are seen, and all its columns.
fn chip_height(raster: &Raster, mark: &Mark) -> f32 {
    let rect = raster.rect_of(mark);
    let tallest = (rect.y1 - rect.y0).max((rect.x1 - rect.x0) / ASPECT);
    (SURROUNDINGS * tallest).max(LEAST_PX)
}
