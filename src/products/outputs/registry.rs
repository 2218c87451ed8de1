//! Lists every file of a run, one row each. The help of `--products`, the refusal to write over
//! inputs, the removal of files of an earlier run, the check for files that are out of date and the
//! list in `report.html` are all derived from these rows. `kinds` has the columns that rows of a
//! kind share.

mod kinds;

use super::content::{FileResult, Need};
use super::order::{Product, When};
use super::results::Results;
use super::{clouds, comparison, lines, object_files, rasters, tiles};
use kinds::{
    CLASSED_POINTS, KEPT_POINTS, LAS_POINTS, NOT_OF_BODY, NOT_OF_CLOUD, NOT_OF_DEPTHS,
    NOT_OF_MOSAIC, NOT_OF_POINTS, boxes, cloud, compared, contour_file, described, footprint,
    isobaths, map_tiles, raster, row, run_file, target_file, track_file,
};
use std::collections::BTreeSet;
use std::path::Path;

/// A file of a run.
#[derive(Debug)]
pub struct OutputFile {
    /// Name of the file with its subfolder: `depth/depth.tif`; for the pictures of boxes, the name
    /// of a folder.
    pub name: &'static str,
    /// Files that are written with the file and belong to it, named in the same way.
    pub companions: &'static [&'static str],
    /// Condition under which a run writes the file.
    pub when: When,
    /// Inputs without which the file is not written; the first missing one is reported as the
    /// reason.
    pub needs: &'static [Need],
    /// Groups of settings, by the first word of the key, that the file does not depend on. It
    /// depends on all others.
    pub regardless_of: &'static [&'static str],
    /// Description in a few words, for people who do not know the file.
    pub brief: &'static str,
    /// Description in the manifest; `None` for a page, for records and for pictures.
    pub described: Option<Described>,
    /// Writer of the file.
    pub(super) writer: FileWriter,
}

/// Description of a file in the manifest, independent of its content.
#[derive(Clone, Copy, Debug)]
pub struct Described {
    /// Description in a sentence, without the full stop.
    pub what: &'static str,
    /// Name of the counted things: `points`.
    pub counted: &'static str,
    /// Name of the measured value, with its unit: `depth_m`; empty where nothing is measured.
    pub measured: &'static str,
}

/// Function that writes a file from the results of the survey.
pub(super) type WriteFile = fn(&Results<'_>, &Path) -> FileResult;

/// Writer of a file.
#[derive(Clone, Copy, Debug)]
pub(super) enum FileWriter {
    /// Writes the file from the results of the survey.
    Results(WriteFile),
    /// Writes `report.html`, which describes the files that were made from results.
    Page,
    /// Writes `report.json`.
    Record,
    /// Writes `manifest.json`, when all other files are there.
    Manifest,
}

impl OutputFile {
    /// Returns true if a file of a run is this file, one of its companions, or in this folder.
    pub fn owns(&self, name: &str) -> bool {
        let in_folder = || name.strip_prefix(self.name)?.strip_prefix('/');
        name == self.name || self.companions.contains(&name) || in_folder().is_some()
    }

    /// Returns true if a version without subfolders, which wrote a record `NAME.json` for each
    /// file, wrote this file or its companions under such a name.
    pub(super) fn owned_beside(&self, name: &str) -> bool {
        let own = file_part(self.name);
        let in_folder = || name.strip_prefix(own)?.strip_prefix('/');
        let mut companions = self.companions.iter().map(|companion| file_part(companion));
        let record = || self.described.and(name.strip_suffix(".json")) == Some(own);
        name == own
            || companions.any(|companion| companion == name)
            || record()
            || in_folder().is_some()
    }

    /// Returns true if the file depends on a setting that begins with one of these words.
    pub(crate) fn depends_on(&self, words: &BTreeSet<String>) -> bool {
        let regardless = |word: &String| self.regardless_of.contains(&word.as_str());
        words.iter().any(|word| !regardless(word))
    }

    /// Returns the subfolder of the file; empty for a file without one.
    pub fn folder(&self) -> &'static str {
        self.name.rsplit_once('/').map_or("", |(folder, _)| folder)
    }

    /// Returns the name of the file without the subfolder.
    pub fn file_name(&self) -> &'static str {
        file_part(self.name)
    }

    /// Returns the name of the file without subfolder and ending.
    pub(crate) fn stem(&self) -> &'static str {
        let name = self.file_name();
        name.split('.').next().unwrap_or(name)
    }
}

/// Returns the part of a name after its folders.
pub(super) fn file_part(name: &str) -> &str {
    name.rsplit('/').next().unwrap_or(name)
}

/// Returns the row that a file of a run belongs to; `None` where there is none.
pub fn row_of(name: &str) -> Option<&'static OutputFile> {
    OUTPUT_FILES.iter().find(|row| row.owns(name))
}

/// Returns the row that a file of a version without subfolders belongs to; `None` where there is
/// none.
pub(crate) fn row_of_beside(name: &str) -> Option<&'static OutputFile> {
    OUTPUT_FILES.iter().find(|row| row.owned_beside(name))
}

