//! Commands that the shell itself carries out; the rest goes to the state.

use super::printing::BUSY;
use super::sides::SidePanel;
use super::{Shell, ViewRequest};
use crate::app::{Action, Command, FileToWrite, Jobs, KeyFocus, Keys, LayoutPreset, View};
use crate::ui::dialogs::PathPurpose;
use crate::ui::panels::{self, find_setting, find_setting::ControlPlace};
use bathyscope_products::pipeline::settings;
use std::path::PathBuf;

/// Said when there is nothing to save or write.
const NO_BOXES: &str = "there are no boxes yet; find objects, or draw a box with N";

/// Said when there is no profile to save or copy.
const NO_PROFILE: &str =
    "there is no depth profile yet; draw a line over the depth map with P first";

/// Frames within which the control of a setting is drawn, if it is: a list that drops down needs a
/// few.
const SEEK_FRAMES: u8 = 6;

impl Shell {
    /// Carries out a command.
    pub(super) fn carry_out(&mut self, ctx: &egui::Context, command: Command) {
        match command {
            Command::Do(action) => self.act(ctx, action),
            Command::ByKey { keys, command, focus } => self.act_by_key(ctx, keys, *command, focus),
            Command::ShowSetting(key) => self.show_setting(ctx, key),
            Command::Focus(view) => self.layout.focus(view),
            Command::PrintInto(path) => self.print_into(path),
            Command::ChooseExportFolder(path) => self.export.take_folder(&path),
            other => self.app.apply(other),
        }
    }

    /// Carries out what a bare key asks for, unless that needs more than a key, and says what it
    /// changed.
    fn act_by_key(&mut self, ctx: &egui::Context, keys: Keys, command: Command, focus: KeyFocus) {
        if self.app.holds_key_back(keys, &command, focus) {
            return ctx.request_repaint();
        }
        let before = self.app.before_key();
        self.carry_out(ctx, command);
        self.app.say_changed_by_key(keys, &before);
    }

    fn act(&mut self, ctx: &egui::Context, action: Action) {
        if let Some(purpose) = self.path_for(action) {
            self.dialogs.ask(purpose, self.app.jobs());
        } else if let Some((view, request)) = self.view_request(action) {
            self.views.request(view, request);
        } else if let Some(preset) = layout_preset(action) {
            self.layout.arrange(preset);
        } else {
            self.act_in_shell(ctx, action);
        }
        ctx.request_repaint();
    }

    /// Purpose of the path that an action needs, if the action does nothing else and the path can
    /// be used with what is open.
    fn path_for(&self, action: Action) -> Option<PathPurpose> {
        let has_survey = self.app.log.survey.is_some();
        let has_products = self.app.log.products.is_some();
        match action {
            Action::Open => Some(PathPurpose::OpenLogs),
            Action::AddLog => Some(PathPurpose::AddLogs),
            Action::OpenFolder => Some(PathPurpose::OpenFolder),
            Action::OpenReview => has_survey.then_some(PathPurpose::OpenReview),
            Action::OpenTruth => has_survey.then_some(PathPurpose::OpenTruth),
            Action::CompareWith => has_products.then_some(PathPurpose::OpenReference),
            Action::ChooseModel => Some(PathPurpose::OpenModel),
            Action::OpenBaseMap => Some(PathPurpose::OpenBaseMap),
            Action::OpenIsobathArea => Some(PathPurpose::OpenIsobathArea),
            Action::OpenWaterLevels => Some(PathPurpose::OpenWaterLevels),
            Action::OpenTrack => Some(PathPurpose::OpenTrack),
            _ => None,
        }
    }

