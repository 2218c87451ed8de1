//! Recordings of soundings without side-scan make a depth map.

use super::*;
use serde_json::Value;

/// Seconds, longitude and latitude (minutes east of 11 degrees and north of 48) and depth of the
/// soundings: four legs over a slope.
fn soundings() -> impl Iterator<Item = (usize, [f64; 2], f64)> {
    (0..400).map(|second| {
        let (leg, along) = (second / 100, second % 100);
        let along = if leg % 2 == 0 { along } else { 99 - along };
        let minutes = [31.0 + along as f64 * 8e-4, 7.0 + leg as f64 * 3e-3];
        (second, minutes, 3.0 + along as f64 / 50.0 + leg as f64 / 10.0)
    })
}

fn sentence(body: &str) -> String {
    let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
    format!("${body}*{sum:02X}\r\n")
}

/// Writes the soundings as a logger of NMEA 0183 writes them.
fn nmea() -> String {
    let each = soundings().map(|(second, [east, north], depth_m)| {
        let time = 100_000 + second / 60 * 100 + second % 60;
        let place = format!("48{north:08.5},N,011{east:08.5},E");
        sentence(&format!("GPRMC,{time},A,{place},004.0,090.0,040326,,,A"))
            + &sentence(&format!("SDDPT,{depth_m:.2},0.30"))
    });
    each.collect()
}

/// Writes the soundings as an app exports them, the depths in feet.
fn table() -> String {
    let each = soundings().map(|(second, [east, north], depth_m)| {
        let [lon_deg, lat_deg] = [11.0 + east / 60.0, 48.0 + north / 60.0];
        let depth_ft = depth_m / 0.3048;
        format!("{second};{lon_deg:.7};{lat_deg:.7};{depth_ft:.3}\n").replace('.', ",")
    });
    "time_s;longitude;latitude;depth_ft\n".to_owned() + &each.collect::<String>()
}

#[test]
fn sentences_and_tables_make_a_depth_map() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in [("boat.nmea", nmea()), ("app.csv", table())] {
        fs::write(folder.path().join(name), text).expect("a recording");
        run(folder.path(), &["process", name, "-o", "out"]);
        let out = folder.path().join("out");
        let report = fs::read_to_string(out.join("report.json")).expect("a report");
        let report: Value = serde_json::from_str(&report).expect("JSON");
        assert_eq!(report["counts"]["pings"], 0, "{name}");
        let kept = report["counts"]["kept"].as_u64();
        // The last depth of a log may come after the last position.
        assert!(kept.is_some_and(|kept| (398..=400).contains(&kept)), "{name}: {kept:?}");
        let depths = fs::read_to_string(out.join("depth/depth.xyz")).expect("depths");
        let depths = depths.lines().filter_map(|line| line.split(' ').nth(2)?.parse().ok());
        let depths: Vec<f64> = depths.collect();
        assert!(depths.len() > 100, "{name}: {}", depths.len());
        assert!(depths.iter().all(|depth_m| (2.5..6.0).contains(depth_m)), "{name}");
        fs::remove_dir_all(out).expect("the folder of the run");
    }
}
