//! Sound files of every kind, and what is made of them.

use super::mutate::{self, Random, WILD};
use super::run::program;
use bathyscope_log::formats;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Identity, Side};
use bathyscope_objects::Mark;
use bathyscope_objects::review::{Edit, Review};
use bathyscope_products::pipeline::settings::rows::ROWS;
use bathyscope_test_support::handmade;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// Files that a case is made from: a simulated pond of ten seconds and all that Bathyscope makes of
/// it.
pub(super) struct Seeds {
    folder: TempDir,
}

/// One run of the program.
pub(super) struct Case {
    /// Kind of the input that is harmed.
    pub kind: &'static str,
    /// Folder of the input and of the products.
    pub folder: TempDir,
    pub args: Vec<String>,
}

type Make = fn(&Seeds, &mut Random, &Path) -> Vec<String>;

/// Kinds of cases, taken in turn, so that all kinds occur equally often.
const KINDS: [(&str, Make); 15] = [
    ("log, info", info),
    ("log, process", process_log),
    ("jumping log", process_jumping),
    ("settings file", settings_file),
    ("settings", settings),
    ("points, filter", filter),
    ("points, compare", compare),
    ("raster", raster),
    ("model", model),
    ("picture", picture),
    ("track", track),
    ("water level", water_level),
    ("review", review),
    ("bottom", bottom),
    ("boxes, evaluate", evaluate),
];

fn strings(args: &[&str]) -> Vec<String> {
    args.iter().map(|arg| (*arg).to_owned()).collect()
}

impl Seeds {
    /// Makes them.
    pub(super) fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path();
        let write = |name: &str, bytes: &[u8]| fs::write(path.join(name), bytes).expect("a file");
        write("scene.toml", b"duration_s = 10.0\n");
        let runs: [&[&str]; 2] = [
            &["simulate", "scene.toml", "-o", "pond", "--seed", "3"],
            &["process", "pond.sl2", "-o", "out", "--no-objects"],
        ];
        for args in runs {
            let outcome = program(path, &strings(args));
            assert_eq!(outcome.code, Some(0), "{args:?}: {}", outcome.stderr);
        }
        write("small.sl3", &handmade::sl3(&handmade::survey_frames(40), 168));
        write("small.xtf", &handmade::xtf(40, 2, 3, (-111.5, 36.9), 4.0));
        let survey = formats::open(&path.join("pond.sl2"), &Progress::new()).expect("a log");
        write("pond.review.json", review_of(&survey).as_bytes());
        write("bottom.toml", bottom_of(&survey).as_bytes());
        let at = |i: usize| (-111.0 + 1e-6 * i as f64, 36.0 + 1e-6 * i as f64);
        let rows = |line: &dyn Fn(usize) -> String| (0..60).map(line).collect::<String>();
        let csv =
            rows(&|i| format!("{},{},{},{}\n", i as f64 * 0.5 - 5.0, at(i).0, at(i).1, i * 3));
        write("track.csv", format!("time,lon,lat,heading_deg\n{csv}").as_bytes());
        let gpx = rows(&|i| {
            let (lon, lat) = at(i);
            format!(
                "<trkpt lat=\"{lat}\" lon=\"{lon}\"><time>2021-10-12T00:53:{i:02}Z</time></trkpt>\n"
            )
        });
        write("track.gpx", format!("<gpx><trk><trkseg>\n{gpx}</trkseg></trk></gpx>\n").as_bytes());
        let start_s = survey.start_unix_s.unwrap_or(0.0) - 60.0;
        let level = rows(&|i| format!("{},{}\n", start_s + 10.0 * i as f64, 1.0 + 0.01 * i as f64));
        write("level.csv", format!("time,level_m\n{level}").as_bytes());
        let speckle = |x: u32, y: u32| (x * x / 7 + y * y / 5 + x * y) as u8;
        let grey = image::GrayImage::from_fn(120, 90, |x, y| image::Luma([speckle(x, y)]));
        let wide = image::ImageBuffer::from_fn(90, 60, |x, y| {
            image::Rgb([u16::from(speckle(x, y)) * 257, 900, 40_000])
        });
        grey.save(path.join("grey.png")).expect("a picture");
        grey.save(path.join("grey.jpg")).expect("a picture");
        image::DynamicImage::ImageRgb16(wide).save(path.join("deep.png")).expect("a picture");
        Self { folder }
    }

    fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.folder.path().join(name)).expect(name)
    }

    fn text(&self, name: &str) -> String {
        String::from_utf8(self.read(name)).expect(name)
    }

    /// The case of a number.
    pub(super) fn case(&self, number: usize) -> Case {
        let mut random = Random(number as u64);
        let (kind, make) = KINDS[number % KINDS.len()];
        let folder = tempfile::tempdir().expect("a folder");
        let args = make(self, &mut random, folder.path());
        Case { kind, folder, args }
    }

    /// A log with scars; its name.
    fn harmed_log(&self, random: &mut Random, folder: &Path) -> String {
        let name = random.pick(&["pond.sl2", "pond.sl2", "small.sl3", "small.xtf", "Rec00007.DAT"]);
        if name == "Rec00007.DAT" {
            let mut files = handmade::humminbird(40, false, false);
            let harmed = random.below(files.len());
            files[harmed].1 = mutate::bytes(random, &files[harmed].1);
            fs::create_dir_all(folder.join("Rec00007")).expect("a folder");
            for (path, bytes) in files {
                fs::write(folder.join(path), bytes).expect("a file");
            }
        } else {
            let bytes = mutate::bytes(random, &self.read(name));
            fs::write(folder.join(name), bytes).expect("a log");
        }
        name.to_owned()
    }

    fn copy(&self, name: &str, folder: &Path) {
        fs::copy(self.folder.path().join(name), folder.join(name)).expect(name);
    }

    /// A text file with something wrong.
    fn harmed_text(&self, random: &mut Random, name: &str, folder: &Path, to: &str) {
        let text = mutate::text(random, &self.text(name));
        fs::write(folder.join(to), text).expect("a file");
    }
}

