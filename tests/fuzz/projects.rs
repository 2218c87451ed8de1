//! Reads the files that Bathyscope itself writes: settings, projects with their journals, the files
//! that earlier versions kept beside a log, scenes.

use super::logs::sl2_seeds;
use super::say;
use super::scratch;
use bathyscope_log::formats::open_bytes;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::support::regular_file::held;
use bathyscope_log::survey::{Identity, Survey};
use bathyscope_objects::objects::SurveyReview;
use bathyscope_objects::review::Review;
use bathyscope_objects::truth::SurveyTruth;
use bathyscope_products::pipeline::{Settings, in_hexadecimal};
use bathyscope_products::project::{self, LogFile, Project, ProjectLog};
use bathyscope_simulation::Scene;
use sha2::{Digest as _, Sha256};
use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock};

/// The folder that projects are read for; nothing lies there.
const FOLDER: &str = "/survey";

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

pub(super) fn settings(bytes: &[u8]) {
    let text = text(bytes);
    let read = Settings::default().with_toml(&text);
    match read.and_then(|settings| settings.check().map(|()| settings)) {
        Ok(settings) => {
            // What was read can be written and read again.
            let written = toml::to_string(&settings).expect("settings are TOML");
            let again = Settings::default().with_toml(&written);
            assert!(again.expect("its own TOML") == settings);
        }
        Err(error) => say(&error),
    }
    if let Err(error) = Settings::default().with_assignment(text.trim()) {
        say(&error);
    }
}

pub(super) fn settings_seeds() -> Vec<Vec<u8>> {
    let some = [
        "draft_m = 0.3\n[first_return]\nmethod = \"threshold\"\nthreshold = 0.41\n[calibration]\nmode = \"flat_spot\"\npings = \"100..200\"\n",
        "[source]\ncrs = \"EPSG:32612\"\n[isobaths]\ninterval_m = 0.5\n[outliers]\nradius_m = 3.011\nmin_neighbors = 10\n",
        "[excluded]\nstretches = [{ pings = [30, 40], reason = \"turn\" }, { reason = \"bad\", time_s = [1.5, 2.0] }]\n",
        "first_return.threshold=0.35",
    ];
    some.iter().map(|text| text.as_bytes().to_vec()).collect()
}

pub(super) fn project(bytes: &[u8]) {
    let folder = Path::new(FOLDER);
    match Project::from_text(&text(bytes), folder) {
        Ok(project) => {
            // What was read can be written, and is the same text when it is read again.
            let written = project.to_text(folder);
            let again = Project::from_text(&written, folder).expect("its own text");
            assert_eq!(again.to_text(folder), written);
            for log in project.logs() {
                if let Err(error) = project.settings_of(log) {
                    say(&error);
                }
            }
        }
        Err(error) => say(&error),
    }
}

pub(super) fn project_seeds() -> Vec<Vec<u8>> {
    let log = |name: &str| {
        ProjectLog::new(LogFile {
            path: PathBuf::from(format!("{FOLDER}/{name}.sl2")),
            sha256: in_hexadecimal(&Sha256::digest(name)),
            byte_count: 1000,
            pings: 500,
        })
    };
    let mut first = log("Chart 1");
    first.review = Arc::new(a_review(&first.file.identity()));
    first.settings.set("draft_m", toml::Value::Float(0.3));
    let project = Project::default();
    let project = project.with_log(first).and_then(|all| all.with_log(log("pond")));
    let mut project = project.expect("two logs");
    project.settings.first_return.threshold = 0.41;
    project.set_view("map", &["depth", "track"]);
    let mut lines = project.to_text(Path::new(FOLDER));
    lines +=
        "\n[measure]\n\n1 = { corners = [[-111.5, 36.8], [-111.4, 36.9]], kind = \"distance\" }\n";
    vec![lines.into_bytes(), b"bathyscope = 1\n".to_vec()]
}

/// A project, a line of two dashes, and the lines of its journal without their sums, which nobody
/// finds by trying.
pub(super) fn journal(bytes: &[u8]) {
    let all = text(bytes);
    let (project, entries) = all.split_once("\n--\n").unwrap_or((&all, ""));
    let line = |json: &str| format!("{} {json}\n", in_hexadecimal(&Sha256::digest(json)[..4]));
    let sha256 = in_hexadecimal(&Sha256::digest(project));
    let saved = format!(r#"{{"saved":{{"sha256":"{sha256}","version":1}}}}"#);
    let journal: String = [saved.as_str()].into_iter().chain(entries.lines()).map(line).collect();
    let folder = Path::new(FOLDER);
    match project::with_journal(project, &sha256, journal.as_bytes(), folder) {
        Ok(project) => drop(project.to_text(folder)),
        Err(error) => say(&error),
    }
}

pub(super) fn journal_seeds() -> Vec<Vec<u8>> {
    let entries = "\n--\n{\"opened\":{\"pid\":7,\"host\":\"ship\",\"since_unix_s\":1700000000}}\n\
        {\"done\":{\"label\":\"Draft\",\"set\":[\"settings.draft_m = 0.4\"]}}\n\
        {\"done\":{\"label\":\"Undo\",\"gone\":[\"settings.draft_m\"]}}\n";
    let projects = project_seeds().into_iter();
    projects.map(|project| [project, entries.as_bytes().to_vec()].concat()).collect()
}

/// A log that sidecars are read for.
fn pond() -> &'static Survey {
    static POND: LazyLock<Survey> = LazyLock::new(|| {
        let log = sl2_seeds().swap_remove(0);
        open_bytes("pond.sl2", log, &Progress::new()).expect("a log")
    });
    &POND
}

