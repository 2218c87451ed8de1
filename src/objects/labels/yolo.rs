//! Reads folders of YOLO labels.

use super::{
    Label, LabelError, LabelFault, LabelFormat, LabelSet, MOST_CLASSES, PictureLabels, text,
};
use crate::Rect;
use std::path::{Path, PathBuf};

/// Names of the files that hold class names.
const NAMES: [&str; 2] = ["classes.txt", "obj.names"];
/// Greatest length of a file, bytes: longer than any label file of one picture.
const LONGEST: u64 = 16 << 20;

/// Returns true if a file holds class names rather than boxes.
pub(super) fn is_names(file: &Path) -> bool {
    file.file_name().is_some_and(|name| NAMES.iter().any(|names| name == *names))
}

/// Reads the label files of a folder; the class names are from a file in this folder or in the
/// folder above.
///
/// # Errors
/// When a file cannot be read or is not of this format; the error names it.
pub(super) fn read(
    folder: &Path,
    texts: &[PathBuf],
    predicted: bool,
) -> Result<LabelSet, LabelError> {
    let mut set = LabelSet::empty(LabelFormat::Yolo, folder);
    set.names = names(folder)?;
    for file in texts.iter().filter(|file| !is_names(file)) {
        let Some(stem) = file.file_stem() else {
            continue;
        };
        let labels = text(file, LONGEST)?
            .lines()
            .enumerate()
            .filter(|(_, line)| !line.trim().is_empty())
            .map(|(index, line)| parse(index + 1, line, predicted).map_err(LabelError::at(file)))
            .collect::<Result<Vec<Label>, LabelError>>()?;
        let size_px = (!predicted).then(|| picture_size(folder, file)).flatten();
        let picture = PictureLabels { size_px, labels };
        set.pictures.insert(stem.to_string_lossy().into_owned(), picture);
    }
    Ok(set)
}

fn names(folder: &Path) -> Result<Vec<String>, LabelError> {
    let folders = [Some(folder), folder.parent()];
    let mut files =
        folders.into_iter().flatten().flat_map(|folder| NAMES.map(|name| folder.join(name)));
    let Some(file) = files.find(|file| file.is_file()) else {
        return Ok(Vec::new());
    };
    let text = text(&file, LONGEST)?;
    let names: Vec<String> =
        text.lines().map(|line| line.trim().to_owned()).filter(|line| !line.is_empty()).collect();
    if names.len() > MOST_CLASSES {
        let what = LabelFault::TooManyClasses { count: names.len(), named: "class names" };
        return Err(LabelError::new(what, &file));
    }
    Ok(names)
}

/// Returns the width and height of the picture of a label file: beside it, or at the same place in
/// `images` if the labels are in `labels`. `None` if there is no readable picture.
fn picture_size(folder: &Path, file: &Path) -> Option<[u32; 2]> {
    let stem = file.file_stem()?;
    let beside = folder.join(stem).with_added_extension("png");
    let images: PathBuf = folder
        .components()
        .map(|part| match part.as_os_str() {
            name if name == "labels" => "images".as_ref(),
            name => name,
        })
        .collect();
    let apart = images.join(stem).with_added_extension("png");
    [beside, apart].iter().find_map(|picture| image::image_dimensions(picture).ok()).map(Into::into)
}

/// Reads a line `class cx cy w h`, with `score` at its end if predicted.
fn parse(line_number: usize, line: &str, predicted: bool) -> Result<Label, LabelFault> {
    let fault = |what: &str| LabelFault::Line { line: line_number, what: what.to_owned() };
    let fields: Vec<&str> = line.split_whitespace().collect();
    match (fields.len(), predicted) {
        (5, false) | (6, true) => {}
        (5, true) => return Err(fault("a predicted box needs a score: class cx cy w h score")),
        (6, false) => {
            return Err(fault(
                "a true box has no sixth number (these may be predictions): class cx cy w h",
            ));
        }
        (count, _) => {
            let shape = if predicted { "class cx cy w h score" } else { "class cx cy w h" };
            return Err(fault(&format!("{count} numbers where a box is written {shape}")));
        }
    }
    let class = fields[0].parse().ok().filter(|&class: &usize| class < MOST_CLASSES);
    let class = class.ok_or_else(|| {
        let field = fields[0];
        fault(&format!("`{field}` is no class (a whole number from 0, below {MOST_CLASSES})"))
    })?;
    let number = |field: &str| {
        let value = field.parse().ok().filter(|value: &f64| value.is_finite());
        value.ok_or_else(|| fault(&format!("`{field}` is no number")))
    };
    let [cx, cy, w, h] =
        [number(fields[1])?, number(fields[2])?, number(fields[3])?, number(fields[4])?];
    // Some writers round a box at the edge to a little beyond the picture; coordinates in pixels
    // are far beyond.
    if [cx, cy, w, h].iter().any(|share| !(-0.5..=1.5).contains(share)) || w < 0.0 || h < 0.0 {
        return Err(fault("centre and size are shares of the picture, from 0 to 1"));
    }
    let score = match fields.get(5) {
        Some(field) => Some(number(field)?).filter(|score| (0.0..=1.0).contains(score)),
        None => None,
    };
    if predicted && score.is_none() {
        return Err(fault(&format!("the score `{}` is not within 0 to 1", fields[5])));
    }
    Ok(Label {
        class,
        score: score.map(|score| score as f32),
        ignored: false,
        rect: Rect::new(
            [(cx - 0.5 * w) as f32, (cy - 0.5 * h) as f32],
            [(cx + 0.5 * w) as f32, (cy + 0.5 * h) as f32],
        ),
    })
}
