//! Writes files that other programs open: CSV, PLY, LAZ, GeoTIFF, PNG, GeoJSON, KML, GPX,
//! shapefiles. Each file is written under a temporary name, then renamed.
//!
//! In: results. Out: one file for each.
//!
//! There is one module for each kind of product. `atomic_write` renames finished files, and
//! [`Summary`] is the content of a file in numbers; `points` writes tables and clouds as text,
//! `las` points of any kind as LAS; `geotiff` writes any raster and the cells of a grid,
//! `qgis_style` the styles of rasters and layers, `vector` lines and areas; `rings` keeps polygons
//! valid; `log_copy` copies a log; `dataset` is the folder that detectors are trained on,
//! `tile_sets` writes maps as tiles, `plan` planned lines for plotters and autopilots. The layouts
//! of rasters and point files are defined in `formats`, which also reads them.

mod atomic_write;
pub mod avi;
mod chips;
mod dataset;
mod figure;
mod geojson;
mod geopackage;
mod geotiff;
mod glb;
mod isobaths;
mod las;
mod log_copy;
mod objects;
mod plan;
mod points;
mod qgis_style;
mod rings;
mod sqlite;
mod survey_layers;
pub(crate) mod tile_sets;
mod track;
mod vector;

pub(crate) use atomic_write::remove_leftovers;
pub use atomic_write::{
    ExportError, is_same_file, make_folder, rename_older, write_atomically, write_bytes, write_json,
};
pub use chips::chip;
pub(crate) use chips::{ChipLog, chips, earlier_chips, picture_chips, remove_passing_chips};
pub use dataset::{DatasetFolder, DatasetPart, PartSummary};
pub use figure::{MeasuredFigure, figure_csv, figure_geojson, profile_csv};
pub(crate) use geopackage::geopackage;
pub use geotiff::{geotiff, metres_raster};
pub(crate) use geotiff::{raster_over, source_raster};
pub(crate) use glb::{TexturedMesh, glb};
pub(crate) use isobaths::{
    DrawnLines, depth_areas_geojson, isobaths_geojson, spot_soundings_geojson, storage_csv,
};
pub(crate) use las::{BottomCell, LasPacking, bottom_las, cloud_las};
pub use log_copy::{LogPartChoice, TimeBound, check_copy, copy_log};
pub(crate) use objects::{
    ObjectLog, box_table, object_layers, object_table, objects_geojson, objects_gpkg, objects_gpx,
    objects_kml, picture_boxes_csv, shapes_ply,
};
pub use plan::{PlanFormat, PlannedWay};
pub use points::kept_points;
pub(crate) use points::{
    LogPoints, cloud_csv, cloud_ply, cloud_xyz, depth_xyz, differences_csv, first_returns_csv,
};
pub(crate) use qgis_style::qgis_classes;
pub use qgis_style::qgis_style;
pub(crate) use survey_layers::{
    MapGeometry, depth_area_layer, footprint_layer, isobath_layer, spot_sounding_layer, track_layer,
};
pub(crate) use track::{SideScanCoverage, footprint_geojson, track_geojson, track_gpx};
pub use track::{TrackPiece, TrackPoint, track};
pub(crate) use vector::{LabelledLine, areas_kmz, lines_kmz, lines_shapefile};

use bathyscope_bottom::cloud::PointSource;
use std::fs::File;
use std::io::{self, BufWriter, Write as _};
use std::path::Path;

/// Number of points, lines or cells of a file, and the box around them in the file's own
/// coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Summary {
    /// Number of points, lines or cells.
    pub count: usize,
    /// Least and greatest x (east, longitude) and y (north, latitude); `None` where nothing has a
    /// place.
    pub extent: Option<[[f64; 2]; 2]>,
    /// Least and greatest value; `None` without values.
    pub values: Option<[f64; 2]>,
}

impl Summary {
    /// Counts a thing with its place and its value, either of which may be NaN.
    pub fn add(&mut self, place: [f64; 2], value: f64) {
        self.count += 1;
        self.reach(place);
        self.value(value);
    }

    /// Widens the extent so that it holds a place.
    pub fn reach(&mut self, [x, y]: [f64; 2]) {
        if x.is_finite() && y.is_finite() {
            let [xs, ys] = self.extent.unwrap_or([[x, x], [y, y]]);
            self.extent = Some([widened(xs, x), widened(ys, y)]);
        }
    }

    /// Widens the range of values so that it holds a value.
    pub fn value(&mut self, value: f64) {
        if value.is_finite() {
            self.values = Some(widened(self.values.unwrap_or([value, value]), value));
        }
    }
}

/// Beginning of a KML file, up to the content of its document.
const KML_HEAD: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<kml xmlns=\"http://www.opengis.net/kml/2.2\">\n<Document>\n";
/// Beginning of a GPX file, up to further attributes of its outermost element.
const GPX_HEAD: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<gpx version=\"1.1\" creator=\"Bathyscope\" xmlns=\"http://www.topografix.com/GPX/1/1\"";

/// Writes a file and returns the summary that `write` collects.
fn write_summed(
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

/// Rounds metres to the millimetre.
fn millimetres(metres: f64) -> f64 {
    (metres * 1e3).round() / 1e3
}

/// Returns the colour of a source, as in the paper: soundings black, starboard red, port blue; the
/// swath violet.
fn colour(source: PointSource) -> [u8; 3] {
    match source {
        PointSource::DownScan => [0, 0, 0],
        PointSource::Starboard => [255, 0, 0],
        PointSource::Port => [0, 0, 255],
        PointSource::Swath => [150, 0, 200],
    }
}
