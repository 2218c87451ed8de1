//! Reads files of other instruments: tracks of another receiver, such as RTK or an autopilot, as
//! CSV with named columns or GPX; and tables of water levels, as CSV with the columns `time` and
//! `level_m`.

use super::gpx::gpx_points;
use crate::support::calendar::unix_from_text;
use crate::support::file_error::{FaultText, FileError};
use crate::support::geo::LonLat;
use crate::support::regular_file;
use crate::survey::{
    Bytes, ExternalTrack, Fix, Gauge, Survey, Track, WATER_LEVELS_M, Warning, drop_false_fixes,
};
use sha2::{Digest as _, Sha256};
use std::path::Path;
use std::sync::Arc;

/// A track that was read from a file.
#[derive(Clone, Debug)]
pub struct TrackFile {
    external: ExternalTrack,
    bytes: Bytes,
    /// Time (Unix seconds, or seconds of the log), position, and heading in radians (NaN where
    /// unknown) of each fix, in time order.
    fixes: Vec<(f64, LonLat, f32)>,
}

/// Lowest Unix time, seconds; lower times count from the beginning of the log: no receiver recorded
/// in 1973.
const LEAST_UNIX_S: f64 = 1e8;
/// Size of the largest track that is read, bytes; enough for ten fixes a second for a month.
const LONGEST_TRACK: u64 = 1 << 31;
/// Size of the largest table of water levels that is read, bytes; enough for a reading every second
/// of a year.
const LONGEST_LEVELS: u64 = 1 << 30;
/// Fault of a track that is too short.
const TOO_SHORT: &str = "the track has fewer than two places with a time";
/// Names of the columns, in lower case; the first name in the header is used.
pub(super) const TIME: &[&str] = &["time", "timestamp", "utc", "unix_s", "time_s"];
pub(super) const LON: &[&str] = &["lon", "longitude", "lon_deg", "lng"];
pub(super) const LAT: &[&str] = &["lat", "latitude", "lat_deg"];
pub(super) const HEADING: &[&str] = &["heading_deg", "yaw_deg", "heading"];

impl TrackFile {
    /// Reads a track. CSV has the columns `time` (ISO 8601, Unix seconds, or seconds of the log),
    /// `lon` and `lat`, degrees, and optionally `heading_deg`; of GPX the track points are read.
    ///
    /// # Errors
    /// When the file cannot be read, or contains fewer than two fixes.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let fail = FileError::<FaultText>::at(path);
        let bytes = regular_file::read(path, LONGEST_TRACK)
            .map_err(|error| fail(format!("cannot read the track: {error}").into()))?;
        let text = std::str::from_utf8(&bytes)
            .map_err(|_| fail("the track is neither CSV nor GPX".into()))?;
        let gpx = text.trim_start_matches('\u{feff}').trim_start().starts_with('<');
        let mut fixes = if gpx { from_gpx(text) } else { from_csv(text) }.map_err(fail)?;
        if fixes.len() < 2 {
            return Err(fail(TOO_SHORT.into()));
        }
        fixes.sort_by(|a, b| a.0.total_cmp(&b.0));
        Ok(Self {
            external: ExternalTrack { path: path.to_owned(), offset_s: 0.0, span_s: [0.0; 2] },
            bytes: Bytes::Held(Arc::from(bytes)),
            fixes,
        })
    }

    /// Returns the path of the file.
    pub fn path(&self) -> &Path {
        &self.external.path
    }

    /// Replaces the track of a survey by this one, with all times `offset_s` later than in the
    /// file. The file is added to the survey's sources. Pings and soundings outside the track's
    /// times have no position afterwards, and a warning states their number.
    ///
    /// # Errors
    /// When the track covers no ping or sounding, has too few plausible fixes, or the start time of
    /// the log is needed but unknown.
    pub fn apply(&self, survey: &mut Survey, offset_s: f64) -> Result<(), FileError> {
        let fail = FileError::<FaultText>::at(self.path());
        let zero_s = match (self.fixes[0].0 < LEAST_UNIX_S, survey.start_unix_s) {
            (true, _) => 0.0,
            (false, Some(start_unix_s)) => start_unix_s,
            (false, None) => {
                return Err(fail("the log does not know the time, so the track cannot be applied to it; give its times in seconds of the log".into()));
            }
        };
        let fix = |&(time_s, position, compass_rad): &(f64, LonLat, f32)| Fix {
            compass_rad,
            ..Fix::at(time_s - zero_s + offset_s, position)
        };
        let mut fixes: Vec<Fix> = self.fixes.iter().map(fix).collect();
        let stray = drop_false_fixes(&mut fixes, true);
        // With two fixes far apart and a third between them, none is near another: no fix is left.
        let (Some(first), Some(last)) = (fixes.first(), fixes.last()) else {
            return Err(fail(TOO_SHORT.into()));
        };
        let span_s = [first.time_s, last.time_s];
        let inside = |time_s: f64| (span_s[0]..=span_s[1]).contains(&time_s);
        let pings = survey.side_scan.iter().map(|ping| ping.time_s);
        let times = pings.chain(survey.soundings.iter().map(|sounding| sounding.time_s));
        let outside = times.clone().filter(|time_s| !inside(*time_s)).count();
        let count = times.count();
        if outside == count {
            let [from_s, to_s] = span_s;
            let what = format!(
                "the track covers no ping of the log: it goes from {from_s:.1} to {to_s:.1} s of the log; set track.offset_s if its clock was wrong, mounting.clock_offset_s if that of the log was"
            );
            return Err(fail(what.into()));
        }
        let stray = stray.into_iter().map(|what| format!("Of the external track {what}."));
        let uncovered = (outside > 0).then(|| {
            format!(
                "The external track does not cover {outside} of {count} pings and soundings, which are left without a place."
            )
        });
        let texts = stray.chain(uncovered);
        survey.warnings.extend(texts.map(|text| Warning { place: None, text }));
        survey.track = Track {
            external: Some(ExternalTrack { offset_s, span_s, ..self.external.clone() }),
            ..Track::new(fixes)
        };
        survey.source.files.push(self.external.path.clone());
        survey.bytes.push(self.bytes.clone());
        Ok(())
    }
}

