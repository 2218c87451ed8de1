//! Carries out the commands of the window, and passes all other commands to the app.

use super::printing::BUSY;
use super::sides::{SideNeeds, SidePanel};
use super::{Shell, ViewRequest};
use crate::app::{
    Action, Command, FileToWrite, JobKey, Jobs, KeyFocus, Keys, OpenLog, View, WindowAction,
    WorkStep,
};
use crate::ui::dialogs::PathPurpose;
use crate::ui::panels::{self, find_setting, find_setting::ControlPlace};
use bathyscope_products::pipeline::settings;
use std::path::PathBuf;

/// Number of frames in which a requested control of a setting must be drawn: a list that drops down
/// needs a few.
const SEEK_FRAMES: u8 = 6;

impl Shell {
    /// Carries out a command of the window or of the app.
    pub(super) fn carry_out(&mut self, ctx: &egui::Context, command: Command) {
        match command {
            Command::Do(action) => self.act(ctx, action),
            Command::ByKey { keys, command, focus } => self.act_by_key(ctx, keys, *command, focus),
            Command::ShowSetting(key) => self.show_setting(ctx, key),
            Command::ShowSection(title) => {
                self.open_section(ctx, title);
                panels::focus_section(ctx, title);
                ctx.request_repaint();
            }
            Command::Focus(view) => self.layout.focus(view),
            Command::PrintInto(path) => self.print_into(path),
            Command::ChooseExportFolder(path) => self.export.take_folder(&path),
            other => self.app.apply(other),
        }
    }

    /// Carries out the command of a bare key, unless it needs more than a key, and notifies the
    /// analyst of changes.
    fn act_by_key(&mut self, ctx: &egui::Context, keys: Keys, command: Command, focus: KeyFocus) {
        if self.app.holds_key_back(keys, &command, focus) {
            return ctx.request_repaint();
        }
        let before = self.app.step_now();
        self.carry_out(ctx, command);
        self.app.say_changed_by_key(keys, &before);
    }

    fn act(&mut self, ctx: &egui::Context, action: Action) {
        match action.in_window() {
            Some(action) => self.act_in_window(ctx, action),
            None => {
                if action == Action::FindObjects {
                    // The boxes that are found are reviewed in the views: the next Tab selects the
                    // first box instead of the next control.
                    leave_control(ctx);
                    self.app.view.options.panels.step = WorkStep::Objects;
                }
                self.app.apply(Command::Do(action));
            }
        }
        ctx.request_repaint();
    }

