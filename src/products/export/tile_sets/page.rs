//! Writes a page that shows the PMTiles of a map without any file from elsewhere.

use super::TileSet;
use crate::export::{ExportError, write_atomically};
use crate::map_tiles::MapScales;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use bathyscope_bottom::bathymetry::isobaths::evenly_apart_m;
use bathyscope_bottom::presentation::colours::depth_colour;
use bathyscope_bottom::presentation::ticks::round_up;
use bathyscope_log::support::printable::xml;
use serde_json::json;
use std::fs;
use std::io::Write as _;
use std::path::Path;

const PAGE: &str = include_str!("../../../../assets/map_page/index.html");
const STYLE: &str = include_str!("../../../../assets/map_page/style.css");
const SCRIPT: &str = include_str!("../../../../assets/map_page/script.js");

/// Largest total size of the archives that are put into the page itself, bytes: the page is then a
/// single file to send and can be opened from a disk, where browsers let no page read other files.
const MOST_INSIDE: u64 = 8 << 20;
/// Number of steps of the colours of the legend.
const STEPS: usize = 20;

/// Writes the page into the folder of its archives (colours, and elevations), which must exist
/// already.
///
/// # Errors
/// When an archive cannot be read or the file cannot be written.
pub(crate) fn map_page(
    path: &Path,
    set: &TileSet,
    archives: [&'static str; 2],
) -> Result<(), ExportError> {
    write_atomically(path, |mut file| {
        let paths = archives.map(|name| path.with_file_name(name));
        let mut bytes = 0;
        for archive in &paths {
            bytes += fs::metadata(archive)?.len();
        }
        let mut inside = String::new();
        if bytes <= MOST_INSIDE {
            for (name, archive) in archives.iter().zip(&paths) {
                let text = STANDARD.encode(fs::read(archive)?);
                inside += &format!(
                    "<script type=\"application/octet-stream\" id=\"{name}\">{text}</script>\n"
                );
            }
        }
        file.write_all(html(set, archives, &inside).as_bytes())
    })
}

fn html(set: &TileSet, archives: [&str; 2], inside: &str) -> String {
    let MapScales { zooms, range_m, .. } = &set.scales;
    let colours = (0..=STEPS).map(|step| {
        let [red, green, blue] = depth_colour(step as f32 / STEPS as f32);
        format!("#{red:02x}{green:02x}{blue:02x}")
    });
    let map = json!({
        "bounds": zooms.bounds_deg,
        "coarsest": zooms.coarsest,
        "finest": zooms.finest,
        "range": range_m,
        "interval": interval_m(&set.scales),
        "colours": colours.collect::<Vec<String>>(),
        "files": archives,
    });
    let title = xml(&set.name);
    // The longest text is put in last, so that inserted texts are not searched for placeholders.
    PAGE.replace("{{style}}", STYLE)
        .replace("{{script}}", SCRIPT)
        .replace("{{map}}", &map.to_string())
        .replace("{{about}}", &xml(&set.description))
        .replace("{{title}}", &title)
        .replace("{{archives}}", inside)
}

/// Returns the interval of the isobaths, metres: that of evenly spaced levels, or a round number.
fn interval_m(scales: &MapScales) -> f64 {
    let [least_m, most_m] = scales.range_m.map(f64::from);
    let usual_m = round_up((most_m - least_m) / 10.0);
    match scales.levels_m.as_slice() {
        levels_m @ [_, _, ..] => evenly_apart_m(levels_m).map_or(usual_m, |[apart_m, _]| apart_m),
        _ => usual_m,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map_tiles::ZoomRange;

    #[test]
    fn a_small_map_lies_in_its_page_and_a_large_one_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("index.html");
        let archives = ["depth.pmtiles", "depth_values.pmtiles"];
        for name in archives {
            fs::write(folder.path().join(name), b"tiles").unwrap();
        }
        let set = TileSet {
            name: "pond & </script>".to_owned(),
            description: "Depth".to_owned(),
            scales: MapScales {
                zooms: ZoomRange::of_map([9.0, 47.0, 9.01, 47.01], 0.5),
                range_m: [1.0, 3.0],
                levels_m: vec![1.0, 1.2],
                isobaths: Default::default(),
            },
        };
        let written = || {
            map_page(&path, &set, archives).unwrap();
            fs::read_to_string(&path).unwrap()
        };
        let small = written();
        assert!(small.contains("id=\"depth.pmtiles\">dGlsZXM=</script>"));
        assert!(small.contains("<h1>pond &amp; &lt;/script&gt;</h1>") && !small.contains("{{"));
        assert!(!small.contains("http://") && small.matches("https://").count() == 1, "one remark");
        fs::write(folder.path().join(archives[1]), vec![0; MOST_INSIDE as usize]).unwrap();
        let large = written();
        assert!(!large.contains("octet-stream") && large.contains("\"finest\":"));
        fs::remove_file(folder.path().join(archives[1])).unwrap();
        assert!(map_page(&path, &set, archives).is_err());
    }
}