type Fixes = Result<Vec<(f64, LonLat, f32)>, FaultText>;

fn from_csv(text: &str) -> Fixes {
    let no_table = |error: csv::Error| format!("the track is no table: {error}");
    let mut table = table(text.as_bytes());
    let header = table.headers().map_err(no_table)?.clone();
    let find = |names: &[&str]| {
        let position =
            |name: &&str| header.iter().position(|field| field.eq_ignore_ascii_case(name));
        names.iter().find_map(position)
    };
    let [Some(time), Some(lon), Some(lat)] = [TIME, LON, LAT].map(find) else {
        let names: Vec<&str> = header.iter().collect();
        return Err(format!(
            "the track has no columns time, lon and lat, only {}; name them so in the first line",
            names.join(", ")
        )
        .into());
    };
    let heading = find(HEADING);
    let mut fixes = Vec::new();
    for row in table.records() {
        let row = row.map_err(no_table)?;
        let line = row.position().map_or(0, csv::Position::line);
        let field = |column: usize| row.get(column).unwrap_or_default();
        let number = |column: usize| field(column).parse::<f64>().ok();
        let position = position(number(lon), number(lat));
        let (Some(time_s), Some(position)) = (unix_from_text(field(time)), position) else {
            return Err(format!(
                "line {line} of the track has no time, longitude and latitude that can be read"
            )
            .into());
        };
        let heading_deg = heading.and_then(number).unwrap_or(f64::NAN);
        fixes.push((time_s, position, heading_deg.to_radians() as f32));
    }
    Ok(fixes)
}

/// Returns the position; `None` where a coordinate is missing or not plausible.
fn position(lon_deg: Option<f64>, lat_deg: Option<f64>) -> Option<LonLat> {
    let (lon_deg, lat_deg) = (lon_deg?, lat_deg?);
    let exists = lon_deg.abs() <= 360.0 && lat_deg.abs() < 90.0;
    exists.then_some(LonLat { lon_deg, lat_deg })
}

