//! Draws the panels around the views, one file each. Each panel reads the state and sends commands.

mod calibration;
mod cloud;
mod corrections;
pub(super) mod depth_line;
pub(super) mod details;
mod exclusions;
pub(super) mod find_setting;
mod first_return;
mod logs;
mod maps;
pub(in crate::ui) mod parts;
mod plan;
mod residuals;
pub(super) mod review;
mod section;
mod selection;
pub(super) mod start;
pub(super) mod status;
pub(super) mod steps;
mod survey;
pub(super) mod timeline;

/// Height of the status line at the bottom of the window, points.
pub(super) const STATUS_HEIGHT: f32 = 24.0;

pub(crate) use parts::of_given_width;
pub(crate) use section::{focus_section, unfold_section};
