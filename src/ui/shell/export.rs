//! Draws the dialog that asks for the products to write, and for their folder.

use crate::app::{App, Command, FileToWrite};
use crate::ui::dialogs::PathPurpose;
use crate::ui::panels::parts;
use crate::ui::{ViewContext, theme};
use bathyscope_bottom::presentation::text::bytes;
use bathyscope_products::outputs::{
    Amounts, MANIFEST, OUTPUT_FILES, Product, When, about_bytes, files_in_words,
};
use egui::text::{CCursor, CCursorRange};
use egui::{Id, Key, Modal, RichText, TextEdit, Ui};
use std::path::{Path, PathBuf};

/// Width of the dialog, points.
const WIDTH: f32 = 460.0;

/// The dialog of the products, if it is open.
#[derive(Default)]
pub(super) struct ExportDialog {
    open: Option<Asked>,
}

/// State of the open dialog.
struct Asked {
    folder: String,
    /// True if the analyst has named the folder; false if it is only proposed.
    is_named: bool,
    /// Amounts of data that determine the sizes of the files.
    amounts: Amounts,
    /// Level that the depths are counted from, and corrections that are not applied.
    statement: Vec<String>,
    /// The folder that was checked last, and the effect of the export on it.
    known: Option<(String, String)>,
    /// True if the field of the folder takes the keyboard in the next frame.
    takes_keyboard: bool,
}

/// Button that the analyst pressed.
#[derive(Clone, Copy, PartialEq)]
enum Pressed {
    Nothing,
    Export,
    Choose,
    Cancel,
}

impl ExportDialog {
    /// Opens the dialog; products are written into `folder` unless another is named. `statement`
    /// describes the depths.
    pub(super) fn ask(&mut self, folder: &Path, amounts: Amounts, statement: Vec<String>) {
        self.open = Some(Asked {
            folder: folder.display().to_string(),
            is_named: false,
            amounts,
            statement,
            known: None,
            takes_keyboard: true,
        });
    }

    /// Sets a folder that was chosen in the dialog of the system.
    pub(super) fn take_folder(&mut self, folder: &Path) {
        if let Some(asked) = &mut self.open {
            asked.folder = folder.display().to_string();
            asked.is_named = true;
            asked.takes_keyboard = true;
        }
    }

    /// Returns true if the dialog is shown.
    pub(super) fn is_open(&self) -> bool {
        self.open.is_some()
    }

    /// Draws the dialog while it is open; returns the path that the dialog of the system is to ask
    /// for.
    pub(super) fn ui(
        &mut self,
        ctx: &egui::Context,
        context: &mut ViewContext<'_>,
    ) -> Option<PathPurpose> {
        let asked = self.open.as_mut()?;
        let modal = Modal::new(Id::unique("export")).show(ctx, |ui| {
            ui.set_width(WIDTH);
            ui.heading("Export products");
            for sentence in &asked.statement {
                parts::remark(ui, context.units().sentence(sentence));
            }
            ui.add_space(4.0);
            products(ui, context, &asked.amounts);
            ui.add_space(6.0);
            let (pressed, goes_on) = folder(ui, asked);
            ui.add_space(6.0);
            match pressed {
                Pressed::Nothing => buttons(ui, asked, goes_on),
                pressed => pressed,
            }
        });
        let closes = modal.should_close();
        match modal.inner {
            Pressed::Export => {
                let folder = PathBuf::from(asked.folder.trim());
                context.push(Command::Write(FileToWrite::Products(folder)));
                self.open = None;
            }
            Pressed::Choose => return Some(PathPurpose::ExportInto),
            Pressed::Cancel => self.open = None,
            Pressed::Nothing if closes => self.open = None,
            Pressed::Nothing => {}
        }
        None
    }
}