    /// View and request of an action; `None` if the action is no request to a view.
    fn view_request(&self, action: Action) -> Option<(View, ViewRequest)> {
        let target = self.layout.target();
        match action {
            Action::Fit => Some((target, ViewRequest::Fit)),
            Action::ZoomIn => Some((target, ViewRequest::ZoomIn)),
            Action::ZoomOut => Some((target, ViewRequest::ZoomOut)),
            Action::OneToOne => Some((View::Waterfall, ViewRequest::OneToOne)),
            Action::TopView => Some((View::Cloud, ViewRequest::Top)),
            Action::SideView => Some((View::Cloud, ViewRequest::Side)),
            _ => None,
        }
    }

    /// Carries out an action that is more than a path, a request to a view or a layout; the others
    /// go to the state.
    fn act_in_shell(&mut self, ctx: &egui::Context, action: Action) {
        match action {
            Action::OpenPath => self.dialogs.ask_for_path(),
            Action::Export => self.ask_to_export(),
            Action::OpenExported => self.open_exported(),
            Action::PrintView => self.ask_to_print(),
            Action::CompareWith => {
                let text = "open a log first, then its reference";
                self.app.apply(Command::Notify(text.to_owned()));
            }
            Action::SaveProject => self.save_project(),
            Action::SaveProjectAs => self.name_project(),
            Action::SaveReview => self.save_review(),
            Action::ExportBoxes => self.export_boxes(),
            Action::FindObjects => {
                // What is found is reviewed in the views: the next Tab goes to the first box, not
                // to the next control.
                leave_control(ctx);
                self.app.apply(Command::Do(action));
            }
            Action::Quit => ctx.send_viewport_cmd(egui::ViewportCommand::Close),
            Action::Palette => self.palette.open(),
            Action::Manual => self.manual.open = !self.manual.open,
            Action::History => self.history.open = !self.history.open,
            Action::Notices => self.notices.open = !self.notices.open,
            Action::FocusPanels => self.focus_panels(ctx),
            Action::NameBox => self.name_box(ctx),
            Action::StepsPanel => self.toggle_panel(SidePanel::Steps, ctx),
            Action::DetailsPanel => self.toggle_panel(SidePanel::Details, ctx),
            Action::Play => self.play.toggle(&self.app),
            Action::PlayFaster => self.play.change_speed(1),
            Action::PlaySlower => self.play.change_speed(-1),
            Action::FullScreen => toggle_full_screen(ctx),
            Action::FocusWaterfall => self.layout.focus(View::Waterfall),
            Action::FocusMap => self.layout.focus(View::Map),
            Action::FocusCloud => self.layout.focus(View::Cloud),
            Action::FocusObjects => {
                self.layout.focus(View::Objects);
                self.views.objects.take_keyboard();
            }
            Action::Maximise => self.layout.toggle_maximised(self.layout.target()),
            Action::SetCorner => match self.target() {
                View::Waterfall => self.views.waterfall.set_corner(),
                View::Map | View::Cloud | View::Objects => self.views.map.set_corner(),
            },
            Action::SaveFigure => self.save_figure(),
            Action::SavePlan => self.save_plan(),
            Action::SaveProfile => self.save_profile(),
            Action::ExportLog => self.ask_for_copy(PathPurpose::ExportLog, "copy.xtf"),
            Action::ExportPings => self.ask_for_copy(PathPurpose::ExportPings, "part.xtf"),
            Action::CopyProfile => match self.app.profile_csv() {
                Some(text) => ctx.copy_text(text),
                None => self.app.apply(Command::Notify(NO_PROFILE.to_owned())),
            },
            other => self.app.apply(Command::Do(other)),
        }
    }

    /// Asks which products to write, and where, unless there are none or some are still being
    /// written.
    fn ask_to_export(&mut self) {
        if self.app.log.products.is_none() {
            let text = "there is no result to export yet; open a log first";
            self.app.apply(Command::Notify(text.to_owned()));
        } else if self.app.export_fraction().is_some() {
            self.say(BUSY);
        } else {
            let (folder, amounts) = (self.app.export_folder(), self.app.amounts());
            let statement = self.app.export_statement();
            self.export.ask(&folder, amounts, statement);
        }
    }