/// Returns the track points of a GPX text; those without a time are left out.
fn from_gpx(text: &str) -> Fixes {
    let mut fixes = Vec::new();
    for (index, point) in gpx_points(text)?.into_iter().enumerate() {
        let [lon_deg, lat_deg] = point.lon_lat.map_or([None; 2], |at| at.map(Some));
        let position = position(lon_deg, lat_deg)
            .ok_or_else(|| format!("track point {} has no place that can be read", index + 1))?;
        let time_s = unix_from_text(point.time.trim());
        fixes.extend(time_s.map(|time_s| (time_s, position, f32::NAN)));
    }
    Ok(fixes)
}

/// Reads a table with the columns `time` (ISO 8601, UTC unless a zone is given, or Unix seconds)
/// and `level_m`, separated by commas or semicolons; other columns are ignored.
///
/// # Errors
/// When the file cannot be read, or is not such a table with readings in time order.
pub fn read_gauge(path: &Path) -> Result<Gauge, FileError> {
    let fail = FileError::<FaultText>::at(path);
    let bytes = regular_file::read(path, LONGEST_LEVELS)
        .map_err(|error| fail(format!("cannot read the water levels: {error}").into()))?;
    let readings = levels(&bytes).map_err(fail)?;
    let hash = Sha256::digest(&bytes);
    Ok(Gauge {
        path: path.to_owned(),
        bytes: bytes.len(),
        sha256: hash.iter().map(|byte| format!("{byte:02x}")).collect(),
        readings,
    })
}

/// Returns the time (Unix seconds) and the level (metres) of every line.
fn levels(bytes: &[u8]) -> Result<Vec<(f64, f64)>, FaultText> {
    let no_table = |error: csv::Error| format!("the water levels are no table: {error}");
    let mut table = table(bytes);
    let header = table.headers().map_err(no_table)?.clone();
    let column = |name: &str| {
        let found = header.iter().position(|field| field.eq_ignore_ascii_case(name));
        found.ok_or_else(|| {
            format!("the water levels have no column `{name}`; name the columns time and level_m")
        })
    };
    let [time, level] = [column("time")?, column("level_m")?];
    let mut readings: Vec<(f64, f64)> = Vec::new();
    for (index, row) in table.records().enumerate() {
        let row = row.map_err(no_table)?;
        let line = row.position().map_or(index as u64 + 2, |at| at.line());
        let field = |column| row.get(column).unwrap_or_default();
        let time_s = unix_from_text(field(time)).ok_or_else(|| {
            format!(
                "line {line} of the water levels: `{}` is no time; write 2021-10-12T00:53:20Z or Unix seconds",
                field(time)
            )
        })?;
        let level_m: Option<f64> = field(level).parse().ok();
        let level_m = level_m.filter(|level_m| WATER_LEVELS_M.contains(level_m));
        let level_m = level_m.ok_or_else(|| {
            format!(
                "line {line} of the water levels: `{}` is no level in metres between -1000 and 10000",
                field(level)
            )
        })?;
        if readings.last().is_some_and(|(last_s, _)| *last_s >= time_s) {
            return Err(format!(
                "line {line} of the water levels: its time is not after the one before; sort the readings"
            )
            .into());
        }
        readings.push((time_s, level_m));
    }
    if readings.is_empty() {
        return Err("the water levels hold no reading".into());
    }
    Ok(readings)
}

