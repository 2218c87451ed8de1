//! `track.geojson` and the insonified area.

use super::TrackPiece;
use crate::export::geojson::{collection, line_at};
use crate::export::{ExportError, Summary};
use serde_json::json;
use std::path::Path;

/// Writes each piece as a line.
pub(crate) fn track_geojson(path: &Path, pieces: &[TrackPiece]) -> Result<Summary, ExportError> {
    let feature = |piece: &TrackPiece, summary: &mut Summary| {
        summary.count += 1;
        let ends = [piece.points.first(), piece.points.last()];
        let [from, to] = ends.map(|end| end.map(|point| (point.ping, point.time_s)));
        let properties = json!({
            "ping_from": from.map(|end| end.0),
            "ping_to": to.map(|end| end.0),
            "from_s": from.map(|end| end.1),
            "to_s": to.map(|end| end.1),
            "length_m": (piece.length_m * 1e3).round() / 1e3,
        });
        line_at(piece.points.iter().map(|point| point.position), properties, summary)
    };
    collection(path, pieces.iter(), feature)
}
