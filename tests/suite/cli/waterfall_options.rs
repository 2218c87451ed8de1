//! Pages and films of the side-scan.

use super::{refusal, run, simulated};
use std::fs;

#[test]
fn a_sonogram_has_every_ping_on_one_page() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulated(folder);
    run(
        folder,
        &[
            "sonogram",
            "pond.sl2",
            "-o",
            "pages",
            "--size",
            "320x200",
            "--page-pings",
            "120",
            "--ground",
        ],
    );
    let mut pages: Vec<_> = fs::read_dir(folder.join("pages"))
        .expect("a folder")
        .map(|entry| entry.expect("an entry").path())
        .collect();
    pages.sort();
    let info = run(folder, &["info", "pond.sl2", "--json"]);
    let info: serde_json::Value = serde_json::from_str(&info).expect("JSON");
    let pings = info["side_scan"]["pings"].as_u64().expect("a count") as usize;
    assert_eq!(pages.len(), pings.div_ceil(120), "{pings} pings");
    let sizes: Vec<_> =
        pages.iter().map(|page| image::image_dimensions(page).expect("a picture")).collect();
    assert_eq!(sizes[0], (320, 200));
    assert!(sizes.iter().all(|size| size.1 == 200 && size.0 <= 320));
    let first = image::open(&pages[0]).expect("a picture").to_luma8();
    let mean = first.pixels().map(|pixel| u64::from(pixel.0[0])).sum::<u64>() / (320 * 200);
    assert!(mean > 20, "a page is no black page: {mean}");
}

#[test]
fn a_film_has_frames_that_move() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulated(folder);
    run(
        folder,
        &["film", "pond.sl2", "-o", "pond.avi", "--size", "160x64", "--speed", "60", "--fps", "10"],
    );
    let film = fs::read(folder.join("pond.avi")).expect("a film");
    let word = |at: usize| u32::from_le_bytes(film[at..at + 4].try_into().expect("four bytes"));
    assert_eq!(&film[8..12], b"AVI ");
    let count = word(48) as usize;
    assert!(count >= 2, "{count} frames");
    let frame = |at: usize| {
        let length = word(at + 4) as usize;
        let picture = image::load_from_memory(&film[at + 8..at + 8 + length]);
        (picture.expect("a JPEG").to_luma8(), at + 8 + length + length % 2)
    };
    let (first, next) = frame(224);
    let (second, _) = frame(next);
    assert_eq!(first.dimensions(), (160, 64));
    assert_ne!(first, second);
    let refused = refusal(folder, &["film", "pond.sl2", "-o", "pond.sl2"], 1);
    assert!(refused.contains(".avi"), "{refused}");
}
