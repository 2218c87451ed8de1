//! `cloud.xyz`: the points of the bottom as plain text, for whatever reads columns.

use super::fixed::Fixed;
use super::{ExportError, LogPoints, Summary, write_summed};
use bathyscope_bottom::cloud::CloudPoint;
use std::io::Write as _;
use std::path::Path;

/// Writes the points of the class of the bottom as lines of x, y and z with spaces between,
/// `decimals` of them for x and y; `place` gives where a point of a log lies. z is elevation in
/// metres above the transducer, so negative.
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
