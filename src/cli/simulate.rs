//! `bathyscope simulate`: simulates a survey of known truth, as a log and tables; or many surveys,
//! as pictures with labels.

use super::status_line::StatusLine;
use super::{Failure, LONGEST_TEXT, output};
use bathyscope_log::formats;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::support::regular_file;
use bathyscope_log::survey::{HeadingSettings, Projection, Survey, navigate};
use bathyscope_objects::dataset::{Chip, KnownObject, PictureBoxes, Slice};
use bathyscope_objects::{Mark, Raster, TILE_PX};
use bathyscope_products::export::{
    DatasetFolder, DatasetPart, ExportError, PartSummary, make_folder, write_atomically,
};
use bathyscope_simulation::{
    ObjectKind, ObjectPass, Scene, Simulated, TrainingPlace, TrainingScene, simulate,
    training_scene, training_seed,
};
use rayon::prelude::*;
use serde::Serialize;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write as _};
use std::path::{Path, PathBuf};

/// `bathyscope simulate [SCENE.toml] -o PREFIX [--seed N]`, `bathyscope simulate --dataset DIR
/// [--images N] [--seed N]`.
#[derive(Debug, clap::Args)]
pub(super) struct SimulateArgs {
    /// The scene; without one, the scene of the bundled demo survey
    scene: Option<PathBuf>,
    /// Written are PREFIX.sl2, PREFIX.truth.csv and PREFIX.objects.csv
    #[arg(short, long, value_name = "PREFIX", required_unless_present = "dataset")]
    output: Option<PathBuf>,
    /// Another seed gives another ground, other objects and other noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    dataset: DatasetArgs,
}

/// Simulates the scene and writes the log and its truth.
pub(super) fn run(args: SimulateArgs) -> Result<(), Failure> {
    let Some(prefix) = &args.output else {
        return run_dataset(&args.dataset, args.seed);
    };
    check_prefix(prefix)?;
    let scene = match &args.scene {
        Some(path) => read_scene(path)?,
        None => Scene::demo(),
    };
    let status = StatusLine::at("simulating");
    let survey = simulate(&scene, args.seed, &status.progress)?;
    status.step("writing");
    let written = write(&survey, prefix)?;
    drop(status);
    output::results(format_args!(
        "simulated {} pings and {} objects (seed {}); wrote {written}",
        survey.pings.len(),
        survey.objects.len(),
        args.seed
    ))
}

/// Refuses, before the work begins, a prefix from which the names of the three files cannot be
/// made, or that would replace a log that was not simulated.
fn check_prefix(prefix: &Path) -> Result<(), Failure> {
    if prefix.is_dir() {
        return Err(format!(
            "the output is a folder; add the beginning of the file names to it, for example {}",
            prefix.join("pond").display()
        )
        .into());
    }
    // A log beside its truth was simulated and may be replaced; any other log may be a user's
    // survey.
    let log = with_ending(prefix, "sl2");
    if log.exists() && !with_ending(prefix, "truth.csv").exists() {
        return Err(format!(
            "a log of that name is there and was not simulated (it has no truth beside it); choose another prefix: {}",
            log.display()
        ).into());
    }
    match prefix.parent() {
        Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => {
            Err(format!("there is no folder to write into; make it first: {}", folder.display())
                .into())
        }
        _ => Ok(()),
    }
}

fn read_scene(path: &Path) -> Result<Scene, Failure> {
    let text = regular_file::read_text(path, LONGEST_TEXT)
        .map_err(|error| format!("cannot read the scene: {error}: {}", path.display()))?;
    let scene = Scene::from_toml(&text);
    Ok(scene.map_err(|error| format!("cannot use the scene: {error}: {}", path.display()))?)
}

/// Writes the three files of a simulated survey, the log and its tables of truth; returns their
/// names.
fn write(survey: &Simulated, prefix: &Path) -> Result<String, ExportError> {
    let log = written(prefix, "sl2", |out| survey.write_sl2(out))?;
    let truth = written(prefix, "truth.csv", |out| survey.write_truth_csv(out))?;
    let objects = written(prefix, "objects.csv", |out| survey.write_objects_csv(out))?;
    Ok(format!("{log}, {truth}, {objects}"))
}