fn review_of(survey: &bathyscope_log::survey::Survey) -> String {
    let names = vec!["rock".to_owned(), "tyre".to_owned()];
    let mut review = Review::new(Identity::of(survey), names);
    for index in 0..6 {
        let mark = Mark {
            side: Side::BOTH[index % 2],
            pings: 10 + 20 * index..18 + 20 * index,
            near_m: 3.0,
            far_m: 4.5,
        };
        let edit = Edit::Add { mark, class: index % 2 };
        review = review.apply(&edit).expect("a box");
    }
    review.to_json()
}

fn bottom_of(survey: &bathyscope_log::survey::Survey) -> String {
    let bytes = survey.source.byte_count;
    let pings = survey.side_scan.len();
    format!(
        "[bottom]\nlog_bytes = {bytes}\npings = {pings}\n\n[[bottom.lines]]\nside = \"port\"\npings = [10, 60]\ncorners = [[10.0, 2.5], [30.0, 2.75], [59.0, 2.5]]\n"
    )
}

fn info(seeds: &Seeds, random: &mut Random, folder: &Path) -> Vec<String> {
    let name = seeds.harmed_log(random, folder);
    match random.below(2) {
        0 => strings(&["info", &name]),
        _ => strings(&["info", &name, "--json"]),
    }
}

/// The search for objects costs most of the time and is the same for all, so that one in five has
/// it.
fn processed(random: &mut Random, name: &str, more: &[&str]) -> Vec<String> {
    let mut args = strings(&["process", name, "-o", "out"]);
    args.extend(strings(more));
    if random.below(5) > 0 {
        args.push("--no-objects".to_owned());
    }
    args
}

fn process_log(seeds: &Seeds, random: &mut Random, folder: &Path) -> Vec<String> {
    let name = seeds.harmed_log(random, folder);
    let preset = random.pick(&["published", "recommended"]);
    processed(random, &name, &["--preset", preset])
}

fn process_jumping(seeds: &Seeds, random: &mut Random, folder: &Path) -> Vec<String> {
    let bytes = mutate::jumping_sl2(random, &seeds.read("pond.sl2"));
    fs::write(folder.join("pond.sl2"), bytes).expect("a log");
    processed(random, "pond.sl2", &[])
}

