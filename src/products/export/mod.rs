//! Files that other programs open: CSV, PLY, LAZ, GeoTIFF, PNG, GeoJSON, KML, GPX, shapefiles;
//! written aside, then renamed.
//!
//! In: results. Out: one file for each.
//!
//! One file a product, `aside` for the renaming; `las` writes any points as LAS, `extra_bytes`
//! names what they carry beyond it; `geotiff` puts any raster into its file, `grid_raster` the
//! cells of a grid, `qgis_style` its colours, `vector` lines and areas, `rings` keeps polygons
//! valid, `summary` counts what a file holds; `fixed` writes numbers; `log_copy` copies a log;
//! `dataset` is the folder that detectors are trained on, `tile_sets` maps as tiles, `points` what
//! `bathyscope filter` kept, `plan` lines to sail for plotters and autopilots. How rasters and
//! point files are laid out is known to `formats`, which also reads them.

mod antimeridian;
mod atomic_write;
pub mod avi;
mod bottom_las;
mod chip_folder;
mod chips;
mod cloud_csv;
mod cloud_las;
mod cloud_ply;
mod cloud_xyz;
mod dataset;
mod depth_xyz;
mod differences_csv;
mod extra_bytes;
mod figure;
mod first_returns;
mod fixed;
mod footprint;
mod geojson;
mod geopackage;
mod geotiff;
mod glb;
mod gps_time;
mod grid_raster;
mod isobaths;
mod las;
mod log_copy;
mod log_points;
mod objects;
mod picture_boxes;
mod plan;
mod points;
mod profile_csv;
mod qgis_style;
mod qgis_vector;
mod rings;
mod sqlite;
mod summary;
mod survey_layers;
pub(crate) mod tile_sets;
mod track;
mod vector;

pub(crate) use atomic_write::remove_leftovers;
pub use atomic_write::{
    ExportError, NoFolder, is_same_file, make_folder, rename_older, write_atomically, write_bytes,
    write_json,
};
pub(crate) use bottom_las::{BottomCell, bottom_las};
pub use chip_folder::ChipFolder;
pub(crate) use chip_folder::{earlier_chips, remove_passing_chips};
pub(crate) use chips::picture_chips;
pub use chips::{ChipError, ChipLog, chip, chips};
pub(crate) use cloud_csv::cloud_csv;
pub(crate) use cloud_las::cloud_las;
pub(crate) use cloud_ply::cloud_ply;
pub(crate) use cloud_xyz::cloud_xyz;
pub use dataset::{DatasetFolder, DatasetPart, PartSummary};
pub(crate) use depth_xyz::depth_xyz;
pub(crate) use differences_csv::differences_csv;
pub use figure::{MeasuredFigure, figure_csv, figure_geojson};
pub(crate) use first_returns::first_returns_csv;
pub(crate) use footprint::footprint_geojson;
pub(crate) use geopackage::geopackage;
pub use geotiff::{RasterError, geotiff};
pub use glb::{TexturedMesh, glb};
pub use grid_raster::metres_raster;
pub(crate) use grid_raster::source_raster;
pub(crate) use isobaths::{
    DrawnLines, depth_areas_geojson, isobaths_geojson, spot_soundings_geojson, storage_csv,
};
pub(crate) use las::LasPacking;
pub use log_copy::{CopyError, LogPartChoice, TimeBound, check_copy, copy_log};
pub(crate) use log_points::LogPoints;
pub(crate) use objects::{
    ObjectLog, box_table, object_layers, object_places, object_table, objects_geojson,
    objects_gpkg, objects_gpx, objects_kml, shapes_ply,
};
pub(crate) use picture_boxes::picture_boxes_csv;
pub use plan::{PlanFormat, PlanFormatError, PlannedWay};
pub use points::kept_points;
pub use profile_csv::{profile_csv, write_profile_csv};
pub(crate) use qgis_style::qgis_classes;
pub use qgis_style::qgis_style;
pub use summary::Summary;
use summary::write_summed;
pub(crate) use survey_layers::{
    MapGeometry, depth_area_layer, footprint_layer, isobath_layer, spot_sounding_layer, track_layer,
};
pub use track::{TrackPiece, TrackPoint, track};
pub(crate) use track::{track_geojson, track_gpx};
pub(crate) use vector::{LabelledLine, areas_kmz, lines_kmz, lines_shapefile};

use bathyscope_bottom::cloud::PointSource;

/// Rounded to the millimetre.
fn millimetres(metres: f64) -> f64 {
    (metres * 1e3).round() / 1e3
}

/// Colours of the paper: soundings black, starboard red, port blue; the swath violet.
fn colour(source: PointSource) -> [u8; 3] {
    match source {
        PointSource::DownScan => [0, 0, 0],
        PointSource::Starboard => [255, 0, 0],
        PointSource::Port => [0, 0, 255],
        PointSource::Swath => [150, 0, 200],
    }
}
