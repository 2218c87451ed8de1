//! `report.html`: whole in itself, and true to the files beside it.

use super::{run, simulated};
use std::fs;
use std::path::Path;

fn page(folder: &Path) -> String {
    fs::read_to_string(folder.join("report.html")).expect("a page")
}

/// Returns the texts between two marks, at every occurrence.
fn between<'a>(text: &'a str, from: &str, to: &str) -> Vec<&'a str> {
    let parts = text.split(from).skip(1);
    parts.filter_map(|part| part.split(to).next()).collect()
}

#[test]
fn the_page_asks_for_nothing_and_agrees_with_the_files() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulated(folder);
    run(folder, &["process", "pond.sl2", "-o", "out"]);
    let out = folder.join("out");
    let page = page(&out);

    // Nothing is fetched: every picture is in the page, and can be read by another decoder.
    let pictures: Vec<&str> =
        [between(&page, "href=\"", "\""), between(&page, "src=\"", "\"")].concat();
    assert!(pictures.len() >= 3, "{} pictures", pictures.len());
    for picture in pictures {
        let (kind, text) = picture.split_once(";base64,").expect("a picture in the page");
        assert!(["data:image/png", "data:image/jpeg"].contains(&kind), "{kind}");
        assert!(text.len() > 100, "{kind} of {} letters", text.len());
    }
    assert!(!page.contains("<script") && !page.contains("url(http"));

    // Its table of storage is that of `storage.csv`.
    let section = between(&page, "Area and volume below each level</h2>", "</table>")[0];
    let row = between(section, "<tr><td>", "</td></tr>")[0];
    let shown: Vec<f64> = row
        .split("</td><td>")
        .map(|cell| cell.replace('\u{202f}', "").parse().expect("a number"))
        .collect();
    let table = fs::read_to_string(out.join("isobaths/storage.csv")).expect("a table");
    let same = table.lines().skip(1).any(|line| {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().expect("a number")).collect();
        (cells[0] - shown[0]).abs() < 5e-3
            && (cells[1] - shown[1]).abs() < 1.0
            && (cells[2] - shown[2]).abs() < 1.0
    });
    assert!(same, "{shown:?} is in no line of\n{table}");

    // Its inputs are named without their folder, with the fingerprint of the record.
    let record = fs::read_to_string(out.join("report.json")).expect("a record");
    let record: serde_json::Value = serde_json::from_str(&record).expect("JSON");
    let fingerprint = record["inputs"][0]["sha256"].as_str().expect("a fingerprint");
    assert!(page.contains(&format!("<code>{fingerprint}</code>")));
    assert!(!page.contains(&folder.display().to_string()));
    for warning in record["warnings"].as_array().expect("warnings") {
        let beginning = warning.as_str().expect("a sentence").split(['\'', '"', '&', '<']).next();
        assert!(page.contains(beginning.unwrap_or_default()), "{warning}");
    }
}

#[test]
fn a_name_from_outside_stays_text_and_the_page_alone_can_be_asked_for() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulated(folder);
    let name = "<b>pond & co.sl2";
    fs::rename(folder.join("pond.sl2"), folder.join(name)).expect("a new name");
    run(folder, &["process", name, "-o", "out", "--no-objects", "--products", "report"]);
    let page = page(&folder.join("out"));
    assert!(page.contains("Survey &lt;b&gt;pond &amp; co"), "the title");
    assert!(!page.contains("<b>pond"));
    assert!(page.contains("Depth map with isobaths"), "a map without depth.tif");
    assert!(!folder.join("out/depth/depth.tif").exists());
}
