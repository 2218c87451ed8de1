//! `bathyscope detect`: finds objects on the bottom with a YOLO model, in logs or in pictures of
//! other programs.

use super::folders::Folders;
use super::settings::{LogOpener, SettingsArgs, processed};
use super::status_line::StatusLine;
use super::survey_logs::logs_of;
use super::{Failure, output};
use bathyscope_log::support::catch_panic::catch_panic;
use bathyscope_log::support::picture_file::{PictureFault, bounded_decoder};
use bathyscope_log::support::progress::Progress;
use bathyscope_objects::{DetectorSettings, Model, Picture};
use bathyscope_products::outputs::{self, Proposed, Replaced, RunFolder};
use image::{ColorType, DynamicImage, ImageDecoder as _};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Most pixels across or down a picture.
const LARGEST_PICTURE: u32 = 40_000;
/// Most bytes of memory for decoding a picture.
const LARGEST_UNPACKED: u64 = 320 << 20;

/// `bathyscope detect SURVEY|PICTURE... -o DIR`.
#[derive(Debug, clap::Args)]
pub(super) struct DetectArgs {
    /// Logs, folders of logs, or pictures (PNG, JPEG); of several, each is written into a folder of
    /// its own
    #[arg(required = true, value_name = "SURVEY|PICTURE")]
    inputs: Vec<PathBuf>,
    /// Folder whose subfolder `objects` gets objects.csv, detections.csv, .geojson, .gpx and the
    /// chips; made when missing
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Another YOLO model than the one that comes with the program; MODEL.json beside it is read
    /// too; the same as the setting `detector.model`
    #[arg(long, value_name = "MODEL.onnx")]
    model: Option<PathBuf>,
    /// Least score of a box, 0 to 1; without it the model's own
    #[arg(long, value_parser = share)]
    score: Option<f32>,
    /// Overlap (IoU) above which the box of the lower score is dropped, 0 to 1; without it the
    /// model's own
    #[arg(long, value_parser = share)]
    iou: Option<f32>,
    #[command(flatten)]
    settings: SettingsArgs,
}

fn share(text: &str) -> Result<f32, &'static str> {
    let number = text.parse().ok();
    number.filter(|share| (0.0..=1.0).contains(share)).ok_or("a number between 0 and 1 is expected")
}

/// Searches every input. If there are several, an input that cannot be used does not prevent the
/// search of the others.
pub(super) fn run(args: DetectArgs) -> Result<(), Failure> {
    let mut settings = args.settings.resolve()?;
    let detector = &mut settings.detector;
    detector.model = args.model.or(detector.model.take());
    detector.score = args.score.or(detector.score);
    detector.iou = args.iou.or(detector.iou);
    let model = Model::load_or_shipped(detector.model.as_deref())?;
    output::notify(format_args!("model: {}", model.description));
    let logs = LogOpener::new(settings)?;
    let inputs = logs_of(&args.inputs);
    let [input] = inputs.as_slice() else {
        return each(&inputs, &model, &logs, &args.output);
    };
    detect_into(input, &model, &logs, &args.output)
}

fn each(inputs: &[PathBuf], model: &Model, logs: &LogOpener, output: &Path) -> Result<(), Failure> {
    let mut folders = Folders::in_folder(output);
    let mut failed = 0;
    for input in inputs {
        let name = input.file_stem().unwrap_or(input.as_os_str());
        let folder = folders.next(&name.to_string_lossy());
        if let Err(Failure { sentence }) = detect_into(input, model, logs, &folder) {
            failed += 1;
            output::notify(format_args!("bathyscope: {sentence}"));
        }
    }
    if failed == 0 {
        return Ok(());
    }
    Err(format!("{failed} of {} inputs could not be searched, for the reasons above", inputs.len())
        .into())
}

fn detect_into(
    input: &Path,
    model: &Model,
    logs: &LogOpener,
    folder: &Path,
) -> Result<(), Failure> {
    // Begun before the work, so that a folder that cannot be written into does not cost minutes
    // first.
    let run = RunFolder::begin(folder)?;
    let (found, replaced) = if is_picture(input) {
        search_picture(input, model, &logs.settings.detector, run)?
    } else {
        search_survey(input, model, logs, run)?
    };
    output::results(format_args!(
        "found {found}; wrote the tables and chips into {}{}",
        folder.join("objects").display(),
        replaced.in_words()
    ))
}

fn is_picture(path: &Path) -> bool {
    let ending = path.extension().map(|ending| ending.to_ascii_lowercase());
    ending.is_some_and(|ending| ["png", "jpg", "jpeg"].iter().any(|known| ending == *known))
}

