//! Every reader as a function of bytes, for the fuzzer and for the tests, which replay its seeds
//! and what it once found.
//!
//! A target reads bytes that may be anything and walks over all that was read. It may refuse them
//! in a sentence; it must not panic, hang, or take more memory than four times the bytes and 64
//! MiB. [`sweep`] harms whole recordings instead, and asks what was lost. `run` in this folder
//! builds and starts both.

mod archives;
mod harm;
mod labels;
mod logs;
mod models;
mod points;
mod projects;
mod rasters;
mod scratch;
pub mod sweep;
mod tables;
#[cfg(test)]
mod tests;

/// A reader to feed.
pub struct Target {
    /// Its name on the command line, and of its folder of inputs.
    pub name: &'static str,
    /// Reads bytes and walks over all that was read.
    pub run: fn(&[u8]),
    /// Small files of its format to begin with.
    pub seeds: fn() -> Vec<Vec<u8>>,
    /// Bytes of the longest input that is worth trying.
    pub longest: usize,
    /// Its part of the time of a run.
    pub share: u32,
    /// Puts right what a reader checks and chance does not hit: sums, and places that records state
    /// of themselves.
    pub repair: fn(&mut [u8]),
}

/// All of them.
pub const TARGETS: &[Target] = &[
    target("sl2", logs::sl2, logs::sl2_seeds, 8192, 12).with_repair(logs::repair_sl2),
    target("sl3", logs::sl3, logs::sl3_seeds, 8192, 12).with_repair(logs::repair_sl3),
    target("rsd", logs::rsd, logs::rsd_seeds, 8192, 12),
    target("xtf", logs::xtf, logs::xtf_seeds, 8192, 12),
    target("jsf", logs::jsf, logs::jsf_seeds, 8192, 12),
    target("svlog", logs::svlog, logs::svlog_seeds, 8192, 12).with_repair(logs::repair_svlog),
    target("humminbird", logs::humminbird, logs::humminbird_seeds, 8192, 12),
    target("slg", logs::slg, logs::slg_seeds, 4096, 6),
    target("sdf", logs::sdf, logs::sdf_seeds, 8192, 8),
    target("nmea", logs::nmea, logs::nmea_seeds, 4096, 8),
    target("soundings", logs::soundings, logs::soundings_seeds, 2048, 6),
    target("picture", logs::picture, logs::picture_seeds, 1024, 4),
    target("growing", logs::growing, logs::growing_seeds, 16_384, 12),
    target("settings", projects::settings, projects::settings_seeds, 2048, 3),
    target("project", projects::project, projects::project_seeds, 4096, 4),
    target("journal", projects::journal, projects::journal_seeds, 4096, 2),
    target("bottom_sidecar", projects::bottom_sidecar, projects::bottom_seeds, 2048, 3),
    target("review", projects::review, projects::review_seeds, 4096, 4),
    target("truth", projects::truth, projects::truth_seeds, 4096, 3),
    target("scene", projects::scene, projects::scene_seeds, 4096, 2),
    target("labels_coco", labels::coco, labels::coco_seeds, 4096, 3),
    target("labels_yolo", labels::yolo, labels::yolo_seeds, 1024, 2),
    target("points_text", points::text, points::text_seeds, 2048, 6),
    target("points_ply", points::ply, points::ply_seeds, 2048, 6),
    target("points_las", points::las, points::las_seeds, 4096, 3),
    target("points_laz", points::laz, points::laz_seeds, 4096, 3),
    target("points_geojson", points::geojson, points::geojson_seeds, 2048, 4),
    target("reference", points::reference, points::reference_seeds, 4096, 2),
    target("raster_cells", rasters::cells, rasters::cells_seeds, 8192, 4),
    target("raster_tiles", rasters::tiles, rasters::cells_seeds, 8192, 3),
    target("base_map", rasters::base_map, rasters::base_map_seeds, 16_384, 4),
    target("track", tables::track, tables::track_seeds, 2048, 6),
    target("gauge", tables::gauge, tables::gauge_seeds, 1024, 4),
    target("area", tables::area, tables::area_seeds, 2048, 6),
    target("model", models::model, models::model_seeds, 2048, 6),
    target("model_sidecar", models::sidecar, models::sidecar_seeds, 2048, 3),
    target("archive_rows", archives::rows, archives::row_seeds, 8192, 3),
    target("archive_records", archives::records, archives::record_seeds, 4096, 3),
];

const fn target(
    name: &'static str,
    run: fn(&[u8]),
    seeds: fn() -> Vec<Vec<u8>>,
    longest: usize,
    share: u32,
) -> Target {
    Target { name, run, seeds, longest, share, repair: |_| () }
}

impl Target {
    const fn with_repair(self, repair: fn(&mut [u8])) -> Self {
        Self { repair, ..self }
    }
}

/// Returns true if a panic is a fault: not where other people's code panicked on damaged bytes and
/// was expected to.
pub fn is_fault(panic: &std::panic::PanicHookInfo<'_>) -> bool {
    let place = panic.location().map_or("", |at| at.file());
    let is_ours = !place.contains("/registry/") && !place.starts_with("/rustc/");
    is_ours || bathyscope_log::support::catch_panic::is_to_be_printed(panic)
}

/// Fails where a value that was read is no number.
fn check_finite(values: impl IntoIterator<Item = f64>) {
    let all_finite = values.into_iter().all(f64::is_finite);
    assert!(all_finite, "a value that was read is no number");
}

/// Writes a refusal out, as users see it.
fn say(refusal: &impl std::fmt::Display) {
    let sentence = refusal.to_string();
    assert!(!sentence.is_empty(), "a refusal says nothing");
}
