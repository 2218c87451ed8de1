//! What each command does to the state.

use super::external::Instrument;
use super::loader::Place;
use super::mounting::with_sides;
use super::project::is_project;
use super::{
    Action, App, Command, LogId, MapLayer, Mark, Orientation, Origin, Reveal, SideColours,
    ThemeChoice, Tool,
};
use crate::detection::review::Edit;
use crate::pipeline::settings::row;
use crate::pipeline::{LogSettings, Preset, Settings};
use crate::project::MeasurementKind;
use crate::support::geo::CoordinateFormat;
use crate::support::presentation::units::{LengthUnit, SpeedUnit};
use crate::support::printable::quoted;
use std::borrow::Cow;
use std::path::PathBuf;
use std::sync::Arc;

impl App {
    /// Carries out a command. Those that only the window can do are left to it.
    pub fn apply(&mut self, command: Command) {
        match command {
            Command::Do(action) => self.act(action),
            Command::Open(path) => self.open_paths(vec![path]),
            Command::SaveProjectAs(path) => self.save_project_as(path),
            Command::SaveProject => self.save_project(),
            Command::OpenAll(paths) => self.open_paths(paths),
            Command::Add(paths) if paths.iter().any(|path| is_project(path)) => {
                self.open_paths(paths);
            }
            Command::Add(paths) => {
                let place = Place::Beside { shown: true };
                self.load(paths.into_iter().map(Origin::Path), place);
            }
            Command::ShowLog(id) => self.show_log(id),
            Command::CloseLog(id) => self.close_log(id),
            Command::MoveLog(id, by) => self.move_log(id, by),
            Command::SetLogVisible(id, is_visible) => self.set_log_visible(id, is_visible),
            Command::FindPasses(at) => self.find_passes(at),
            Command::ShowPlace(at) => self.show_place(at),
            Command::RevealIn(id, mark) => self.reveal_in(id, mark),
            Command::GoToStep(count) => self.go_to_step(count),
            Command::SetOwn { key, own } => self.set_own_key(&key, own),
            Command::OpenDemo => self.start_loading(Origin::Demo),
            Command::Change {
                settings,
                label,
                live,
            } => self.change(*settings, label, live),
            Command::UsePreset(preset) => self.use_preset(preset),
            Command::ProposeStretch(pings) => self.propose_stretch(pings),
            Command::Show(options) => self.options = *options,
            Command::Hover(mark) => self.hover = mark,
            Command::Select(mark) => {
                self.selection = mark;
                self.log.reviewing.selected = None;
                self.log.reviewing.judging.look_away();
            }
            Command::Reveal(mark) => self.reveal(mark),
            Command::Visible(pings) => self.visible = pings,
            Command::Tabulate => self.tabulate(),
            Command::CompareWith(path) => self.compare_with(path),
            Command::MatchBy { by, radius_m } => self.match_by(by, radius_m),
            Command::Measure(request) => self.measure(request),
            Command::Plan(request) => self.change_plan(request),
            Command::SavePlan(path) => self.save_plan(path),
            Command::OpenBaseMap(path) => self.open_base_map(path),
            Command::OpenIsobathArea(path) => self.open_isobath_area(path),
            Command::OpenWaterLevels(path) => self.read_external(path, Some(Instrument::Gauge)),
            Command::OpenTrack(path) => self.read_external(path, Some(Instrument::Receiver)),
            Command::OpenTable(path) => self.read_external(path, None),
            Command::SaveFigure(path) => self.save_figure(path),
            Command::SaveProfile(path) => self.save_profile(path),
            Command::Notify(text) => self.notify(text, true),
            Command::Dismiss(index) => self.dismiss(index),
            Command::Export(folder) => self.export(folder),
            Command::Edit { edit, live } => self.edit(&edit, live),
            Command::MarkTarget(mark) => self.mark_target(mark),
            Command::SetClasses(classes) => {
                self.set_classes(crate::detection::ReviewSettings { classes })
            }
            Command::RenameClass { from, to } => self.rename_class(&from, to.trim()),
            Command::EditIn(log, edit) => {
                self.with_log(log, |app| app.edit(&edit, false));
            }
            Command::SelectBox(id) => self.select_box(id),
            Command::SelectLogBox(id) => self.select_log_box(id),
            Command::FlyTo(id) => self.fly_to(id),
            Command::Nudge(nudge) => self.nudge_box(nudge),
            Command::LeaveOut { log, part, leave } => self.leave_out(log, part, leave),
            Command::AcceptBottom {
                side,
                pings,
                accept,
            } => self.accept_bottom(side, pings, accept),
            Command::DrawBottom(stroke) => self.draw_bottom(&stroke),
            Command::NudgeBottom(samples) => self.nudge_bottom(samples),
            Command::LineUp(queue) => self.set_queue(&queue),
            Command::UseModel(path) => self.use_model(Some(path)),
            Command::OpenReview(path) => self.open_review(path),
            Command::OpenTruth(path) => self.open_truth(path),
            Command::ShowMistake(mistake) => self.show_mistake(&mistake),
            Command::SortMistakes(sort) => self.sort_mistakes(sort),
            Command::SaveReview(path) => self.save_review(path),
            Command::SaveReviews => self.save_reviews(),
            Command::ExportBoxes(folder) => self.export_boxes(folder),
            // Views, their arrangement and the keyboard belong to the shell.
            Command::ByKey { .. }
            | Command::ShowSetting(_)
            | Command::Focus(_)
            | Command::Layout(_)
            | Command::ChooseExportFolder(_)
            | Command::PrintInto(_) => {}
        }
    }

