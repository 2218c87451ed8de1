//! Draws the foldable sections of a panel, with their headings, and moves the keyboard to them.

use super::parts::within;
use crate::app::Freshness;
use crate::ui::{ViewContext, theme};
use bathyscope_products::pipeline::Stage;
use egui::{Response, Ui};

/// The heading of a section.
pub(crate) struct Section {
    /// Title, in the letters of the manual; headings are drawn in capitals.
    pub(super) title: &'static str,
    /// The stage whose result the section shows, for the mark of stale results.
    stage: Option<Stage>,
    /// True if the section is folded until the analyst opens it.
    begins_folded: bool,
}

impl Section {
    /// Creates a section with a title.
    pub(crate) const fn new(title: &'static str) -> Self {
        Self { title, stage: None, begins_folded: false }
    }

    /// Sets the stage whose result the section shows.
    pub(super) const fn of(mut self, stage: Stage) -> Self {
        self.stage = Some(stage);
        self
    }

    /// Folds the section until the analyst opens it.
    pub(super) const fn folded(mut self) -> Self {
        self.begins_folded = true;
        self
    }
}

fn folded_id(title: &str) -> egui::Id {
    egui::Id::unique(("folded", title))
}

fn wanted_id() -> egui::Id {
    egui::Id::unique("section that gets the keyboard")
}

/// Requests that the title of a section takes the keyboard when it is drawn next.
pub(crate) fn focus_section(ctx: &egui::Context, title: &'static str) {
    ctx.data_mut(|data| data.insert_temp(wanted_id(), title));
}

/// Opens a section.
pub(crate) fn unfold_section(ctx: &egui::Context, title: &str) {
    ctx.data_mut(|data| data.insert_persisted(folded_id(title), false));
}

/// Draws a section of a panel with a title; a click on the title folds or opens it.
pub(crate) fn section(
    ui: &mut Ui,
    context: &mut ViewContext<'_>,
    section: &Section,
    body: impl FnOnce(&mut Ui, &mut ViewContext<'_>),
) {
    let folded_id = folded_id(section.title);
    let known = ui.data_mut(|data| data.get_persisted::<bool>(folded_id));
    let mut folded = known.unwrap_or(section.begins_folded);
    let of_stage = |stage| Freshness::of(context.app, stage);
    let freshness = section.stage.map_or(Freshness::Fresh, of_stage);
    let title = heading(ui, context, section, folded, freshness);
    let wanted = ui.data_mut(|data| {
        let is_this = data.get_temp(wanted_id()) == Some(section.title);
        is_this.then(|| data.remove::<&'static str>(wanted_id()))
    });
    if wanted.is_some() {
        title.request_focus();
        title.scroll_to_me(None);
    }
    if title.clicked() {
        folded = !folded;
        ui.data_mut(|data| data.insert_persisted(folded_id, folded));
    }
    if !folded {
        within(ui, |ui| body(ui, context));
        ui.add_space(2.0);
    }
    ui.add(egui::Separator::default().spacing(5.0));
}

fn heading(
    ui: &mut Ui,
    context: &ViewContext<'_>,
    section: &Section,
    folded: bool,
    freshness: Freshness,
) -> Response {
    let look = context.theme();
    let size = egui::vec2(ui.available_width(), 20.0);
    let (rect, response) = ui.allocate_exact_size(size, egui::Sense::click());
    let painter = ui.painter();
    let strong = ui.visuals().strong_text_color();
    let left = rect.left();
    let at = |x: f32| egui::pos2(x, rect.center().y);
    triangle(painter, at(left + 4.0), folded, strong);
    let beside = egui::Align2::LEFT_CENTER;
    let title = section.title.to_uppercase();
    let font = egui::FontId::proportional(12.0);
    painter.text(at(left + 14.0), beside, title, font, strong);
    let mark = match freshness {
        Freshness::Fresh => None,
        Freshness::OutOfDate => Some(("out of date".to_owned(), theme::stale_colour(look))),
        Freshness::Waiting => Some(("updating".to_owned(), theme::accent_colour(look))),
        Freshness::Running(share) => {
            Some((format!("{:.0} %", f64::from(share) * 100.0), theme::accent_colour(look)))
        }
    };
    if let Some((text, colour)) = mark {
        let font = egui::FontId::proportional(theme::SMALL);
        let right = egui::Align2::RIGHT_CENTER;
        painter.text(rect.right_center(), right, text, font, colour);
    }
    let state = match freshness {
        Freshness::OutOfDate => ", out of date",
        Freshness::Waiting => ", updating",
        Freshness::Fresh | Freshness::Running(_) => "",
    };
    let name = format!("{} section{state}", section.title);
    response.widget_info(|| egui::WidgetInfo::selected(egui::Role::Button, true, !folded, &name));
    if response.has_focus() {
        let stroke = ui.visuals().widgets.hovered.fg_stroke;
        let kind = egui::StrokeKind::Inside;
        ui.painter().rect_stroke(rect, 2.0, stroke, kind);
    }
    response.on_hover_cursor(egui::CursorIcon::PointingHand)
}

/// Draws the triangle of a heading: down while the section is open, to the right while it is
/// folded.
fn triangle(painter: &egui::Painter, at: egui::Pos2, folded: bool, ink: egui::Color32) {
    let corners = if folded {
        [[-2.5, -4.0], [3.5, 0.0], [-2.5, 4.0]]
    } else {
        [[-4.0, -2.5], [4.0, -2.5], [0.0, 3.5]]
    };
    let points = corners.map(|[x, y]| at + egui::vec2(x, y)).to_vec();
    painter.add(egui::Shape::convex_polygon(points, ink, egui::Stroke::NONE));
}
