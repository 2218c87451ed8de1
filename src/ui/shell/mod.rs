//! Draws the window as a whole: menu, panels and tiles of views, connected with the state of the
//! app.
//!
//! The window reads the state, keys, dropped files and the commands of panels and views, and
//! changes the state by commands.

mod commands;
mod export;
mod input;
mod layout;
mod levels;
mod lists;
mod manual;
mod menu;
mod palette;
mod play;
mod print_picture;
mod printing;
mod sides;
mod toolbar;

use super::dialogs::{Dialogs, PathPurpose};
use super::panels;
use super::panels::review::ReviewPanel;
use super::panels::timeline::TimeLine;
use super::views::{CloudView, MapView, ObjectsView, ProfileView, WaterfallView};
use super::{ViewContext, ViewRequest, flat, theme};
use crate::app::{Action, App, Command, KeyFocus, Mountings, PrintText, View, ViewOptions};
use eframe::egui_wgpu::RenderState;
use egui::{CentralPanel, Frame, LayerId, Panel, Rect, Response, Ui};
use export::ExportDialog;
use layout::Layout;
use lists::HistoryList;
use manual::Manual;
use palette::CommandPalette;
use play::Play;
use printing::Printing;
use serde::{Deserialize, Serialize};
use sides::{SidePanel, scrolled, time_line_height};
use std::path::PathBuf;

/// The views, each with the part of the survey that it shows.
#[derive(Default)]
struct Views {
    waterfall: WaterfallView,
    map: MapView,
    cloud: CloudView,
    objects: ObjectsView,
    profile: ProfileView,
    /// Area of each view where it was drawn last, in the order of [`View::ALL`].
    areas: [Option<Rect>; View::ALL.len()],
}

impl Views {
    fn ui(&mut self, view: View, ui: &mut Ui, context: &mut ViewContext<'_>) {
        self.areas[view as usize] = Some(ui.available_rect_before_wrap());
        match view {
            View::Waterfall => self.waterfall.ui(ui, context),
            View::Map => self.map.ui(ui, context),
            View::Cloud => self.cloud.ui(ui, context),
            View::Objects => self.objects.ui(ui, context),
            View::Profile => self.profile.ui(ui, context),
        }
    }

    fn request(&mut self, view: View, request: ViewRequest) {
        match view {
            View::Waterfall => self.waterfall.request(request),
            View::Map => self.map.request(request),
            View::Cloud => self.cloud.request(request),
            // The table has no scale, and the profile is always fitted.
            View::Objects | View::Profile => {}
        }
    }

    /// Returns the width and height of a view, points; those of a small window if it was not drawn
    /// yet.
    fn size(&self, view: View) -> [f32; 2] {
        let area = self.areas[view as usize].filter(|area| area.width() > 0.0);
        area.map_or([800.0, 500.0], |area| area.size().into())
    }

    /// Returns the visible view that contains a control; `None` if none does.
    fn around(&self, shown: &[View], control: &Response) -> Option<View> {
        // A control above the views belongs to none of them.
        if control.layer_id != LayerId::background() {
            return None;
        }
        let holds = |view: &View| {
            let area = self.areas[*view as usize];
            area.is_some_and(|area| area.contains(control.rect.center()))
        };
        shown.iter().copied().find(holds)
    }

    /// Returns copies of the views that show the same part of the survey, for a picture.
    fn for_picture(&self, app: &App) -> Self {
        Self {
            waterfall: self.waterfall.for_picture(),
            map: self.map.for_picture(app),
            cloud: self.cloud.for_picture(app),
            ..Self::default()
        }
    }

    fn is_settled(&self, view: View) -> bool {
        match view {
            View::Waterfall => self.waterfall.is_settled(),
            View::Map => self.map.is_settled(),
            View::Cloud => self.cloud.is_settled(),
            View::Objects => self.objects.is_settled(),
            View::Profile => self.profile.is_settled(),
        }
    }
}

/// The window: state of the app, views, and everything around them.
pub struct Shell {
    /// The state of the app.
    pub app: App,
    views: Views,
    layout: Layout,
    timeline: TimeLine,
    review: ReviewPanel,
    palette: CommandPalette,
    dialogs: Dialogs,
    play: Play,
    printing: Printing,
    export: ExportDialog,
    manual: Manual,
    history: HistoryList,
    /// True if the list of all notices is shown.
    shows_notices: bool,
    /// The view that fills the whole picture; `None` in a window.
    alone: Option<View>,
    /// Text around the view on a print; `None` without a print.
    text_around: Option<PrintText>,
    started: bool,
    /// True if each frame begins in the colour of the panels.
    is_cleared: bool,
    /// The panel to which the keyboard was moved, if it was.
    keyboard_in: Option<SidePanel>,
    /// Number of frames in which a requested control of a setting may still be drawn.
    seeking: u8,
    /// True if the analyst was warned that closing loses decisions.
    warned_of_loss: bool,
    /// Serial number of the shown log at the last frame; the play head stops when it changes.
    met: u64,
    /// Title of the window.
    title: String,
}