    /// Saves what is worked on: the project; without one, the review file that is open; without
    /// either, a project to be named.
    fn save_project(&mut self) {
        if self.app.project_path().is_some() {
            self.app.apply(Command::SaveProject);
        } else if self.app.log.reviewing.path.is_some() {
            self.save_review();
        } else {
            self.name_project();
        }
    }

    /// Shows the folder that was written last.
    fn open_exported(&mut self) {
        let Some(folder) = &self.app.written_into else {
            return;
        };
        // Nobody looks at a file manager in a test.
        if matches!(self.app.jobs(), Jobs::Threads(_))
            && let Err(error) = open::that_detached(folder)
        {
            let text = format!("no file manager opens {}: {error}", folder.display());
            self.app.apply(Command::Notify(text));
        }
    }

    fn toggle_panel(&mut self, panel: SidePanel, ctx: &egui::Context) {
        let (panels, width) = (self.app.view.options.panels, ctx.content_rect().width());
        self.show_panel(panel, !panel.is_shown(panels, width), ctx);
    }

    /// Shows or hides a panel, unless it is so already.
    fn show_panel(&mut self, panel: SidePanel, shown: bool, ctx: &egui::Context) {
        let (panels, width) = (self.app.view.options.panels, ctx.content_rect().width());
        if panel.is_shown(panels, width) != shown {
            self.app.view.options.panels = panel.set_shown(panels, shown, width);
        }
    }

    /// Says why something is not done.
    pub(super) fn say(&mut self, text: &str) {
        self.app.apply(Command::Notify(text.to_owned()));
    }

    /// Asks where a file is to be written, which is proposed beside the log.
    pub(super) fn ask_beside_log(&mut self, purpose: PathPurpose, ending: &str) {
        let proposed = self.sidecar_path(ending);
        self.dialogs.name(purpose, proposed, self.app.jobs());
    }

    /// Moves the keyboard on: to the steps, to the details, back to the views.
    fn focus_panels(&mut self, ctx: &egui::Context) {
        let focused = ctx.memory(|memory| memory.focused());
        let width = ctx.content_rect().width();
        let from = self.keyboard_in.filter(|_| focused.is_some());
        let rest: &[SidePanel] = match from {
            None => &[SidePanel::Steps, SidePanel::Details],
            Some(SidePanel::Steps) => &[SidePanel::Details],
            Some(SidePanel::Details) => &[],
        };
        let panels = self.app.view.options.panels;
        let next = rest.iter().find(|panel| panel.is_shown(panels, width));
        self.keyboard_in = next.copied();
        let title = match next {
            Some(SidePanel::Steps) => "Survey",
            Some(SidePanel::Details) if self.app.has_boxes() => "Review",
            Some(SidePanel::Details) => "Selection",
            None => return leave_control(ctx),
        };
        panels::focus_section(ctx, title);
    }

    /// Opens where the control of a setting is, and moves the keyboard to it.
    fn show_setting(&mut self, ctx: &egui::Context, key: &'static str) {
        match find_setting::place_of(key) {
            Some(ControlPlace::Section(title)) => {
                self.show_panel(SidePanel::Steps, true, ctx);
                panels::unfold_section(ctx, title);
            }
            Some(ControlPlace::Levels) => self.layout.focus(View::Waterfall),
            None => return,
        }
        find_setting::seek(ctx, key);
        self.seeking = SEEK_FRAMES;
        ctx.request_repaint();
    }

