//! Loads a model from a file and runs it once, on a guarded thread. Also holds the model that comes
//! with the program.

use super::family::{self, DetectorFamily, Shaped};
use super::input::InputSpec;
use super::screen::{self, Declared};
use super::sidecar::{Augmentation, Colour, FamilyName, LevelEntry, Metadata, Resize, Sidecar};
use super::tract::{self, Network, Output};
use super::{Model, ModelError, Unusable};
use crate::{NAMELESS_CLASS, Nms, class_index};
use bathyscope_log::support::catch_panic::catch_panic;
use bathyscope_log::support::printable::one_line;
use bathyscope_log::support::regular_file;
use std::borrow::Cow;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;
use tract_onnx::pb::ModelProto;

/// Greatest size of a model file, MiB: twice that of the largest detector that runs on a laptop.
const LARGEST_MIB: u64 = 512;
/// Greatest size of a sidecar file, bytes: it holds names and anchors.
const LARGEST_SIDECAR: u64 = 1 << 20;
/// Greatest width and height of an input, pixels.
const LARGEST_INPUT: usize = 4096;
/// Width and height of an input if no file states them, pixels.
const USUAL_INPUT: usize = 416;
/// Size of the stack of a guarded thread, bytes. tract recurses through deep networks; the memory
/// is only reserved as address space.
const STACK_BYTES: usize = 64 << 20;
/// The shipped model, YOLOv4-tiny; the model card beside it states its origin, data and figures.
const ONNX: &[u8] = include_bytes!("../../../assets/detector/default.onnx");
/// Sidecar text of the shipped model: classes, input and thresholds.
const SIDECAR: &str = include_str!("../../../assets/detector/default.json");

/// Longest times that a network may take.
#[derive(Clone, Copy)]
pub(super) struct Limits {
    /// Time to parse and compile the network. YOLOv4 at full width takes a second.
    compilation: Duration,
    /// Time of the first picture. YOLOv4 at full width and 608 pixels takes a second and a half.
    first_picture: Duration,
}

impl Limits {
    /// Limits for a file of unknown origin.
    pub(super) const USUAL: Self =
        Self { compilation: Duration::from_secs(60), first_picture: Duration::from_secs(30) };
    /// No limits, for a network that is known to end: on an emulated computer, a picture can take
    /// over 30 s.
    pub(super) const NONE: Self = Self { compilation: Duration::MAX, first_picture: Duration::MAX };
}

/// Loads the model that comes with the program. It is compiled into the program, so that nothing is
/// downloaded.
///
/// # Errors
/// When the model cannot be used; the error names the model and the reason.
pub fn shipped() -> Result<Model, ModelError> {
    from_bytes(ONNX.into(), Some(SIDECAR), None, Limits::NONE).map_err(|reason| ModelError {
        reason,
        path: PathBuf::from("the model that comes with the program"),
    })
}

/// Loads a model from its file and the sidecar file beside it, if there is one.
///
/// # Errors
/// When a file cannot be read, or the model cannot be used; the error is the reason.
pub(super) fn from_path(path: &Path) -> Result<Model, Unusable> {
    let bytes =
        regular_file::read(path, LARGEST_MIB << 20).map_err(|error| match error.kind() {
            ErrorKind::FileTooLarge => Unusable::TooLarge(LARGEST_MIB),
            _ => error.into(),
        })?;
    let sidecar_path = path.with_extension("json");
    let sidecar = match regular_file::read_text(&sidecar_path, LARGEST_SIDECAR) {
        Ok(text) => Some(text),
        Err(error) if error.kind() == ErrorKind::NotFound => None,
        Err(error) => return Err(Unusable::Sidecar(error.to_string())),
    };
    from_bytes(bytes.into(), sidecar.as_deref(), path.parent(), Limits::USUAL)
}