/// Writes `PREFIX.ending` as a temporary file, renamed when it is complete; returns the path as
/// text.
fn written(
    prefix: &Path,
    ending: &str,
    fill: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<String, ExportError> {
    let path = with_ending(prefix, ending);
    write_atomically(&path, |file| {
        let mut out = BufWriter::new(file);
        fill(&mut out)?;
        out.flush()
    })?;
    Ok(path.display().to_string())
}

/// Returns `PREFIX.ending`, even if the prefix contains dots.
fn with_ending(prefix: &Path, ending: &str) -> PathBuf {
    let mut name = prefix.as_os_str().to_owned();
    name.push(".");
    name.push(ending);
    PathBuf::from(name)
}

/// Options of a dataset: the kind and number of its pictures.
#[derive(Debug, clap::Args)]
struct DatasetArgs {
    /// Instead of one survey, write pictures of many random ones with labels into this new folder
    #[arg(long, value_name = "DIR", conflicts_with_all = ["scene", "output"])]
    dataset: Option<PathBuf>,
    /// Pictures in all; without it, the sum of the split
    #[arg(long, value_name = "N", requires = "dataset")]
    images: Option<usize>,
    /// Shares of the pictures for training, validation and test; no survey is in two of them
    #[arg(long, value_name = "TRAIN/VAL/TEST", default_value = "332/33/41", value_parser = Split::parse)]
    split: Split,
    /// Pictures cut out of one survey
    #[arg(long, value_name = "N", default_value_t = 6, value_parser = clap::value_parser!(u8).range(1..=40))]
    per_scene: u8,
    /// Also keep the surveys that the pictures are cut out of, each with its table of objects, for
    /// `bathyscope evaluate`
    #[arg(long, requires = "dataset")]
    surveys: bool,
    /// Threads; without it, one for each core
    #[arg(long, value_name = "N", requires = "dataset")]
    threads: Option<usize>,
}

/// Side of a pixel, metres.
const PIXEL_M: f64 = 0.04;
/// Least number of columns of the range in a tile.
const LEAST_COLUMNS: usize = 316;
/// Most pictures in a dataset.
const MOST_IMAGES: usize = 1_000_000;

/// Numbers of pictures for training, validation and test.
#[derive(Clone, Copy, Debug)]
struct Split([usize; 3]);

impl Split {
    fn parse(text: &str) -> Result<Self, &'static str> {
        const WRONG: &str = "give three numbers of pictures, for example 332/33/41";
        let parts: Result<Vec<usize>, _> = text.split('/').map(str::parse).collect();
        let parts: [usize; 3] = parts.ok().and_then(|parts| parts.try_into().ok()).ok_or(WRONG)?;
        if parts.iter().any(|&part| part > MOST_IMAGES) || parts == [0; 3] {
            return Err(WRONG);
        }
        Ok(Self(parts))
    }

    /// Returns the numbers of pictures, scaled to a sum; the remainder of the rounding goes to the
    /// first part that is not empty.
    fn of(self, images: Option<usize>) -> [usize; 3] {
        let sum: usize = self.0.iter().sum();
        let Some(images) = images else {
            return self.0;
        };
        let [train, val, test] = self.0.map(|part| part * images / sum);
        let rest = images - train - val - test;
        match self.0 {
            [0, 0, _] => [0, 0, test + rest],
            [0, _, _] => [0, val + rest, test],
            _ => [train + rest, val, test],
        }
    }
}

/// Makes the dataset and writes it into its folder.
fn run_dataset(args: &DatasetArgs, seed: u64) -> Result<(), Failure> {
    let Some(folder) = &args.dataset else {
        return Err("nothing to do; name an output with -o or --dataset".into());
    };
    let images = args.split.of(args.images);
    if images.iter().sum::<usize>() > MOST_IMAGES {
        return Err(format!("more than {MOST_IMAGES} pictures; ask for fewer").into());
    }
    refuse_in_use(folder)?;
    let names = ObjectKind::ALL.map(|kind| kind.name().to_owned());
    let dataset = DatasetFolder::new(folder, &names)?;
    let mut pool = rayon::ThreadPoolBuilder::new();
    if let Some(threads) = args.threads {
        pool = pool.num_threads(threads);
    }
    let pool = pool.build().map_err(|error| format!("cannot start the threads: {error}"))?;
    let status = StatusLine::at("simulating pictures");
    status.progress.start(images.iter().sum::<usize>() as u64);
    let per_scene = usize::from(args.per_scene);
    let surveys = folder.join("surveys");
    let made = pool.install(|| {
        let parts = DatasetPart::ALL.into_iter().zip(images);
        parts
            .map(|(part, images)| {
                let maker = Maker {
                    dataset: &dataset,
                    part,
                    seed,
                    per_scene,
                    images,
                    surveys: args.surveys.then(|| surveys.join(part.name())),
                    progress: &status.progress,
                };
                maker.part()
            })
            .collect::<Result<Vec<PartRecord>, Failure>>()
    })?;
    dataset.manifest(&Manifest {
        program: "bathyscope simulate --dataset",
        version: env!("CARGO_PKG_VERSION"),
        seed,
        split: args.split.0,
        per_scene: args.per_scene,
        pixel_m: PIXEL_M,
        tile_px: TILE_PX,
        classes: ObjectKind::ALL.map(ObjectKind::name),
        parts: &made,
    })?;
    drop(status);
    let labels: usize = made.iter().map(|made| made.part.labels.values().sum::<usize>()).sum();
    output::results(format_args!(
        "made {} pictures with {labels} boxes (seed {seed}) in {}",
        images.iter().sum::<usize>(),
        folder.display()
    ))
}

/// Refuses a folder that is not empty, so that an old dataset is never mixed with a new one.
fn refuse_in_use(folder: &Path) -> Result<(), Failure> {
    let in_use = fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some());
    if in_use {
        Err(format!("the folder is not empty; name a new one: {}", folder.display()).into())
    } else {
        Ok(())
    }
}