    fn act_in_window(&mut self, ctx: &egui::Context, action: WindowAction) {
        let has_survey = self.app.logs.shown.survey.is_some();
        match action {
            WindowAction::OpenLogs => self.ask(PathPurpose::OpenLogs),
            WindowAction::AddLogs => self.ask(PathPurpose::AddLogs),
            WindowAction::OpenFolder => self.ask(PathPurpose::OpenFolder),
            WindowAction::OpenPath => self.dialogs.ask_for_path(),
            WindowAction::OpenBaseMap => self.ask(PathPurpose::OpenBaseMap),
            WindowAction::OpenIsobathArea => self.ask(PathPurpose::OpenIsobathArea),
            WindowAction::OpenWaterLevels => self.ask(PathPurpose::OpenWaterLevels),
            WindowAction::OpenTrack => self.ask(PathPurpose::OpenTrack),
            WindowAction::OpenModel => self.ask(PathPurpose::OpenModel),
            WindowAction::OpenReview if has_survey => self.ask(PathPurpose::OpenReview),
            WindowAction::OpenReview => self.say("open a log first, then its review"),
            WindowAction::OpenTruth if has_survey => self.ask(PathPurpose::OpenTruth),
            WindowAction::OpenTruth => self.say("open a log first, then its known objects"),
            WindowAction::OpenReference if self.app.logs.shown.products.is_some() => {
                self.ask(PathPurpose::OpenReference);
            }
            WindowAction::OpenReference => self.say("open a log first, then its reference"),
            WindowAction::Export => self.ask_to_export(),
            WindowAction::ExportLog => self.ask_for_copy(PathPurpose::ExportLog, "copy.xtf"),
            WindowAction::ExportPings => self.ask_for_copy(PathPurpose::ExportPings, "part.xtf"),
            WindowAction::OpenExported => self.open_exported(),
            WindowAction::PrintView => self.ask_to_print(),
            WindowAction::Quit => ctx.send_viewport_cmd(egui::ViewportCommand::Close),
            WindowAction::SaveProject => self.save_project(),
            WindowAction::SaveProjectAs => self.name_project(),
            WindowAction::SaveReview => self.save_review(),
            WindowAction::ExportBoxes => self.export_boxes(),
            WindowAction::History => self.history.open = !self.history.open,
            WindowAction::Notices => self.shows_notices = !self.shows_notices,
            WindowAction::Palette => self.palette.open(),
            WindowAction::Manual => self.manual.open = !self.manual.open,
            WindowAction::Focus(view) => {
                self.layout.focus(view);
                if view == View::Objects {
                    self.views.objects.take_keyboard();
                }
            }
            WindowAction::FullScreen => toggle_full_screen(ctx),
            WindowAction::Maximise => self.layout.toggle_maximised(self.layout.target()),
            WindowAction::FocusPanels => self.focus_panels(ctx),
            WindowAction::OpenStep(step) => self.open_step(ctx, step),
            WindowAction::StepsPanel => self.toggle_panel(SidePanel::Steps, ctx),
            WindowAction::DetailsPanel => self.toggle_panel(SidePanel::Details, ctx),
            WindowAction::Arrange(preset) => self.layout.arrange(preset),
            WindowAction::Fit => self.views.request(self.layout.target(), ViewRequest::Fit),
            WindowAction::ZoomIn => self.views.request(self.layout.target(), ViewRequest::ZoomIn),
            WindowAction::ZoomOut => self.views.request(self.layout.target(), ViewRequest::ZoomOut),
            WindowAction::TopView => self.views.request(View::Cloud, ViewRequest::Top),
            WindowAction::SideView => self.views.request(View::Cloud, ViewRequest::Side),
            WindowAction::OneToOne => self.views.request(View::Waterfall, ViewRequest::OneToOne),
            WindowAction::Play => self.play.toggle(&self.app),
            WindowAction::PlayFaster => self.play.change_speed(1),
            WindowAction::PlaySlower => self.play.change_speed(-1),
            WindowAction::NameBox => self.name_box(ctx),
            WindowAction::SetCorner => match self.target() {
                View::Waterfall => self.views.waterfall.set_corner(),
                _ => self.views.map.set_corner(),
            },
            WindowAction::SaveFigure if self.app.measured().is_some() => {
                self.ask_beside_log(PathPurpose::SaveFigure, "measured.geojson");
            }
            WindowAction::SaveFigure => {
                self.say("nothing is measured yet; draw a line or an area on the map first");
            }
            WindowAction::SaveProfile if self.app.profile_csv().is_some() => {
                self.ask_beside_log(PathPurpose::SaveProfile, "profile.csv");
            }
            WindowAction::SaveProfile => self.say_no_profile(),
            WindowAction::CopyProfile => match self.app.profile_csv() {
                Some(text) => ctx.copy_text(text),
                None => self.say_no_profile(),
            },
            WindowAction::SavePlan if self.app.map.planning.lines.is_some() => {
                self.ask_beside_log(PathPurpose::SavePlan, "lines.gpx");
            }
            WindowAction::SavePlan => self.say("no lines are planned yet; use Plan lines first"),
        }
    }

    /// Asks for a path in a dialog of the system.
    fn ask(&mut self, purpose: PathPurpose) {
        self.dialogs.ask(purpose, self.app.jobs.workers());
    }

    /// Opens the dialog of the products and their folder, unless there are no results, or some are
    /// still being written.
    fn ask_to_export(&mut self) {
        if self.app.logs.shown.products.is_none() {
            self.say("there is no result to export yet; open a log first");
        } else if self.app.jobs.fraction(&JobKey::Export).is_some() {
            self.say(BUSY);
        } else {
            let (folder, amounts) = (self.app.export_folder(), self.app.amounts());
            let statement = self.app.logs.export_statement();
            self.export.ask(&folder, amounts, statement);
        }
    }

    /// Saves the project; asks for its name if it has none. Of a survey that is no file, such as
    /// the demo, saves the review.
    fn save_project(&mut self) {
        if self.app.files.project_saving.path().is_some() {
            self.app.apply(Command::SaveProject);
        } else if self.app.logs.all().any(OpenLog::is_file)
            || !self.app.logs.shown.reviewing.has_boxes()
        {
            self.name_project();
        } else {
            self.save_review();
        }
    }