/// Loads a model from the bytes of its file; weights outside the file are searched in `folder`.
///
/// # Errors
/// When the model cannot be used; the error is the reason.
pub(super) fn from_bytes(
    onnx: Cow<'static, [u8]>,
    sidecar: Option<&str>,
    folder: Option<&Path>,
    limits: Limits,
) -> Result<Model, Unusable> {
    let sidecar = sidecar.map(Sidecar::parse).transpose()?.unwrap_or_default();
    let (owned_sidecar, folder) = (sidecar.clone(), folder.map(Path::to_path_buf));
    let (network, mut input, metadata) =
        guarded("its compilation", limits.compilation, move || {
            open(&onnx, &owned_sidecar, folder.as_deref())
        })?;

    let (first, numbers) = (Arc::clone(&network), vec![0.5; input.count()]);
    let outputs = guarded("its first picture", limits.first_picture, move || first.run(&numbers))?;
    let known = sidecar.names.clone().or_else(|| metadata.names());
    let known_count = known.as_ref().map(Vec::len);
    let (family, name) = understand(&outputs, &input, &sidecar, &metadata, known_count)?;
    prepare_as_trained(&mut input, name, &sidecar)?;
    let mut names = class_names(known, family.classes)?;
    let mut description = describe(name, sidecar.family.is_none(), &names, &input);
    let nameless = class_index(&mut names, NAMELESS_CLASS);
    let augments = sidecar.test_time_augmentation == Some(Augmentation::Mirrored);
    if augments {
        description.push_str(", with test-time augmentation (mirrored)");
    }
    let thresholds = &sidecar.thresholds;
    Ok(Model {
        network,
        family,
        input,
        names,
        nameless,
        pixel_m: sidecar.pixel_m.unwrap_or(0.04),
        levelled: sidecar.level != Some(LevelEntry::Raw),
        score: thresholds.score.unwrap_or(0.25),
        iou: thresholds.iou.unwrap_or(0.45),
        name_score: thresholds.name.unwrap_or(0.0),
        nms: Nms {
            overlap: thresholds.nms.unwrap_or_default(),
            across_classes: thresholds.class_agnostic.unwrap_or(false),
        },
        vote: thresholds.vote,
        augments,
        calibration: sidecar.calibration().unwrap_or_default(),
        description,
    })
}

/// Reads, checks and compiles a network.
fn open(
    onnx: &[u8],
    sidecar: &Sidecar,
    folder: Option<&Path>,
) -> Result<(Arc<Network>, InputSpec, Metadata), Unusable> {
    let Screened { proto, declared, metadata, input } = checked(onnx, sidecar, folder)?;
    let network = Network::compile(&proto, &declared, input.shape(), folder)?;
    Ok((Arc::new(network), input, metadata))
}

/// A graph that was checked, and is not compiled yet.
struct Screened {
    proto: ModelProto,
    declared: Declared,
    metadata: Metadata,
    input: InputSpec,
}

/// Reads and checks a graph. Until then, no number in it can be trusted.
fn checked(onnx: &[u8], sidecar: &Sidecar, folder: Option<&Path>) -> Result<Screened, Unusable> {
    let proto = tract::parse(onnx)?;
    let declared = screen::screen(&proto)?;
    let metadata = screen::metadata(&proto);
    if let Some(task) = metadata.other_task() {
        return Err(Unusable::Task(task.to_owned()));
    }
    check_outside_files(&proto, folder)?;
    let input = input_of(&declared, sidecar, &metadata)?;
    Ok(Screened { proto, declared, metadata, input })
}

/// Makes the checks of [`Model::from_bytes`] that come before any computation, for the fuzzer.
///
/// # Errors
/// When the model cannot be used; the error is the reason.
pub fn screened(onnx: &[u8], sidecar: Option<&str>) -> Result<(), Unusable> {
    let sidecar = sidecar.map(Sidecar::parse).transpose()?.unwrap_or_default();
    checked(onnx, &sidecar, None)?.metadata.names();
    Ok(())
}

fn check_outside_files(proto: &ModelProto, folder: Option<&Path>) -> Result<(), Unusable> {
    let mut bytes = 0;
    for name in screen::outside_files(proto) {
        let found = folder.and_then(|folder| folder.join(&name).metadata().ok());
        let Some(found) = found.filter(std::fs::Metadata::is_file) else {
            return Err(Unusable::WeightsElsewhere(name));
        };
        bytes += found.len();
    }
    if bytes > LARGEST_MIB << 20 {
        return Err(Unusable::TooLarge(LARGEST_MIB));
    }
    Ok(())
}

