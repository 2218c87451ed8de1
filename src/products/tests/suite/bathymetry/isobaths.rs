//! Isobaths and depth areas against GDAL and contourpy (`make_isobaths.py` shows how their figures
//! were made).

use bathyscope_bottom::bathymetry::isobaths::{Isobath, depth_areas, isobaths, storage};
use bathyscope_bottom::bathymetry::{Grid, Surface};
use bathyscope_log::support::progress::{Cancelled, Progress};
use serde::Deserialize;

#[derive(Deserialize)]
struct Case {
    name: String,
    rows: usize,
    columns: usize,
    depth_m: Vec<Option<f32>>,
    levels_m: Vec<f64>,
    contourpy: Vec<Drawn>,
    areas: Vec<Filled>,
    gdal: Option<Vec<Drawn>>,
}

#[derive(Deserialize)]
struct Drawn {
    length: f64,
    lines: usize,
}

#[derive(Deserialize)]
struct Filled {
    area: f64,
    polygons: usize,
    rings: usize,
}

fn cases() -> Vec<Case> {
    serde_json::from_str(include_str!("isobaths.json")).unwrap()
}

/// Cells of a metre.
fn surface(rows: usize, columns: usize, depth_m: Vec<f32>) -> Surface {
    let grid = Grid { west_m: 100.0, north_m: -40.0, cell_m: 1.0, columns, rows };
    Surface::of_depths(grid, depth_m)
}

impl Case {
    fn surface(&self) -> Surface {
        let depths = self.depth_m.iter().map(|depth| depth.unwrap_or(f32::NAN));
        surface(self.rows, self.columns, depths.collect())
    }
}

fn of_level(lines: &[Isobath], level_m: f64) -> impl Iterator<Item = &Isobath> {
    lines.iter().filter(move |line| line.depth_m == level_m)
}

fn assert_near(found: f64, expected: f64, share: f64, what: &str) {
    let off = (found - expected).abs();
    assert!(off <= share * expected.abs(), "{what}: {found} instead of {expected}");
}

#[test]
fn lines_are_as_long_and_as_many_as_those_of_contourpy() {
    for case in cases() {
        let lines = isobaths(&case.surface(), &case.levels_m, &Progress::new()).unwrap();
        for (level_m, drawn) in case.levels_m.iter().zip(&case.contourpy) {
            let what = format!("{} at {level_m}", case.name);
            let length_m = of_level(&lines, *level_m).map(Isobath::length_m).sum();
            assert_near(length_m, drawn.length, 1e-6, &what);
            assert_eq!(of_level(&lines, *level_m).count(), drawn.lines, "{what}");
        }
    }
}

#[test]
fn lines_are_as_long_as_those_of_gdal_and_none_is_the_frame() {
    let cases = cases();
    let with_gdal = cases.iter().filter_map(|case| Some((case, case.gdal.as_ref()?)));
    let mut seen = 0;
    for (case, drawn) in with_gdal {
        let lines = isobaths(&case.surface(), &case.levels_m, &Progress::new()).unwrap();
        for (level_m, drawn) in case.levels_m.iter().zip(drawn) {
            let what = format!("{} at {level_m}", case.name);
            let length_m = of_level(&lines, *level_m).map(Isobath::length_m).sum();
            assert_near(length_m, drawn.length, 1e-3, &what);
            assert_eq!(of_level(&lines, *level_m).count(), drawn.lines, "{what}");
            assert!(of_level(&lines, *level_m).all(Isobath::is_ring), "{what}");
            seen += 1;
        }
    }
    assert_eq!(seen, 5);
}

#[test]
fn areas_are_those_of_contourpy() {
    for case in cases() {
        let areas = depth_areas(&case.surface(), &case.levels_m, &Progress::new()).unwrap();
        assert_eq!(areas.len(), case.areas.len());
        for (area, filled) in areas.iter().zip(&case.areas) {
            let what = format!("{} from {}", case.name, area.from_m);
            assert_near(area.area_m2(), filled.area, 1e-6, &what);
            let rings = area.polygons.iter().map(|polygon| 1 + polygon.holes.len());
            assert_eq!(
                (area.polygons.len(), rings.sum()),
                (filled.polygons, filled.rings),
                "{what}"
            );
        }
    }
}

#[test]
fn the_deeper_side_is_on_the_left() {
    // A pit: its ring runs counter-clockwise around the deeper middle.
    let bed = |i: usize| 5.0 - ((i % 9) as f32 - 4.0).hypot((i / 9) as f32 - 4.0);
    let pit = surface(9, 9, (0..81).map(bed).collect());
    let lines = isobaths(&pit, &[3.5], &Progress::new()).unwrap();
    let [ring] = lines.as_slice() else {
        panic!("{} lines", lines.len());
    };
    let steps = ring.points.windows(2);
    let doubled: f64 = steps.map(|s| s[0][0] * s[1][1] - s[1][0] * s[0][1]).sum();
    assert!(doubled > 0.0);
    // A summit that just touches the level is no line.
    let peak = isobaths(&pit, &[5.0], &Progress::new()).unwrap();
    assert!(peak.iter().all(|line| line.length_m() == 0.0), "{peak:?}");
}

#[test]
fn storage_is_that_of_a_cone() {
    // A cone of 20 m radius and 10 m depth, cells of a metre: below 2 m of depth, the cone of 16 m
    // radius and 8 m.
    let side = 61;
    let bed = |i: usize| {
        let off = ((i % side) as f32 - 30.0).hypot((i / side) as f32 - 30.0);
        if off < 20.0 { 10.0 - off / 2.0 } else { f32::NAN }
    };
    let cone = surface(side, side, (0..side * side).map(bed).collect());
    let table = storage(&cone, &[0.0, 2.0, 99.0], None);
    let volume = |radius: f64| std::f64::consts::PI * radius.powi(2) * radius / 2.0 / 3.0;
    assert_near(table[0].volume_m3, volume(20.0), 2e-3, "all");
    assert_near(table[1].volume_m3, volume(16.0), 2e-3, "below 2 m");
    assert_near(table[1].area_m2, std::f64::consts::PI * 256.0, 1e-2, "area");
    assert_eq!((table[2].area_m2, table[2].volume_m3), (0.0, 0.0));
}

#[test]
fn no_surface_and_a_cancelled_one_have_no_lines() {
    let unknown = surface(3, 3, vec![f32::NAN; 9]);
    assert_eq!(isobaths(&unknown, &[1.0], &Progress::new()), Ok(Vec::new()));
    let progress = Progress::new();
    progress.cancel();
    assert_eq!(isobaths(&unknown, &[1.0], &progress), Err(Cancelled));
    assert_eq!(depth_areas(&unknown, &[1.0, 2.0], &progress), Err(Cancelled));
}
