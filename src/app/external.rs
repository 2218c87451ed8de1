//! What other instruments recorded of the open survey: readings of a gauge, and the track of another receiver.
//!
//! Files are read off the window's thread. A file becomes part of the settings only once it is known to fit the log: a bad one
//! leaves everything as it was.

use super::{App, Outcome, Task};
use crate::cloud::Correction;
use crate::cloud::correction::WaterLevelSettings;
use crate::formats::{TrackFile, read_gauge};
use crate::pipeline::Settings;
use crate::progress::Progress;
use crate::regular_file;
use crate::survey::{Gauge, Survey, TrackSettings, TracksApart};
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Pairs of places that two tracks are compared at.
const PAIRS: usize = 400;

/// What recorded a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Instrument {
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
pub struct External {
    /// The survey with the recorder's own track, while another lies over it.
    pub recorded: Option<Arc<Survey>>,
    /// How far the two tracks lie apart.
    pub apart: Arc<TracksApart>,
    /// The tracks read for the open survey: undo goes back to them.
    tracks: Vec<Arc<TrackFile>>,
    reading: Option<Task<Result<Read, String>>>,
}

impl External {
    /// Whether a file is being read.
    pub fn is_reading(&self) -> bool {
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
    fn track(&mut self, path: &Path) -> Result<Arc<TrackFile>, String> {
        if let Some(known) = self.tracks.iter().find(|track| track.path() == path) {
            return Ok(known.clone());
        }
        let read = TrackFile::read(path).map_err(|error| error.to_string())?;
        let read = Arc::new(read);
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
            let text = "open the log first, then the water levels or the track that belong to it";
            return self.notify(text.to_owned(), true);
        }
        let work = move |_: &Progress| match instrument.or_else(|| instrument_of(&path)) {
            Some(Instrument::Gauge) => read_gauge(&path)
                .map(Read::Levels)
                .map_err(|error| error.to_string()),
            Some(Instrument::Receiver) => TrackFile::read(&path)
                .map(Read::Track)
                .map_err(|error| error.to_string()),
            None => Ok(Read::Points(path)),
        };
        self.log.external.reading = Some(Task::start(&self.jobs, work));
    }

    /// Collects a file that was read, and takes it into the settings.
    pub(super) fn poll_external(&mut self) {
        let read = match self.log.external.reading.as_ref().map(Task::poll) {
            None | Some(Outcome::Pending) => return,
            Some(Outcome::Done(read)) => read,
            Some(Outcome::Failed) => Err("reading the table failed unexpectedly".to_owned()),
        };
        self.log.external.reading = None;
        match read {
            Ok(Read::Levels(gauge)) => self.take_levels(gauge),
            Ok(Read::Track(track)) => self.take_track(track),
            Ok(Read::Points(path)) => self.compare_with(path),
            Err(text) => self.notify(text, true),
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
            ..settings.water_level
        };
        match Correction::new(settings.depth(), survey).refused() {
            Some(sentence) => self.notify(sentence.to_owned(), true),
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

    /// Makes the open survey one with the requested track. The error is a sentence; the survey is as it was then.
    pub(super) fn follow_track(&mut self, requested: &TrackSettings) -> Result<(), String> {
        let Some(survey) = self.log.survey.clone() else {
            return Ok(());
        };
        let applied = survey.track.external.as_ref();
        let applied = applied.map(|applied| (applied.path.as_path(), applied.offset_s));
        let request = requested
            .file
            .as_deref()
            .map(|path| (path, requested.offset_s));
        if applied == request {
            return Ok(());
        }
        let recorded = self.log.external.recorded.clone().unwrap_or(survey.clone());
        let now = match request {
            None => recorded.clone(),
            Some((path, offset_s)) => {
                let mut now = Survey::clone(&recorded);
                self.log
                    .external
                    .track(path)?
                    .apply(&mut now, offset_s)
                    .map_err(|error| error.to_string())?;
                Arc::new(now)
            }
        };
        let now = match self.log_count() {
            0 | 1 => now,
            // Several logs lie in one plane.
            _ => Arc::new(Survey::clone(&now).in_frame(&self.plane)),
        };
        self.log.external.apart = Arc::new(apart(&recorded, &now));
        self.log.external.recorded = request.map(|_| recorded);
        if now.track.frame.origin() != survey.track.frame.origin() {
            self.plane = now.track.frame.clone();
            self.plane_serial += 1;
        }
        self.log.survey = Some(now);
        Ok(())
    }
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
