//! `depth.xyz`: the cells of the depth map as plain text, for whatever reads columns.

use super::fixed::Fixed;
use super::{ExportError, Summary, write_summed};
use bathyscope_log::support::progress::Progress;
use std::io::{self, Write as _};
use std::path::Path;

/// Cells written between two looks at whether the work was cancelled.
const CHUNK: usize = 4096;

/// Writes cells as lines of x, y and depth in metres, positive down, with spaces between;
/// `decimals` of them for x and y. `cells` gives the middle of a cell in the file's coordinates and
/// its depth.
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

#[cfg(test)]
mod tests {
    use super::*;

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
}
