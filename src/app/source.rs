//! Applies to a log what its settings say of its source: recordings of other instruments, which are
//! readings of a gauge and the track of another receiver, and the mounting of its recorder, which
//! are exchanged sides and the default for the logs of a recorder.
//!
//! Files are read in a background thread. A file becomes part of the settings only if it fits the
//! log; another file leaves everything as it was.

use super::error::AppError;
use super::jobs::JobKey;
use super::{App, LogId, OpenLog};
use bathyscope_bottom::calibration::SoundingLag;
use bathyscope_bottom::cloud::Correction;
use bathyscope_bottom::cloud::correction::WaterLevelSettings;
use bathyscope_log::formats::{TrackFile, read_gauge};
use bathyscope_log::support::file_error::FileError;
use bathyscope_log::support::geo::{Crs, LocalFrame};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::support::regular_file;
use bathyscope_log::survey::{Gauge, MountingSettings, Side, Survey, TrackSettings, TracksApart};
use bathyscope_products::pipeline::{Settings, SourceKey, as_set};
use std::collections::BTreeMap;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Number of pairs of positions at which two tracks are compared.
const PAIRS: usize = 400;

/// Name of undo steps that change the track of another receiver.
const TRACK: &str = "external track";

/// Mountings by recorder ([`bathyscope_log::survey::Source::recorder`]).
pub type Mountings = BTreeMap<String, MountingSettings>;

/// Kind of instrument that recorded a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Instrument {
    /// A gauge or tide table: readings of the water's height.
    Gauge,
    /// A receiver of satellites: a track.
    Receiver,
}

enum ExternalContent {
    Levels(Gauge),
    Track(TrackFile),
    /// A table of neither kind: points to compare the survey with.
    Points(PathBuf),
}

/// Recordings of other instruments, and their effect on the survey.
#[derive(Default)]
pub struct External {
    /// The survey with the recorder's own track, while another track replaces it; otherwise `None`.
    pub recorded: Option<Arc<Survey>>,
    /// Distance between the two tracks.
    pub apart: Arc<TracksApart>,
    /// The tracks that were read for the open survey, so that undo can restore them.
    tracks: Vec<Arc<TrackFile>>,
}

impl External {
    /// Returns a copy that holds only the drawn parts.
    pub(super) fn for_picture(&self) -> Self {
        Self { recorded: self.recorded.clone(), apart: self.apart.clone(), ..Self::default() }
    }

    /// Returns the track of a file, which is read unless it was read before.
    fn track(&mut self, path: &Path) -> Result<Arc<TrackFile>, FileError> {
        if let Some(known) = self.tracks.iter().find(|track| track.path() == path) {
            return Ok(known.clone());
        }
        let read = Arc::new(TrackFile::read(path)?);
        self.tracks.push(read.clone());
        Ok(read)
    }

    fn keep(&mut self, track: TrackFile) {
        self.tracks.retain(|known| known.path() != track.path());
        self.tracks.push(Arc::new(track));
    }
}

impl App {
    /// Starts reading a file for a log; without an instrument, the columns of the file identify it.
    pub(super) fn read_external(
        &mut self,
        id: LogId,
        path: PathBuf,
        instrument: Option<Instrument>,
    ) {
        let work = move |_: &Progress| -> Result<_, AppError> {
            match instrument.or_else(|| instrument_of(&path)) {
                Some(Instrument::Gauge) => Ok(ExternalContent::Levels(read_gauge(&path)?)),
                Some(Instrument::Receiver) => Ok(ExternalContent::Track(TrackFile::read(&path)?)),
                None => Ok(ExternalContent::Points(path)),
            }
        };
        if self.logs.get(id).is_none() {
            return self.notices.warn("open the log first, then its water levels or its track");
        }
        self.jobs.run(JobKey::ReadTable(id), work, move |app, read| match read {
            Ok(ExternalContent::Levels(gauge)) => app.take_levels(id, gauge),
            Ok(ExternalContent::Track(track)) => app.take_track(id, track),
            Ok(ExternalContent::Points(path)) => app.compare_with(path),
            Err(error) => app.notices.warn(error),
        });
    }