/// Draws a check box for each group of files, with its size.
fn products(ui: &mut Ui, context: &mut ViewContext<'_>, amounts: &Amounts) {
    let mut options = context.options().clone();
    let grid = egui::Grid::new("products").num_columns(2);
    grid.spacing([24.0, 4.0]).show(ui, |ui| {
        for product in Product::ALL {
            let mut requested = !options.excluded_products.contains(&product);
            let tick = ui.checkbox(&mut requested, product.title());
            if tick.on_hover_text(files(context.app, product)).clicked() {
                if requested {
                    options.excluded_products.retain(|excluded| *excluded != product)
                } else {
                    options.excluded_products.push(product)
                }
            }
            let size = bytes(about_bytes(Some(product), amounts));
            ui.label(RichText::new(format!("about {size}")).weak());
            ui.end_row();
        }
    });
    let ticked = Product::ALL.into_iter();
    let ticked = ticked.filter(|product| !options.excluded_products.contains(product));
    let always = about_bytes(None, amounts);
    let chosen: u64 = (ticked.map(|product| about_bytes(Some(product), amounts))).sum();
    let sum = bytes(always + chosen);
    let text = format!(
        "About {sum} with the tables of first returns and points, which are always written."
    );
    ui.add(egui::Label::new(text).wrap());
    context.show(options);
}

/// Returns the names of the files of a product.
fn files(app: &App, product: Product) -> String {
    let files = product.files();
    if product != Product::Residuals || app.map.comparing.reference.is_none() {
        return files;
    }
    let compared = OUTPUT_FILES.iter().filter(|row| row.when == When::Compared);
    format!("{files}; {}", files_in_words(compared))
}

/// Draws the field of the folder, and the effect of the export on it. Returns the pressed button,
/// and true if the keyboard moves on to the button. Return alone does not start an export into a
/// folder that is only proposed.
fn folder(ui: &mut Ui, asked: &mut Asked) -> (Pressed, bool) {
    let label = ui.label("Folder to write into");
    let (mut pressed, mut goes_on) = (Pressed::Nothing, false);
    ui.horizontal(|ui| {
        let hint = "Opens the system's dialog.";
        if ui.button("Choose…").on_hover_text(hint).clicked() {
            pressed = Pressed::Choose;
        }
        let line = TextEdit::singleline(&mut asked.folder).desired_width(f32::INFINITY);
        let mut shown = line.show(ui);
        let line = shown.response.response.labelled_by(label.id);
        asked.is_named |= line.changed();
        if std::mem::take(&mut asked.takes_keyboard) {
            // Typing replaces the proposed folder.
            let end = CCursor::new(asked.folder.chars().count());
            let all = CCursorRange::two(CCursor::new(0), end);
            shown.state.cursor.set_char_range(Some(all));
            shown.state.store(ui.ctx(), line.id);
            line.request_focus();
        }
        let enter = line.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
        if asked.is_named && !asked.folder.trim().is_empty() && enter {
            pressed = Pressed::Export
        } else {
            goes_on = enter
        }
    });
    if asked.known.as_ref().is_none_or(|(of, _)| *of != asked.folder) {
        let said = state_of(Path::new(asked.folder.trim()));
        asked.known = Some((asked.folder.clone(), said.to_owned()));
    }
    let said = asked.known.as_ref().map_or("", |(_, said)| said);
    ui.label(RichText::new(said).small().weak());
    (pressed, goes_on)
}

/// Describes the effect of an export on a folder.
fn state_of(folder: &Path) -> &'static str {
    if folder.join(MANIFEST).is_file() {
        "The files of an earlier export there will be replaced."
    } else if folder.is_dir() {
        "Products go into subfolders; other files there stay as they are."
    } else {
        "The folder will be made."
    }
}

fn buttons(ui: &mut Ui, asked: &Asked, take_keyboard: bool) -> Pressed {
    let is_named = !asked.folder.trim().is_empty();
    ui.horizontal(|ui| {
        let button = egui::Button::new("Export").min_size(theme::DIALOG_BUTTON);
        let export = ui.add_enabled(is_named, button);
        if take_keyboard {
            export.request_focus();
        }
        let cancel = ui.button("Cancel").clicked();
        match (export.clicked(), cancel) {
            (true, _) => Pressed::Export,
            (_, true) => Pressed::Cancel,
            _ => Pressed::Nothing,
        }
    })
    .inner
}