/// Maker of one part of the dataset.
struct Maker<'a> {
    dataset: &'a DatasetFolder,
    part: DatasetPart,
    seed: u64,
    per_scene: usize,
    images: usize,
    /// Folder in which the surveys are kept; `None` if they are not kept.
    surveys: Option<PathBuf>,
    progress: &'a Progress,
}

/// Entry of a part in the manifest: its contents, and the scenes that it was made from.
#[derive(Serialize)]
struct PartRecord {
    #[serde(flatten)]
    part: PartSummary,
    scenes: usize,
    /// Seed of each scene, in the order of the pictures.
    scene_seeds: Vec<u64>,
}

impl Maker<'_> {
    fn part(&self) -> Result<PartRecord, Failure> {
        if let Some(folder) = &self.surveys {
            make_folder(folder)?;
        }
        let scenes = self.images.div_ceil(self.per_scene);
        let boxes: Vec<Vec<PictureBoxes>> = (0..scenes)
            .into_par_iter()
            .map(|scene| self.scene(scene))
            .collect::<Result<_, Failure>>()?;
        let boxes: Vec<PictureBoxes> = boxes.into_iter().flatten().collect();
        Ok(PartRecord {
            part: self.dataset.finish(self.part, &boxes)?,
            scenes,
            scene_seeds: (0..scenes).map(|scene| self.seed_of(scene)).collect(),
        })
    }

    fn seed_of(&self, scene: usize) -> u64 {
        training_seed(self.seed, self.part as u64, scene as u64)
    }

    /// Simulates one scene and writes its pictures and their YOLO labels.
    fn scene(&self, index: usize) -> Result<Vec<PictureBoxes>, Failure> {
        self.progress.check()?;
        let seed = self.seed_of(index);
        let training = training_scene(seed, self.per_scene, TILE_PX as f64 * PIXEL_M);
        let first = index * self.per_scene;
        let requested = self.per_scene.min(self.images - first);
        let quiet = Progress::new();
        let simulated = simulate(&training.scene, seed, &quiet)?;
        if let Some(folder) = &self.surveys {
            write(&simulated, &folder.join(format!("{index:04}")))?;
        }
        let chips = chips(&training, &simulated, requested)?;
        let mut all = Vec::with_capacity(chips.len());
        for (number, chip) in (first..).zip(chips) {
            self.dataset.chip(self.part, number, &chip)?;
            all.push(chip.boxes);
        }
        self.progress.advance(all.len() as u64);
        Ok(all)
    }
}

/// Returns the first `requested` pictures of a scene.
fn chips(
    training: &TrainingScene,
    simulated: &Simulated,
    requested: usize,
) -> Result<Vec<Chip>, Failure> {
    let quiet = Progress::new();
    let survey = formats::open_bytes("scene.sl2", simulated.sl2_bytes(), &quiet)?;
    let navigation = navigate(&survey, &HeadingSettings::default(), Projection::Enu, &quiet)?;
    let raster = Raster::new(&survey, &navigation, PIXEL_M);
    let known = known_objects(simulated);
    let looks = training.looks.iter().take(requested);
    Ok(looks.map(|look| chip(&survey, &raster, look, &known)).collect())
}

fn chip(survey: &Survey, raster: &Raster, look: &TrainingPlace, known: &[KnownObject]) -> Chip {
    let start = |share: f64, room: usize| (share * room as f64) as usize;
    let row = start(look.along, raster.rows().saturating_sub(TILE_PX));
    let column = start(look.outward, raster.columns.saturating_sub(LEAST_COLUMNS));
    Chip::new(raster.tile(survey, look.side, row, column), raster, known)
}

/// Returns the true boxes of all objects of a simulated survey, one for each sighting.
pub fn known_objects(simulated: &Simulated) -> Vec<KnownObject> {
    let count = simulated.pings.len();
    let mut known = Vec::new();
    for object in &simulated.objects {
        let class = ObjectKind::ALL.iter().position(|&kind| kind == object.kind);
        for sighting in &object.sightings {
            known.extend(class.map(|class| of_sighting(class, sighting, count)));
        }
    }
    known
}

fn of_sighting(class: usize, sighting: &ObjectPass, count: usize) -> KnownObject {
    let [near_m, far_m] = sighting.echo_and_shadow_m();
    let slices = sighting.shown.iter().flat_map(|shown| &shown.slices);
    KnownObject {
        class,
        whole: Mark { side: sighting.side, pings: sighting.pings(count), near_m, far_m },
        shown: sighting.shown.is_some(),
        slices: slices
            .map(|slice| Slice {
                ping: slice.ping,
                near_m: slice.near_m,
                far_m: slice.far_m,
                visibility: slice.visibility,
            })
            .collect(),
    }
}

/// Manifest of a dataset, with the values needed to make the dataset again.
#[derive(Serialize)]
struct Manifest<'a> {
    program: &'static str,
    version: &'static str,
    seed: u64,
    split: [usize; 3],
    per_scene: u8,
    pixel_m: f64,
    tile_px: usize,
    classes: [&'static str; ObjectKind::ALL.len()],
    parts: &'a [PartRecord],
}