    fn take_levels(&mut self, id: LogId, gauge: Gauge) {
        let Some((log, survey)) = self.logs.log_and_survey(id) else {
            return;
        };
        let mut settings = Settings::clone(&log.settings);
        settings.water_level =
            WaterLevelSettings { file: Some(gauge.path.clone()), gauge: Some(Arc::new(gauge)) };
        match Correction::new(settings.depth(), survey).refused {
            Some(why) => self.notices.warn(why),
            None => self.change_of(id, settings, "water levels", false),
        }
    }

    fn take_track(&mut self, id: LogId, track: TrackFile) {
        let Some(log) = self.logs.get_mut(id) else {
            return;
        };
        let mut settings = Settings::clone(&log.settings);
        settings.track.file = Some(track.path().to_owned());
        // The same file may have been written again meanwhile.
        if settings.track == log.settings.track {
            let mut without = settings.clone();
            without.track = TrackSettings::default();
            self.change_of(id, without, TRACK, false);
        }
        if let Some(log) = self.logs.get_mut(id) {
            log.external.keep(track);
        }
        self.change_of(id, settings, TRACK, false);
    }

    /// Applies the settings of a log's source to its survey, and updates everything that depends on
    /// its plane and its sides. After an error the log is unchanged.
    pub(super) fn follow_source(&mut self, id: LogId, settings: &Settings) -> Result<(), AppError> {
        // Several logs share one plane.
        let plane = (self.logs.count() > 1).then(|| self.document.plane.clone());
        let Some(log) = self.logs.get_mut(id) else {
            return Ok(());
        };
        let Some([before, now]) = log.follow_source(settings, plane.as_ref())? else {
            return Ok(());
        };
        if now.track.frame.origin() != before.track.frame.origin() {
            self.enter_plane(now.track.frame.clone());
        }
        self.document.is_plane_moved |= system_of(&now) != system_of(&before);
        if now.swapped_sides != before.swapped_sides {
            self.forget_preview(id);
            // The results of a search of the log as it was would be put on the wrong side.
            self.findings.search.leave(id, &mut self.jobs);
            if id == self.logs.shown.id {
                // The marks stay on the same echo.
                let marks = [&mut self.view.selection, &mut self.view.hover];
                for mark in marks.into_iter().flatten() {
                    mark.side = mark.side.map(Side::other);
                }
            }
        }
        Ok(())
    }

    /// Moves all logs into the plane of the first log with a position on the Earth, after the
    /// coordinate system of a log's metres has changed: a plane thousands of kilometres away would
    /// distort their positions.
    pub(super) fn settle_plane(&mut self) {
        if !std::mem::take(&mut self.document.is_plane_moved) || self.logs.count() < 2 {
            return;
        }
        let on_earth =
            |survey: &Arc<Survey>| survey.track.projected.is_none() || system_of(survey).is_some();
        let visible = || self.logs.visible().filter(|log| log.is_placed());
        let first = visible().find(|log| log.survey.as_ref().is_some_and(on_earth));
        let first = first.or_else(|| visible().next());
        let first = first.or_else(|| self.logs.all().find(|log| log.is_placed()));
        let fix = first.and_then(|log| log.survey.as_ref()?.track.fixes.first());
        let Some(fix) = fix else {
            return;
        };
        let frame = LocalFrame::new(fix.position);
        self.enter_plane(frame.clone());
        for log in self.logs.all_mut() {
            for survey in [&mut log.survey, &mut log.as_read, &mut log.external.recorded] {
                *survey =
                    survey.take().map(|survey| Arc::new(Survey::clone(&survey).in_frame(&frame)));
            }
            // Their positions are in the earlier plane.
            log.products = None;
            log.preview = None;
        }
        self.schedule();
    }

    /// Returns the default mounting of the shown log's recorder; `None` if it has none.
    pub(crate) fn usual_mounting(&self) -> Option<MountingSettings> {
        self.document.mountings.get(&self.logs.shown.recorder()).copied()
    }

