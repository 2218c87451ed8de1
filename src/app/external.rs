//! What other instruments recorded of the open survey: readings of a gauge, and the track of another receiver.
//!
//! Files are read in a background thread. A file becomes part of the settings only once it is known to fit the log: a bad one
//! leaves everything as it was.

use super::error::AppError;
use super::{App, Outcome, Task};
use crate::bottom::cloud::Correction;
use crate::bottom::cloud::correction::WaterLevelSettings;
use crate::formats::{TrackError, TrackFile, read_gauge};
use crate::pipeline::{Settings, SourceKey, as_set};
use crate::support::geo::{Crs, LocalFrame};
use crate::support::progress::Progress;
use crate::support::regular_file;
use crate::survey::{Gauge, Side, Survey, TrackSettings, TracksApart};
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Pairs of places that two tracks are compared at.
const PAIRS: usize = 400;

/// What recorded a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Instrument {
    /// A gauge or tide table: readings of the water's height.
    Gauge,
    /// A receiver of satellites: a track.
    Receiver,
}

enum Read {
    Levels(Gauge),
    Track(TrackFile),
    /// Neither: points to compare with.
    Points(PathBuf),
}

/// What other instruments recorded, and what became of it.
#[derive(Default)]
pub(crate) struct External {
    /// The survey with the recorder's own track, while another lies over it.
    pub recorded: Option<Arc<Survey>>,
    /// How far the two tracks lie apart.
    pub apart: Arc<TracksApart>,
    /// The tracks read for the open survey: undo goes back to them.
    tracks: Vec<Arc<TrackFile>>,
    reading: Option<Task<Result<Read, AppError>>>,
}

impl External {
    /// Whether a file is being read.
    pub(crate) fn is_reading(&self) -> bool {
        self.reading.is_some()
    }

    /// What is drawn of it.
    pub(super) fn for_picture(&self) -> Self {
        Self {
            recorded: self.recorded.clone(),
            apart: self.apart.clone(),
            ..Self::default()
        }
    }

    pub(super) fn stop_reading(&mut self) {
        self.reading = None;
    }