/// Determines the input's size and layout; how grey levels become numbers is set later, once the
/// family is known.
fn input_of(
    declared: &Declared,
    sidecar: &Sidecar,
    metadata: &Metadata,
) -> Result<InputSpec, Unusable> {
    let [batch, second, third, fourth] = declared.shape;
    let input_error = |what: &str| Unusable::Input(format!("`{}` {what}", declared.name));
    if ![tract::FLOAT32, tract::FLOAT16].contains(&declared.element) {
        return Err(input_error("takes no fractions (f32 or f16)"));
    }
    if batch.is_some_and(|batch| batch != 1) {
        return Err(input_error("takes several pictures at once"));
    }
    let picture = |size: Option<usize>| matches!(size, Some(1 | 3));
    let channels_last = picture(fourth) && !picture(second);
    let (channels, height, width) =
        if channels_last { (fourth, second, third) } else { (second, third, fourth) };
    let [usual_height, usual_width] = metadata.image_size().unwrap_or([USUAL_INPUT; 2]);
    let input = InputSpec {
        width: width.or(sidecar.input.width).unwrap_or(usual_width),
        height: height.or(sidecar.input.height).unwrap_or(usual_height),
        channels: channels.unwrap_or(3),
        channels_last,
        colour: Colour::Rgb,
        scale: 1.0 / 255.0,
        mean: [0.0; 3],
        std: [1.0; 3],
        resize: Resize::Stretch,
    };
    if ![1, 3].contains(&input.channels) {
        return Err(input_error(&format!("has {} channels", input.channels)));
    }
    let sizes = [input.width, input.height];
    if sizes.iter().any(|size| !(32..=LARGEST_INPUT).contains(size)) {
        return Err(input_error(&format!("is {} x {} pixels", sizes[0], sizes[1])));
    }
    Ok(input)
}

/// Returns the family of the network and its name.
fn understand(
    outputs: &[Output],
    input: &InputSpec,
    sidecar: &Sidecar,
    metadata: &Metadata,
    known_names: Option<usize>,
) -> Result<(DetectorFamily, FamilyName), Unusable> {
    let shapes: Vec<Shaped<'_>> =
        outputs.iter().map(|output| (output.name.as_str(), output.shape.as_slice())).collect();
    let size = [input.width, input.height];
    let name = match sidecar.family {
        Some(name) => name,
        None => family::guess(&shapes, size, metadata)?,
    };
    let mut family = family::bind(name, &shapes, size, sidecar, known_names)?;
    family.learn(outputs);
    Ok((family, name))
}

/// Sets the preparation of a picture to that of the training of the family, and then to the entries
/// of the sidecar file.
fn prepare_as_trained(
    input: &mut InputSpec,
    family: FamilyName,
    sidecar: &Sidecar,
) -> Result<(), Unusable> {
    let (resize, colour, scale) = match family {
        FamilyName::Yolov4 | FamilyName::RawHeads => (Resize::Stretch, Colour::Rgb, 1.0 / 255.0),
        FamilyName::Yolox => (Resize::LetterboxTopLeft, Colour::Bgr, 1.0),
        _ => (Resize::Letterbox, Colour::Rgb, 1.0 / 255.0),
    };
    let entry = &sidecar.input;
    input.resize = entry.resize.unwrap_or(resize);
    input.colour = entry.colour.unwrap_or(colour);
    input.scale = entry.scale.unwrap_or(scale);
    let channels = input.channels;
    let spread = |values: &Option<Vec<f32>>, usual: f32| match values.as_deref() {
        None => Ok([usual; 3]),
        Some(&[value]) => Ok([value; 3]),
        Some(&[red, green, blue]) if channels == 3 => Ok([red, green, blue]),
        Some(_) => {
            Err(Unusable::Sidecar("input.mean and input.std hold a number a channel".to_owned()))
        }
    };
    input.mean = spread(&entry.mean, 0.0)?;
    input.std = spread(&entry.std, 1.0)?;
    if input.std.contains(&0.0) {
        return Err(Unusable::Sidecar("input.std is not 0".to_owned()));
    }
    Ok(())
}

