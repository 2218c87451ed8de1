//! Geometries as a GeoPackage stores them: a header with the box around them, and well-known binary
//! (OGC 06-103r4) behind it, all of it with the lowest byte first.

/// Kinds of geometry in well-known binary.
const POINT: u32 = 1;
const LINE: u32 = 2;
const POLYGON: u32 = 3;
const POLYGONS: u32 = 6;

/// Corners of a ring, the last one that of the first.
pub(crate) type Ring = Vec<[f64; 2]>;

/// Geometry of a feature, in the system of its file: east or longitude first.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum FeatureGeometry {
    /// A place.
    Point([f64; 2]),
    /// A line.
    Line(Vec<[f64; 2]>),
    /// An outline and its holes.
    Polygon(Vec<Ring>),
    /// Several of them.
    Polygons(Vec<Vec<Ring>>),
}

impl FeatureGeometry {
    fn places(&self) -> impl Iterator<Item = [f64; 2]> {
        let (one, line, rings, polygons) = match self {
            FeatureGeometry::Point(place) => (Some(*place), &[][..], &[][..], &[][..]),
            FeatureGeometry::Line(line) => (None, &line[..], &[][..], &[][..]),
            FeatureGeometry::Polygon(rings) => (None, &[][..], &rings[..], &[][..]),
            FeatureGeometry::Polygons(polygons) => (None, &[][..], &[][..], &polygons[..]),
        };
        let rings = polygons.iter().flatten().chain(rings);
        let corners = rings.flatten().copied();
        one.into_iter().chain(line.iter().copied()).chain(corners)
    }

    /// Least x and y, most x and y; NaN of nothing.
    pub(crate) fn bounds(&self) -> [f64; 4] {
        self.places().fold([f64::NAN; 4], |bounds, [x, y]| united(bounds, [x, y, x, y]))
    }

    /// The bytes in a system by its number.
    pub(crate) fn bytes(&self, system: i32) -> Vec<u8> {
        let is_point = matches!(self, FeatureGeometry::Point(_));
        // Lowest byte first; an envelope of two dimensions where it is no point.
        let flags = if is_point { 0b001 } else { 0b011 };
        let mut bytes = vec![b'G', b'P', 0, flags];
        bytes.extend(system.to_le_bytes());
        if !is_point {
            let [west, south, east, north] = self.bounds();
            for end in [west, east, south, north] {
                bytes.extend(end.to_le_bytes());
            }
        }
        match self {
            FeatureGeometry::Point(place) => {
                begin(&mut bytes, POINT);
                put_places(&mut bytes, &[*place]);
            }
            FeatureGeometry::Line(line) => {
                begin(&mut bytes, LINE);
                put_line(&mut bytes, line);
            }
            FeatureGeometry::Polygon(rings) => put_polygon(&mut bytes, rings),
            FeatureGeometry::Polygons(polygons) => {
                begin(&mut bytes, POLYGONS);
                put_count(&mut bytes, polygons.len());
                for rings in polygons {
                    put_polygon(&mut bytes, rings);
                }
            }
        }
        bytes
    }
}

/// The box around two boxes; NaN counts for nothing.
pub(super) fn united(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])]
}

fn begin(bytes: &mut Vec<u8>, kind: u32) {
    bytes.push(1);
    bytes.extend(kind.to_le_bytes());
}

fn put_count(bytes: &mut Vec<u8>, count: usize) {
    bytes.extend((count as u32).to_le_bytes());
}

fn put_polygon(bytes: &mut Vec<u8>, rings: &[Ring]) {
    begin(bytes, POLYGON);
    put_count(bytes, rings.len());
    rings.iter().for_each(|ring| put_line(bytes, ring));
}

fn put_line(bytes: &mut Vec<u8>, line: &[[f64; 2]]) {
    put_count(bytes, line.len());
    put_places(bytes, line);
}

fn put_places(bytes: &mut Vec<u8>, places: &[[f64; 2]]) {
    for number in places.iter().flatten() {
        bytes.extend(number.to_le_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shape_is_well_known_binary_behind_a_header() {
        let point = FeatureGeometry::Point([1.5, -2.0]).bytes(4326);
        assert_eq!(point[..8], [b'G', b'P', 0, 1, 0xe6, 0x10, 0, 0]);
        assert_eq!(point[8..13], [1, 1, 0, 0, 0]);
        assert_eq!(point[13..21], 1.5_f64.to_le_bytes());
        assert_eq!(point.len(), 29);
        let ring = vec![[0.0, 0.0], [2.0, 0.0], [1.0, 3.0], [0.0, 0.0]];
        let polygon = FeatureGeometry::Polygon(vec![ring.clone()]).bytes(4326);
        assert_eq!(polygon[3], 3);
        // West, east, south, north.
        assert_eq!(polygon[16..24], 2.0_f64.to_le_bytes());
        assert_eq!(polygon[32..40], 3.0_f64.to_le_bytes());
        assert_eq!(polygon[40..49], [1, 3, 0, 0, 0, 1, 0, 0, 0]);
        assert_eq!(polygon.len(), 8 + 32 + 5 + 8 + 4 * 16);
        let line = FeatureGeometry::Line(ring.clone()).bytes(4326);
        assert_eq!(line[40..49], [1, 2, 0, 0, 0, 4, 0, 0, 0]);
        let several = FeatureGeometry::Polygons(vec![vec![ring.clone()], vec![ring]]).bytes(4326);
        assert_eq!(several[40..49], [1, 6, 0, 0, 0, 2, 0, 0, 0]);
        assert_eq!(several[49..], [&polygon[40..], &polygon[40..]].concat());
    }

    #[test]
    fn nothing_has_no_bounds() {
        assert!(FeatureGeometry::Line(Vec::new()).bounds().iter().all(|end| end.is_nan()));
        let line = FeatureGeometry::Line(vec![[3.0, 1.0], [-2.0, 5.0]]);
        assert_eq!(line.bounds(), [-2.0, 1.0, 3.0, 5.0]);
    }
}