    /// Opens a project, or logs, in the place of what is open.
    fn open_paths(&mut self, paths: Vec<PathBuf>) {
        match paths.iter().find(|path| is_project(path)) {
            Some(project) => self.open_project(project.clone()),
            None => self.load(paths.into_iter().map(Origin::Path), Place::Instead),
        }
    }

    pub(super) fn change(
        &mut self,
        settings: Settings,
        label: impl Into<Cow<'static, str>>,
        live: bool,
    ) {
        let allowed = settings.check().map_err(|error| error.to_string());
        let settings = with_sides(settings, &self.log.settings);
        let before = self.step_now();
        let allowed = allowed.and_then(|()| self.follow_source(&settings));
        let parts = allowed.and_then(|()| {
            let parts = self.log.own.change(&self.shared, &settings);
            parts.map_err(|error| error.to_string())
        });
        let (shared, own) = match parts {
            Ok(parts) => parts,
            Err(text) => {
                // A drag would say it over and over.
                if self.notices.last().is_none_or(|last| last.text != text) {
                    self.notify(text, true);
                }
                return;
            }
        };
        if shared != *self.shared {
            self.shared = Arc::new(shared);
        }
        let own = match own == *self.log.own {
            true => self.log.own.clone(),
            false => Arc::new(own),
        };
        self.log.own = own.clone();
        self.exchange_boxes();
        let after = self.step_now();
        self.record_step(&before, &after, label, live);
        self.set_own(own, live);
        if !live {
            self.share_settings();
        }
        self.settle_plane();
    }

    /// Gives a log its own settings over the shared ones.
    pub(super) fn set_own(&mut self, own: Arc<LogSettings>, live: bool) {
        self.log.own = own;
        match self.log.own.compose(&self.shared) {
            Ok(settings) => self.set(settings, live),
            Err(error) => self.notify(error.to_string(), true),
        }
    }

    /// Has all other logs follow the shared settings.
    fn share_settings(&mut self) {
        let shown = self.log.id;
        let others: Vec<LogId> = self.logs().map(|log| log.id).collect();
        for id in others.into_iter().filter(|id| *id != shown) {
            self.with_log(id, |app| app.set_own(app.log.own.clone(), false));
        }
    }

    fn set(&mut self, settings: Settings, live: bool) {
        if let Err(text) = self.follow_source(&settings) {
            return self.notify(text, true);
        }
        let changed = settings != *self.log.settings;
        if changed {
            self.log.settings = Arc::new(settings);
        }
        let shows_only = self.log.take_settings_of_no_result();
        if !live {
            self.keep_bottom();
        }
        if shows_only {
            return;
        }
        if !self.is_shown() {
            return self.schedule();
        }
        let same_returns = self.log.products.as_ref().is_some_and(|products| {
            let made_with = &products.settings.first_return;
            made_with.finds_the_same(&self.log.settings.first_return)
                && products.settings.image == self.log.settings.image
        });
        if !same_returns && changed {
            self.preview_returns();
        }
        // The search over the whole log waits until the slider is let go; all later stages follow the drag.
        if same_returns && changed || !live && self.stale().is_some() {
            self.process();
        } else if live && changed {
            self.is_waiting = true;
        }
    }

