//! What stands around the views: one file a panel. Each reads the state and pushes commands.

pub mod axes;
mod calibration;
pub mod cloud;
pub mod exclusions;
pub mod external_track;
pub mod find_setting;
pub mod first_return;
pub mod logs;
pub mod maps;
pub mod mounting;
pub mod notices;
pub mod objects;
pub mod outliers;
pub(in crate::ui) mod parts;
pub mod plan;
mod positions;
pub mod products;
pub mod residuals;
pub mod review;
mod section;
pub mod selection;
pub mod shadow;
pub mod status;
pub mod survey;
pub mod timeline;
pub mod water;

/// Height of the line of words at the bottom of the window, points.
pub const STATUS_HEIGHT: f32 = 24.0;

pub use parts::of_given_width;
pub use section::{Section, focus_section, section, unfold_section};

use super::ViewContext;

/// The left side: the survey and the paper's steps in order.
pub fn steps(ui: &mut egui::Ui, context: &mut ViewContext<'_>) {
    survey::ui(ui, context);
    if context.app.log.survey.is_none() {
        return;
    }
    logs::ui(ui, context);
    first_return::ui(ui, context);
    calibration::ui(ui, context);
    cloud::ui(ui, context);
    outliers::ui(ui, context);
    objects::ui(ui, context);
    maps::ui(ui, context);
    plan::ui(ui, context);
    products::ui(ui, context);
    water::ui(ui, context);
    external_track::ui(ui, context);
    mounting::ui(ui, context);
    exclusions::ui(ui, context);
    residuals::ui(ui, context);
}
