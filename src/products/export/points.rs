//! Writes pings and points as tables and plain files: `first_returns.csv`, `cloud.csv`, the
//! differences of points from a reference, `cloud.ply`, `cloud.xyz`, `depth.xyz`, and point files
//! with some of their points.
//!
//! The points are those of one log, or of all logs of a survey. `*.xyz` is plain text for any
//! program that reads columns. Numbers are formatted fast enough for tables of millions of rows.

use super::{ExportError, Summary, colour, write_atomically, write_summed};
use bathyscope_bottom::bathymetry::compare::Match;
use bathyscope_bottom::calibration::Calibration;
use bathyscope_bottom::cloud::{CloudPoint, PointClass, PointCloud, Reduction};
use bathyscope_bottom::first_return::FirstReturns;
use bathyscope_log::formats::points::{PointFile, PointFormat};
use bathyscope_log::support::geo::compass_deg;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{
    ExclusionReason, Exclusions, Navigation, Side, SoundingFault, Survey,
};
use std::fmt::{self, Display, Formatter};
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Columns of `first_returns.csv`.
const HEADER: &str = "ping,time_s,lon,lat,east_m,north_m,heading_deg,depth_m,\
     port_sample,port_range_m,port_confidence,starboard_sample,starboard_range_m,starboard_confidence,excluded";
/// Number of cells that are written between two checks for cancellation.
const CHUNK: usize = 4096;

/// The points of a log and the results that they were made from.
#[derive(Clone, Copy)]
pub(crate) struct LogPoints<'a> {
    /// Name of the log, in a table of several logs.
    pub name: &'a str,
    /// The recording.
    pub survey: &'a Survey,
    /// Places of the pings.
    pub navigation: &'a Navigation,
    /// First returns of the log.
    pub returns: &'a FirstReturns,
    /// Scales of the slant ranges.
    pub calibration: &'a Calibration,
    /// Reduction of samples and recorded depths to metres.
    pub reduction: Reduction<'a>,
    /// Excluded pings and soundings.
    pub exclusions: &'a Exclusions,
    /// Points of the log.
    pub cloud: &'a PointCloud,
    /// The class of each point.
    pub classes: &'a [PointClass],
}