    /// Says where the control of a setting would be that was sought and is not drawn: other
    /// settings decide about it.
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
        if self.app.log.reviewing.selected.is_none() {
            return self.say("select a box first, with Tab or a click");
        }
        self.show_panel(SidePanel::Details, true, ctx);
        panels::unfold_section(ctx, "Review");
        self.review.name_box();
    }

    /// Asks where the project is to be kept.
    fn name_project(&mut self) {
        if self.app.log_count() == 0 {
            return self.say("there is nothing to keep yet; open a log first");
        }
        let known = self.app.project_path().map(std::path::Path::to_owned);
        let proposed = known.unwrap_or_else(|| self.sidecar_path("bathyscope"));
        self.dialogs.name(PathPurpose::SaveProject, proposed, self.app.jobs());
    }

    /// Writes the review where it is kept, or asks where that is to be; those of several logs
    /// without asking.
    fn save_review(&mut self) {
        if self.app.review_counts().logs > 1 {
            return self.app.apply(Command::Write(FileToWrite::Reviews));
        }
        match (self.app.review_path(), &self.app.log.reviewing.path) {
            (_, Some(path)) => {
                let path = path.clone();
                self.app.apply(Command::Write(FileToWrite::Review(path)));
            }
            (Some(path), None) if self.app.log.reviewing.has_boxes() => {
                self.dialogs.name(PathPurpose::SaveReview, path, self.app.jobs());
            }
            _ => self.say(NO_BOXES),
        }
    }

    /// The path of a sidecar file of the log.
    pub(super) fn sidecar_path(&self, ending: &str) -> PathBuf {
        let survey = self.app.log.survey.as_ref();
        let log = survey.and_then(|survey| survey.source.files.first());
        log.map_or_else(|| PathBuf::from(ending), |log| log.with_extension(ending))
    }

    fn save_figure(&mut self) {
        if self.app.measured().is_some() {
            self.ask_beside_log(PathPurpose::SaveFigure, "measured.geojson");
        } else {
            self.say("nothing is measured yet; draw a line or an area on the map first");
        }
    }

    fn save_plan(&mut self) {
        if self.app.map.planning.lines.is_some() {
            self.ask_beside_log(PathPurpose::SavePlan, "lines.gpx");
        } else {
            self.say("no lines are planned yet; use Plan lines first");
        }
    }

    /// Asks where a copy of the log is to be written.
    fn ask_for_copy(&mut self, purpose: PathPurpose, ending: &str) {
        if self.app.log.survey.is_none() {
            self.say("there is no log to export yet; open one first");
        } else if self.app.export_fraction().is_some() {
            self.say(BUSY);
        } else {
            self.ask_beside_log(purpose, ending);
        }
    }

    fn save_profile(&mut self) {
        match self.app.profile_csv() {
            Some(_) => self.ask_beside_log(PathPurpose::SaveProfile, "profile.csv"),
            None => self.say(NO_PROFILE),
        }
    }

    fn export_boxes(&mut self) {
        let is_writing = self.app.export_fraction().is_some();
        if !self.app.log.reviewing.has_boxes() {
            self.say(NO_BOXES);
        } else if is_writing {
            self.say(BUSY);
        } else {
            self.dialogs.ask(PathPurpose::ExportBoxesInto, self.app.jobs());
        }
    }
}

/// Arrangement of the views by an action; `None` if the action is no such command.
fn layout_preset(action: Action) -> Option<LayoutPreset> {
    match action {
        Action::LayoutSurvey => Some(LayoutPreset::Survey),
        Action::LayoutReview => Some(LayoutPreset::Review),
        Action::LayoutWaterfall => Some(LayoutPreset::Only(View::Waterfall)),
        Action::LayoutMap => Some(LayoutPreset::Only(View::Map)),
        Action::LayoutCloud => Some(LayoutPreset::Only(View::Cloud)),
        _ => None,
    }
}

/// Takes the keyboard from the control that has it, and gives it back to the views.
fn leave_control(ctx: &egui::Context) {
    if let Some(focused) = ctx.memory(|memory| memory.focused()) {
        ctx.memory_mut(|memory| memory.surrender_focus(focused));
    }
}

fn toggle_full_screen(ctx: &egui::Context) {
    let is_full = ctx.input(|input| input.viewport().fullscreen == Some(true));
    ctx.send_viewport_cmd(egui::ViewportCommand::Fullscreen(!is_full));
}