    /// Makes a setting one of the shown log alone, or one that all share again, as an undo step.
    fn set_own_key(&mut self, key: &str, own: bool) {
        let Some(owning) = self.log.own.owning(&self.shared, key, own) else {
            return;
        };
        let before = self.step_now();
        let owning = Arc::new(owning);
        self.log.own = owning.clone();
        let after = self.step_now();
        let what = row(key).map_or(key, |row| row.name);
        let title = match own {
            true => format!("{what} for {} alone", quoted(&self.log.name())),
            false => format!("{what} for all logs again"),
        };
        self.record_named(&before, &after, title);
        self.set_own(owning, false);
    }

    fn use_preset(&mut self, preset: Preset) {
        let settings = Settings::preset(preset).with_survey_of(&self.log.settings);
        self.change(settings, "preset", false);
    }

    pub(super) fn reveal(&mut self, mark: Mark) {
        let serial = self.reveal.map_or(0, |reveal| reveal.serial) + 1;
        self.selection = Some(mark);
        self.reveal = Some(Reveal {
            mark,
            serial,
            close_up: None,
        });
    }

    fn act(&mut self, action: Action) {
        match action {
            Action::OpenDemo => self.start_loading(Origin::Demo),
            Action::FollowRecording => self.toggle_following(),
            Action::Undo => self.undo(),
            Action::Redo => self.redo(),
            Action::Update => self.update(),
            Action::NextLog => self.step_log(1),
            Action::PreviousLog => self.step_log(-1),
            Action::ShowTogether => self.show_together(),
            Action::CloseLog => self.close_log(self.log.id),
            Action::Cancel => {
                self.cancel();
            }
            Action::PreviousPing => self.step(-1),
            Action::NextPing => self.step(1),
            Action::Back25 => self.step(-25),
            Action::Forward25 => self.step(25),
            Action::FirstPing => self.step(isize::MIN),
            Action::LastPing => self.step(isize::MAX),
            Action::ThresholdDown => self.nudge_threshold(-0.01),
            Action::ThresholdUp => self.nudge_threshold(0.01),
            Action::FirstReturnLine => {
                let waterfall = &mut self.options.waterfall;
                waterfall.first_return = !waterfall.first_return;
            }
            Action::DepthLine => {
                let waterfall = &mut self.options.waterfall;
                waterfall.depth_line = !waterfall.depth_line;
            }
            Action::LevelsReset => self.reset_picture(),
            Action::GainNormalised => self.toggle_gain(),
            Action::Despeckle => self.toggle_despeckle(),
            Action::StripeFilter => self.toggle_stripe_filter(),
            Action::FlipAlong => self.toggle_flip(),
            Action::StarboardFirst => self.toggle_starboard_first(),
            Action::SwapSides => self.swap_sides(),
            Action::UseMounting => self.use_mounting(),
            Action::ForgetMounting => self.forget_mounting(),
            Action::RangeLines => {
                let waterfall = &mut self.options.waterfall;
                waterfall.range_lines = !waterfall.range_lines;
            }
            Action::DepthMapLayer => self.options.map.layers.toggle(MapLayer::DepthMap),
            Action::HillShadeLayer => self.options.map.layers.toggle(MapLayer::HillShade),
            Action::MosaicLayer => self.options.map.layers.toggle(MapLayer::Mosaic),
            Action::IsobathLayer => self.options.map.layers.toggle(MapLayer::Isobaths),
            Action::PointLayer => self.options.map.layers.toggle(MapLayer::Points),
            Action::ResidualLayer => self.options.map.layers.toggle(MapLayer::Residuals),
            Action::TrackLayer => self.options.map.layers.toggle(MapLayer::Track),
            Action::BoxLayer => self.options.map.layers.toggle(MapLayer::Boxes),
            Action::Boxes => self.toggle_boxes(),
            Action::SideColours => {
                self.options.side_colours = match self.options.side_colours {
                    SideColours::Paper => SideColours::Maritime,
                    SideColours::Maritime => SideColours::Paper,
                }
            }
            Action::BaseMapLayer => self.options.map.layers.toggle(MapLayer::BaseMap),
            Action::CloseReference => self.leave_reference(),
            Action::RemoveIsobathArea => self.remove_isobath_area(),
            Action::RemoveWaterLevels => self.remove_water_levels(),
            Action::RemoveTrack => self.remove_track(),
            Action::CloseBaseMap => self.close_base_map(),
            Action::Swipe => self.options.map.swipe.toggle(&mut self.options.map.layers),
            Action::Graticule => self.options.map.graticule = !self.options.map.graticule,
            Action::CoordinatesDegrees => self.options.coordinates = CoordinateFormat::Degrees,
            Action::CoordinatesMinutes => self.options.coordinates = CoordinateFormat::Minutes,
            Action::CoordinatesSeconds => self.options.coordinates = CoordinateFormat::Seconds,
            Action::CoordinatesUtm => self.options.coordinates = CoordinateFormat::Utm,
            Action::UnitsMetres => self.options.units.length = LengthUnit::Metres,
            Action::UnitsFeet => self.options.units.length = LengthUnit::Feet,
            Action::UnitsFathoms => self.options.units.length = LengthUnit::Fathoms,
            Action::SpeedMetres => self.options.units.speed = SpeedUnit::MetresPerSecond,
            Action::SpeedKnots => self.options.units.speed = SpeedUnit::Knots,
            Action::CompareHeights => self.match_heights(),
            Action::ApplyHeights => self.apply_heights(),
            Action::ComparePositions => self.match_positions(),
            Action::ApplyPositions => self.apply_positions(),
            Action::Calibrate => self.take_calibration_tool(),
            Action::UseScale => self.use_scale(),
            Action::KeepRecordedRange => self.keep_recorded_range(),
            Action::DropProposal => self.drop_proposal(),
            Action::UseFlatterStretch => self.use_offered_stretch(),
            Action::OutlierPreview => {
                self.options.cloud.outlier_preview = !self.options.cloud.outlier_preview;
            }
            Action::NextCloudColour => {
                let has_several = self.log_count() > 1;
                self.options.cloud.colour = self.options.cloud.colour.next(has_several);
            }
            Action::Bottom3d => self.options.cloud.bottom = !self.options.cloud.bottom,
            Action::NextBottomColour => {
                let cloud = &mut self.options.cloud;
                // What is not shown is shown as it was.
                if std::mem::replace(&mut cloud.bottom, true) {
                    cloud.bottom_colour = cloud.bottom_colour.next();
                }
            }
            Action::BottomIsobaths => self.options.cloud.isobaths = !self.options.cloud.isobaths,
            Action::TurnLight => self.options.cloud.turn_light(),
            Action::ClipBox3d => self.options.cloud.toggle_clip(),
            Action::NextPass => self.next_pass(),
            Action::Cut3d => self.toggle_cut(),
            Action::Water3d => self.options.cloud.water = !self.options.cloud.water,
            Action::Points3d => self.options.cloud.points = !self.options.cloud.points,
            Action::Theme => {
                self.options.theme = match self.options.theme {
                    ThemeChoice::Dark => ThemeChoice::Light,
                    ThemeChoice::Light => ThemeChoice::Dark,
                }
            }
            Action::Orientation => {
                let waterfall = &mut self.options.waterfall;
                waterfall.orientation = match waterfall.orientation {
                    Orientation::Horizontal => Orientation::Vertical,
                    Orientation::Vertical => Orientation::Horizontal,
                }
            }
            Action::GroundRange => {
                let waterfall = &mut self.options.waterfall;
                waterfall.ground_range = !waterfall.ground_range;
            }
            Action::WaterColumn => {
                let waterfall = &mut self.options.waterfall;
                waterfall.water_column = !waterfall.water_column;
            }
            Action::NextChannel => self.next_channel(),
            Action::PresetRecommended => self.use_preset(Preset::Recommended),
            Action::PresetPublished => self.use_preset(Preset::Published),
            Action::FindObjects => self.detect(),
            Action::ShippedModel => self.use_model(None),
            Action::NextBox => self.step_box(1),
            Action::PreviousBox => self.step_box(-1),
            Action::AcceptBox => self.decide(Edit::Accept),
            Action::RejectBox => self.decide(Edit::Reject),
            Action::UndecideBox => self.edit_selected(Edit::Undecide),
            Action::AcceptObject => self.decide_object(Edit::Accept, "accept object"),
            Action::RejectObject => self.decide_object(Edit::Reject, "reject object"),
            Action::UndecideObject => {
                self.edit_object(Edit::Undecide, "mark object as undecided");
            }
            Action::NextSighting => self.step_sighting(),
            Action::FlyToBox => match self.selected_log_box() {
                Some(id) => self.fly_to(id),
                None => self.ask_for_box(),
            },
            Action::ZoomToBoxes => self.toggle_zoom_to_boxes(),
            Action::SwapSide => self.edit_selected(Edit::SwapSide),
            Action::RemoveBox => self.remove_box(),
            Action::EditBox => self.take_tool(Tool::Edit),
            Action::NewBox => self.take_tool(Tool::Draw),
            Action::NextEdge => self.next_edge(),
            Action::FindEdges => self.edit_selected(Edit::FindEdges),
            Action::MarkTarget => self.point_tool(),
            Action::LeaveOut => self.take_tool(Tool::LeaveOut),
            Action::TakeBackIn => self.take_back_in(),
            Action::DrawBottom => self.take_tool(Tool::Bottom),
            Action::BottomBothSides => {
                let both = &mut self.options.waterfall.bottom_both_sides;
                *both = !*both;
            }
            Action::AcceptBottom => self.take_tool(Tool::Accept),
            Action::ForgetBottom => self.forget_bottom(),
            Action::LeaveTool if self.leave_measuring() => {}
            Action::LeaveTool if self.log.reviewing.is_in_use() => self.leave_tool(),
            Action::LeaveTool if self.log.proposed_stretch().is_some() => self.drop_proposal(),
            Action::LeaveTool => self.remove_figure(),
            Action::MeasureDistance => self.take_measuring_tool(MeasurementKind::Distance),
            Action::MeasureArea => self.take_measuring_tool(MeasurementKind::Area),
            Action::DepthProfile => self.take_measuring_tool(MeasurementKind::Profile),
            Action::UseShadow => self.use_shadow(),
            Action::HeightFromShadow => self.take_measuring_tool(MeasurementKind::Height),
            Action::TakeCornerBack => self.take_corner_back(),
            Action::EndFigure => self.end_figure(),
            Action::RemoveFigure => self.remove_figure(),
            Action::PlanLines => self.plan_lines(),
            Action::RemoveLine => self.remove_line(),
            Action::RemovePlan => self.remove_plan(),
            Action::TakeUpUnsaved => self.take_up_unsaved(),
            Action::ForgetTruth => self.forget_truth(),
            Action::NextMistake => self.step_mistake(1),
            Action::PreviousMistake => self.step_mistake(-1),
            // Windows, dialogs, layout and cameras belong to the shell.
            _ => {}
        }
    }

    fn update(&mut self) {
        self.tabulating.resume();
        self.process();
    }

    fn toggle_boxes(&mut self) {
        let shown = !self.options.shows_boxes();
        self.options.show_boxes(shown);
        if !shown && self.has_boxes() {
            let keys = Action::Boxes.keys().unwrap_or_default();
            self.notify(format!("boxes are hidden; {keys} shows them again"), false);
        }
    }

    fn step(&mut self, pings: isize) {
        let Some(last) = self
            .log
            .survey
            .as_ref()
            .and_then(|survey| survey.side_scan.len().checked_sub(1))
        else {
            return;
        };
        let ping = match self.selection {
            Some(mark) => mark.ping.saturating_add_signed(pings).min(last),
            None if pings == isize::MAX => last,
            None => 0,
        };
        self.reveal(Mark::ping(ping));
    }

    fn nudge_threshold(&mut self, by: f32) {
        let mut settings = Settings::clone(&self.log.settings);
        let threshold = settings.first_return.threshold + by;
        // Steps of a hundredth stay hundredths.
        settings.first_return.threshold = ((threshold * 100.0).round() / 100.0).clamp(0.0, 1.0);
        self.change(settings, "threshold", false);
    }
}