pub(super) fn bottom_sidecar(bytes: &[u8]) {
    let read = scratch::with_file("pond.bottom.toml", bytes, |path| {
        project::read_bottom(&path.with_file_name("pond.sl2"), pond())
    });
    match read {
        Some(Ok(bottom)) => assert!(bottom.check().is_ok()),
        Some(Err(error)) => say(&error),
        None => {}
    }
}

pub(super) fn bottom_seeds() -> Vec<Vec<u8>> {
    let Identity { byte_count, pings, .. } = Identity::of(pond());
    let text = format!(
        "[bottom]\nlog_bytes = {byte_count}\npings = {pings}\n\n[[bottom.lines]]\nside = \"port\"\npings = [0, 1]\ncorners = [[0.0, 2.5], [1.0, 2.75]]\n\n\
        [[bottom.lines]]\nside = \"starboard\"\npings = [1, 2]\n"
    );
    vec![text.into_bytes()]
}

fn a_review(of: &Identity) -> Review {
    let Identity { file, byte_count, pings, .. } = of;
    let text = format!(
        r#"{{"version":1,"survey":{{"file":"{file}","byte_count":{byte_count},"pings":{pings}}},"classes":["rock","tyre"],
        "searched":[{{"model":"demo","pings":[0,2]}}],"boxes":[
        {{"id":1,"side":"port","pings":[0,2],"near_m":4.5,"far_m":6.25,"class":"rock","score":0.91,"state":"proposed","model":"demo"}},
        {{"id":4,"side":"starboard","pings":[1,2],"near_m":3.5,"far_m":5.25,"class":"tyre","state":"added"}}]}}"#
    );
    Review::from_json(&text, of).expect("a review")
}

pub(super) fn review(bytes: &[u8]) {
    let of = Identity::of(pond());
    match Review::from_json(&text(bytes), &of) {
        Ok(review) => {
            let written = review.to_json();
            let again = Review::from_json(&written, &of).expect("its own text");
            assert_eq!(again.to_json(), written);
            drop(SurveyReview::default());
        }
        Err(error) => say(&error),
    }
}

pub(super) fn review_seeds() -> Vec<Vec<u8>> {
    vec![a_review(&Identity::of(pond())).to_json().into_bytes()]
}

pub(super) fn truth(bytes: &[u8]) {
    if let Err(error) = SurveyTruth::parse(&text(bytes), &Identity::of(pond())) {
        say(&error);
    }
}

pub(super) fn truth_seeds() -> Vec<Vec<u8>> {
    let table = "object,kind,lon,lat,east_m,north_m,length_m,width_m,height_m,heading_deg,side,first_ping,last_ping,near_m,far_m,shadow_start_m,shadow_end_m,box_first_ping,box_last_ping,box_near_m,box_far_m,shown\n\
        0,block,-82.1,29.4,14.3,12.7,1.0,0.7,0.5,20.0,starboard,0,1,4.09,5.12,4.95,6.41,0,1,4.13,6.44,1\n\
        1,tyre,-82.1,29.4,14.3,12.7,1.0,0.7,0.5,20.0,port,1,2,4.67,5.68,5.68,,1,2,4.68,6.98,0\n";
    let mut seeds = review_seeds();
    seeds.push(table.as_bytes().to_vec());
    seeds
}

pub(super) fn scene(bytes: &[u8]) {
    if let Err(error) = Scene::from_toml(&text(bytes)) {
        say(&error);
    }
}

pub(super) fn scene_seeds() -> Vec<Vec<u8>> {
    vec![include_bytes!("../../assets/demo.toml").to_vec(), b"duration_s = 10.0\n".to_vec()]
}

/// Reads text files without touching the disk.
pub(super) fn held_as<T>(name: &str, bytes: &[u8], read: impl FnOnce(&Path) -> T) -> T {
    let path = PathBuf::from(name);
    held::with(&path, bytes, || read(&path))
}