/// Returns the reader of a table whose fields are separated by commas or semicolons, as in its
/// first line, and in which lines that begin with `#` are comments.
fn table(bytes: &[u8]) -> csv::Reader<&[u8]> {
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let mut lines = bytes.split(|byte| *byte == b'\n');
    let header = lines.find(|line| !line.starts_with(b"#"));
    let semicolons = header.is_some_and(|line| line.contains(&b';'));
    csv::ReaderBuilder::new()
        .delimiter(if semicolons { b';' } else { b',' })
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::survey::Sounding;

    fn survey() -> Survey {
        let sounding = |time_s| Sounding::new(time_s, 2.0);
        Survey {
            start_unix_s: Some(1_634_000_000.0),
            soundings: Arc::new((0..10).map(f64::from).map(sounding).collect()),
            ..Survey::default()
        }
    }

    fn read(name: &str, text: &str) -> Result<TrackFile, FileError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        TrackFile::read(&path)
    }

    #[test]
    fn csv_and_gpx_give_the_same_track() {
        let csv = "Latitude,Time,Longitude,Heading_deg\n29.41,2021-10-12T00:53:20Z,-82.11,90\n29.4101,1634000010,-82.1101,\n";
        let gpx = "<?xml version='1.0'?><gpx><trk><trkseg><trkpt lon='-82.11' lat = \"29.41\"><ele>3</ele><time>2021-10-12T00:53:20Z</time></trkpt>\
                   <trkpt lat=\"1\" lon=\"1\"/><trkpt lat=\"29.4101\" lon=\"-82.1101\"><time>2021-10-12T00:53:30Z</time></trkpt></trkseg></trk></gpx>";
        let [csv, gpx] = [read("a.csv", csv), read("a.gpx", gpx)].map(Result::unwrap);
        let places = |track: &TrackFile| -> Vec<(f64, LonLat)> {
            track.fixes.iter().map(|(time_s, place, _)| (*time_s, *place)).collect()
        };
        assert_eq!(places(&csv), places(&gpx));
        assert_eq!(places(&csv).len(), 2);
        assert!((csv.fixes[0].2 - std::f32::consts::FRAC_PI_2).abs() < 1e-6);
        let mut survey = survey();
        csv.apply(&mut survey, -2.0).unwrap();
        assert_eq!(survey.track.fixes[1].time_s, 8.0);
        assert_eq!(survey.source.files.len(), survey.bytes.len());
        // The last sounding is a second after the last fix.
        assert!(survey.warnings[0].text.contains("1 of 10"), "{:?}", survey.warnings);
    }

    #[test]
    fn times_of_the_log_need_no_clock_and_others_are_refused() {
        let mut unknown = Survey { start_unix_s: None, ..survey() };
        let own = read("a.csv", "time_s,lon,lat\n0,1,2\n9,1,2.1\n").unwrap();
        own.apply(&mut unknown, 0.0).unwrap();
        assert!(unknown.warnings.is_empty());
        let dated = read("a.csv", "time,lon,lat\n1634000000,1,2\n1634000009,1,2.1\n").unwrap();
        unknown.start_unix_s = None;
        assert!(
            dated
                .apply(&mut unknown, 0.0)
                .unwrap_err()
                .to_string()
                .contains("does not know the time")
        );
        let error = dated.apply(&mut survey(), 3600.0).unwrap_err().to_string();
        assert!(error.contains("track.offset_s"), "{error}");
        for (text, words) in [
            ("time,x,y\n1,2,3\n", "time, lon and lat"),
            ("time,lon,lat\n1,2,3\n2,2,95\n", "line 3"),
            ("time,lon,lat\n1,2,3\n", "fewer than two"),
            ("<gpx><trkpt lat='1'></trkpt></gpx>", "point 1"),
        ] {
            let error = read("a.csv", text).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
    }

    fn read_levels(text: &str) -> Result<Gauge, FileError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("levels.csv");
        std::fs::write(&path, text).unwrap();
        read_gauge(&path)
    }

    #[test]
    fn either_separator_and_either_time_are_read() {
        let text = "# gauge at the dam\nstation;time;level_m\nA;2021-10-12T00:53:20Z;1.5\nA;1634003600;2.5\n";
        let found = read_levels(text).unwrap();
        let expected = [(1_634_000_000.0, 1.5), (1_634_003_600.0, 2.5)];
        assert_eq!(found.readings, expected);
        assert_eq!(found.bytes, text.len());
    }

    #[test]
    fn what_is_wrong_is_said_with_its_line() {
        for (text, words) in [
            ("time,level\n1,2\n", "no column `level_m`"),
            ("time,level_m\n", "no reading"),
            ("time,level_m\n1,2\nnoon,3\n", "line 3"),
            ("time,level_m\n1,2\n2,high\n", "line 3"),
            ("time,level_m\n1,2\n1,3\n", "sort"),
            ("time,level_m\n1,nan\n", "line 2"),
            ("time,level_m\n1,2\n2,1e9\n", "line 3"),
        ] {
            let error = read_levels(text).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
    }
}