/// All files of a run, in the order of writing.
pub const OUTPUT_FILES: [OutputFile; 49] = [
    OutputFile {
        regardless_of: NOT_OF_POINTS,
        brief: "first sonar return of every ping on both sides",
        described: described(
            "First return on both sides, position and recorded depth of every side-scan ping",
            "pings",
            "depth_m",
        ),
        ..row("points/first_returns.csv", When::Always, clouds::first_returns)
    },
    OutputFile {
        regardless_of: NOT_OF_CLOUD,
        brief: "all points with their classes",
        described: described(
            "All points with their classes; kept is 1 for those that count for the depth map",
            "points",
            "z_m",
        ),
        ..row("points/cloud.csv", When::Always, clouds::table)
    },
    cloud(
        "points/cloud.copc.laz",
        LAS_POINTS,
        "all points with their classes for GIS and point cloud programs (COPC, which is LAZ)",
        clouds::copc,
    ),
    OutputFile {
        needs: &[Need::PlainLas, Need::KeptPoints],
        ..cloud(
            "points/cloud.las",
            LAS_POINTS,
            "the same as plain LAS, where the settings ask for it",
            clouds::las,
        )
    },
    cloud(
        "points/cloud.ply",
        CLASSED_POINTS,
        "all points with their classes for 3D viewers",
        clouds::ply,
    ),
    cloud(
        "points/cloud.xyz",
        KEPT_POINTS,
        "the points that count for the depth map as plain text",
        clouds::xyz,
    ),
    track_file("track/track.gpx", "points", lines::track_gpx),
    track_file("track/track.geojson", "lines", lines::track_geojson),
    track_file("track/track.kmz", "lines", lines::track_kmz),
    OutputFile {
        companions: &["track/track.shx", "track/track.dbf", "track/track.prj", "track/track.cpg"],
        ..track_file("track/track.shp", "lines", lines::track_shapefile)
    },
    footprint("track/footprint.geojson", lines::footprint_geojson),
    footprint("track/footprint.kmz", lines::footprint_kmz),
    raster(
        "depth/depth.tif",
        &["depth/depth.qml"],
        rasters::DEPTH,
        "depth_m",
        "depth map, metres",
        rasters::depth,
    ),
    raster(
        "depth/uncertainty.tif",
        &["depth/uncertainty.qml"],
        rasters::SPREAD,
        "standard_deviation_m",
        "standard deviation of the depths in a cell, metres",
        rasters::uncertainty,
    ),
    raster(
        "depth/shoalest.tif",
        &["depth/shoalest.qml"],
        rasters::SHOALEST,
        "depth_m",
        "shoalest depth measured in each cell, metres",
        rasters::shoalest,
    ),
    raster(
        "depth/distance.tif",
        &["depth/distance.qml"],
        rasters::DISTANCE,
        "distance_m",
        "distance to the nearest depth, metres",
        rasters::distance,
    ),
    raster(
        "depth/source.tif",
        &["depth/source.qml"],
        "Source of the depth in each cell: 4 a sounding, 3 a first return, 2 echo levels, 1 interpolated",
        "class",
        "source of the depth in each cell",
        rasters::source,
    ),
    OutputFile {
        needs: &[Need::Surface, Need::Hardness],
        ..raster(
            "depth/hardness.tif",
            &["depth/hardness.qml"],
            "How much brighter the bed is than the median of the map, decibels of power, without slope, angle, range and gain",
            "hardness_db",
            "how hard the bed is, decibels (with surface.swath)",
            rasters::hardness,
        )
    },
    OutputFile {
        when: When::Chosen(Product::Xyz),
        ..raster(
            "depth/depth.xyz",
            &[],
            "East, north and depth in metres, positive down, of every cell of the depth map that has one",
            "depth_m",
            "cells of the depth map as plain text",
            rasters::xyz,
        )
    },
    OutputFile {
        when: When::Chosen(Product::Bottom),
        regardless_of: NOT_OF_BODY,
        ..raster(
            "depth/bottom.glb",
            &[],
            "The depth map as a mesh with its colours and the mosaic as pictures (glTF 2.0: y up, metres)",
            "depth_m",
            "the bottom for 3D programs",
            clouds::bottom_mesh,
        )
    },
    OutputFile {
        when: When::Chosen(Product::Bottom),
        ..raster(
            "depth/bottom.copc.laz",
            &[],
            "The cells of the depth map as points: z is minus the depth, source as in source.tif; what nothing measured is marked synthetic",
            "z_m",
            "cells of the depth map as points, with the source of each depth",
            clouds::bottom_points,
        )
    },
    isobaths("isobaths/isobaths.geojson", lines::isobaths_geojson),
    OutputFile {
        needs: &[Need::Surface, Need::Levels, Need::Isobaths],
        ..isobaths("isobaths/isobaths.kmz", lines::isobaths_kmz)
    },
    OutputFile {
        needs: &[Need::Surface, Need::Levels, Need::Isobaths],
        companions: &[
            "isobaths/isobaths.shx",
            "isobaths/isobaths.dbf",
            "isobaths/isobaths.prj",
            "isobaths/isobaths.cpg",
        ],
        ..isobaths("isobaths/isobaths.shp", lines::isobaths_shapefile)
    },
    contour_file(
        "isobaths/depth_areas.geojson",
        "Areas between depths",
        "areas",
        "areas between them",
        lines::depth_areas,
    ),
    OutputFile {
        needs: &[Need::Surface, Need::Area],
        ..contour_file(
            "isobaths/spot_soundings.geojson",
            "The shoalest depths of their surroundings",
            "points",
            "depths as a chart prints them, shoal first",
            lines::spot_soundings,
        )
    },
    contour_file(
        "isobaths/storage.csv",
        "Area and volume below each depth",
        "levels",
        "area and volume below each level",
        lines::storage,
    ),
    map_tiles(
        "map_tiles/depth.mbtiles",
        "Tiles of the depth map with isobaths in Web Mercator, PNG (MBTiles 1.3)",
        "depth map with isobaths for plotters and phones (OpenCPN, Locus)",
        tiles::chart,
    ),
    map_tiles(
        "map_tiles/depth.pmtiles",
        "Tiles of the depth map in Web Mercator, PNG (PMTiles 3)",
        "depth map for web maps",
        tiles::colours,
    ),
    map_tiles(
        "map_tiles/depth_values.pmtiles",
        "Elevations, minus the depths, in Web Mercator as colours of PNG (PMTiles 3): red * 256 + green + blue / 256 - 32768 metres (Terrarium)",
        "depths for web maps, as colours that stand for metres",
        tiles::values,
    ),
    OutputFile {
        described: None,
        ..map_tiles(
            "map_tiles/index.html",
            "",
            "the depth map as a page for browsers, to look at and to send",
            tiles::page,
        )
    },
    OutputFile {
        needs: &[Need::Agreement],
        regardless_of: NOT_OF_DEPTHS,
        brief: "agreement of depths, all statistics",
        described: described(
            "Side-scan points against the soundings of the survey, and crossing tracks",
            "comparisons",
            "",
        ),
        ..row("quality/residuals.json", When::Chosen(Product::Residuals), comparison::residuals)
    },
    OutputFile {
        needs: &[Need::SideScan, Need::Mosaic],
        regardless_of: NOT_OF_MOSAIC,
        brief: "side-scan mosaic",
        described: described(
            "Side-scan mosaic: echoes at their place on the ground, transparent where nothing was insonified",
            "cells",
            "",
        ),
        ..row("mosaic/mosaic.tif", When::Chosen(Product::Mosaic), rasters::mosaic)
    },
    compared("quality/comparison.json", "The survey against a reference", "", comparison::json),
    compared(
        "quality/comparison.csv",
        "Points of the survey with the elevation of the reference there; measured minus reference, positive is shallower",
        "difference_m",
        comparison::csv,
    ),
    target_file("objects/targets.csv", "boxes", object_files::targets_csv),
    target_file("objects/targets.geojson", "objects", object_files::targets_geojson),
    target_file("objects/targets.gpx", "objects", object_files::targets_gpx),
    target_file("objects/targets.kml", "objects", object_files::targets_kml),
    OutputFile {
        when: When::Listed,
        described: described(
            "Objects of the review, or of the detector where there is no review, with all that is known of each",
            "objects",
            "",
        ),
        ..boxes(
            "objects/objects.csv",
            "objects, a row each: place, size, height and its source",
            object_files::all_objects,
        )
    },
    boxes(
        "objects/detections.csv",
        "boxes of the detector with place and size",
        object_files::detections_csv,
    ),
    OutputFile {
        described: described("Objects that the detector proposes, not reviewed", "objects", ""),
        ..boxes("objects/detections.geojson", "objects for maps", object_files::detections_geojson)
    },
    OutputFile {
        described: described("Objects that the detector proposes, not reviewed", "objects", ""),
        ..boxes(
            "objects/detections.gpx",
            "objects for maps and plotters",
            object_files::detections_gpx,
        )
    },
    OutputFile {
        described: described(
            "Solids that the detector's objects are like, fitted to echo and shadow: inferred, not measured",
            "objects",
            "z_m",
        ),
        ..boxes("objects/shapes.ply", "shapes of objects for 3D programs", object_files::shapes)
    },
    OutputFile {
        described: None,
        ..boxes("objects/chips", "folder: a picture of each object", object_files::chips)
    },
    OutputFile {
        needs: &[Need::Track],
        brief: "all lines, areas and objects in one file, with styles for QGIS",
        described: described(
            "Track, footprint, isobaths, depth areas and objects, a layer each, with styles for QGIS",
            "features",
            "",
        ),
        ..row("survey.gpkg", When::Chosen(Product::Geopackage), lines::geopackage)
    },
    run_file(
        "report.html",
        When::Chosen(Product::Report),
        "the report to read and to print",
        FileWriter::Page,
    ),
    run_file(
        "report.json",
        When::Always,
        "the report for programs: inputs, settings, counts, statistics",
        FileWriter::Record,
    ),
    run_file(
        super::MANIFEST,
        When::Always,
        "list of all files: what each is, coordinate system, extent, count, SHA-256",
        FileWriter::Manifest,
    ),
];