    /// Shifts the soundings of the shown log to earlier times by the lag that its first returns
    /// show.
    pub(super) fn apply_sounding_lag(&mut self) {
        let Some((lag, in_force_s)) = self.logs.shown.sounding_lag() else {
            return self.notices.warn("first returns show no lag of the soundings");
        };
        let lag_s = in_force_s + lag.told_s();
        self.edit_settings("lag of the soundings", |settings| {
            settings.mounting.sounding_lag_s = lag_s;
        });
    }

    /// Applies the default mounting of its recorder to a log that was just opened. This is not an
    /// undo step.
    pub(super) fn mount_as_usual(&mut self, id: LogId) {
        let Some(log) = self.logs.get(id) else {
            return;
        };
        let (name, recorder, shared) = (log.name(), log.recorder(), log.settings.clone());
        if let Err(error) = self.follow_source(id, &shared) {
            self.notices.warn(error);
        }
        let Some(mounting) = self.document.mountings.get(&recorder).copied() else {
            return;
        };
        let mounted = self.mount(id, mounting);
        let said = |()| format!("{name} has the default mounting of {recorder}");
        self.notices.tell(mounted.map(said));
    }

    /// Makes the mounting of the shown log the default of its recorder, and applies it to all open
    /// logs of that recorder, as an undo step.
    pub(super) fn use_mounting(&mut self) {
        let recorder = self.logs.shown.recorder();
        if recorder.is_empty() {
            return;
        }
        let before = self.step_now();
        let mounting = self.logs.shown.settings.mounting;
        let mountings = Arc::make_mut(&mut self.document.mountings);
        if mounting.is_none() {
            mountings.remove(&recorder)
        } else {
            mountings.insert(recorder.clone(), mounting)
        };
        let shown = self.logs.shown.id;
        let is_other = |log: &&OpenLog| {
            log.id != shown && log.recorder() == recorder && log.settings.mounting != mounting
        };
        let others: Vec<LogId> = self.logs.all().filter(is_other).map(|log| log.id).collect();
        for id in others {
            if let Err(error) = self.mount(id, mounting) {
                self.notices.warn(error);
            }
        }
        self.record_named(&before, format!("mounting of {recorder}"));
        self.schedule();
    }

    /// Removes the default mounting of the shown log's recorder, as an undo step.
    pub(super) fn forget_mounting(&mut self) {
        let recorder = self.logs.shown.recorder();
        let before = self.step_now();
        if Arc::make_mut(&mut self.document.mountings).remove(&recorder).is_none() {
            return self.notices.warn("the recorder of this log has no default mounting");
        }
        self.record_named(&before, format!("no default mounting of {recorder}"));
    }

    /// Sets the mounting of a log, with its boxes and its bottom edits. After an error the log is
    /// unchanged.
    fn mount(&mut self, id: LogId, mounting: MountingSettings) -> Result<(), AppError> {
        let Some(log) = self.logs.get(id) else {
            return Ok(());
        };
        let mut settings = Settings::clone(&log.settings);
        settings.mounting = mounting;
        let settings = with_sides(settings, &log.settings);
        let own = log.own.clone();
        settings.check()?;
        self.follow_source(id, &settings)?;
        let (_, own) = own.change(&self.document.shared, &settings)?;
        if let Some(log) = self.logs.get_mut(id) {
            log.own = Arc::new(own);
            log.settings = Arc::new(settings);
            log.exchange_boxes();
        }
        Ok(())
    }
}

impl OpenLog {
    /// Applies the settings of the log's source to its survey: the sides, the clock, the coordinate
    /// system of its metres, and the track of another receiver; in `plane`, if the log shares it
    /// with others. Returns the survey before and after, or `None` if it has not changed.
    fn follow_source(
        &mut self,
        settings: &Settings,
        plane: Option<&LocalFrame>,
    ) -> Result<Option<[Arc<Survey>; 2]>, AppError> {
        let request = SourceKey::of(settings);
        let Some(survey) = self.survey.clone().filter(|_| self.source != request) else {
            return Ok(None);
        };
        let read = self.as_read.clone().unwrap_or(survey.clone());
        let recorded = as_set(Survey::clone(&read), settings, None)?;
        let now = match &request.track.file {
            None => recorded.clone(),
            Some(path) => {
                let track = self.external.track(path)?;
                as_set(Survey::clone(&read), settings, Some(&track))?
            }
        };
        let now = Arc::new(match plane {
            None => now,
            Some(plane) => now.in_frame(plane),
        });
        let has_track = request.track.file.is_some();
        self.external.apart = Arc::new(apart(&recorded, &now));
        self.external.recorded = has_track.then(|| Arc::new(recorded));
        self.as_read = (request != SourceKey::default()).then_some(read);
        self.source = request;
        self.survey = Some(now.clone());
        Ok(Some([survey, now]))
    }

