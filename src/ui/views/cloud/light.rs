//! The light on the bottom, moved by hand: a disc seen from above, north up, with the light where
//! it stands.

use crate::ui::list_keys::keep_arrows;
use egui::{Key, Response, Role, Sense, Stroke, Ui, Vec2, WidgetInfo, vec2};

/// Radius of the disc, points.
const RADIUS: f32 = 11.0;
/// Lowest that the light stands over the horizon, degrees.
const LOWEST_DEG: f32 = 5.0;
/// Step of the arrow keys, degrees.
const STEP_DEG: f32 = 5.0;

/// The disc; `light_deg` is the direction clockwise from north and the height over the horizon,
/// degrees. A drag takes the light along, the arrow keys turn and raise it.
pub(super) fn dial(ui: &mut Ui, light_deg: &mut [f32; 2]) -> Response {
    let size = Vec2::splat(2.0 * RADIUS);
    let (rect, mut response) = ui.allocate_exact_size(size, Sense::click_and_drag());
    let before = *light_deg;
    if let Some(at) = response.interact_pointer_pos() {
        response.request_focus();
        *light_deg = light_at((at - rect.center()) / RADIUS, light_deg[0]);
    }
    if response.has_focus() {
        keep_arrows(ui.ctx(), response.id, true, true);
        let pressed = |key| ui.input_mut(|input| input.consume_key(egui::Modifiers::NONE, key));
        let [left, right, up, down] =
            [Key::ArrowLeft, Key::ArrowRight, Key::ArrowUp, Key::ArrowDown].map(pressed);
        let step = |more: bool, less: bool| STEP_DEG * (f32::from(more) - f32::from(less));
        let [azimuth_deg, altitude_deg] = *light_deg;
        *light_deg = [
            (azimuth_deg + step(right, left)).rem_euclid(360.0),
            (altitude_deg + step(up, down)).clamp(LOWEST_DEG, 90.0),
        ];
    }
    if *light_deg != before {
        response.mark_changed();
    }
    paint(ui, &response, *light_deg);
    let [azimuth_deg, altitude_deg] = *light_deg;
    let name = format!("Light from {azimuth_deg:.0} degrees, {altitude_deg:.0} degrees high");
    response.widget_info(|| WidgetInfo::labeled(Role::Slider, ui.is_enabled(), &name));
    response.on_hover_text(format!("{name}. Drag the light, or turn it (arrow keys, Shift+L)."))
}

/// Direction of the light at a place of the disc, azimuth and height in degrees: overhead in the
/// middle, at the horizon on the rim. In the very middle it keeps its azimuth.
fn light_at(place: Vec2, azimuth_deg: f32) -> [f32; 2] {
    let altitude_deg = 90.0 * (1.0 - place.length()).clamp(0.0, 1.0);
    let turned_deg = if place.length() > 0.05 {
        place.x.atan2(-place.y).to_degrees().rem_euclid(360.0)
    } else {
        azimuth_deg
    };
    [turned_deg.round(), altitude_deg.max(LOWEST_DEG).round()]
}

fn paint(ui: &Ui, response: &Response, [azimuth_deg, altitude_deg]: [f32; 2]) {
    let visuals = ui.style().interact(response);
    let (centre, painter) = (response.rect.center(), ui.painter());
    painter.circle(centre, RADIUS, visuals.bg_fill, visuals.fg_stroke);
    let (sin, cos) = azimuth_deg.to_radians().sin_cos();
    let at = centre + vec2(sin, -cos) * RADIUS * (1.0 - altitude_deg / 90.0);
    let colour = visuals.fg_stroke.color;
    painter.line_segment([centre, at], Stroke::new(1.0, colour));
    painter.circle_filled(at, 3.0, colour);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_light_stands_where_the_disc_shows_it() {
        assert_eq!(light_at(vec2(0.0, -0.5), 0.0), [0.0, 45.0]);
        assert_eq!(light_at(vec2(0.5, 0.0), 0.0), [90.0, 45.0]);
        assert_eq!(light_at(vec2(-3.0, 3.0), 0.0), [225.0, 5.0]);
        assert_eq!(light_at(vec2(0.0, 0.0), 315.0), [315.0, 90.0]);
    }
}
