//! The maps of an archive joined to one map of the web.

use super::{add, files, sail, scene};
use crate::cli::run;
use std::fs;

const FILES: [&str; 5] =
    ["depth.mbtiles", "depth.pmtiles", "depth_values.pmtiles", "index.html", "map_tiles.json"];

#[test]
fn they_are_made_of_all_tiles_whatever_the_order_of_the_logs_and_only_when_one_changed() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let [one, other] = ["one", "other"].map(|name| temporary.path().join(name));
    for (folder, order) in [(&one, [0, 1]), (&other, [1, 0])] {
        fs::create_dir(folder).expect("a folder");
        for log in order {
            sail(folder, log, &scene(log, [3.0, -4.0], 0.0));
            add(folder, &[&format!("log-{log}.sl2")]);
        }
    }
    assert!(run(&one, &["archive", "archive"]).contains("map_tiles/index.html"));
    run(&other, &["archive", "archive"]);
    let made = files(&one.join("archive/map_tiles"));
    assert!(made.keys().map(String::as_str).eq(FILES), "{:?}", made.keys());
    assert!(made == files(&other.join("archive/map_tiles")), "other bytes");

    assert!(!run(&one, &["archive", "archive"]).contains("map_tiles"), "nothing had changed");
    fs::remove_file(one.join("archive/map_tiles/depth.pmtiles")).expect("a file");
    assert!(run(&one, &["archive", "archive"]).contains("map_tiles/index.html"));
    assert!(made == files(&one.join("archive/map_tiles")), "other bytes");

    sail(&one, 2, &scene(2, [9.0, -4.0], 0.0));
    add(&one, &["log-2.sl2"]);
    assert!(run(&one, &["archive", "archive"]).contains("map_tiles/index.html"));
    let grown = files(&one.join("archive/map_tiles"));
    assert!(FILES.iter().all(|name| grown[*name] != made[*name]));

    // Without a log no tile has a map.
    for name in files(&one.join("archive/logs")).keys() {
        fs::remove_file(one.join("archive/logs").join(name)).expect("a file");
    }
    run(&one, &["archive", "archive"]);
    assert!(files(&one.join("archive/map_tiles")).is_empty());
    assert!(files(&one.join("archive/map_parts")).is_empty());
}

#[test]
fn a_log_elsewhere_leaves_the_parts_of_the_map_that_it_does_not_reach() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    let archive = folder.join("archive");
    let build = || {
        run(folder, &["archive", "archive"]);
        ["map_tiles", "map_parts"].map(|name| files(&archive.join(name)))
    };
    sail(folder, 0, &scene(0, [3.0, -4.0], 0.0));
    add(folder, &["log-0.sl2"]);
    let [_, parts] = build();
    sail(folder, 1, &scene(1, [1500.0, -4.0], 0.0));
    add(folder, &["log-1.sl2"]);
    let [grown, more] = build();
    assert!(!parts.is_empty() && parts.keys().all(|name| more.contains_key(name)));
    assert!(parts.len() < more.len());

    // What was kept and what is drawn anew, for want of a part or because it is damaged, are the
    // same map.
    let (name, bytes) = more.first_key_value().expect("a part");
    fs::write(archive.join("map_parts").join(name), &bytes[..bytes.len() / 2]).expect("a file");
    fs::remove_dir_all(archive.join("map_tiles")).expect("a folder");
    assert!(build() == [grown.clone(), more.clone()]);
    fs::remove_dir_all(archive.join("map_tiles")).expect("a folder");
    fs::remove_dir_all(archive.join("map_parts")).expect("a folder");
    assert!(build() == [grown, more]);
}
