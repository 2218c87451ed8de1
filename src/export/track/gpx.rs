//! `track.gpx` (GPX 1.1): the track as plotters and handheld receivers read it.

use super::TrackPiece;
use crate::calendar::{date, time_of_day};
use crate::export::{ExportError, Summary, write_aside, xml};
use std::io::{BufWriter, Write as _};
use std::path::Path;

/// Writes the pieces as segments of one track; with times where it is known when the log began (Unix seconds).
pub fn track_gpx(
    path: &Path,
    name: &str,
    start_unix_s: Option<f64>,
    pieces: &[TrackPiece],
) -> Result<Summary, ExportError> {
    write_aside(path, |file| {
        let (mut out, mut summary) = (BufWriter::new(file), Summary::default());
        let name = xml(name);
        write!(
            out,
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<gpx version=\"1.1\" creator=\"Bathyscope\" \
             xmlns=\"http://www.topografix.com/GPX/1/1\">\n<trk><name>{name}</name>\n"
        )?;
        for piece in pieces {
            writeln!(out, "<trkseg>")?;
            for point in &piece.points {
                let (lon, lat) = (point.position.lon_deg, point.position.lat_deg);
                summary.add([lon, lat], f64::NAN);
                write!(out, "<trkpt lat=\"{lat:.8}\" lon=\"{lon:.8}\">")?;
                if let Some(start_unix_s) = start_unix_s {
                    write!(
                        out,
                        "<time>{}</time>",
                        timestamp(start_unix_s + point.time_s)
                    )?;
                }
                writeln!(out, "</trkpt>")?;
            }
            writeln!(out, "</trkseg>")?;
        }
        writeln!(out, "</trk>\n</gpx>")?;
        out.flush()?;
        Ok(summary)
    })
}

/// `2014-09-08T12:57:01.250Z`.
fn timestamp(unix_s: f64) -> String {
    let whole_ms = (unix_s * 1e3).round();
    let seconds = (whole_ms / 1e3).floor();
    let ms = whole_ms.rem_euclid(1e3) as u32;
    format!("{}T{}.{ms:03}Z", date(seconds), time_of_day(seconds))
}

#[cfg(test)]
mod tests {
    #[test]
    fn times_are_those_of_iso_8601() {
        assert_eq!(
            super::timestamp(1_410_181_021.25),
            "2014-09-08T12:57:01.250Z"
        );
        assert_eq!(super::timestamp(-0.0004), "1970-01-01T00:00:00.000Z");
        assert_eq!(super::timestamp(-0.25), "1969-12-31T23:59:59.750Z");
    }
}