fn class_names(known: Option<Vec<String>>, classes: usize) -> Result<Vec<String>, Unusable> {
    match known {
        // Names are put on one line, because they are shown in tables, folder names and the window.
        Some(names) if names.len() == classes => {
            Ok(names.iter().map(|name| one_line(name)).collect())
        }
        Some(names) => Err(Unusable::Sidecar(format!(
            "{} class names are given, but the outputs distinguish {classes} classes",
            names.len()
        ))),
        None => Ok((0..classes).map(|class| format!("class {class}")).collect()),
    }
}

fn describe(name: FamilyName, guessed: bool, names: &[String], input: &InputSpec) -> String {
    let by = if guessed {
        "guessed from the shapes of its outputs; a sidecar JSON file corrects that"
    } else {
        "by its JSON file"
    };
    let colour = match (input.channels, input.colour) {
        (1, _) | (_, Colour::Grey) => "grey",
        (_, Colour::Rgb) => "RGB",
        (_, Colour::Bgr) => "BGR",
    };
    let resize = match input.resize {
        Resize::Stretch => "stretched",
        Resize::Letterbox => "letterboxed",
        Resize::LetterboxTopLeft => "letterboxed from the top left",
    };
    let classes = if names.len() == 1 { "class" } else { "classes" };
    format!(
        "{} with {} {classes}, {} x {} pixels, {colour}, {resize} ({by})",
        name.words(),
        names.len(),
        input.width,
        input.height,
    )
}

/// Runs `work` on a thread of its own and waits for its result no longer than `limit`. `what` names
/// the work in the error. A thread that takes longer is not stopped: its cost was bounded before it
/// started, and its result is dropped.
///
/// The work is on a file that may be malicious: the work may fail, panic or never end, and the
/// program still continues.
///
/// # Errors
/// When the work fails, panics or takes too long; the error is the reason why the model cannot be
/// used.
fn guarded<T: Send + 'static>(
    what: &'static str,
    limit: Duration,
    work: impl FnOnce() -> Result<T, Unusable> + Send + 'static,
) -> Result<T, Unusable> {
    let (sender, receiver) = mpsc::channel();
    thread::Builder::new().name(what.to_owned()).stack_size(STACK_BYTES).spawn(move || {
        let outcome = catch_panic(work).unwrap_or(Err(Unusable::Damaged(what)));
        // The receiver is gone if the work took too long.
        sender.send(outcome).ok();
    })?;
    receiver.recv_timeout(limit).unwrap_or_else(|gone| {
        Err(match gone {
            RecvTimeoutError::Timeout => Unusable::Slow { what, seconds: limit.as_secs() },
            RecvTimeoutError::Disconnected => Unusable::Damaged(what),
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_network_that_is_late_is_refused_unless_it_has_no_limit() {
        let load = |limits| from_bytes(ONNX.into(), Some(SIDECAR), None, limits);
        let first_picture = Duration::ZERO;
        let late = load(Limits { first_picture, ..Limits::NONE });
        assert!(matches!(late, Err(Unusable::Slow { .. })), "{late:?}");
        assert!(load(Limits::NONE).is_ok());
    }

    #[test]
    fn what_fails_stops_or_never_ends_is_distinguished() {
        let soon = Duration::from_millis(50);
        let late = Duration::from_secs(600);
        assert_eq!(guarded("this", late, || Ok(7)).unwrap(), 7);
        let panicked = guarded::<()>("this", late, || panic!("a fault"));
        assert!(matches!(panicked, Err(Unusable::Damaged("this"))));
        let slow = guarded("this", soon, || {
            thread::sleep(Duration::from_millis(500));
            Ok(())
        });
        assert!(matches!(slow, Err(Unusable::Slow { what: "this", .. })));
    }
}
