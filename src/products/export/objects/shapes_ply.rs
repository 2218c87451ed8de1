//! Writes `shapes.ply`: the solids fitted to objects, as bodies for 3D programs.

use crate::export::{ExportError, Summary, write_summed};
use bathyscope_objects::objects::ListedObject;
use bathyscope_objects::targets::FittedShape;
use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::Path;

/// Number of squares of the grid along the length and across the width of a solid.
const SQUARES: usize = 40;
/// Size of the grid relative to that of the solid: the sides of the solid are in the outermost
/// squares.
const ROOM: f64 = 1.02;
/// Colour of inferred shapes, the same as in Bathyscope and different from those of all sources of
/// points: inferred shapes must not be mistaken for measured ones.
const COLOUR: [u8; 3] = [255, 122, 46];

/// The upper surface of a solid as a grid of squares.
struct Body {
    /// Places of the corners, metres east, north and up.
    corners: Vec<[f64; 3]>,
    /// Corners of each square that the solid reaches into, counter-clockwise from above.
    squares: Vec<[u32; 4]>,
}

impl Body {
    fn new(shape: &FittedShape) -> Self {
        let posed = shape.posed;
        let solid = posed.solid;
        let heights = (0..=SQUARES).flat_map(|row| (0..=SQUARES).map(move |column| (row, column)));
        let heights: Vec<([f64; 2], f64)> = heights
            .map(|(row, column)| {
                let share = |index: usize| ROOM * (index as f64 / SQUARES as f64 - 0.5);
                let place_m = [share(row) * solid.length_m, share(column) * solid.width_m];
                (place_m, solid.height_at_m(place_m[0], place_m[1]))
            })
            .collect();
        let mut index_of = vec![None; heights.len()];
        let mut body = Self { corners: Vec::new(), squares: Vec::new() };
        for row in 0..SQUARES {
            for column in 0..SQUARES {
                let first = row * (SQUARES + 1) + column;
                // Along is ahead, across is to starboard; the corners are reversed below to be
                // counter-clockwise.
                let square = [first, first + SQUARES + 1, first + SQUARES + 2, first + 1];
                if square.iter().all(|corner| heights[*corner].1 == 0.0) {
                    continue;
                }
                let mut corners = [0; 4];
                for (corner, into) in square.into_iter().zip(corners.iter_mut().rev()) {
                    let index = index_of[corner].get_or_insert_with(|| {
                        let (place_m, height_m) = heights[corner];
                        let [east_m, north_m] = posed.place_m(place_m);
                        body.corners.push([east_m, north_m, shape.bottom_z_m + height_m]);
                        body.corners.len() as u32 - 1
                    });
                    *into = *index;
                }
                body.squares.push(corners);
            }
        }
        body
    }
}

/// Writes the shapes of objects as binary little-endian PLY, a body for each object: x east, y
/// north, z up, metres from the survey's origin in the local coordinate frame, as doubles; red,
/// green, blue as bytes; the object's number as `object`. Comments name the kind and the size of
/// each solid.
pub(crate) fn shapes_ply(
    path: &Path,
    objects: &[ListedObject<'_>],
) -> Result<Summary, ExportError> {
    let shapes: BTreeMap<u32, &FittedShape> =
        (objects.iter()).filter_map(|of| Some((of.object.number, of.shape?))).collect();
    let bodies: Vec<(u32, Body)> =
        (shapes.iter()).map(|(number, shape)| (*number, Body::new(shape))).collect();
    write_summed(path, |out, summary| {
        out.write_all(
            b"ply\nformat binary_little_endian 1.0\ncomment metres east, north and up of the survey's origin\n\
              comment source inferred: solids fitted to echo and shadow, not measured\n",
        )?;
        for (number, shape) in &shapes {
            let solid = shape.posed.solid;
            writeln!(
                out,
                "comment object {number}: {}, {:.2} x {:.2} x {:.2} m",
                solid.kind.name(),
                solid.length_m,
                solid.width_m,
                solid.height_m
            )?;
        }
        let corners = bodies.iter().map(|(_, body)| body.corners.len());
        let squares = bodies.iter().map(|(_, body)| body.squares.len());
        write!(
            out,
            "element vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
             property uchar red\nproperty uchar green\nproperty uchar blue\nproperty int object\n\
             element face {}\nproperty list uchar int vertex_indices\nend_header\n",
            corners.sum::<usize>(),
            squares.sum::<usize>()
        )?;
        for (number, body) in &bodies {
            for [east_m, north_m, z_m] in &body.corners {
                summary.add([*east_m, *north_m], *z_m);
                for value in [east_m, north_m, z_m] {
                    out.write_all(&value.to_le_bytes())?;
                }
                out.write_all(&COLOUR)?;
                out.write_all(&i32::try_from(*number).unwrap_or(i32::MAX).to_le_bytes())?;
            }
        }
        let mut first = 0;
        for (_, body) in &bodies {
            for square in &body.squares {
                out.write_all(&[4])?;
                for corner in square {
                    out.write_all(&(first + corner).to_le_bytes())?;
                }
            }
            first += body.corners.len() as u32;
        }
        summary.count = shapes.len();
        Ok(())
    })
}