    /// The track of a file, read before or now.
    fn track(&mut self, path: &Path) -> Result<Arc<TrackFile>, TrackError> {
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
    /// Starts reading a file of an instrument, or of the one that its columns identify.
    pub(super) fn read_external(&mut self, path: PathBuf, instrument: Option<Instrument>) {
        if self.log.survey.is_none() {
            let text = "open the log first, then its water levels or its track";
            return self.notify(text.to_owned(), true);
        }
        let work = move |_: &Progress| match instrument.or_else(|| instrument_of(&path)) {
            Some(Instrument::Gauge) => Ok(Read::Levels(read_gauge(&path)?)),
            Some(Instrument::Receiver) => Ok(Read::Track(TrackFile::read(&path)?)),
            None => Ok(Read::Points(path)),
        };
        self.log.external.reading = Some(Task::start(&self.jobs, work));
    }

    /// Collects a file that was read, and takes it into the settings.
    pub(super) fn poll_external(&mut self) {
        let read = match self.log.external.reading.as_ref().map(Task::poll) {
            None | Some(Outcome::Pending) => return,
            Some(Outcome::Done(read)) => read,
            Some(Outcome::Failed) => Err(AppError::Failed("reading the table")),
        };
        self.log.external.reading = None;
        match read {
            Ok(Read::Levels(gauge)) => self.take_levels(gauge),
            Ok(Read::Track(track)) => self.take_track(track),
            Ok(Read::Points(path)) => self.compare_with(path),
            Err(error) => self.notify(error.to_string(), true),
        }
    }

    fn take_levels(&mut self, gauge: Gauge) {
        let Some(survey) = &self.log.survey else {
            return;
        };
        let mut settings = Settings::clone(&self.log.settings);
        settings.water_level = WaterLevelSettings {
            file: Some(gauge.path.clone()),
            gauge: Some(Arc::new(gauge)),
        };
        match Correction::new(settings.depth(), survey).refused() {
            Some(why) => self.notify(why.to_string(), true),
            None => self.change(settings, "water levels", false),
        }
    }

    fn take_track(&mut self, track: TrackFile) {
        let mut settings = Settings::clone(&self.log.settings);
        settings.track.file = Some(track.path().to_owned());
        // The same file may have been written anew meanwhile.
        if settings.track == self.log.settings.track {
            self.remove_track();
        }
        self.log.external.keep(track);
        self.change(settings, "external track", false);
    }

    /// Leaves the readings of the water's height.
    pub(super) fn remove_water_levels(&mut self) {
        let mut settings = Settings::clone(&self.log.settings);
        settings.water_level = WaterLevelSettings::default();
        self.change(settings, "water levels", false);
    }

    /// Takes the boat's places from the recorder again.
    pub(super) fn remove_track(&mut self) {
        let mut settings = Settings::clone(&self.log.settings);
        settings.track = TrackSettings::default();
        self.change(settings, "external track", false);
    }

    /// Makes the open survey what the settings say of its source: its sides, its clock, the system of its metres, and the track of
    /// another receiver. After an error the survey is as it was.
    pub(super) fn follow_source(&mut self, settings: &Settings) -> Result<(), AppError> {
        let Some(survey) = self.log.survey.clone() else {
            return Ok(());
        };
        let request = SourceKey::of(settings);
        if self.log.source == request {
            return Ok(());
        }
        let read = self.log.as_read.clone().unwrap_or(survey.clone());
        let recorded = as_set(Survey::clone(&read), settings, None)?;
        let now = match &request.track.file {
            None => recorded.clone(),
            Some(path) => {
                let track = self.log.external.track(path)?;
                as_set(Survey::clone(&read), settings, Some(&track))?
            }
        };
        let now = match self.log_count() {
            0 | 1 => Arc::new(now),
            // Several logs lie in one plane.
            _ => Arc::new(now.in_frame(&self.document.plane)),
        };
        let has_track = request.track.file.is_some();
        self.log.external.apart = Arc::new(apart(&recorded, &now));
        self.log.external.recorded = has_track.then(|| Arc::new(recorded));
        self.log.as_read = (request != SourceKey::default()).then_some(read);
        self.log.source = request;
        if now.track.frame.origin() != survey.track.frame.origin() {
            self.document.plane = now.track.frame.clone();
            self.enter_plane();
        }
        self.document.is_plane_moved |= system_of(&now) != system_of(&survey);
        if now.swapped_sides != survey.swapped_sides {
            self.exchange_sides();
        }
        self.log.survey = Some(now);
        Ok(())
    }

    /// What points to a side points to the same echo once the sides are exchanged.
    fn exchange_sides(&mut self) {
        self.log.preview = None;
        // What is found in the log as it was would come to the other side.
        self.findings.search.leave(self.log.id);
        if !self.is_shown() {
            return;
        }
        self.pipeline.previewer.forget();
        for mark in [&mut self.view.selection, &mut self.view.hover]
            .into_iter()
            .flatten()
        {
            mark.side = mark.side.map(Side::other);
        }
    }

    /// Puts all logs into the plane of the first that is on the Earth, after the metres of one became those of another system: a plane
    /// thousands of kilometres away would bend them.
    pub(super) fn settle_plane(&mut self) {
        if !std::mem::take(&mut self.document.is_plane_moved) || self.log_count() < 2 {
            return;
        }
        let is_placed =
            |survey: &Option<Arc<Survey>>| survey.as_ref().is_some_and(|survey| survey.has_place());
        let on_earth =
            |survey: &Arc<Survey>| survey.track.projected.is_none() || system_of(survey).is_some();
        let visible = || self.visible_logs().filter(|log| is_placed(&log.survey));
        let first = visible().find(|log| log.survey.as_ref().is_some_and(on_earth));
        let first = first.or_else(|| visible().next());
        let first = first.or_else(|| self.logs().find(|log| is_placed(&log.survey)));
        let fix = first.and_then(|log| log.survey.as_ref()?.track.fixes.first());
        let Some(fix) = fix else {
            return;
        };
        let frame = LocalFrame::new(fix.position);
        self.document.plane = frame.clone();
        self.enter_plane();
        for log in self.logs_mut() {
            for survey in [
                &mut log.survey,
                &mut log.as_read,
                &mut log.external.recorded,
            ] {
                *survey = survey
                    .take()
                    .map(|survey| Arc::new(Survey::clone(&survey).in_frame(&frame)));
            }
            // They lie in the plane that was.
            log.products = None;
            log.preview = None;
        }
        self.schedule();
    }
}

/// The system of a log's metres, where it is known.
fn system_of(survey: &Survey) -> Option<&Crs> {
    survey.track.projected.as_ref()?.system.as_ref()
}

/// Where recorder and receiver have the boat while it recorded.
fn apart(recorded: &Survey, now: &Survey) -> TracksApart {
    // As many as are drawn, whatever the length of the log: this runs while the clock is dragged.
    let evenly = |count: usize| count.div_ceil(PAIRS).max(1);
    let pings = recorded.side_scan.iter().map(|ping| ping.time_s);
    let mut times_s: Vec<f64> = pings.step_by(evenly(recorded.side_scan.len())).collect();
    if times_s.is_empty() {
        let soundings = recorded.soundings.iter().map(|sounding| sounding.time_s);
        times_s = soundings
            .step_by(evenly(recorded.soundings.len()))
            .collect();
    }
    TracksApart::new(&recorded.track, &now.track, &times_s, PAIRS)
}

/// The instrument that the columns of a table identify: levels are a gauge's; times and places without a depth are a track, as is all GPX.
fn instrument_of(path: &Path) -> Option<Instrument> {
    let mut beginning = Vec::new();
    let opened = regular_file::open(path);
    opened
        .and_then(|file| file.take(1 << 16).read_to_end(&mut beginning))
        .ok();
    let beginning = String::from_utf8_lossy(&beginning).to_lowercase();
    if beginning
        .trim_start_matches('\u{feff}')
        .trim_start()
        .starts_with('<')
    {
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
