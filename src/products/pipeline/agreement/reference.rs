//! References of a survey: points of a file, or another mission over the same water.

use crate::Error;
use crate::pipeline::fingerprint::{Fingerprint, hash_file, hash_inputs};
use crate::pipeline::{ProcessedLog, Products, Settings, as_mounted, run};
use bathyscope_bottom::cloud::Correction;
use bathyscope_bottom::first_return::BottomSettings;
use bathyscope_log::formats::points::{Elevations, PointPlane};
use bathyscope_log::formats::{ReferenceFile, open_reference};
use bathyscope_log::support::file_error::FileError;
use bathyscope_log::support::geo::{Crs, LocalFrame, LonLat};
use bathyscope_log::support::outline;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::Survey;
use rayon::prelude::*;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// Reference that a survey is compared with.
#[derive(Debug)]
pub struct Reference {
    path: PathBuf,
    /// Notes on how the reference was read, in sentences.
    pub notes: Vec<String>,
    held: Held,
}

/// Longitude and latitude, degrees, and elevation, metres.
type Position = [f64; 3];

#[derive(Debug)]
enum Held {
    Points(Vec<Position>),
    /// One or several logs of another mission.
    Mission {
        logs: Vec<MissionLog>,
        /// Last results of each log: most changes of a setting leave most stages unchanged.
        made: Mutex<Vec<Products>>,
    },
}

/// Log of another mission.
#[derive(Clone, Debug)]
pub struct MissionLog {
    /// Recording of the log: as it was read if `settings` is `None`, otherwise with the settings
    /// applied.
    pub survey: Arc<Survey>,
    /// Settings with which the log is processed; `None` for those of the survey that is compared
    /// with it.
    pub settings: Option<Settings>,
}

impl Reference {
    /// Opens the reference of a survey: points or a log, which [`open_reference`] distinguishes.
    ///
    /// # Errors
    /// When the reference cannot be read, its metres are nowhere near the survey, or the work was
    /// cancelled.
    pub fn open(
        argument: &OsStr,
        survey: &Survey,
        settings: &Settings,
        progress: &Progress,
    ) -> Result<Self, Error> {
        match open_reference(argument, progress)? {
            ReferenceFile::Points(file) => Self::of_points(file, survey, settings),
            ReferenceFile::Log(log) => {
                let path = log.source.files.first().cloned().unwrap_or_default();
                let log = MissionLog { survey: Arc::new(*log), settings: None };
                Ok(Self::of_logs(&path, vec![log]))
            }
        }
    }

    /// Creates a reference of the points of a file. If the file does not name the coordinate system
    /// of its metres, they are taken as metres in the system that `crs` names, or else as metres
    /// east and north of the survey's first fix, whichever is over the survey.
    fn of_points(file: Elevations, survey: &Survey, settings: &Settings) -> Result<Self, Error> {
        let system = System::of(&file, survey, settings);
        let (system, guess) = system.map_err(FileError::at(&file.path))?;
        let blank = (file.blank > 0).then(|| {
            let count = file.blank;
            format!("{count} lines or features without a coordinate are left out")
        });
        let positions = file.points.par_iter().map(|&[x, y, z_m]| {
            let at = system.to_lon_lat([x, y]);
            [at.lon_deg, at.lat_deg, z_m]
        });
        Ok(Self {
            held: Held::Points(positions.collect()),
            notes: [file.note, guess, blank].into_iter().flatten().collect(),
            path: file.path,
        })
    }

    /// Creates a reference of another mission of several logs; `path` is that of their folder or
    /// project.
    pub fn of_logs(path: &Path, logs: Vec<MissionLog>) -> Self {
        Self {
            path: path.to_owned(),
            notes: Vec::new(),
            held: Held::Mission { logs, made: Mutex::default() },
        }
    }

    /// Returns the name of the reference's file.
    pub fn name(&self) -> String {
        let name = self.path.file_name().unwrap_or_default();
        name.to_string_lossy().into_owned()
    }

    /// Returns the path of the reference's file, folder or project.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns true if the reference is another mission.
    pub fn is_mission(&self) -> bool {
        matches!(self.held, Held::Mission { .. })
    }

    /// Returns true if the reference is another mission whose logs have their own settings.
    pub(crate) fn has_own_settings(&self) -> bool {
        match &self.held {
            Held::Points(_) => false,
            Held::Mission { logs, .. } => logs.iter().any(|log| log.settings.is_some()),
        }
    }

    /// Returns east, north and elevation of the reference's points in the plane of a log, metres.
    /// Another mission is processed with the settings of that log.
    ///
    /// # Errors
    /// When a log of the other mission cannot be processed with these settings, or the work was
    /// cancelled.
    pub(super) fn places(
        &self,
        log: &ProcessedLog,
        progress: &Progress,
    ) -> Result<Vec<[f64; 3]>, Error> {
        let ProcessedLog { survey, products } = log;
        let place = |&[lon_deg, lat_deg, z_m]: &Position| {
            let at = LonLat { lon_deg, lat_deg };
            let [east_m, north_m] = products.navigation.to_plane(&survey.track, at);
            [east_m, north_m, z_m]
        };
        match &self.held {
            Held::Points(points) => Ok(points.par_iter().map(place).collect()),
            Held::Mission { logs, made } => {
                let mut made = made.lock().unwrap_or_else(PoisonError::into_inner);
                let mut places = Vec::new();
                for (index, other) in logs.iter().enumerate() {
                    let (survey, now) = other
                        .processed(&products.settings, made.get(index), progress)
                        .map_err(FileError::at(&self.path))?;
                    places.par_extend(positions(&survey, &now).par_iter().map(place));
                    match made.get_mut(index) {
                        Some(before) => *before = now,
                        None => made.push(now),
                    }
                }
                Ok(places)
            }
        }
    }