impl Shell {
    /// Creates the window of `app`.
    pub fn new(app: App) -> Self {
        Self {
            app,
            views: Views::default(),
            layout: Layout::default(),
            timeline: TimeLine::default(),
            review: ReviewPanel::default(),
            palette: CommandPalette::default(),
            dialogs: Dialogs::default(),
            play: Play::default(),
            printing: Printing::default(),
            export: ExportDialog::default(),
            manual: Manual::default(),
            history: HistoryList::default(),
            shows_notices: false,
            alone: None,
            text_around: None,
            started: false,
            is_cleared: false,
            keyboard_in: None,
            seeking: 0,
            warned_of_loss: false,
            met: 0,
            title: String::new(),
        }
    }

    /// Leaves the background to the window, whose frames begin in the colour of
    /// [`eframe::App::clear_color`]. A picture begins transparent.
    pub(crate) fn on_cleared_window(mut self) -> Self {
        self.is_cleared = true;
        self
    }

    /// Fills the whole picture with one view, without panels around it.
    pub fn show_alone(&mut self, alone: View) {
        self.alone = Some(alone);
    }

    /// Makes the waterfall show exactly these pings.
    pub fn show_pings(&mut self, pings: std::ops::Range<usize>) {
        self.views.waterfall.show_pings(pings);
    }

    /// Returns true if no work is running and everything visible is drawn in its final quality.
    pub fn is_settled(&self) -> bool {
        let views_settled = match self.alone {
            Some(view) => self.views.is_settled(view),
            // The page that offers logs has no picture.
            None if self.app.logs.shown.survey.is_none() => true,
            None => {
                let shown = self.layout.shown();
                shown.into_iter().all(|view| self.views.is_settled(view))
                    && self.timeline.is_settled()
                    && self.review.is_settled()
            }
        };
        self.app.is_idle() && views_settled
    }

    /// Returns the drawn share of the map's tiles, 0 to 1.
    pub(crate) fn drawn_share(&self) -> f32 {
        match self.views.map.missing() {
            [_, 0] => 0.0,
            [missing, all] => 1.0 - missing as f32 / all as f32,
        }
    }

    /// Draws a frame: collects the results of finished work, draws everything, and carries out the
    /// commands of the analyst.
    pub fn frame(&mut self, ui: &mut Ui, render_state: Option<&RenderState>) {
        self.app.poll();
        self.meet_survey(ui.ctx());
        self.guard_decisions(ui.ctx());
        theme::apply(ui.ctx(), self.app.view.options.theme);
        let mut commands = Vec::new();
        self.dialogs.poll(&mut commands);
        input::collect_dropped(ui, self.app.logs.count() > 0, &mut commands);
        forget_vanished_control(ui.ctx());
        self.dialogs.take_typed(ui);
        let asks = [
            self.palette.is_open(),
            self.dialogs.is_open(),
            self.printing.is_open(),
            self.export.is_open(),
        ];
        if !asks.contains(&true) {
            input::collect_keys(ui, &self.app, self.key_focus(ui), &mut commands);
        }
        if commands.contains(&Command::Do(Action::Palette)) {
            commands.retain(|command| *command != Command::Do(Action::Palette));
            self.palette.open();
        }
        self.play.advance(ui, &self.app, &mut commands);
        let ctx = ui.ctx().clone();
        // Views send all options or settings when one changes: those that they read must contain
        // the changes by keys of the same frame.
        for command in std::mem::take(&mut commands) {
            self.carry_out(&ctx, command);
        }
        let asked = self.draw(ui, render_state, &mut commands);
        match asked {
            Some(PathPurpose::PrintInto) => self.name_print(),
            Some(purpose) => self.dialogs.ask(purpose, self.app.jobs.workers()),
            None => {}
        }
        self.give_up_seeking(&ctx);
        if !self.started {
            // The first frame was laid out in sizes other than those of the theme.
            self.started = true;
            ctx.request_repaint();
        }
        for command in commands {
            self.carry_out(&ctx, command);
        }
        let busy = (!self.app.is_idle()).then_some(std::time::Duration::ZERO);
        if let Some(due) = busy.or(self.app.following.due()) {
            ctx.request_repaint_after(due.max(std::time::Duration::from_millis(100)));
        }
    }

    /// Updates the window after another log is shown: sets the title, and stops the play head.
    fn meet_survey(&mut self, ctx: &egui::Context) {
        let title = self.title();
        if title != self.title {
            ctx.send_viewport_cmd(egui::ViewportCommand::Title(title.clone()));
            self.title = title;
        }
        if self.met != self.app.view.survey_serial {
            self.met = self.app.view.survey_serial;
            self.play.stop();
        }
    }

