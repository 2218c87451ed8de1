//! A project whose log is another file than the one that it was made of.

use crate::cli::stderr_of;
use crate::support::demo_log;
use bathyscope_log::formats;
use bathyscope_log::support::geo::LonLat;
use bathyscope_log::support::progress::Progress;
use bathyscope_products::project::{LogFile, Project, ProjectLog, Store};
use std::fs;

#[test]
fn a_log_with_other_bytes_in_a_plane_of_other_waters_is_processed_with_a_warning() {
    let temporary = tempfile::tempdir().expect("a folder");
    let folder = temporary.path();
    let log = folder.join("pond.sl2");
    fs::copy(demo_log(), &log).expect("a log");
    let survey = formats::open(&log, &Progress::new()).expect("a log");
    let file = LogFile::of(&survey, &Progress::new()).expect("a log");
    let project = Project::default().with_log(ProjectLog::new(file));
    let mut project = project.expect("a project of one log");
    // A quarter of the Earth away all places of the log would lie on one line.
    project.origin = Some(LonLat { lon_deg: 7.9, lat_deg: 0.0 });
    drop(Store::create(&folder.join("far.bathyscope"), &project, Vec::new()).expect("a project"));
    let mut bytes = fs::read(&log).expect("a log");
    *bytes.last_mut().expect("a byte") ^= 1;
    fs::write(&log, bytes).expect("a log");
    let args = ["process", "far.bathyscope", "--no-objects", "-o", "out"];
    let said = stderr_of(folder, &args);
    assert!(said.contains("pond is not the file that the project was made of"), "{said}");
    assert!(folder.join("out/depth/depth.tif").is_file(), "{said}");
}