    /// Opens the folder that was written last in the file manager of the system.
    fn open_exported(&mut self) {
        let Some(folder) = &self.app.written_into else {
            return;
        };
        // Tests must not open a file manager.
        if matches!(self.app.jobs.workers(), Jobs::Threads(_))
            && let Err(error) = open::that_detached(folder)
        {
            let text = format!("no file manager opens {}: {error}", folder.display());
            self.app.apply(Command::Notify(text));
        }
    }

    fn toggle_panel(&mut self, panel: SidePanel, ctx: &egui::Context) {
        let needs = SideNeeds::of(&self.app, ctx.content_rect().width());
        self.show_panel(panel, !panel.is_shown(self.app.view.options.panels, needs), ctx);
    }

    /// Shows or hides a panel, unless it is in that state already.
    fn show_panel(&mut self, panel: SidePanel, shown: bool, ctx: &egui::Context) {
        let panels = self.app.view.options.panels;
        let needs = SideNeeds::of(&self.app, ctx.content_rect().width());
        if panel.is_shown(panels, needs) != shown {
            self.app.view.options.panels = panel.set_shown(panels, shown, needs);
        }
    }

    /// Notifies the analyst of the reason why a command is not carried out.
    pub(super) fn say(&mut self, text: &str) {
        self.app.apply(Command::Notify(text.to_owned()));
    }

    /// Notifies the analyst that there are no boxes to save or write.
    fn say_no_boxes(&mut self) {
        let key = Action::NewBox.key();
        self.say(&format!("there are no boxes yet; find objects, or draw a box with {key}"));
    }

    /// Notifies the analyst that there is no depth profile to save or copy.
    fn say_no_profile(&mut self) {
        let key = Action::DepthProfile.key();
        self.say(&format!(
            "there is no depth profile yet; draw a line over the depth map with {key} first"
        ));
    }

    /// Asks for the path of a file to write, and proposes one beside the log.
    pub(super) fn ask_beside_log(&mut self, purpose: PathPurpose, ending: &str) {
        let proposed = self.sidecar_path(ending);
        self.dialogs.name(purpose, proposed, self.app.jobs.workers());
    }

    /// Moves the keyboard to the steps, then to the details, then back to the views.
    fn focus_panels(&mut self, ctx: &egui::Context) {
        let focused = ctx.memory(|memory| memory.focused());
        if self.app.logs.shown.survey.is_none() {
            return leave_control(ctx);
        }
        let needs = SideNeeds::of(&self.app, ctx.content_rect().width());
        let from = self.keyboard_in.filter(|_| focused.is_some());
        let rest: &[SidePanel] = match from {
            None => &[SidePanel::Steps, SidePanel::Details],
            Some(SidePanel::Steps) => &[SidePanel::Details],
            Some(SidePanel::Details) => &[],
        };
        let panels = self.app.view.options.panels;
        let next = rest.iter().find(|panel| {
            let is_empty = **panel == SidePanel::Details && !needs.has_details;
            panel.is_shown(panels, needs) && !is_empty
        });
        self.keyboard_in = next.copied();
        let title = match next {
            Some(SidePanel::Steps) => panels::steps::first_section(panels.step),
            Some(SidePanel::Details) => {
                panels::details::first_section(&self.app).unwrap_or_default()
            }
            None => return leave_control(ctx),
        };
        panels::focus_section(ctx, title);
    }

    /// Shows a step of the work in the panel of steps.
    fn open_step(&mut self, ctx: &egui::Context, step: WorkStep) {
        self.show_panel(SidePanel::Steps, true, ctx);
        self.app.view.options.panels.step = step;
    }

    /// Shows a section of the panel of steps, with its contents.
    fn open_section(&mut self, ctx: &egui::Context, title: &str) {
        if let Some(step) = panels::steps::step_of(title) {
            self.open_step(ctx, step);
        }
        panels::unfold_section(ctx, title);
    }

    /// Shows the place of the control of a setting, and moves the keyboard to the control.
    fn show_setting(&mut self, ctx: &egui::Context, key: &'static str) {
        match find_setting::place_of(key) {
            Some(ControlPlace::Section(title)) => {
                self.open_section(ctx, title);
            }
            Some(ControlPlace::Levels) => self.layout.focus(View::Waterfall),
            None => return,
        }
        find_setting::seek(ctx, key);
        self.seeking = SEEK_FRAMES;
        ctx.request_repaint();
    }