/// Searches a log; returns the findings as text, and what was replaced in the folder.
fn search_survey(
    input: &Path,
    model: &Model,
    logs: &LogOpener,
    run: RunFolder,
) -> Result<(String, Replaced), Failure> {
    let survey = Arc::new(logs.open(input, &Progress::new())?);
    let status = StatusLine::new();
    status.work_on("", survey.side_scan.len());
    let log = processed(&survey, &logs.settings, None, &status)?;
    status.step("detecting");
    let (found, replaced) = outputs::write_detected(&log, model, run, &status.progress)
        .map_err(|error| format!("{error}: {}", input.display()))?;
    Ok((proposed_in_words(&found, model.names()), replaced))
}

/// Searches a picture; returns the findings as text, and what was replaced in the folder.
fn search_picture(
    input: &Path,
    model: &Model,
    settings: &DetectorSettings,
    run: RunFolder,
) -> Result<(String, Replaced), Failure> {
    let status = StatusLine::at("detecting");
    let picture = read_picture(input).map_err(|Failure { sentence }| {
        format!("cannot read the picture: {sentence}: {}", input.display())
    })?;
    let name = input.file_name().unwrap_or_default().to_string_lossy();
    let progress = &status.progress;
    let (found, replaced) =
        outputs::write_detected_in_picture(&name, &picture, model, settings, run, progress)
            .map_err(|error| format!("{error}: {}", input.display()))?;
    let names = found.iter().map(|detection| model.names()[detection.class].as_str());
    Ok((boxes_in_words(names), replaced))
}

/// Reads the pixels of a file; the error is a sentence without the path.
fn read_picture(path: &Path) -> Result<Picture, Failure> {
    catch_panic(|| decode_picture(path)).unwrap_or_else(|| Err(PictureFault::Damaged.into()))
}

fn decode_picture(path: &Path) -> Result<Picture, Failure> {
    // Bytes per pixel of the copy with 8 bits a channel and without transparency; 0 if none is
    // made.
    let copied = |colours| match colours {
        ColorType::L8 | ColorType::Rgb8 => 0,
        colours if colours.has_color() => 3,
        _ => 1,
    };
    let decoder = bounded_decoder(BufReader::new(File::open(path)?), LARGEST_UNPACKED, copied)?;
    let (width, height) = decoder.dimensions();
    if width.max(height) > LARGEST_PICTURE {
        return Err(format!(
            "it has {width} by {height} pixels, and {LARGEST_PICTURE} across or down are searched at most; cut it into pieces"
        ).into());
    }
    let decoded = DynamicImage::from_decoder(decoder)?;
    let (width, height) = (decoded.width() as usize, decoded.height() as usize);
    Ok(if decoded.color().has_color() {
        Picture { width, height, channels: 3, levels: decoded.into_rgb8().into_raw() }
    } else {
        Picture::grey(width, height, decoded.into_luma8().into_raw())
    })
}

/// Returns the number of boxes and of each class as text: `7 boxes (4 rock, 3 tyre)`.
fn boxes_in_words<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for name in names {
        *counts.entry(name).or_default() += 1;
    }
    let each: Vec<String> = counts.iter().map(|(name, count)| format!("{count} {name}")).collect();
    match counts.values().sum() {
        0 => "no objects".to_owned(),
        1 => format!("1 box ({})", each.join("")),
        count => format!("{count} boxes ({})", each.join(", ")),
    }
}

/// Returns the numbers of boxes and objects as text: `7 boxes (4 rock, 3 tyre) on 5 objects`. An
/// object found in several passes has several boxes.
pub(super) fn proposed_in_words(found: &Proposed, names: &[String]) -> String {
    let name = |class: usize| names.get(class).map_or("object", String::as_str);
    let boxes = boxes_in_words(found.boxes.iter().map(|detection| name(detection.class)));
    let objects = match found.objects {
        0 => String::new(),
        1 => " on 1 object".to_owned(),
        count => format!(" on {count} objects"),
    };
    let unplaced = match found.unplaced {
        0 => String::new(),
        count => format!(", {count} of them without a place in the world"),
    };
    boxes + &objects + &unplaced
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_log::survey::Side;
    use bathyscope_objects::{Detection, Mark};

    fn summary_of(classes: &[usize], objects: usize, unplaced: usize) -> String {
        let detection = |&class: &usize| Detection {
            class,
            score: 0.5,
            mark: Mark { side: Side::Port, pings: 0..4, near_m: 3.0, far_m: 4.0 },
        };
        let boxes = classes.iter().map(detection).collect();
        let found = Proposed { boxes, objects, unplaced };
        proposed_in_words(&found, &["rock".to_owned(), "tyre".to_owned()])
    }

    #[test]
    fn boxes_are_distinguished_from_objects() {
        assert_eq!(summary_of(&[], 0, 0), "no objects");
        assert_eq!(summary_of(&[1], 1, 0), "1 box (1 tyre) on 1 object");
        assert_eq!(summary_of(&[0, 1, 0], 2, 0), "3 boxes (2 rock, 1 tyre) on 2 objects");
        assert_eq!(
            summary_of(&[0, 0], 0, 2),
            "2 boxes (2 rock), 2 of them without a place in the world"
        );
    }
}
