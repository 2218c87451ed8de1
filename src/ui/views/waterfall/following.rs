//! Keeping the newest ping of a followed log in view, until the analyst looks elsewhere.

use super::camera::{Camera, PictureExtent, Size};
use crate::app::App;

/// Share of the view by which the newest ping may lie beyond its edge and still count as in view.
const NEAR: f64 = 0.02;

/// State of the newest ping: its number and whether it is in view.
#[derive(Default)]
pub(super) struct NewestPing {
    /// Pings in the last frame, where the last of them was in view then.
    seen: Option<f64>,
    serial: u64,
}

impl NewestPing {
    /// Moves along by what was added where the newest ping was in view; goes to it when a log
    /// begins to be followed.
    pub(super) fn keep(
        &mut self,
        camera: &mut Camera,
        extent: &PictureExtent,
        size: Size,
        app: &App,
    ) {
        let begins =
            std::mem::replace(&mut self.serial, app.follow_serial()) != app.follow_serial();
        if !app.is_following() {
            return;
        }
        if begins || self.seen.is_some_and(|pings| pings < extent.pings) {
            camera.show_end(extent.pings, size);
        }
    }

    /// Notes whether the newest ping is in view now.
    pub(super) fn note(&mut self, camera: &Camera, extent: &PictureExtent, size: Size) {
        let [from, to, ..] = camera.seen(size);
        let is_seen = to >= extent.pings - NEAR * (to - from);
        self.seen = is_seen.then_some(extent.pings);
    }
}