fn settings(seeds: &Seeds, random: &mut Random, folder: &Path) -> Vec<String> {
    seeds.copy("pond.sl2", folder);
    let mut args = processed(random, "pond.sl2", &[]);
    for _ in 0..1 + random.below(3) {
        let key = random.pick(ROWS).key;
        let value = random.pick(&WILD);
        args.extend(["--set".to_owned(), format!("{key}={value}")]);
    }
    args
}

fn settings_file(seeds: &Seeds, random: &mut Random, folder: &Path) -> Vec<String> {
    seeds.copy("pond.sl2", folder);
    let sound = "draft_m = 0.3\nwater_level_m = 1.5\ncrs = \"EPSG:32612\"\n\n[first_return]\nmethod = \"tracker\"\nthreshold = 0.2\n\n\
        [calibration]\npings = \"40..90\"\n\n[surface]\ncell_m = 0.5\nmax_gap_m = 12.0\n\n[isobaths]\ninterval_m = 0.25\n\n\
        [outliers]\nradius_m = 2.0\nmin_neighbors = 6\n";
    fs::write(folder.join("mine.toml"), mutate::text(random, sound)).expect("settings");
    processed(random, "pond.sl2", &["--settings", "mine.toml"])
}

/// A file of points, harmed; its name.
fn points(seeds: &Seeds, random: &mut Random, folder: &Path) -> String {
    let from = random.pick(&[
        "points/cloud.csv",
        "points/cloud.csv",
        "points/cloud.xyz",
        "points/cloud.ply",
        "points/cloud.copc.laz",
        "isobaths/depth_areas.geojson",
    ]);
    let name = from.rsplit('/').next().unwrap_or(from);
    let from = format!("out/{from}");
    match name.rsplit('.').next() {
        Some("ply" | "laz") => {
            let bytes = mutate::bytes(random, &seeds.read(&from));
            fs::write(folder.join(name), bytes).expect("points");
        }
        _ => seeds.harmed_text(random, &from, folder, name),
    }
    name.to_owned()
}

fn filter(seeds: &Seeds, random: &mut Random, folder: &Path) -> Vec<String> {
    let name = points(seeds, random, folder);
    let output = random.pick(&["kept.csv", "kept.ply", "kept.las", "kept.laz", "kept.copc.laz"]);
    let radius = random.pick(&["1", "1e-9", "1e9", "1e300"]);
    let neighbors = random.pick(&["1", "10", "500", "1000000"]);
    strings(&["filter", &name, "-o", output, "--radius", radius, "--min-neighbors", neighbors])
}

fn compare(seeds: &Seeds, random: &mut Random, folder: &Path) -> Vec<String> {
    let measured = points(seeds, random, folder);
    let sound = random.pick(&["cloud.xyz", "cloud.copc.laz", "cloud.csv"]);
    fs::create_dir(folder.join("sound")).expect("a folder");
    let reference = format!("sound/{sound}");
    let points = seeds.read(&format!("out/points/{sound}"));
    fs::write(folder.join(&reference), points).expect("points");
    let by = random.pick(&["nearest", "surface"]);
    let mut files = [measured, reference];
    if random.below(2) == 0 {
        files.reverse();
    }
    strings(&["compare", &files[0], &files[1], "--by", by])
}

fn raster(seeds: &Seeds, random: &mut Random, folder: &Path) -> Vec<String> {
    let bytes = mutate::bytes(random, &seeds.read("out/depth/depth.tif"));
    fs::write(folder.join("depth.tif"), bytes).expect("a raster");
    seeds.copy("pond.sl2", folder);
    match random.below(3) {
        0 => processed(random, "pond.sl2", &["--reference", "depth.tif"]),
        1 => strings(&["compare", "pond.sl2", "depth.tif", "--by", "surface"]),
        _ => strings(&["compare", "depth.tif", "depth.tif", "--by", "nearest"]),
    }
}

