//! Writes points to LAS and LAZ, and chooses the scale and offset of their 32-bit coordinates.

use crate::support::catch_panic::catch_panic;
use las::{Header, Point, PointData, Transform, Vector, Writer};
use std::fs::File;
use std::io::{self, BufWriter, Write as _};

/// Writer that returns an error where the writer of the crate panics: if dropped before the end,
/// the crate's writer writes its header again, which fails where the disk is full or a point is
/// outside the range of LAS.
pub struct LasWriter(Option<Writer<BufWriter<File>>>);

impl LasWriter {
    /// Creates a writer of an open file and writes the header.
    pub fn new(file: File, header: Header) -> io::Result<Self> {
        let writer = Writer::new(BufWriter::new(file), header).map_err(failed)?;
        Ok(Self(Some(writer)))
    }

    /// Writes a point.
    pub fn point(&mut self, point: Point) -> io::Result<()> {
        let writer = self.0.as_mut().ok_or_else(closed)?;
        writer.write_point(point).map_err(failed)
    }

    /// Writes points in their stored form, as read from another file.
    pub fn points(&mut self, points: &PointData) -> io::Result<()> {
        let writer = self.0.as_mut().ok_or_else(closed)?;
        writer.write_points(points).map_err(failed)
    }

    /// Writes the remaining points, and the header with the count and bounds of the points.
    pub fn finish(mut self) -> io::Result<()> {
        let writer = self.0.as_mut().ok_or_else(closed)?;
        writer.close().map_err(failed)?;
        let writer = self.0.take().ok_or_else(closed)?;
        let file = writer.into_inner().map_err(failed)?;
        file.into_inner().map_err(|error| error.into_error())?.flush()
    }
}

impl Drop for LasWriter {
    fn drop(&mut self) {
        let left = self.0.take();
        // The error that matters was returned earlier.
        catch_panic(|| drop(left));
    }
}

/// Returns the operating system's error where the crate wraps it.
fn failed(error: las::Error) -> io::Error {
    match error {
        las::Error::Io(error) => error,
        error => io::Error::other(error),
    }
}

fn closed() -> io::Error {
    io::Error::other("the LAS file is closed already")
}

/// Multiples of the finest resolution that are tried where points are too far apart for it.
const COARSER: [f64; 3] = [1.0, 10.0, 100.0];
/// Most steps between a coordinate and the offset, a little less than 32 bits allow.
const MOST_STEPS: f64 = 2_147_483_000.0;

/// Returns the scale and offset of every axis: the finest resolution, with an offset near `near`,
/// if all points are within its range; otherwise an offset in the middle of the points, at the
/// finest resolution, or at ten or a hundred times that.
///
/// The error is a sentence without the path: a coordinate is no number, or the points are too far
/// apart even then.
pub fn transforms(
    points: impl Iterator<Item = [f64; 3]>,
    near: [f64; 3],
    finest: [f64; 3],
) -> io::Result<Vector<Transform>> {
    let nothing = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    let mut are_numbers = true;
    let (low, high) = points.fold(nothing, |(low, high), point| {
        are_numbers &= point.iter().all(|value| value.is_finite());
        (
            [0, 1, 2].map(|axis| low[axis].min(point[axis])),
            [0, 1, 2].map(|axis| high[axis].max(point[axis])),
        )
    });
    if !are_numbers {
        return Err(io::Error::other(
            "a point has a coordinate that is no number, which LAS cannot hold",
        ));
    }
    let axis = |axis: usize| {
        let span = [low[axis], high[axis]];
        let found = transform(span, near[axis], finest[axis]);
        found.ok_or_else(|| {
            let name = ["x", "y", "z"][axis];
            let [from, to] = span.map(short);
            let most = short(2.0 * MOST_STEPS * COARSER[2] * finest[axis]);
            io::Error::other(format!(
                "the points reach from {from} to {to} along {name}, and LAS holds {most} at most; remove what lies far off, or write .csv or .ply"
            ))
        })
    };
    Ok(Vector { x: axis(0)?, y: axis(1)?, z: axis(2)? })
}

fn transform([low, high]: [f64; 2], near: f64, finest: f64) -> Option<Transform> {
    let near = near.round();
    let middle = (0.5 * low + 0.5 * high).round();
    let fits = |transform: &Transform| {
        // Without points, the bounds are infinite with the wrong signs, and every transform fits.
        let reach = MOST_STEPS * transform.scale;
        !(transform.offset - low > reach || high - transform.offset > reach)
    };
    let finest = [near, middle].map(|offset| Transform { scale: finest, offset });
    let coarser = COARSER[1..]
        .iter()
        .map(|times| Transform { scale: finest[0].scale * times, offset: middle });
    finest.into_iter().chain(coarser).find(fits)
}

/// Formats a number in few characters at any size.
fn short(value: f64) -> String {
    match value.abs() {
        1e-3..1e5 => format!("{value:.3}"),
        1e5..1e12 => format!("{value:.0}"),
        _ => format!("{value:e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn made(points: &[[f64; 3]]) -> io::Result<Vector<Transform>> {
        transforms(points.iter().copied(), [5e5, 4e6, 0.0], [1e-3; 3])
    }

    #[test]
    fn the_resolution_follows_the_extent_and_what_does_not_fit_is_said() {
        let usual = made(&[[500_010.0, 4_000_020.0, -3.0]]).unwrap();
        assert_eq!((usual.x.offset, usual.x.scale), (5e5, 1e-3));
        let nothing = made(&[]).unwrap();
        assert_eq!((nothing.z.offset, nothing.z.scale), (0.0, 1e-3));
        let far = made(&[[9.5e9, 0.0, 1e9], [9.5e9, 0.0, 1e9]]).unwrap();
        assert_eq!((far.x.offset, far.z.offset), (9.5e9, 1e9));
        let wide = made(&[[-9e6, 0.0, 0.0], [9e6, 0.0, 0.0]]).unwrap();
        assert_eq!((wide.x.offset, wide.x.scale), (0.0, 1e-2));
        for transform in [usual.x, far.x, wide.x] {
            let reach = f64::from(i32::MAX) * transform.scale;
            assert!(transform.offset.abs() < 1e10 && reach > 2e6);
        }
        let apart = made(&[[0.0, 0.0, -1e300], [0.0, 0.0, 1e300]]).unwrap_err().to_string();
        assert!(apart.contains("-1e300 to 1e300 along z"), "{apart}");
        let none = made(&[[0.0, f64::NAN, 0.0]]).unwrap_err().to_string();
        assert!(none.contains("no number"), "{none}");
    }
}