    /// Notifies the analyst of the place of a requested control that is not drawn, because other
    /// settings hide it.
    pub(super) fn give_up_seeking(&mut self, ctx: &egui::Context) {
        let Some(key) = find_setting::sought(ctx) else {
            return;
        };
        self.seeking = self.seeking.saturating_sub(1);
        if self.seeking > 0 {
            return ctx.request_repaint();
        }
        find_setting::give_up(ctx);
        let name = settings::row(key).map_or(key, |row| row.name);
        let text = match find_setting::place_of(key) {
            Some(ControlPlace::Section(title)) => {
                panels::focus_section(ctx, title);
                ctx.request_repaint();
                format!("{name} has no control now: other settings of {title} decide about it")
            }
            _ => format!("{name} has no control now: see Levels in the options of the waterfall"),
        };
        self.app.apply(Command::Notify(text));
    }

    /// Moves the keyboard to the name of the selected box.
    fn name_box(&mut self, ctx: &egui::Context) {
        if self.app.logs.shown.reviewing.selected.is_none() {
            return self.say("select a box first, with Tab or a click");
        }
        self.show_panel(SidePanel::Details, true, ctx);
        panels::unfold_section(ctx, "Review");
        self.review.name_box();
    }

    /// Asks for the file in which the project is to be saved.
    fn name_project(&mut self) {
        if self.app.logs.count() == 0 {
            return self.say("there is nothing to keep yet; open a log first");
        }
        let known = self.app.files.project_saving.path().map(std::path::Path::to_owned);
        let proposed = known.unwrap_or_else(|| self.sidecar_path("bathyscope"));
        self.dialogs.name(PathPurpose::SaveProject, proposed, self.app.jobs.workers());
    }

    /// Saves the review in its file, or asks for one; reviews of several logs are saved without a
    /// question.
    fn save_review(&mut self) {
        if self.app.logs.review_counts().logs > 1 {
            return self.app.apply(Command::Write(FileToWrite::Reviews));
        }
        match (self.app.logs.shown.review_path(), &self.app.logs.shown.reviewing.path) {
            (_, Some(path)) => {
                let path = path.clone();
                self.app.apply(Command::Write(FileToWrite::Review(path)));
            }
            (Some(path), None) if self.app.logs.shown.reviewing.has_boxes() => {
                self.dialogs.name(PathPurpose::SaveReview, path, self.app.jobs.workers());
            }
            _ => self.say_no_boxes(),
        }
    }

    /// Returns the path of a sidecar file of the log.
    pub(super) fn sidecar_path(&self, ending: &str) -> PathBuf {
        let survey = self.app.logs.shown.survey.as_ref();
        let log = survey.and_then(|survey| survey.source.files.first());
        log.map_or_else(|| PathBuf::from(ending), |log| log.with_extension(ending))
    }

    /// Asks for the file of a copy of the log.
    fn ask_for_copy(&mut self, purpose: PathPurpose, ending: &str) {
        if self.app.logs.shown.survey.is_none() {
            self.say("there is no log to export yet; open one first");
        } else if self.app.jobs.fraction(&JobKey::Export).is_some() {
            self.say(BUSY);
        } else {
            self.ask_beside_log(purpose, ending);
        }
    }

    fn export_boxes(&mut self) {
        let is_writing = self.app.jobs.fraction(&JobKey::Export).is_some();
        if !self.app.logs.shown.reviewing.has_boxes() {
            self.say_no_boxes();
        } else if is_writing {
            self.say(BUSY);
        } else {
            self.ask(PathPurpose::ExportBoxesInto);
        }
    }
}

/// Takes the keyboard from the focused control, so that the views have it.
fn leave_control(ctx: &egui::Context) {
    if let Some(focused) = ctx.memory(|memory| memory.focused()) {
        ctx.memory_mut(|memory| memory.surrender_focus(focused));
    }
}

fn toggle_full_screen(ctx: &egui::Context) {
    let is_full = ctx.input(|input| input.viewport().fullscreen == Some(true));
    ctx.send_viewport_cmd(egui::ViewportCommand::Fullscreen(!is_full));
}
