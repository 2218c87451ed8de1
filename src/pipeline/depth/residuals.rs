//! `residuals.json`: side-scan points against the soundings of the same log.

use super::DepthWritten;
use super::plane::Plane;
use crate::bathymetry::compare::{Comparison, Matching, match_points};
use crate::cloud::PointSource;
use crate::export::{self, Summary};
use crate::pipeline::record::{Coordinates, Made};
use crate::pipeline::{Products, Settings};
use crate::progress::{Cancelled, Progress};
use serde::Serialize;
use std::io::Write as _;
use std::path::Path;

/// Farthest sounding that a side-scan point is held against by place, metres.
const RADIUS_M: f64 = 1.0;

#[derive(Serialize)]
struct Record<'a> {
    program: String,
    sign: &'static str,
    statement: String,
    comparisons: &'a [NamedComparison],
    settings: &'a Settings,
}

/// How the depths of one source agree with those of another.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NamedComparison {
    /// What was measured.
    pub source: &'static str,
    /// What it is held against.
    pub reference: &'static str,
    /// How a point finds its reference, in words.
    pub matching: String,
    /// The statistics.
    #[serde(flatten)]
    pub comparison: Comparison,
}

const SIGN: &str = "measured minus reference elevation, metres; positive is shallower";
const STATEMENT: &str = "Soundings and first returns of one log share transducer, position and sound speed: this is agreement \
     within one instrument, not accuracy against a reference.";

/// Writes the record of some comparisons; nothing without any.
pub(super) fn write(
    products: &Products,
    comparisons: &[NamedComparison],
    folder: &Path,
    written: &mut DepthWritten,
) -> Result<(), String> {
    if comparisons.is_empty() {
        let why = "no residuals: the log has no side-scan points, or none near a sounding";
        written.warnings.push(why.to_owned());
        return Ok(());
    }
    let record = Record {
        program: format!("bathyscope {}", env!("CARGO_PKG_VERSION")),
        sign: SIGN,
        statement: format!("{} {STATEMENT}", products.correction.statement()),
        comparisons,
        settings: &products.settings,
    };
    let name = "residuals.json";
    export::write_aside(&folder.join(name), |mut file| {
        let text = serde_json::to_vec_pretty(&record)?;
        file.write_all(&text)?;
        file.write_all(b"\n")
    })
    .map_err(|error| error.to_string())?;
    written.made.push(Made {
        name,
        what: "Side-scan points against the soundings of the same log",
        coordinates: Coordinates::None,
        counted: "comparisons",
        measured: "",
        summary: Summary {
            count: record.comparisons.len(),
            ..Summary::default()
        },
        regardless_of: &["detector", "isobaths", "mosaic"],
    });
    Ok(())
}

/// Port, starboard and both against the surface of the soundings at their place, and against the nearest sounding; empty
/// where there is no side-scan point or no sounding.
pub(super) fn comparisons(
    products: &Products,
    plane: &Plane<'_>,
    progress: &Progress,
) -> Result<Vec<NamedComparison>, Cancelled> {
    use PointSource::{DownScan, Port, Starboard};
    let reference = plane.points(products, &[DownScan]);
    let max_gap_m = products.settings.surface.max_gap_m;
    let ways = [
        (
            Matching::Surface { max_gap_m },
            format!("triangulated surface, gap {max_gap_m} m"),
        ),
        (
            Matching::Nearest { radius_m: RADIUS_M },
            format!("nearest point within {RADIUS_M} m"),
        ),
    ];
    let sides: [(&'static str, &[PointSource]); 3] = [
        ("side-scan", &[Port, Starboard]),
        ("port", &[Port]),
        ("starboard", &[Starboard]),
    ];
    let mut found = Vec::new();
    for (matching, how) in ways {
        for (source, sources) in sides {
            let points = plane.points(products, sources);
            let matches = match_points(&points, &reference, matching, progress)?;
            if !matches.is_empty() {
                found.push(NamedComparison {
                    source,
                    reference: "down-scan",
                    matching: how.clone(),
                    comparison: Comparison::new(
                        points.len(),
                        &matches,
                        products.correction.middle_level_m(),
                    ),
                });
            }
        }
    }
    Ok(found)
}