    /// Returns the files from which the reference was read, with their hashes.
    ///
    /// # Errors
    /// When a file can no longer be read or has changed, or the work was cancelled.
    pub fn inputs(&self, progress: &Progress) -> Result<Vec<Fingerprint>, Error> {
        match &self.held {
            Held::Points(_) => Ok(vec![hash_file(&self.path, progress)?]),
            Held::Mission { logs, .. } => {
                let inputs = logs.iter().map(|log| {
                    let hashed = hash_inputs(&log.survey, progress)?;
                    log.survey.check_files()?;
                    Ok(hashed)
                });
                let inputs: Result<Vec<_>, Error> = inputs.collect();
                Ok(inputs?.concat())
            }
        }
    }
}

impl MissionLog {
    /// Runs the pipeline on the log; returns the recording as mounted, and the results. Without its
    /// own settings, the log is processed with those of the compared log, including its mounting,
    /// but without that log's flat spot, strokes, excluded stretches and height offset, which do
    /// not apply to this log.
    fn processed(
        &self,
        settings: &Settings,
        before: Option<&Products>,
        progress: &Progress,
    ) -> Result<(Arc<Survey>, Products), Error> {
        let (survey, settings) = match &self.settings {
            Some(own) => (self.survey.clone(), own.clone()),
            None => {
                let mut settings = settings.clone();
                settings.calibration.pings = None;
                settings.bottom = BottomSettings::default();
                settings.excluded.log = None;
                settings.excluded.stretches.clear();
                settings.height_offset_m = 0.0;
                let recorded = Survey::clone(&self.survey);
                let mounted = as_mounted(recorded, &settings.mounting, &settings.source);
                (Arc::new(mounted.map_err(|error| error.to_string())?), settings)
            }
        };
        if let Some(why) = Correction::new(settings.depth(), &survey).refused {
            return Err(why.to_string().into());
        }
        let made = run(&survey, &settings, before, progress, |_| ())?;
        Ok((survey, made))
    }
}

/// Returns longitude, latitude and elevation of the points from which a depth map of a survey is
/// made.
pub fn positions(survey: &Survey, products: &Products) -> Vec<Position> {
    let counted = super::counted(products).into_iter();
    let points = counted.map(|index| &products.cloud.points[index]);
    let positions = points.map(|point| {
        let (east_m, north_m) = (point.east_m, point.north_m);
        let at = products.navigation.to_lon_lat(&survey.track, east_m, north_m);
        [at.lon_deg, at.lat_deg, point.z_m]
    });
    positions.collect()
}

/// Coordinate system of a file of points.
enum System {
    Crs(Crs),
    /// Metres east and north of the survey's first fix.
    Local(LocalFrame),
}

impl System {
    /// Returns the coordinate system of a file, and a sentence if the system is a guess.
    fn of(
        file: &Elevations,
        survey: &Survey,
        settings: &Settings,
    ) -> Result<(Self, Option<String>), Error> {
        let named = |epsg: u16| Ok((Self::Crs(Crs::from_epsg(epsg)?), None));
        match file.plane {
            PointPlane::Degrees => named(4326),
            PointPlane::Utm(zone) => named(zone.epsg() as u16),
            PointPlane::Epsg(epsg) => named(epsg),
            PointPlane::Metres => Self::guessed(file, survey, settings),
        }
    }

    fn guessed(
        file: &Elevations,
        survey: &Survey,
        settings: &Settings,
    ) -> Result<(Self, Option<String>), Error> {
        let frame = &survey.track.frame;
        let map = settings.crs.at(frame.origin()).ok();
        let map = map.unwrap_or_else(|| Crs::utm(frame.origin()));
        let asked = format!("the file does not say so, but its metres are taken as those of {map}");
        let local =
            "the file does not say so, but its metres are taken as east and north of the first fix";
        let whats =
            [(Self::Crs(map.clone()), asked), (Self::Local(frame.clone()), local.to_owned())];
        let fixes = survey.track.fixes.iter();
        let track = bounds(fixes.map(|fix| frame.to_enu(fix.position)));
        for (system, words) in whats {
            let points = file.points.iter();
            let points = points.map(|&[x, y, _]| frame.to_enu(system.to_lon_lat([x, y])));
            if distance_m(track, bounds(points)) < NEAR_M {
                return Ok((system, Some(words)));
            }
        }
        Err(format!(
            "the file does not say which system its metres are in, and they lie over this survey neither as {map} nor as metres from its first fix; give longitude and latitude, or set crs to the file's system"
        )
        .into())
    }

    fn to_lon_lat(&self, [x, y]: [f64; 2]) -> LonLat {
        match self {
            Self::Crs(crs) => crs.to_lon_lat([x, y]),
            Self::Local(frame) => frame.to_lon_lat(x, y),
        }
    }
}

/// Distance from the track, metres, up to which a file may be of the same water in the wrong place,
/// and is reported with its distance.
const NEAR_M: f64 = 20_000.0;

/// Returns west, south, east and north of the finite places.
pub(super) fn bounds(places: impl Iterator<Item = [f64; 2]>) -> [f64; 4] {
    outline::bounds(places.filter(|[x, y]| x.is_finite() && y.is_finite()))
}

/// Returns the distance between two rectangles; 0 if they meet.
pub(super) fn distance_m(one: [f64; 4], other: [f64; 4]) -> f64 {
    let apart = |low: usize, high: usize| {
        let gap = (other[low] - one[high]).max(one[low] - other[high]);
        gap.max(0.0)
    };
    apart(0, 2).hypot(apart(1, 3))
}
