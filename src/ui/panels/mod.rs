//! Draws the panels around the views, one file each. Each panel reads the state and sends commands.

mod calibration;
pub(super) mod cloud;
mod corrections;
pub(super) mod depth_line;
pub(super) mod exclusions;
pub(super) mod find_setting;
pub(super) mod first_return;
pub(super) mod logs;
pub(super) mod maps;
pub(in crate::ui) mod parts;
pub(super) mod plan;
pub(super) mod residuals;
pub(super) mod review;
mod section;
pub(super) mod selection;
pub(super) mod status;
pub(super) mod survey;
pub(super) mod timeline;

/// Height of the status line at the bottom of the window, points.
pub(super) const STATUS_HEIGHT: f32 = 24.0;

pub(crate) use parts::of_given_width;
pub(crate) use section::{Section, section};
pub(crate) use section::{focus_section, unfold_section};

use super::ViewContext;

/// Draws the left side: the survey and the paper's steps in order.
pub(super) fn steps(ui: &mut egui::Ui, context: &mut ViewContext<'_>) {
    survey::ui(ui, context);
    if context.app.logs.shown.survey.is_none() {
        return;
    }
    logs::ui(ui, context);
    first_return::ui(ui, context);
    calibration::ui(ui, context);
    cloud::ui(ui, context);
    cloud::outliers(ui, context);
    cloud::objects(ui, context);
    maps::ui(ui, context);
    plan::ui(ui, context);
    maps::products(ui, context);
    corrections::depths(ui, context);
    corrections::positions(ui, context);
    corrections::mounting(ui, context);
    exclusions::ui(ui, context);
    residuals::ui(ui, context);
}
