//! Counts the content of a file and finds its extent.

use super::atomic_write::{ExportError, write_atomically};
use std::fs::File;
use std::io::{self, BufWriter, Write as _};
use std::path::Path;

/// Number of points, lines or cells of a file, and the box around them in the file's own
/// coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Summary {
    /// Number of points, lines or cells.
    pub count: usize,
    /// Least and most of x (east, longitude) and y (north, latitude); `None` where nothing has a
    /// place.
    pub extent: Option<[[f64; 2]; 2]>,
    /// Least and most value; `None` where there are none.
    pub values: Option<[f64; 2]>,
}

impl Summary {
    /// Counts a thing with a value, which may be NaN, as may its place.
    pub fn add(&mut self, place: [f64; 2], value: f64) {
        self.count += 1;
        self.reach(place);
        self.value(value);
    }

    /// Widens the box.
    pub fn reach(&mut self, [x, y]: [f64; 2]) {
        if x.is_finite() && y.is_finite() {
            let [xs, ys] = self.extent.unwrap_or([[x, x], [y, y]]);
            self.extent = Some([widened(xs, x), widened(ys, y)]);
        }
    }

    /// Widens the range of values.
    pub fn value(&mut self, value: f64) {
        if value.is_finite() {
            self.values = Some(widened(self.values.unwrap_or([value, value]), value));
        }
    }
}

/// Writes a file, and sums up on the way what it holds.
pub(super) fn write_summed(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>, &mut Summary) -> io::Result<()>,
) -> Result<Summary, ExportError> {
    write_atomically(path, |file| {
        let (mut out, mut summary) = (BufWriter::new(file), Summary::default());
        write(&mut out, &mut summary)?;
        out.flush()?;
        Ok(summary)
    })
}

fn widened([least, most]: [f64; 2], value: f64) -> [f64; 2] {
    [least.min(value), most.max(value)]
}
