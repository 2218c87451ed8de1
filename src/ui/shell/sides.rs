//! Draws the panels left and right of the views, and the buttons that show and hide them.

use crate::app::{Action, App, PanelOptions, PanelShown};
use crate::ui::panels::details;
use crate::ui::{ViewContext, theme};
use egui::{Button, Frame, Id, Panel, Rect, Stroke, Ui, UiBuilder, UiKind, UiStackInfo, vec2};

/// Facts of the window that decide which panels are shown if the analyst has not chosen.
#[derive(Clone, Copy)]
pub(super) struct SideNeeds {
    /// Width of the window, points.
    pub width: f32,
    /// True if the right panel has contents.
    pub has_details: bool,
}

impl SideNeeds {
    pub(super) fn of(app: &App, width: f32) -> Self {
        Self { width, has_details: details::first_section(app).is_some() }
    }
}

/// A panel beside the views.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SidePanel {
    /// The panel of steps, on the left.
    Steps,
    /// The panel of details, on the right.
    Details,
}

impl SidePanel {
    /// Returns the width of the window from which the panel is shown if the analyst has not chosen,
    /// points.
    fn room(self) -> f32 {
        match self {
            SidePanel::Steps => 700.0,
            SidePanel::Details => 1200.0,
        }
    }

    fn choice(self, options: &mut PanelOptions) -> &mut PanelShown {
        match self {
            SidePanel::Steps => &mut options.steps,
            SidePanel::Details => &mut options.details,
        }
    }

    fn other(self) -> Self {
        match self {
            SidePanel::Steps => SidePanel::Details,
            SidePanel::Details => SidePanel::Steps,
        }
    }

    /// Returns true if the panel is shown.
    pub(super) fn is_shown(self, mut options: PanelOptions, needs: SideNeeds) -> bool {
        match self.choice(&mut options) {
            PanelShown::WithRoom => {
                needs.width >= self.room() && (self == SidePanel::Steps || needs.has_details)
            }
            PanelShown::Always => true,
            PanelShown::Never => false,
        }
    }

    /// Returns the options after the panel was shown or hidden by hand. In a window without space
    /// for both panels, the other one is hidden. A panel that is shown by hand with contents and
    /// space goes again when it has none.
    pub(super) fn set_shown(
        self,
        mut options: PanelOptions,
        shown: bool,
        needs: SideNeeds,
    ) -> PanelOptions {
        *self.choice(&mut options) = if shown { PanelShown::WithRoom } else { PanelShown::Never };
        if shown && !self.is_shown(options, needs) {
            *self.choice(&mut options) = PanelShown::Always;
        }
        if shown && needs.width < SidePanel::BOTH && self.other().is_shown(options, needs) {
            *self.other().choice(&mut options) = PanelShown::Never;
        }
        options
    }

    /// Width of the window from which both panels are shown at once, points.
    const BOTH: f32 = 900.0;

    fn action(self) -> Action {
        match self {
            SidePanel::Steps => Action::StepsPanel,
            SidePanel::Details => Action::DetailsPanel,
        }
    }

