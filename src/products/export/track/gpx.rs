//! `track.gpx` (GPX 1.1): the track as plotters and handheld receivers read it.

use super::TrackPiece;
use crate::products::export::{ExportError, Summary, write_summed};
use crate::support::calendar::timestamp;
use crate::support::printable::xml;
use std::io::Write as _;
use std::path::Path;

/// Writes the pieces as segments of one track; with times where it is known when the log began (Unix seconds).
pub(crate) fn track_gpx(
    path: &Path,
    name: &str,
    start_unix_s: Option<f64>,
    pieces: &[TrackPiece],
) -> Result<Summary, ExportError> {
    write_summed(path, |out, summary| {
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
        Ok(())
    })
}