    /// Returns the title: the name of the project or else that of the log, with a mark if there are
    /// changes that no file with a name contains.
    fn title(&self) -> String {
        let project = self.app.files.project_saving.path().and_then(|path| path.file_stem());
        let mark = if self.app.files.project_saving.is_unsaved() { "*" } else { "" };
        match (project, &self.app.logs.shown.survey) {
            (Some(project), _) => format!("{}{mark} - Bathyscope", project.to_string_lossy()),
            (None, Some(survey)) => format!("{}{mark} - Bathyscope", survey.name()),
            (None, None) => "Bathyscope".to_owned(),
        }
    }

    /// Protects decisions that are in no file from closing by mistake: the first request to close
    /// only warns the analyst.
    fn guard_decisions(&mut self, ctx: &egui::Context) {
        let closes = ctx.input(|input| input.viewport().close_requested());
        if closes {
            self.app.keep_all();
        }
        if !self.app.is_at_risk() {
            self.warned_of_loss = false;
            return;
        }
        if closes && !self.warned_of_loss {
            self.warned_of_loss = true;
            ctx.send_viewport_cmd(egui::ViewportCommand::CancelClose);
            self.say(&format!(
                "decisions are in no file; save the project with {} or the review in the Review menu, or close again to discard them",
                Action::SaveProject.key()
            ));
        }
    }

    /// Returns the part of the window in which bare keys act; `None` while a dialog, a drop-down
    /// list, the manual or a control outside of views and review has the keyboard.
    fn key_focus(&self, ui: &Ui) -> Option<KeyFocus> {
        let ctx = ui.ctx();
        if self.dialogs.is_waiting() || self.manual.open || egui::Popup::is_any_open(ctx) {
            return None;
        }
        match ctx.memory(|memory| memory.focused()) {
            None => Some(KeyFocus::View(self.target())),
            Some(_) if ui.text_edit_focused() => None,
            Some(control) => {
                let control = ctx.read_response(control)?;
                if self.review.holds(&control) {
                    return Some(KeyFocus::Review);
                }
                let view = self.views.around(&self.layout.shown(), &control);
                view.map(KeyFocus::View)
            }
        }
    }

    /// Returns the view in which keys act.
    fn target(&self) -> View {
        self.alone.unwrap_or_else(|| self.layout.target())
    }

    /// Draws the window; returns the path that the dialog of the system is to ask for.
    fn draw(
        &mut self,
        ui: &mut Ui,
        render_state: Option<&RenderState>,
        commands: &mut Vec<Command>,
    ) -> Option<PathPurpose> {
        let mut context =
            ViewContext { app: &self.app, render_state, target: self.target(), commands };
        if let Some(alone) = self.alone {
            if let Some(text) = &self.text_around {
                printing::frame(ui, context.app, text);
            }
            draw_alone(ui, &mut self.views, &mut context, alone);
            return None;
        }
        // One fill is drawn below everything: panels have no fill of their own.
        if !self.is_cleared {
            let (window, fill) = (ui.content_rect(), ui.visuals().panel_fill);
            flat::fill(ui.painter(), window, fill, render_state);
        }
        let bar = Frame::new().inner_margin(egui::Margin::symmetric(8, 3));
        Panel::top("menu bar").frame(bar).show(ui, |ui| {
            menu::ui(ui, &mut context);
        });
        if context.app.logs.shown.survey.is_some() {
            Panel::top("steps bar")
                .exact_size(panels::steps::BAR_HEIGHT)
                .frame(bar.inner_margin(egui::Margin::symmetric(8, 1)))
                .show(ui, |ui| panels::steps::bar(ui, &mut context));
            if context.app.view.has_tour {
                Panel::top("tour")
                    .exact_size(panels::steps::TOUR_HEIGHT)
                    .frame(bar)
                    .show(ui, |ui| panels::steps::tour(ui, &mut context));
            }
        }
        Panel::bottom("status bar")
            .exact_size(panels::STATUS_HEIGHT)
            .frame(bar)
            .show(ui, |ui| panels::status::ui(ui, &mut context));
        if context.app.logs.shown.survey.is_some() {
            Panel::bottom("depth line")
                .exact_size(panels::depth_line::HEIGHT)
                .frame(bar.inner_margin(egui::Margin::symmetric(8, 1)))
                .show(ui, |ui| panels::depth_line::ui(ui, &mut context));
        }
        let mut centre = ui.available_rect_before_wrap();
        if context.app.logs.shown.survey.is_some() {
            side_panels(ui, &mut context, &mut self.review, bar);
            Panel::bottom("time line")
                .exact_size(time_line_height(ui.content_rect().height()))
                .frame(bar)
                .show(ui, |ui| {
                    self.timeline.ui(ui, &mut context);
                    self.play.ui(ui, &mut context);
                });
            centre = ui.available_rect_before_wrap();
            draw_views(ui, &mut context, &mut self.layout, &mut self.views);
        } else {
            CentralPanel::no_frame().show(ui, |ui| panels::start::ui(ui, &mut context));
        }
        lists::show_notices(ui.ctx(), &mut context, centre);
        self.palette.ui(ui.ctx(), &mut context);
        self.manual.ui(ui.ctx());
        self.history.ui(ui.ctx(), &mut context);
        lists::all_notices(ui.ctx(), &mut context, &mut self.shows_notices);
        self.dialogs.ui(ui.ctx(), &mut context);
        input::drop_overlay(ui);
        let names_print = self.printing.ui(ui.ctx(), &mut context, &self.views);
        let asked = self.export.ui(ui.ctx(), &mut context);
        asked.or(names_print.then_some(PathPurpose::PrintInto))
    }
}