    /// Draws the panel while it is shown; a drag of its edge hides or shows it, too.
    pub(super) fn ui(
        self,
        ui: &mut Ui,
        context: &mut ViewContext<'_>,
        frame: Frame,
        add: impl FnOnce(&mut Ui, &mut ViewContext<'_>),
    ) {
        let width = ui.content_rect().width();
        let options = context.options().panels;
        let needs = SideNeeds::of(context.app, width);
        let was_shown = self.is_shown(options, needs);
        let mut is_shown = was_shown;
        // The limit also applies to a width that an earlier run saved: on a small screen the views
        // keep half of the width.
        let widest = |most: f32| (width / 4.0).clamp(240.0, most);
        let (panel, sizes) = match self {
            SidePanel::Steps => (Panel::left("steps"), 240.0..=widest(480.0)),
            SidePanel::Details => (Panel::right("details"), 220.0..=widest(560.0)),
        };
        let panel = panel.default_size(default_width(width)).size_range(sizes);
        let panel = panel.frame(frame);
        panel.show_collapsible(ui, &mut is_shown, |ui| add(ui, context));
        if is_shown != was_shown {
            let mut shown = context.options().clone();
            shown.panels = self.set_shown(options, is_shown, needs);
            context.show(shown);
        }
    }

    /// Draws the button that shows and hides the panel: a small window, whose side is filled while
    /// the panel is shown.
    pub(super) fn button(self, ui: &mut Ui, context: &mut ViewContext<'_>) {
        let action = self.action();
        let needs = SideNeeds::of(context.app, ui.content_rect().width());
        let is_shown = self.is_shown(context.options().panels, needs);
        let button = ui.add(Button::new("").min_size(vec2(26.0, 18.0)));
        button.widget_info(|| {
            egui::WidgetInfo::selected(egui::Role::Button, true, is_shown, action.label())
        });
        let stroke = ui.style().interact(&button).fg_stroke;
        let window = Rect::from_center_size(button.rect.center(), vec2(15.0, 11.0));
        let mut side = window.shrink(2.5);
        match self {
            SidePanel::Steps => side.max.x = side.min.x + 4.0,
            SidePanel::Details => side.min.x = side.max.x - 4.0,
        }
        let outline = Stroke::new(1.2, stroke.color);
        let kind = egui::StrokeKind::Inside;
        ui.painter().rect_stroke(window, 2.0, outline, kind);
        if is_shown {
            ui.painter().rect_filled(side, 0.0, stroke.color)
        } else {
            ui.painter().rect_stroke(side, 0.0, Stroke::new(1.0, stroke.color), kind)
        };
        context.keyed_button(button, action);
    }
}

/// Returns the initial width of a panel, points: in a window of 1280 points the views keep half of
/// the width, in one of 1400 points everything has enough space.
fn default_width(window: f32) -> f32 {
    let least = 240.0;
    let share = ((window - 1280.0) / 120.0).clamp(0.0, 1.0);
    least + share * (theme::SIDE_PANEL_WIDTH - least)
}

/// Returns the height of the time line in a window of this height, points: in a low window the
/// views need the space.
pub(super) fn time_line_height(window: f32) -> f32 {
    let (low, high) = (720.0, 1000.0);
    let share = ((window - low) / (high - low)).clamp(0.0, 1.0);
    egui::lerp(52.0..=crate::ui::panels::timeline::HEIGHT, share)
}

/// Draws the scroll area of a panel. Its contents are as wide without a bar as with one: otherwise
/// text that is wrapped for the bar could be short enough without it, and the bar would appear and
/// disappear in every frame.
pub(super) fn scrolled(ui: &mut Ui, name: &str, add: impl FnOnce(&mut Ui)) {
    let width = ui.available_width() - ui.spacing().scroll.allocated_width();
    // Nothing is filled here: the contents fade into this colour at the edges.
    let ground = Frame::new().fill(ui.visuals().panel_fill);
    let ground = UiStackInfo::new(UiKind::Frame).with_frame(ground);
    ui.scope_builder(UiBuilder::new().ui_stack_info(ground), |ui| {
        egui::ScrollArea::vertical().id_salt(Id::unique(name)).auto_shrink([false, false]).show(
            ui,
            |ui| {
                ui.set_max_width(width.min(ui.available_width()));
                add(ui);
            },
        );
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_narrow_window_begins_without_panels_and_shows_one_at_a_time() {
        let needs = |width: f32| SideNeeds { width, has_details: true };
        let shown = |options: PanelOptions, width: f32| {
            [SidePanel::Steps, SidePanel::Details].map(|side| side.is_shown(options, needs(width)))
        };
        let options = PanelOptions::default();
        assert_eq!(shown(options, 1600.0), [true, true]);
        assert_eq!(shown(options, 1280.0), [true, true]);
        assert_eq!(shown(options, 960.0), [true, false]);
        assert_eq!(shown(options, 640.0), [false, false]);
        let steps = SidePanel::Steps.set_shown(options, true, needs(640.0));
        assert_eq!(shown(steps, 640.0), [true, false]);
        let details = SidePanel::Details.set_shown(steps, true, needs(640.0));
        assert_eq!(shown(details, 640.0), [false, true]);
        let both = SidePanel::Details.set_shown(options, true, needs(960.0));
        assert_eq!(shown(both, 960.0), [true, true]);
        // The analyst's choice also holds in a wide window.
        let hidden = SidePanel::Steps.set_shown(options, false, needs(1600.0));
        assert_eq!(shown(hidden, 1600.0), [false, true]);
    }

    #[test]
    fn the_right_panel_gives_its_place_to_the_views_while_it_is_empty() {
        let empty = SideNeeds { width: 1600.0, has_details: false };
        let filled = SideNeeds { has_details: true, ..empty };
        let is_shown = |options, needs| SidePanel::Details.is_shown(options, needs);
        let options = PanelOptions::default();
        assert!(!is_shown(options, empty) && is_shown(options, filled));
        // Shown by hand while it is empty, it stays; hidden and shown by hand while it has
        // contents, it goes with them.
        assert!(is_shown(SidePanel::Details.set_shown(options, true, empty), empty));
        let hidden = SidePanel::Details.set_shown(options, false, filled);
        assert!(!is_shown(hidden, filled));
        assert!(!is_shown(SidePanel::Details.set_shown(hidden, true, filled), empty));
    }
}
