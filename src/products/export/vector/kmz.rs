//! `*.kmz`: KML 2.2 (OGC 07-147r2) in a zip archive, as map programs and phones open it.

use super::LabelledLine;
use super::zipped::one_file;
use crate::export::geojson::{areas, positions};
use crate::export::{ExportError, Summary, write_atomically};
use bathyscope_bottom::bathymetry::isobaths::Polygon;
use bathyscope_log::support::geo::LonLat;
use bathyscope_log::support::printable::xml;
use std::io::{self, Write};
use std::path::Path;

/// Lines longer than this, degrees (some 10 m), show their label.
const LABELLED_DEG: f64 = 1e-4;

/// Writes lines, and in a folder of their own the labels of the longer ones, each a point in the
/// middle of its line, for a line alone shows none. Geometries of both kinds in one would be no
/// layer of lines for QGIS.
pub(crate) fn lines_kmz(
    path: &Path,
    name: &str,
    lines: &[LabelledLine],
) -> Result<Summary, ExportError> {
    archive(path, name, |out| {
        let mut summary = Summary::default();
        let mut labels = String::new();
        for line in lines {
            let points = positions(line.points.iter().copied());
            summary.count += 1;
            points.iter().for_each(|at| summary.reach(*at));
            let [red, green, blue] = line.colour;
            let label = xml(&line.label);
            writeln!(
                out,
                "<Placemark><name>{label}</name><Style><LineStyle><color>ff{blue:02x}{green:02x}{red:02x}</color><width>2</width></LineStyle>\
                 </Style><LineString><tessellate>1</tessellate><coordinates>{}</coordinates></LineString></Placemark>",
                coordinates(&points)
            )?;
            if let Some(at) = anchor(&points) {
                labels += &format!(
                    "<Placemark><name>{label}</name><Style><IconStyle><scale>0</scale></IconStyle></Style><Point><coordinates>{}</coordinates></Point></Placemark>\n",
                    coordinates(&[at])
                );
            }
        }
        if !labels.is_empty() {
            write!(out, "<Folder><name>Labels</name>\n{labels}</Folder>\n")?;
        }
        Ok(summary)
    })
}

/// The middle of a line that is long enough for its label.
fn anchor(points: &[[f64; 2]]) -> Option<[f64; 2]> {
    let steps = points.windows(2);
    let length: f64 =
        steps.map(|step| (step[1][0] - step[0][0]).hypot(step[1][1] - step[0][1])).sum();
    let middle = points.get(points.len() / 2);
    middle.copied().filter(|_| length > LABELLED_DEG)
}

/// Writes areas as one thing on the map; `place` gives where a corner lies.
pub(crate) fn areas_kmz(
    path: &Path,
    name: &str,
    shapes: &[Polygon],
    place: impl Fn([f64; 2]) -> LonLat,
) -> Result<Summary, ExportError> {
    archive(path, name, |out| {
        let mut summary = Summary { count: 1, ..Summary::default() };
        write!(
            out,
            "<Placemark><name>{}</name><Style><LineStyle><color>ff00d7ff</color><width>2</width></LineStyle>\
             <PolyStyle><color>4000d7ff</color></PolyStyle></Style><MultiGeometry>",
            xml(name)
        )?;
        for polygon in areas(shapes, &place) {
            write!(out, "<Polygon><tessellate>1</tessellate>")?;
            for (index, ring) in polygon.iter().enumerate() {
                ring.iter().for_each(|at| summary.reach(*at));
                let border = if index == 0 { "outer" } else { "inner" };
                write!(
                    out,
                    "<{border}BoundaryIs><LinearRing><coordinates>{}</coordinates></LinearRing></{border}BoundaryIs>",
                    coordinates(ring)
                )?;
            }
            write!(out, "</Polygon>")?;
        }
        writeln!(out, "</MultiGeometry></Placemark>")?;
        Ok(summary)
    })
}

/// A document named `name` with what `write` puts into it, as `doc.kml` of an archive.
fn archive(
    path: &Path,
    name: &str,
    write: impl FnOnce(&mut dyn Write) -> io::Result<Summary>,
) -> Result<Summary, ExportError> {
    write_atomically(path, |file| {
        one_file(file, "doc.kml", |out| {
            write!(
                out,
                "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<kml xmlns=\"http://www.opengis.net/kml/2.2\">\n\
                 <Document>\n<name>{}</name>\n",
                xml(name)
            )?;
            let summary = write(out)?;
            out.write_all(b"</Document>\n</kml>\n")?;
            Ok(summary)
        })
    })
}

fn coordinates(points: &[[f64; 2]]) -> String {
    let texts = points.iter().map(|at| {
        let [lon, lat] = at;
        format!("{lon:.8},{lat:.8}")
    });
    texts.collect::<Vec<_>>().join(" ")
}