fn model(seeds: &Seeds, random: &mut Random, folder: &Path) -> Vec<String> {
    let models = bathyscope_test_support::detector_models();
    let mut names: Vec<_> = fs::read_dir(models).expect("models").flatten().collect();
    names.retain(|name| name.path().extension().is_some_and(|suffix| suffix == "onnx"));
    names.sort_by_key(std::fs::DirEntry::file_name);
    let path = names[random.below(names.len())].path();
    let sound = fs::read(&path).expect("a model");
    let sidecar = fs::read_to_string(path.with_extension("json")).ok();
    let harms_sidecar = sidecar.is_some() && random.below(2) == 0;
    let bytes = if harms_sidecar { sound } else { mutate::bytes(random, &sound) };
    fs::write(folder.join("model.onnx"), bytes).expect("a model");
    if let Some(sidecar) = sidecar {
        let text =
            if harms_sidecar { mutate::text(random, &sidecar) } else { sidecar.into_bytes() };
        fs::write(folder.join("model.json"), text).expect("a sidecar");
    }
    seeds.copy("grey.png", folder);
    strings(&["detect", "grey.png", "-o", "out", "--model", "model.onnx"])
}

fn picture(seeds: &Seeds, random: &mut Random, folder: &Path) -> Vec<String> {
    let name = random.pick(&["grey.png", "grey.jpg", "deep.png"]);
    let mut bytes = mutate::bytes(random, &seeds.read(name));
    if name != "grey.jpg" && random.below(2) == 0 {
        // Any width and height, with the checksum that belongs to them.
        let sizes = [1, 2, 90, 4_000, 20_000, 40_000, 60_000, u32::MAX];
        bytes = seeds.read(name);
        bytes[16..20].copy_from_slice(&random.pick(&sizes).to_be_bytes());
        bytes[20..24].copy_from_slice(&random.pick(&sizes).to_be_bytes());
        let mut checksum = flate2::Crc::new();
        checksum.update(&bytes[12..29]);
        bytes[29..33].copy_from_slice(&checksum.sum().to_be_bytes());
    }
    fs::write(folder.join(name), bytes).expect("a picture");
    strings(&["detect", name, "-o", "out"])
}

fn track(seeds: &Seeds, random: &mut Random, folder: &Path) -> Vec<String> {
    seeds.copy("pond.sl2", folder);
    let name = random.pick(&["track.csv", "track.csv", "track.gpx"]);
    seeds.harmed_text(random, name, folder, name);
    let mut args = processed(random, "pond.sl2", &["--track", name]);
    if name == "track.gpx" {
        let offset_s = random.pick(&["0", "-1634000000", "-1.634e9"]);
        args.extend(["--set".to_owned(), format!("track.offset_s={offset_s}")]);
    }
    args
}

fn water_level(seeds: &Seeds, random: &mut Random, folder: &Path) -> Vec<String> {
    seeds.copy("pond.sl2", folder);
    seeds.harmed_text(random, "level.csv", folder, "level.csv");
    processed(random, "pond.sl2", &["--set", "water_level.file=level.csv"])
}

fn review(seeds: &Seeds, random: &mut Random, folder: &Path) -> Vec<String> {
    seeds.copy("pond.sl2", folder);
    seeds.harmed_text(random, "pond.review.json", folder, "pond.review.json");
    strings(&["review", "pond.sl2", "-o", "out"])
}

fn bottom(seeds: &Seeds, random: &mut Random, folder: &Path) -> Vec<String> {
    seeds.copy("pond.sl2", folder);
    seeds.harmed_text(random, "bottom.toml", folder, "bottom.toml");
    processed(random, "pond.sl2", &["--settings", "bottom.toml"])
}

fn evaluate(seeds: &Seeds, random: &mut Random, folder: &Path) -> Vec<String> {
    if random.below(2) == 0 {
        let objects = "pond.objects.csv";
        seeds.copy("pond.sl2", folder);
        seeds.harmed_text(random, objects, folder, objects);
        seeds.harmed_text(random, "pond.review.json", folder, "pond.review.json");
        let truth = random.pick(&[objects, "pond.review.json"]);
        return strings(&["evaluate", "pond.sl2", "--truth", truth]);
    }
    let truth = "0 0.5 0.5 0.1 0.1\n1 0.25 0.5 0.2 0.1\n";
    let found = "0 0.5 0.5 0.1 0.1 0.9\n1 0.25 0.5 0.2 0.1 0.4\n";
    for (name, labels) in [("truth", truth), ("found", found)] {
        fs::create_dir(folder.join(name)).expect("a folder");
        let labels = mutate::text(random, labels);
        fs::write(folder.join(name).join("one.txt"), labels).expect("labels");
    }
    strings(&["evaluate", "--truth", "truth", "--predicted", "found"])
}