impl<'a> LogPoints<'a> {
    /// Returns all points in the order of the cloud, each with its class.
    pub(crate) fn points(
        &self,
    ) -> impl Iterator<Item = (&'a CloudPoint, PointClass)> + Clone + use<'a> {
        self.cloud.points.iter().zip(self.classes.iter().copied())
    }
}

/// Writes a table: the heading, then the rows of each log by its index. With several logs the
/// column `log` comes first: each row begins with the field that `write_rows` gets, the name of the
/// log and a comma, quoted where the name contains a separator, a quote or a line break. With a
/// single log that field is empty.
fn table(
    path: &Path,
    heading: &str,
    logs: &[LogPoints<'_>],
    write_rows: impl Fn(usize, &str, &mut BufWriter<File>, &mut Summary) -> io::Result<()>,
) -> Result<Summary, ExportError> {
    let is_of_several = logs.len() > 1;
    write_summed(path, |out, summary| {
        writeln!(out, "{}{heading}", if is_of_several { "log," } else { "" })?;
        for (index, log) in logs.iter().enumerate() {
            let name = match (is_of_several, log.name.contains([',', '"', '\n', '\r'])) {
                (false, _) => String::new(),
                (true, false) => format!("{},", log.name),
                (true, true) => format!("\"{}\",", log.name.replace('"', "\"\"")),
            };
            write_rows(index, &name, out, summary)?;
        }
        Ok(())
    })
}

/// Writes one line for each side-scan ping; a field is empty where there is no value. `*_sample`
/// counts u8 samples outward from the middle, `*_range_m` is after calibration, `excluded` is the
/// reason for which a ping is excluded. With several logs the column `log` comes first.
pub(crate) fn first_returns_csv(
    path: &Path,
    logs: &[LogPoints<'_>],
) -> Result<Summary, ExportError> {
    table(path, HEADER, logs, |index, name, out, summary| {
        let log = &logs[index];
        for ping in 0..log.survey.side_scan.len().min(log.navigation.pings.len()) {
            write!(out, "{name}")?;
            write_ping(log, ping, out, summary)?;
        }
        Ok(())
    })
}

fn write_ping(
    log: &LogPoints<'_>,
    index: usize,
    out: &mut impl Write,
    summary: &mut Summary,
) -> io::Result<()> {
    let LogPoints { survey, navigation, .. } = log;
    let (ping, place) = (&survey.side_scan[index], &navigation.pings[index]);
    let at = navigation.to_lon_lat(&survey.track, place.east_m, place.north_m);
    summary.add([at.lon_deg, at.lat_deg], f64::from(ping.depth_m));
    write!(out, "{index},{:.3}", ping.time_s)?;
    number(out, at.lon_deg, 9)?;
    number(out, at.lat_deg, 9)?;
    number(out, place.east_m, 3)?;
    number(out, place.north_m, 3)?;
    number(out, compass_deg(place.heading_rad, 2), 2)?;
    number(out, f64::from(ping.depth_m), 3)?;
    for side in [Side::Port, Side::Starboard] {
        let pick = (log.returns.side(side).get(index)).filter(|pick| pick.is_some());
        let [sample, range_m, confidence] = pick.map_or([f64::NAN; 3], |pick| {
            let range_m = log.calibration.first_return_m(survey, log.returns, index, side);
            [f64::from(pick.sample), range_m, f64::from(pick.confidence)]
        });
        number(out, sample, 2)?;
        number(out, range_m, 4)?;
        number(out, confidence, 3)?;
    }
    let reason = log.exclusions.ping(index).map_or("", ExclusionReason::name);
    writeln!(out, ",{reason}")
}

/// Writes a comma and the number; only a comma for a number that is not finite.
fn number(out: &mut impl Write, value: f64, decimals: usize) -> io::Result<()> {
    if value.is_finite() { write!(out, ",{}", Fixed(value, decimals)) } else { write!(out, ",") }
}

/// Writes every point with its class, log by log in the order of the cloud; with several logs the
/// column `log` comes first. `kept` is 1 where the class is that of the bottom. `level` is the echo
/// level of first returns, 0 to 255; the slant range of a sounding is the distance straight below,
/// that of a swath point the distance straight to the point. `fault` is the reason for which a
/// sounding does not count.
pub(crate) fn cloud_csv(path: &Path, logs: &[LogPoints<'_>]) -> Result<Summary, ExportError> {
    const HEADING: &str = "source,ping,lon,lat,east_m,north_m,z_m,kept,class,level,range_m,fault";
    table(path, HEADING, logs, |index, name, out, summary| {
        let log = &logs[index];
        for (point, class) in log.points() {
            let (east_m, north_m) = (point.east_m, point.north_m);
            let at = log.navigation.to_lon_lat(&log.survey.track, east_m, north_m);
            summary.add([at.lon_deg, at.lat_deg], point.z_m);
            let range_m = log.reduction.point_range_m(log.survey, point);
            let level =
                if point.source.is_side_scan() { point.level.to_string() } else { String::new() };
            writeln!(
                out,
                "{name}{},{},{},{},{},{},{},{},{},{level},{},{}",
                point.source.name(),
                point.ping,
                Fixed(at.lon_deg, 9),
                Fixed(at.lat_deg, 9),
                Fixed(east_m, 4),
                Fixed(north_m, 4),
                Fixed(point.z_m, 4),
                u8::from(class.is_kept()),
                class.code(),
                Fixed(range_m, 3),
                point.fault().map_or("", SoundingFault::name)
            )?;
        }
        Ok(())
    })
}

/// Writes the points that have differences from a reference, log by log; `measured` of a difference
/// is the index of the point in the log's cloud.
pub(crate) fn differences_csv(
    path: &Path,
    logs: &[LogPoints<'_>],
    differences: &[&[Match]],
) -> Result<Summary, ExportError> {
    const HEADING: &str = "source,ping,lon,lat,east_m,north_m,z_m,reference_z_m,difference_m";
    table(path, HEADING, logs, |index, name, out, summary| {
        let log = &logs[index];
        for matched in differences.get(index).copied().unwrap_or_default() {
            let Some(point) = log.cloud.points.get(matched.measured) else {
                continue;
            };
            let (track, east_m, north_m) = (&log.survey.track, point.east_m, point.north_m);
            let at = log.navigation.to_lon_lat(track, east_m, north_m);
            summary.add([at.lon_deg, at.lat_deg], matched.difference_m);
            writeln!(
                out,
                "{name}{},{},{:.9},{:.9},{east_m:.4},{north_m:.4},{:.4},{:.4},{:.4}",
                point.source.name(),
                point.ping,
                at.lon_deg,
                at.lat_deg,
                point.z_m,
                matched.reference_z_m,
                matched.difference_m
            )?;
        }
        Ok(())
    })
}

/// Writes all points as binary little-endian PLY: x east, y north, z up, metres from the survey's
/// origin in the local coordinate frame of the cloud, as doubles; red, green, blue, the level of
/// the echo (`intensity`, 0 for soundings) and the class (`classification`) as bytes; the slant
/// range in metres as a float.
pub(crate) fn cloud_ply(path: &Path, logs: &[LogPoints<'_>]) -> Result<Summary, ExportError> {
    write_summed(path, |out, summary| {
        write!(
            out,
            "ply\nformat binary_little_endian 1.0\ncomment metres east, north and up of the survey's origin\n\
             element vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
             property uchar red\nproperty uchar green\nproperty uchar blue\n\
             property uchar intensity\nproperty uchar classification\nproperty float range_m\nend_header\n",
            logs.iter().map(|log| log.points().count()).sum::<usize>()
        )?;
        for log in logs {
            for (point, class) in log.points() {
                summary.add([point.east_m, point.north_m], point.z_m);
                for value in [point.east_m, point.north_m, point.z_m] {
                    out.write_all(&value.to_le_bytes())?;
                }
                out.write_all(&colour(point.source))?;
                out.write_all(&[point.level, class.code()])?;
                let range_m = log.reduction.point_range_m(log.survey, point) as f32;
                out.write_all(&range_m.to_le_bytes())?;
            }
        }
        Ok(())
    })
}

/// Writes the points of the bottom class as lines of x, y and z with spaces between, x and y with
/// `decimals`; `place` returns the x and y of a point of a log. z is elevation in metres above the
/// transducer, so negative.
pub(crate) fn cloud_xyz(
    path: &Path,
    decimals: usize,
    place: impl Fn(&LogPoints<'_>, &CloudPoint) -> [f64; 2],
    logs: &[LogPoints<'_>],
) -> Result<Summary, ExportError> {
    write_summed(path, |out, summary| {
        for log in logs {
            for (_, point) in log.cloud.kept(log.classes) {
                let [x, y] = place(log, point);
                summary.add([x, y], point.z_m);
                let [x, y] = [x, y].map(|value| Fixed(value, decimals));
                writeln!(out, "{x} {y} {}", Fixed(point.z_m, 3))?;
            }
        }
        Ok(())
    })
}

/// Writes cells as lines of x, y and depth in metres, positive down, with spaces between, x and y
/// with `decimals`. `cells` are the middles of the cells in the file's coordinates with their
/// depths.
pub(crate) fn depth_xyz(
    path: &Path,
    decimals: usize,
    cells: impl Iterator<Item = ([f64; 2], f32)>,
    progress: &Progress,
) -> Result<Summary, ExportError> {
    write_summed(path, |out, summary| {
        for (index, ([x, y], depth_m)) in cells.enumerate() {
            if index % CHUNK == 0 {
                progress.check().map_err(io::Error::other)?;
            }
            summary.add([x, y], f64::from(depth_m));
            let [x, y] = [x, y].map(|value| Fixed(value, decimals));
            writeln!(out, "{x} {y} {}", Fixed(depth_m.into(), 3))?;
        }
        Ok(())
    })
}

/// Writes the points of a point file whose flag is true.
///
/// # Errors
/// When the file cannot be written, or the format cannot hold the points.
pub fn kept_points(
    path: &Path,
    format: PointFormat,
    points: &PointFile,
    kept: &[bool],
) -> Result<(), ExportError> {
    write_atomically(path, |file| points.write_kept(file, format, kept))
}

/// A number and its decimals. Formatting gives the same text as `{:.decimals$}` in a third of the
/// time.
#[derive(Clone, Copy, Debug)]
struct Fixed(f64, usize);

/// Powers of 10 by the number of decimals; more decimals are formatted by the standard library.
const POWERS: [u64; 10] =
    [1, 10, 100, 1_000, 10_000, 100_000, 1_000_000, 10_000_000, 100_000_000, 1_000_000_000];
/// Bound below which the rounding error of a scaled number is less than [`NEAR_HALF`].
const MOST_SCALED: f64 = 1e12;
/// Distance to the middle between two last digits below which the product is too inexact to round;
/// such numbers are formatted by the standard library.
const NEAR_HALF: f64 = 1e-3;
/// Number of bytes of the longest text: digits of a number below [`MOST_SCALED`], a point, a zero
/// before it, and a sign.
const MOST_BYTES: usize = 24;

impl Display for Fixed {
    fn fmt(&self, out: &mut Formatter<'_>) -> fmt::Result {
        let Self(value, decimals) = *self;
        let mut bytes = [0; MOST_BYTES];
        match digits(value, decimals, &mut bytes) {
            Some(text) => out.write_str(text),
            None => write!(out, "{value:.decimals$}"),
        }
    }
}

/// Writes the text of a number to the end of some bytes and returns it; `None` where the number
/// must be formatted by the standard library.
fn digits(value: f64, decimals: usize, bytes: &mut [u8; MOST_BYTES]) -> Option<&str> {
    let power = *POWERS.get(decimals)?;
    let scaled = value.abs() * power as f64;
    if scaled.is_nan() || scaled >= MOST_SCALED {
        return None;
    }
    let below = scaled.floor();
    let rest = scaled - below;
    if (rest - 0.5).abs() < NEAR_HALF {
        return None;
    }
    let mut left = below as u64 + u64::from(rest > 0.5);
    let mut at = MOST_BYTES;
    let mut put = |byte: u8| {
        at -= 1;
        bytes[at] = byte;
    };
    let mut written = 0;
    while left > 0 || written <= decimals {
        put(b'0' + (left % 10) as u8);
        left /= 10;
        written += 1;
        if written == decimals {
            put(b'.');
        }
    }
    if value.is_sign_negative() {
        put(b'-');
    }
    std::str::from_utf8(&bytes[at..]).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_line_is_a_cell_and_the_summary_counts_them() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("depth.xyz");
        let cells = [([500_000.25, 3_000_000.5], 2.25), ([500_000.75, 3_000_000.0], 1.0)];
        let summary = depth_xyz(&path, 3, cells.into_iter(), &Progress::new()).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(text, "500000.250 3000000.500 2.250\n500000.750 3000000.000 1.000\n");
        assert_eq!((summary.count, summary.values), (2, Some([1.0, 2.25])));
        let cancelled = Progress::new();
        cancelled.cancel();
        std::fs::remove_file(&path).unwrap();
        assert!(depth_xyz(&path, 3, cells.into_iter(), &cancelled).is_err());
        assert!(!path.exists(), "nothing half written");
    }

    #[track_caller]
    fn is_same(value: f64) {
        for decimals in 0..12 {
            assert_eq!(
                Fixed(value, decimals).to_string(),
                format!("{value:.decimals$}"),
                "{value:e}, {decimals} decimals"
            );
        }
    }

    #[test]
    fn numbers_are_written_as_the_standard_library_writes_them() {
        for value in [
            0.0,
            -0.0,
            0.5,
            1.5,
            2.5,
            0.05,
            0.045,
            1.005,
            -0.0004,
            0.9999,
            9.9995,
            -99.999_95,
            1e9,
            123_456_789.125,
            999_999_999_999.9,
            1e15,
            -1e300,
            5e-324,
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
        ] {
            is_same(value);
            is_same(-value);
        }
    }

    proptest! {
        #[test]
        fn any_number_is(
            value in prop_oneof![any::<f64>(), -1e7..1e7, -10.0..10.0, (-100_000_000_i64..100_000_000).prop_map(|n| n as f64 / 1e4)]
        ) {
            is_same(value);
            // Halves of the last digit, and the neighbouring numbers.
            let half = (value * 1000.0).round() / 1000.0 + 0.0005;
            for near in [half, half.next_up(), half.next_down()] {
                is_same(near);
            }
        }
    }
}
