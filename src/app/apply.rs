//! Applies each command to the state, and assigns to each command without arguments the function
//! that carries it out and the condition under which it has something to act on.

use super::action::action_rows;
use super::crossings::FoundHeights;
use super::error::AppError;
use super::opening::OpenMode;
use super::project::is_project;
use super::source::{Instrument, with_sides};
use super::{
    Action, App, Command, Enlarged, FileToOpen, FileToWrite, FoundPositions, LayoutPreset, LogId,
    LogOrigin, LogPlace, MapLayer, Orientation, SideColours, ThemeChoice, Tool, View, ViewOptions,
    WindowAction, WorkStep,
};
use bathyscope_bottom::mosaic::Gain;
use bathyscope_bottom::presentation::units::{LengthUnit, SpeedUnit};
use bathyscope_log::support::geo::CoordinateFormat;
use bathyscope_objects::ReviewSettings;
use bathyscope_objects::review::Edit;
use bathyscope_products::pipeline::settings::{self, ControlValue};
use bathyscope_products::pipeline::{LogSettings, Preset, Settings, SettingsError};
use bathyscope_products::project::MeasurementKind;
use std::borrow::Cow;
use std::path::PathBuf;
use std::sync::Arc;

/// Effect of a command.
enum Effect {
    /// A function that changes the state.
    State(fn(&mut App)),
    /// A function that changes the settings of the shown log, with the name of its undo step.
    Settings(&'static str, fn(&mut Settings)),
    /// A function that changes the display options.
    Options(fn(&mut ViewOptions)),
    /// A display option that the command turns on or off, with its name.
    Toggle(&'static str, fn(&mut ViewOptions) -> &mut bool),
    /// Something that the window carries out.
    Window(WindowAction),
}

macro_rules! effects {
    ($(
        $(#[$of_group:meta])*
        $group:ident {$(
            $action:ident, $label:literal, $($with:ident($($arg:tt)*),)* $hint:literal
                => $effect:ident($($do:tt)*) $(, when($($when:tt)*))?;
        )*}
    )*) => {
        impl Action {
            fn effect(self) -> Effect {
                match self {
                    $($(Action::$action => Effect::$effect($($do)*),)*)*
                }
            }

            /// Returns the condition under which a command has something to act on; `None` for
            /// commands that notify the analyst themselves of what is missing.
            fn condition(self) -> Option<fn(&App) -> bool> {
                match self {
                    $($($(Action::$action => Some($($when)*),)?)*)*
                    _ => None,
                }
            }
        }
    };
}

action_rows!(effects);

impl Action {
    /// Returns the effect of a command on the window; `None` for a command that changes the state.
    pub(crate) fn in_window(self) -> Option<WindowAction> {
        match self.effect() {
            Effect::Window(action) => Some(action),
            _ => None,
        }
    }

    /// Returns the name of the display option that the command turns on or off, and the option in
    /// `options`; `None` for other commands.
    pub(crate) fn display_option(
        self,
        options: &mut ViewOptions,
    ) -> Option<(&'static str, &mut bool)> {
        match self.effect() {
            Effect::Toggle(name, option) => Some((name, option(options))),
            _ => None,
        }
    }
}

impl App {
    /// Carries out a command; commands of the window have no effect here.
    pub fn apply(&mut self, command: Command) {
        match command {
            Command::Do(action) => self.act(action),
            Command::Open(path) => self.open_paths(vec![path]),
            Command::SaveProject => self.save_project(),
            Command::OpenAll(paths) => self.open_paths(paths),
            Command::Add(paths) if paths.iter().any(|path| is_project(path)) => {
                self.open_paths(paths);
            }
            Command::Add(paths) => {
                let place = OpenMode::Added { shown: true };
                self.load(paths.into_iter().map(LogOrigin::Path), place);
            }
            Command::ShowLog(id) => self.show_log(id),
            Command::CloseLog(id) => self.close_log(id),
            Command::MoveLog(id, by) => self.move_log(id, by),
            Command::HoldHeight(held) => self.findings.heights.held = held,
            Command::SetLogVisible(id, is_visible) => self.set_log_visible(id, is_visible),
            Command::FindPasses(at) => self.find_passes(at),
            Command::ShowPlace(at) => self.show_place(at),
            Command::RevealIn(id, mark) => self.reveal_in(id, mark),
            Command::GoToStep(count) => self.go_to_step(count),
            Command::OpenDemo => self.act(Action::OpenDemo),
            Command::Change { settings, label, live } => {
                self.change_of(self.logs.shown.id, *settings, label, live);
            }
            Command::Set { key, value, live } => self.set_by_control(key, value, live),
            Command::UsePreset(preset) => self.use_preset(preset),
            Command::ProposeStretch(pings) => self.logs.shown.propose_stretch(pings),
            Command::Show(options) => self.view.options = *options,
            Command::Hover(mark) => self.view.hover = mark,
            Command::Select(mark) => {
                self.view.selection = mark;
                self.logs.shown.reviewing.selected = None;
                self.logs.shown.reviewing.judging.look_away();
            }
            Command::Reveal(mark) => self.view.reveal(mark),
            Command::Visible(pings) => self.view.visible = pings,
            Command::CompareWithReference => self.compare_with_reference(),
            Command::CompareWith(path) => self.compare_with(path),
            Command::MatchBy { by, radius_m } => self.map.comparing.match_by(by, radius_m),
            Command::Measure(request) => self.measure(request),
            Command::Plan(request) => self.change_plan(request),
            Command::Notify(text) => self.notices.warn(text),
            Command::Dismiss(index) => self.notices.dismiss(index),
            Command::Edit { edit, live } => self.edit(&edit, live),
            Command::MarkTarget(mark) => self.mark_target(mark),
            Command::SetClasses(classes) => {
                let review = ReviewSettings { classes };
                self.edit_settings("classes of objects", |settings| settings.review = review);
            }
            Command::RenameClass { from, to } => self.rename_class(&from, to.trim()),
            Command::EditIn(log, edit) => {
                self.edit_of(log, &edit, false);
            }
            Command::SelectBox(id) => self.select_box(id),
            Command::SelectLogBox(id) => self.select_log_box(id),
            Command::FlyTo(id) => self.show_box(id, Enlarged::Third),
            Command::Nudge(nudge) => self.nudge_box(nudge),
            Command::Exclude { log, part, edit } => self.exclude(log, part, edit),
            Command::AcceptBottom { side, pings, accept } => {
                self.accept_bottom(side, pings, accept)
            }
            Command::DrawBottom(stroke) => self.draw_bottom(&stroke),
            Command::NudgeBottom(samples) => self.nudge_bottom(samples),
            Command::LineUp(queue) => self.logs.set_queue(&queue),
            Command::UseModel(path) => self.findings.search.use_model(Some(path)),
            Command::ShowMistake(mistake) => self.show_mistake(&mistake),
            Command::SortMistakes(sort) => self.logs.shown.reviewing.sort_mistakes(sort),
            Command::Write(file) => self.write_file(file),
            Command::OpenFile(file) => self.open_file(file),
            // Views, their arrangement and the keyboard are handled by the window.
            Command::ByKey { .. }
            | Command::ShowSetting(_)
            | Command::ShowSection(_)
            | Command::Focus(_)
            | Command::ChooseExportFolder(_)
            | Command::PrintInto(_) => {}
        }
    }

    /// Writes a file or a folder.
    fn write_file(&mut self, file: FileToWrite) {
        match file {
            FileToWrite::Project(path) => self.save_project_as(path),
            FileToWrite::Plan(path) => self.save_plan(path),
            FileToWrite::Figure(path) => self.save_figure(path),
            FileToWrite::Profile(path) => self.save_profile(path),
            FileToWrite::Products(folder) => self.export(folder),
            FileToWrite::Review(path) => self.save_review(self.logs.shown.id, path),
            FileToWrite::Reviews => self.save_reviews(),
            FileToWrite::Boxes(folder) => self.export_boxes(folder),
            FileToWrite::Log(path) => self.export_log(path, None),
            FileToWrite::Pings(path) => self.export_log(path, Some(self.view.visible.clone())),
        }
    }

    /// Reads a file for the open survey.
    fn open_file(&mut self, file: FileToOpen) {
        match file {
            FileToOpen::BaseMap(path) => self.open_base_map(path, false),
            FileToOpen::IsobathArea(path) => self.open_isobath_area(path),
            FileToOpen::WaterLevels(path) => {
                self.read_external(self.logs.shown.id, path, Some(Instrument::Gauge))
            }
            FileToOpen::Track(path) => {
                self.read_external(self.logs.shown.id, path, Some(Instrument::Receiver))
            }
            FileToOpen::Table(path) => self.read_external(self.logs.shown.id, path, None),
            FileToOpen::Review(path) => self.open_review(path),
            FileToOpen::Truth(path) => self.open_truth(path),
        }
    }

    /// Opens a project or logs, and replaces what is open.
    fn open_paths(&mut self, paths: Vec<PathBuf>) {
        match paths.iter().find(|path| is_project(path)) {
            Some(project) => self.open_project(project.clone()),
            None => self.load(paths.into_iter().map(LogOrigin::Path), OpenMode::Instead),
        }
    }

    /// Returns `false` if a command would remove or leave something that does not exist.
    pub(crate) fn is_available(&self, action: Action) -> bool {
        action.condition().is_none_or(|condition| condition(self))
    }

    /// Carries out a command; commands of the window have no effect here.
    fn act(&mut self, action: Action) {
        match action.effect() {
            Effect::State(change) => change(self),
            Effect::Settings(label, change) => self.edit_settings(label, change),
            Effect::Options(change) => change(&mut self.view.options),
            Effect::Toggle(_, option) => toggle(option(&mut self.view.options)),
            Effect::Window(_) => {}
        }
    }

    /// Changes the settings of the shown log by a function, as an undo step.
    pub(super) fn edit_settings(
        &mut self,
        label: &'static str,
        change: impl FnOnce(&mut Settings),
    ) {
        let mut settings = Settings::clone(&self.logs.shown.settings);
        change(&mut settings);
        self.change_of(self.logs.shown.id, settings, label, false);
    }

    /// Gives a setting of the shown log the value of its control.
    fn set_by_control(&mut self, key: &'static str, value: ControlValue, live: bool) {
        let Some(row) = settings::row(key) else {
            return;
        };
        let mut settings = Settings::clone(&self.logs.shown.settings);
        row.set(&mut settings, value);
        // A value that is set again changes nothing, but may end the undo step of a drag.
        let is_same = settings == *self.logs.shown.settings;
        self.change_by(self.logs.shown.id, settings, row.name, live, |own, shared, after| {
            Ok(if is_same {
                (shared.clone(), own.clone())
            } else {
                own.set_by_control(shared, after, (row, value))
            })
        });
    }

    /// Changes the settings of a log, and the shared settings of all other logs with them.
    pub(super) fn change_of(
        &mut self,
        id: LogId,
        settings: Settings,
        label: impl Into<Cow<'static, str>>,
        live: bool,
    ) {
        self.change_by(id, settings, label, live, LogSettings::change);
    }

    /// Changes the settings of a log to `settings`; `parts` returns the shared settings and the
    /// log's own after the change.
    fn change_by(
        &mut self,
        id: LogId,
        settings: Settings,
        label: impl Into<Cow<'static, str>>,
        live: bool,
        parts: impl FnOnce(
            &LogSettings,
            &Settings,
            &Settings,
        ) -> Result<(Settings, LogSettings), SettingsError>,
    ) {
        let Some(log) = self.logs.get_mut(id) else {
            return;
        };
        let allowed = settings.check().map_err(AppError::from);
        let settings = with_sides(settings, &log.settings);
        let own_before = log.own.clone();
        let before = self.step_now();
        let allowed = allowed.and_then(|()| self.follow_source(id, &settings));
        let parts =
            allowed.and_then(|()| Ok(parts(&own_before, &self.document.shared, &settings)?));
        let (shared, own) = match parts {
            Ok(parts) => parts,
            Err(error) => {
                let text = error.to_string();
                // A drag would repeat the notice over and over.
                if self.notices.shown().last().is_none_or(|last| last.text != text) {
                    self.notices.warn(text);
                }
                return;
            }
        };
        if shared != *self.document.shared {
            self.document.shared = Arc::new(shared);
        }
        let own = if own == *own_before { own_before } else { Arc::new(own) };
        if let Some(log) = self.logs.get_mut(id) {
            log.own = own.clone();
            log.exchange_boxes();
        }
        self.record_step(&before, label, live);
        self.set_own(id, own, live);
        if !live {
            // The shared settings apply to all other logs.
            let others = self.logs.all().filter(|log| log.id != id);
            let others: Vec<_> = others.map(|log| (log.id, log.own.clone())).collect();
            for (id, own) in others {
                self.set_own(id, own, false);
            }
        }
        self.settle_plane();
    }

    /// Sets the own settings of a log, and its settings, composed of these and the shared ones.
    pub(super) fn set_own(&mut self, id: LogId, own: Arc<LogSettings>, live: bool) {
        let composed = own.compose(&self.document.shared).map_err(AppError::from);
        let Some(log) = self.logs.get_mut(id) else {
            return;
        };
        log.own = own;
        let followed = composed.and_then(|settings| {
            self.follow_source(id, &settings)?;
            Ok(settings)
        });
        let settings = match followed {
            Ok(settings) => settings,
            Err(error) => return self.notices.warn(error),
        };
        let Some(log) = self.logs.get_mut(id) else {
            return;
        };
        let changed = settings != *log.settings;
        if changed {
            log.settings = Arc::new(settings);
        }
        if log.take_settings_of_no_result() {
            return;
        }
        if id != self.logs.shown.id {
            return self.schedule();
        }
        let same_returns = self.logs.shown.products.as_ref().is_some_and(|products| {
            let made_with = &products.settings.first_return;
            made_with.finds_the_same(&self.logs.shown.settings.first_return)
                && products.settings.image == self.logs.shown.settings.image
        });
        if !same_returns
            && changed
            && let Some(request) = self.preview_request()
        {
            self.pipeline.previewer.want(request, &mut self.jobs);
        }
        // The search for first returns over the whole log waits until the slider is released; all
        // later stages follow the drag.
        if same_returns && changed || !live && self.logs.shown.stale().is_some() {
            self.process();
        } else if live && changed {
            self.pipeline.is_waiting = true;
        }
    }

    fn use_preset(&mut self, preset: Preset) {
        self.edit_settings("preset", |settings| {
            *settings = Settings::preset(preset).with_survey_of(settings);
        });
    }

    /// Leaves the innermost activity: measuring, a tool or selected box, a proposed stretch, the
    /// finished measurement, or else the selected ping.
    fn leave_current_tool(&mut self) {
        if self.leave_measuring() {
            return;
        }
        let shown = &mut self.logs.shown;
        if shown.reviewing.tool != Tool::Look {
            shown.reviewing.tool = Tool::Look;
        } else if shown.reviewing.selected.is_some() {
            self.select_box(None);
        } else if shown.proposed_stretch().is_some() {
            shown.calibrating.drop_proposal();
        } else if self.map.measuring.figure.is_some() {
            self.remove_figure();
        } else {
            self.view.selection = None;
        }
    }

    fn toggle_boxes(&mut self) {
        let shown = !self.view.options.shows_boxes();
        self.view.options.show_boxes(shown);
        if !shown && self.logs.has_boxes() {
            let keys = Action::Boxes.key();
            self.notices.notify(format!("boxes are hidden; {keys} shows them again"));
        }
    }

    fn step(&mut self, pings: isize) {
        let survey = self.logs.shown.survey.as_ref();
        let Some(last) = survey.and_then(|survey| survey.side_scan.len().checked_sub(1)) else {
            return;
        };
        let ping = match self.view.selection {
            Some(mark) => mark.ping.saturating_add_signed(pings).min(last),
            None if pings == isize::MAX => last,
            None => 0,
        };
        self.view.reveal(LogPlace::ping(ping));
    }
}

fn toggle(option: &mut bool) {
    *option = !*option;
}

/// Exchanges one of two choices for the other.
fn exchange<T: PartialEq>(choice: &mut T, [one, other]: [T; 2]) {
    *choice = if *choice == one { other } else { one };
}

fn nudge_threshold(settings: &mut Settings, by: f32) {
    let threshold = settings.first_return.threshold + by;
    // Rounding keeps the steps of a hundredth exact.
    settings.first_return.threshold = ((threshold * 100.0).round() / 100.0).clamp(0.0, 1.0);
}

fn next_bottom_colour(options: &mut ViewOptions) {
    let cloud = &mut options.cloud;
    // A hidden bottom is shown with the colours that it had.
    if std::mem::replace(&mut cloud.bottom, true) {
        cloud.bottom_colour = cloud.bottom_colour.next();
    }
}
