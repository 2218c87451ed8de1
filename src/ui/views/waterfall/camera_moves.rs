//! Moves the camera by wheel, drag and keys, and with a log that is being followed.

use super::camera::{Camera, PictureExtent, Size};
use super::lens::{Arrangement, Lens};
use crate::app::App;
use crate::ui::ViewRequest;
use egui::{Key, PointerButton};

/// Enlargement of one press of the zoom keys.
const KEY_STEP: f64 = 1.25;
/// Wheel points that enlarge by a factor of e.
const WHEEL_POINTS: f64 = 200.0;
/// Share of the view by which the newest ping may be beyond its edge and still counts as visible.
const NEAR: f64 = 0.02;

/// Carries out a request from menu, key or palette.
pub(super) fn carry_out(
    camera: &mut Camera,
    request: ViewRequest,
    extent: &PictureExtent,
    size: Size,
) {
    let middle = Size::both(0.0);
    match request {
        ViewRequest::Fit => camera.fit(extent, size),
        ViewRequest::OneToOne => camera.toggle_one_to_one(extent, size),
        ViewRequest::ZoomIn => camera.zoom(Size::both(KEY_STEP), middle),
        ViewRequest::ZoomOut => camera.zoom(Size::both(1.0 / KEY_STEP), middle),
        ViewRequest::Top | ViewRequest::Side => {}
    }
}

/// Moves the camera by pointer and keys. The wheel zooms at the pointer; with Shift it moves along
/// the track, with Ctrl it zooms the track only, with Alt the range only. A drag with the main
/// button (only if `drag_moves`; otherwise that button has another use) or with the middle one, or
/// a move with Space held, pans. A double-click shows everything (only if `fits`; otherwise it ends
/// a measurement).
pub(super) fn apply(
    camera: &mut Camera,
    ui: &egui::Ui,
    response: &egui::Response,
    arrangement: &Arrangement,
    extent: &PictureExtent,
    drag_moves: bool,
    fits: bool,
) {
    let size = Size::of(response.rect.size(), arrangement.orientation);
    if response.double_clicked() && fits {
        return camera.fit(extent, size);
    }
    let space = response.hovered() && ui.input(|input| input.key_down(Key::Space));
    let held = (drag_moves && response.dragged_by(PointerButton::Primary))
        || response.dragged_by(PointerButton::Middle)
        || space;
    if held {
        let by = ui.input(|input| input.pointer.delta());
        camera.pan(arrangement.size(by));
    }
    let Some(pointer) = response.hover_pos() else {
        return;
    };
    let (scroll, modifiers) = ui.input(|input| (input.smooth_scroll_delta(), input.modifiers));
    let zoom = f64::from(ui.input(|input| input.zoom_delta()));
    let offset = Lens::arranged(*camera, response.rect, arrangement).offset(pointer);
    let wheel = (f64::from(scroll.y) / WHEEL_POINTS).exp();
    let factor = match (modifiers.alt, modifiers.command) {
        (true, _) => Size::new(1.0, wheel),
        (_, true) => Size::new(zoom, 1.0),
        _ => Size::both(wheel * zoom),
    };
    camera.zoom(factor, offset);
    // egui turns the wheel sideways while Shift is held.
    let sideways = f64::from(scroll.x);
    let sideways = if arrangement.flip { -sideways } else { sideways };
    camera.pan(Size::new(sideways, 0.0));
}

/// Keeps the newest ping of a followed log in the view until the user moves the view elsewhere.
#[derive(Default)]
pub(super) struct NewestPing {
    /// Number of pings in the last frame; `None` if the last of them was not visible.
    seen: Option<f64>,
    serial: u64,
}

impl NewestPing {
    /// Moves the view to the end of the log when pings were added and the newest ping was visible,
    /// and when a log begins to be followed.
    pub(super) fn keep(
        &mut self,
        camera: &mut Camera,
        extent: &PictureExtent,
        size: Size,
        app: &App,
    ) {
        let begins =
            std::mem::replace(&mut self.serial, app.following.serial) != app.following.serial;
        if !app.is_following() {
            return;
        }
        if begins || self.seen.is_some_and(|pings| pings < extent.pings) {
            camera.show_end(extent.pings, size);
        }
    }

    /// Records whether the newest ping is visible now.
    pub(super) fn note(&mut self, camera: &Camera, extent: &PictureExtent, size: Size) {
        let [from, to, ..] = camera.seen(size);
        let is_seen = to >= extent.pings - NEAR * (to - from);
        self.seen = is_seen.then_some(extent.pings);
    }
}