    /// Returns the lag of the soundings that first returns show, and the lag in force when they
    /// were found, seconds; `None` if they show none.
    pub fn sounding_lag(&self) -> Option<(SoundingLag, f64)> {
        let products = self.products.as_ref()?;
        Some((products.calibration.sounding_lag?, products.settings.mounting.sounding_lag_s))
    }

    /// Returns the recorder of the log, as far as the log names it; empty in an empty window.
    pub fn recorder(&self) -> String {
        let survey = self.survey.as_ref();
        survey.map_or_else(String::new, |survey| survey.source.recorder())
    }

    /// Moves the boxes with their echoes to the other side if the sides are exchanged.
    pub(super) fn exchange_boxes(&mut self) {
        let swapped = (self.survey.as_ref()).is_some_and(|survey| survey.swapped_sides);
        self.reviewing.exchange(swapped);
    }
}

/// Returns the settings with their bottom edits on the side of the echoes that they were drawn on,
/// if the settings exchange the sides.
pub(super) fn with_sides(mut settings: Settings, before: &Settings) -> Settings {
    let swapped = settings.mounting.swap_sides;
    if swapped != before.mounting.swap_sides {
        settings.bottom = settings.bottom.with_sides(swapped);
    }
    settings
}

/// Returns the coordinate system of a log's metres; `None` if it is not known.
fn system_of(survey: &Survey) -> Option<&Crs> {
    survey.track.projected.as_ref()?.system.as_ref()
}

/// Compares the positions of the boat by the recorder's track with those by the track in use, at
/// times of the log.
fn apart(recorded: &Survey, now: &Survey) -> TracksApart {
    // As many times are compared as are drawn, whatever the length of the log: this runs while the
    // clock setting is dragged.
    let evenly = |count: usize| count.div_ceil(PAIRS).max(1);
    let pings = recorded.side_scan.iter().map(|ping| ping.time_s);
    let mut times_s: Vec<f64> = pings.step_by(evenly(recorded.side_scan.len())).collect();
    if times_s.is_empty() {
        let soundings = recorded.soundings.iter().map(|sounding| sounding.time_s);
        times_s = soundings.step_by(evenly(recorded.soundings.len())).collect();
    }
    TracksApart::new(&recorded.track, &now.track, &times_s, PAIRS)
}

/// Returns the instrument that the columns of a table identify: levels are from a gauge; times and
/// positions without a depth are a track, as is all GPX.
fn instrument_of(path: &Path) -> Option<Instrument> {
    let mut beginning = Vec::new();
    let opened = regular_file::open(path);
    opened.and_then(|file| file.take(1 << 16).read_to_end(&mut beginning)).ok();
    let beginning = String::from_utf8_lossy(&beginning).to_lowercase();
    if beginning.trim_start_matches('\u{feff}').trim_start().starts_with('<') {
        return Some(Instrument::Receiver);
    }
    let header = beginning.lines().find(|line| !line.starts_with('#'));
    let columns = header.unwrap_or_default().split([',', ';']);
    let columns: Vec<&str> = columns
        .map(|column| {
            column.trim_matches(|c: char| c == '"' || c == '\u{feff}' || c.is_whitespace())
        })
        .collect();
    let has = |start: &str| columns.iter().any(|column| column.starts_with(start));
    let has_depth = has("depth") || has("z") || has("elevation");
    if columns.contains(&"level_m") {
        Some(Instrument::Gauge)
    } else if (has("time") || has("utc") || has("unix_s")) && has("lon") && !has_depth {
        Some(Instrument::Receiver)
    } else {
        None
    }
}