/// Gives the keyboard back to the views if the control that had it is not drawn any more: otherwise
/// the first key would do nothing else.
fn forget_vanished_control(ctx: &egui::Context) {
    if let Some(focused) = ctx.memory(|memory| memory.focused())
        && ctx.read_response(focused).is_none()
    {
        ctx.memory_mut(|memory| memory.surrender_focus(focused));
    }
}

/// Draws the panels left and right of the views.
fn side_panels(ui: &mut Ui, context: &mut ViewContext<'_>, review: &mut ReviewPanel, bar: Frame) {
    let side = bar.inner_margin(egui::Margin::symmetric(10, 6));
    SidePanel::Steps.ui(ui, context, side, |ui, context| {
        panels::of_given_width(ui, |ui| {
            scrolled(ui, "scrolled steps", |ui| panels::steps::ui(ui, context));
        });
    });
    SidePanel::Details.ui(ui, context, side, |ui, context| {
        panels::of_given_width(ui, |ui| {
            scrolled(ui, "scrolled details", |ui| panels::details::ui(ui, context, review));
        });
    });
}

/// Draws the views in the arrangement of the open step.
fn draw_views(ui: &mut Ui, context: &mut ViewContext<'_>, layout: &mut Layout, views: &mut Views) {
    CentralPanel::no_frame().show(ui, |ui| {
        let before = views.areas;
        layout.follow_step(context.options().panels.step);
        layout.ui(ui, views, context);
        if before != views.areas {
            // A view fits its contents to a new area in the next frame.
            ui.ctx().request_repaint();
        }
    });
}

fn draw_alone(ui: &mut Ui, views: &mut Views, context: &mut ViewContext<'_>, alone: View) {
    let canvas = Frame::new().fill(theme::canvas_colour(context.options()));
    CentralPanel::no_frame().frame(canvas).show(ui, |ui| views.ui(alone, ui, context));
}

impl eframe::App for Shell {
    fn ui(&mut self, ui: &mut Ui, frame: &mut eframe::Frame) {
        let render_state = frame.wgpu_render_state().cloned();
        self.frame(ui, render_state.as_ref());
    }

    fn on_exit(&mut self) {
        self.app.keep_all();
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        let saving = Saved {
            options: self.app.view.options.clone(),
            layout: self.layout.clone(),
            recent: self.app.recent.clone(),
            base_map: self.app.map.base_map.as_ref().map(|map| map.path.clone()),
            mountings: Mountings::clone(&self.app.document.mountings),
        };
        if let Ok(text) = serde_json::to_string(&saving) {
            storage.set_string(KEY, text);
        }
    }

    fn clear_color(&self, visuals: &egui::Visuals) -> [f32; 4] {
        visuals.panel_fill.to_normalized_gamma_f32()
    }
}

/// Key in the store; its number grows when old contents cannot be read any more.
const KEY: &str = "bathyscope window 1";

/// The saved preferences.
#[derive(Serialize, Deserialize)]
struct Saved {
    options: ViewOptions,
    layout: Layout,
    recent: Vec<PathBuf>,
    #[serde(default)]
    base_map: Option<PathBuf>,
    /// Default mountings of the recorders.
    #[serde(default)]
    mountings: Mountings,
}

impl Shell {
    /// Restores the preferences of an earlier run; those that cannot be read keep their defaults.
    pub fn restore(&mut self, storage: &dyn eframe::Storage) {
        let Some(text) = storage.get_string(KEY) else {
            return;
        };
        if let Ok(saved) = serde_json::from_str::<Saved>(&text) {
            self.app.document.mountings = saved.mountings.into();
            self.app.view.options = saved.options.for_new_survey();
            self.app.recent = saved.recent;
            self.layout = saved.layout;
            if let Some(path) = saved.base_map {
                self.app.reopen_base_map(path);
            }
        }
    }
}
