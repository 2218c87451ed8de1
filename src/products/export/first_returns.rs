//! `first_returns.csv`: one line a ping.

use super::fixed::Fixed;
use super::log_points::LogColumn;
use super::{ExportError, LogPoints, Summary, write_summed};
use bathyscope_log::support::geo::compass_deg;
use bathyscope_log::survey::{ExclusionReason, Side};
use std::io::{self, Write};
use std::path::Path;

const HEADER: &str = "ping,time_s,lon,lat,east_m,north_m,heading_deg,depth_m,\
     port_sample,port_range_m,port_confidence,starboard_sample,starboard_range_m,starboard_confidence,excluded";

/// Writes one line for each side-scan ping; a field is empty where there is no value. `*_sample`
/// counts u8 samples outward from the middle, `*_range_m` is after calibration, `excluded` why a
/// ping counts for nothing. Of several logs the column `log` stands before the others.
pub(crate) fn first_returns_csv(
    path: &Path,
    logs: &[LogPoints<'_>],
) -> Result<Summary, ExportError> {
    let column = LogColumn::of(logs);
    write_summed(path, |out, summary| {
        writeln!(out, "{}{HEADER}", column.header)?;
        for log in logs {
            let name = column.field(log);
            for ping in 0..log.survey.side_scan.len().min(log.navigation.pings.len()) {
                write!(out, "{name}")?;
                write_ping(log, ping, out, summary)?;
            }
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
            let range_m = log.calibration.pick_range_m(survey, index, side, pick.sample);
            [f64::from(pick.sample), range_m, f64::from(pick.confidence)]
        });
        number(out, sample, 2)?;
        number(out, range_m, 4)?;
        number(out, confidence, 3)?;
    }
    let reason = log.exclusions.ping(index).map_or("", ExclusionReason::name);
    writeln!(out, ",{reason}")
}

/// A comma and the number, or a comma alone where there is none.
fn number(out: &mut impl Write, value: f64, decimals: usize) -> io::Result<()> {
    if value.is_finite() { write!(out, ",{}", Fixed(value, decimals)) } else { write!(out, ",") }
}
