//! `track.gpx` (GPX 1.1): the track as plotters and handheld receivers read it.

use super::TrackPiece;
use crate::export::{ExportError, Summary, write_summed};
use bathyscope_log::support::calendar::timestamp;
use bathyscope_log::support::printable::xml;
use std::io::{self, Write};
use std::path::Path;

/// Writes the pieces as segments of one track; with times where it is known when the log began
/// (Unix seconds).
pub(crate) fn track_gpx(
    path: &Path,
    name: &str,
    start_unix_s: Option<f64>,
    pieces: &[TrackPiece],
) -> Result<Summary, ExportError> {
    write_summed(path, |out, summary| {
        for point in pieces.iter().flat_map(|piece| &piece.points) {
            summary.add([point.position.lon_deg, point.position.lat_deg], f64::NAN);
        }
        write_track_gpx(out, name, start_unix_s, pieces)
    })
}

/// Does the same as [`track_gpx`] for a file that is open.
pub(crate) fn write_track_gpx(
    out: &mut impl Write,
    name: &str,
    start_unix_s: Option<f64>,
    pieces: &[TrackPiece],
) -> io::Result<()> {
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
            write!(out, "<trkpt lat=\"{lat:.8}\" lon=\"{lon:.8}\">")?;
            if let Some(start_unix_s) = start_unix_s {
                let time = timestamp(start_unix_s + point.time_s);
                write!(out, "<time>{time}</time>")?;
            }
            writeln!(out, "</trkpt>")?;
        }
        writeln!(out, "</trkseg>")?;
    }
    writeln!(out, "</trk>\n</gpx>")
}
