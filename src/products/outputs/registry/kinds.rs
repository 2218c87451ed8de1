//! Defines the columns that rows of the same kind of file share.

use super::{Described, FileWriter, OutputFile, WriteFile};
use crate::outputs::content::Need;
use crate::outputs::order::{Product, When};

type Text = &'static str;

/// Groups of settings that no table of pings depends on.
pub(super) const NOT_OF_POINTS: &[&str] = &["detector", "isobaths", "mosaic", "review", "surface"];
/// Groups of settings that no cloud depends on. Those of the surface are not among them, because
/// points above the bottom are classified by the surface.
pub(super) const NOT_OF_CLOUD: &[&str] = NOT_OF_DEPTHS;
const NOT_OF_TRACK: &[&str] = &[
    "calibration",
    "cloud",
    "detector",
    "draft_m",
    "height_offset_m",
    "first_return",
    "image",
    "isobaths",
    "mosaic",
    "outliers",
    "review",
    "sound_speed",
    "surface",
    "water_level",
];
const NOT_OF_FOOTPRINT: &[&str] = &["detector", "isobaths", "review"];
pub(super) const NOT_OF_DEPTHS: &[&str] = &["detector", "isobaths", "mosaic", "review"];
pub(super) const NOT_OF_BODY: &[&str] = &["detector", "isobaths", "review"];
const NOT_OF_ISOBATHS: &[&str] = &["detector", "mosaic", "review"];
// Echoes and boxes are placed on the bottom that the points define.
pub(super) const NOT_OF_MOSAIC: &[&str] = &["detector", "isobaths", "review"];
const NOT_OF_BOXES: &[&str] = &["crs", "isobaths", "mosaic", "review"];

const TRACK: &str = "The boat's track, thinned to half a metre, broken where the log paused";
const FOOTPRINT: &str = "The ground that the side-scan insonified, without turns";
pub(super) const KEPT_POINTS: &str =
    "The points that count for the depth map; z is elevation above the transducer";
pub(super) const CLASSED_POINTS: &str =
    "All points with their classes; z is elevation above the transducer";
pub(super) const LAS_POINTS: &str = "All points with their classes; z is elevation above the transducer, intensity the echo level of the first return times 257";
const TARGETS: &str = "Targets that an analyst accepted, drew or marked";
const BOXES: &str = "Boxes that the detector proposes, not reviewed";

/// Creates a row with the values that most rows share.
pub(super) const fn row(name: Text, when: When, write: WriteFile) -> OutputFile {
    run_file(name, when, "", FileWriter::Results(write))
}

/// Creates the row of a file, as of those that describe all others.
pub(super) const fn run_file(
    name: Text,
    when: When,
    brief: Text,
    writer: FileWriter,
) -> OutputFile {
    OutputFile {
        name,
        companions: &[],
        when,
        needs: &[],
        regardless_of: &[],
        brief,
        described: None,
        writer,
    }
}

pub(super) const fn described(what: Text, counted: Text, measured: Text) -> Option<Described> {
    Some(Described { what, counted, measured })
}

pub(super) const fn cloud(name: Text, what: Text, brief: Text, write: WriteFile) -> OutputFile {
    OutputFile {
        needs: &[Need::KeptPoints],
        regardless_of: NOT_OF_CLOUD,
        brief,
        described: described(what, "points", "z_m"),
        ..row(name, When::Chosen(Product::Cloud), write)
    }
}

pub(super) const fn track_file(name: Text, counted: Text, write: WriteFile) -> OutputFile {
    OutputFile {
        needs: &[Need::Track],
        regardless_of: NOT_OF_TRACK,
        brief: "way of the boat",
        described: described(TRACK, counted, ""),
        ..row(name, When::Chosen(Product::Track), write)
    }
}

pub(super) const fn footprint(name: Text, write: WriteFile) -> OutputFile {
    OutputFile {
        needs: &[Need::Track, Need::Footprint],
        regardless_of: NOT_OF_FOOTPRINT,
        brief: "ground that the side-scan covers",
        described: described(FOOTPRINT, "areas", "area_m2"),
        ..row(name, When::Chosen(Product::Track), write)
    }
}

pub(super) const fn raster(
    name: Text,
    companions: &'static [Text],
    what: Text,
    measured: Text,
    brief: Text,
    write: WriteFile,
) -> OutputFile {
    OutputFile {
        companions,
        needs: &[Need::Surface],
        regardless_of: NOT_OF_DEPTHS,
        brief,
        described: described(what, "cells", measured),
        ..row(name, When::Chosen(Product::Depth), write)
    }
}

pub(super) const fn contour_file(
    name: Text,
    what: Text,
    counted: Text,
    brief: Text,
    write: WriteFile,
) -> OutputFile {
    OutputFile {
        needs: &[Need::Surface, Need::Levels],
        regardless_of: NOT_OF_ISOBATHS,
        brief,
        described: described(what, counted, "depth_m"),
        ..row(name, When::Chosen(Product::Isobaths), write)
    }
}

pub(super) const fn isobaths(name: Text, write: WriteFile) -> OutputFile {
    contour_file(name, "Lines of equal depth", "lines", "lines of equal depth", write)
}

pub(super) const fn map_tiles(name: Text, what: Text, brief: Text, write: WriteFile) -> OutputFile {
    OutputFile {
        needs: &[Need::Surface],
        regardless_of: NOT_OF_ISOBATHS,
        brief,
        described: described(what, "tiles", "depth_m"),
        ..row(name, When::Chosen(Product::MapTiles), write)
    }
}

pub(super) const fn compared(
    name: Text,
    what: Text,
    measured: Text,
    write: WriteFile,
) -> OutputFile {
    OutputFile {
        needs: &[Need::Reference],
        regardless_of: NOT_OF_DEPTHS,
        brief: "agreement of depths with the reference",
        described: described(what, "points", measured),
        ..row(name, When::Compared, write)
    }
}

pub(super) const fn target_file(name: Text, counted: Text, write: WriteFile) -> OutputFile {
    OutputFile {
        needs: &[Need::Targets],
        regardless_of: NOT_OF_BOXES,
        brief: "reviewed targets for maps and plotters",
        described: described(TARGETS, counted, ""),
        ..row(name, When::Chosen(Product::Targets), write)
    }
}

pub(super) const fn boxes(name: Text, brief: Text, write: WriteFile) -> OutputFile {
    OutputFile {
        regardless_of: NOT_OF_BOXES,
        brief,
        described: described(BOXES, "boxes", ""),
        ..row(name, When::Searched, write)
    }
}
