//! Asks for a log, a review or a folder: with the system's dialog on a worker, or with a path field
//! where there is no such dialog.

use super::ViewContext;
use crate::app::{Command, FileToOpen, FileToWrite, Jobs, Task, TaskOutcome};
use bathyscope_log::formats;
use egui::text::{CCursor, CCursorRange};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Duration below which a dialog counts as never shown: "cancelled" and "no dialog service" look
/// the same. No user reads and cancels a dialog so fast, and a busy machine takes that long to find
/// out that there is no service.
const TOO_FAST: Duration = Duration::from_millis(600);

/// Label of the path field for a copy of a log.
const COPY_FIELD: &str = "File to write, .xtf, .sl2, .csv, .parquet or .gpx";

/// Purpose of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PathPurpose {
    /// Logs that replace the open logs.
    OpenLogs,
    /// Logs to add to the open logs.
    AddLogs,
    /// A folder of logs.
    OpenFolder,
    /// The folder that products go into.
    ExportInto,
    /// A review of the open survey.
    OpenReview,
    /// Known objects of the open survey (the truth for detections).
    OpenTruth,
    /// The file that the project is saved in.
    SaveProject,
    /// The file that the review is saved in.
    SaveReview,
    /// The folder that reviewed boxes are exported into.
    ExportBoxesInto,
    /// The file of a detector's model.
    OpenModel,
    /// The file that the depth profile is written into.
    SaveProfile,
    /// A picture to be shown under the map.
    OpenBaseMap,
    /// The reference that the points are compared with.
    OpenReference,
    /// The area at whose edge isobaths end.
    OpenIsobathArea,
    /// Readings of a gauge or tide.
    OpenWaterLevels,
    /// The track of another receiver.
    OpenTrack,
    /// The file that a view is printed into.
    PrintInto,
    /// The file that a measurement is saved in.
    SaveFigure,
    /// The file that planned lines are written into.
    SavePlan,
    /// The file that the shown log is copied into.
    ExportLog,
    /// The file that the visible pings are copied into.
    ExportPings,
}

impl PathPurpose {
    /// Returns the title of the system's dialog, and the path that it asks for.
    fn system_dialog(self) -> (&'static str, AskedPath) {
        use AskedPath::{File, Folder, Logs, NewFile};
        match self {
            Self::OpenLogs => ("Open sonar logs", Logs),
            Self::AddLogs => ("Add sonar logs to those that are open", Logs),
            Self::OpenFolder => ("Open a folder of sonar logs", Folder),
            Self::ExportInto => ("Write the products into", Folder),
            Self::ExportBoxesInto => ("Write the boxes into", Folder),
            Self::OpenModel => ("Choose a detector", File(&[("ONNX models", &["onnx"])])),
            Self::OpenBaseMap => {
                ("Open a base map", File(&[("GeoTIFF", &["tif", "TIF", "tiff", "TIFF"])]))
            }
            Self::OpenReference => {
                ("Compare with points, a GeoTIFF or another log", File(&[("All files", &["*"])]))
            }
            Self::OpenIsobathArea => (
                "Open the area that isobaths end at",
                File(&[("Polygons", &["geojson", "json", "kml", "gpx"]), ("All files", &["*"])]),
            ),
            Self::OpenWaterLevels => (
                "Open readings of the water's height",
                File(&[("Tables", &["csv", "CSV", "txt", "TXT"])]),
            ),
            Self::OpenTrack => (
                "Open the track of another receiver",
                File(&[("Tracks", &["csv", "CSV", "gpx", "GPX", "txt", "TXT"])]),
            ),
            Self::OpenReview => ("Open a review of boxes", File(&[("Reviews", &["json"])])),
            Self::OpenTruth => (
                "Open the objects that are known to lie in the log",
                File(&[("Objects and reviews", &["csv", "json"])]),
            ),
            Self::SaveProject => ("Save the project", NewFile),
            Self::SaveReview => ("Save the review of boxes", NewFile),
            Self::SaveProfile => ("Save the depth profile", NewFile),
            Self::SaveFigure => ("Save the measurement", NewFile),
            Self::SavePlan => ("Save the planned lines", NewFile),
            Self::PrintInto => ("Print the view", NewFile),
            Self::ExportLog => ("Export the log", NewFile),
            Self::ExportPings => ("Export the visible pings", NewFile),
        }
    }

    /// Returns the title of the path field, the description of the path, and the verb of its
    /// button.
    fn words_of_field(self) -> (&'static str, &'static str, &'static str) {
        match self {
            Self::OpenFolder => ("Open a folder", "Path of a folder of logs", "Open"),
            Self::AddLogs => ("Add a survey", "Path of a log or its folder", "Add"),
            Self::OpenLogs => ("Open by path", "Path of a log or its folder", "Open"),
            Self::ExportInto => ("Choose a folder", "Path of the folder", "Choose"),
            Self::OpenReview => ("Open a review", "Path of a review of boxes", "Open"),
            Self::OpenTruth => {
                ("Open known objects", "Path of a table of objects or a review", "Open")
            }
            Self::SaveProject => ("Save the project", "File to write, .bathyscope", "Save"),
            Self::SaveReview => ("Save the review", "File to write", "Save"),
            Self::ExportBoxesInto => ("Export boxes", "Folder to write into", "Export"),
            Self::OpenBaseMap => ("Open a base map", "Path of a GeoTIFF", "Open"),
            Self::OpenReference => (
                "Compare with",
                "Points (with columns: FILE.csv:x,y,z, or -z for a depth), GeoTIFF or log",
                "Compare",
            ),
            Self::OpenIsobathArea => {
                ("Open the area of the isobaths", "Path of polygons: GeoJSON, KML or GPX", "Open")
            }
            Self::OpenWaterLevels => {
                ("Open water levels", "Path of a CSV with time and level_m", "Open")
            }
            Self::OpenTrack => (
                "Open an external track",
                "Path of a CSV with time, lon and lat, or of a GPX",
                "Open",
            ),
            Self::SaveProfile => ("Save the depth profile", "File to write", "Save"),
            Self::SaveFigure => ("Save the measurement", "File to write, .geojson or .csv", "Save"),
            Self::SavePlan => {
                ("Save the planned lines", "File to write, .gpx, .kml, .plan or .waypoints", "Save")
            }
            Self::PrintInto => ("Print the view", "File to write", "Print"),
            Self::ExportLog => ("Export the log", COPY_FIELD, "Export"),
            Self::ExportPings => ("Export the visible pings", COPY_FIELD, "Export"),
            Self::OpenModel => ("Choose a model", "Path of an ONNX file", "Choose"),
        }
    }
}

/// Path that a system dialog asks for.
enum AskedPath {
    /// Logs and projects.
    Logs,
    /// A folder.
    Folder,
    /// A file to be read, with one of the endings of these named lists.
    File(&'static [(&'static str, &'static [&'static str])]),
    /// A file to be written.
    NewFile,
}

/// Result of a system dialog.
struct Chosen {
    /// Empty when nothing was chosen.
    paths: Vec<PathBuf>,
    /// Time for which the worker waited for the dialog; not measured in frames, which may come
    /// late.
    took: Duration,
}

struct Waiting {
    purpose: PathPurpose,
    task: Task<Chosen>,
}

/// The dialogs of the window; one at a time.
#[derive(Default)]
pub(super) struct Dialogs {
    waiting: Option<Waiting>,
    field: Option<Field>,
    /// Name proposed for a file to be written; the user may choose another.
    proposed: Option<PathBuf>,
    /// Text typed while the system's dialog was awaited; the path field begins with this text if
    /// there is no such dialog.
    typed: String,
}

/// The path field: its purpose, the typed text, and whether it replaces the system's dialog.
struct Field {
    purpose: PathPurpose,
    path: String,
    instead: bool,
    /// True once the field has been given the keyboard.
    focused: bool,
    /// True if the text was typed by the user: typing then continues at its end.
    goes_on: bool,
}

impl Field {
    fn new(purpose: PathPurpose, instead: bool, proposed: Option<&PathBuf>) -> Option<Self> {
        let is_named = matches!(purpose.system_dialog().1, AskedPath::NewFile);
        let proposed = proposed.filter(|_| is_named);
        Some(Self {
            purpose,
            path: proposed.map_or_else(String::new, |path| path.display().to_string()),
            instead,
            focused: false,
            goes_on: false,
        })
    }

    /// Draws the field; returns the answer given in this frame.
    fn ui(&mut self, ui: &mut egui::Ui) -> Option<Answer> {
        let (title, name, verb) = self.purpose.words_of_field();
        ui.set_width(480.0);
        ui.heading(title);
        if self.instead {
            ui.label("The system's file dialog is not available here.");
        }
        let label = ui.label(name);
        let line = self.line(ui).labelled_by(label.id);
        let enter = line.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
        let is_new = !std::mem::replace(&mut self.focused, true);
        if is_new || self.path.is_empty() && !enter {
            line.request_focus();
        }
        ui.add_space(6.0);
        ui.horizontal(|ui| {
            let given = !self.path.trim().is_empty();
            let go = ui.add_enabled(given, egui::Button::new(verb)).clicked();
            let cancel = ui.button("Cancel").clicked();
            if given && (go || enter) { Some(Answer::Go) } else { cancel.then_some(Answer::Cancel) }
        })
        .inner
    }

    /// Draws the line that the path is typed into. In its first frame, a proposed path is selected,
    /// and after typed text the cursor is at the end.
    fn line(&mut self, ui: &mut egui::Ui) -> egui::Response {
        let line = egui::TextEdit::singleline(&mut self.path).desired_width(f32::INFINITY);
        let mut shown = line.show(ui);
        if !self.focused {
            let end = CCursor::new(self.path.chars().count());
            // Typing replaces a proposed path, which is selected.
            let marked = if self.goes_on {
                CCursorRange::one(end)
            } else {
                CCursorRange::two(CCursor::new(0), end)
            };
            shown.state.cursor.set_char_range(Some(marked));
            shown.state.store(ui.ctx(), shown.response.id);
        }
        shown.response.response
    }
}

/// Button that closed the path field.
enum Answer {
    Go,
    Cancel,
}

impl Dialogs {
    /// Asks for a file to be written and proposes a name.
    pub(super) fn name(&mut self, purpose: PathPurpose, proposed: PathBuf, jobs: &Jobs) {
        self.proposed = Some(proposed);
        self.ask(purpose, jobs);
    }

    /// Shows the path field.
    pub(super) fn ask_for_path(&mut self) {
        self.field = Field::new(PathPurpose::OpenLogs, false, None);
    }

    /// Returns true if the path field is shown.
    pub(super) fn is_open(&self) -> bool {
        self.field.is_some()
    }

    /// Returns true if the system's dialog is shown or about to be.
    pub(super) fn is_waiting(&self) -> bool {
        self.waiting.is_some()
    }

    /// Keeps the text that is typed while the system's dialog is awaited, unless a text field of
    /// the window has the keyboard: the text is meant for the dialog.
    pub(super) fn take_typed(&mut self, ui: &egui::Ui) {
        if self.waiting.is_none() || ui.text_edit_focused() {
            return;
        }
        self.typed += &super::take_typed(ui);
    }

    /// Shows the dialog for a purpose, unless another one is awaited.
    pub(super) fn ask(&mut self, purpose: PathPurpose, jobs: &Jobs) {
        if self.waiting.is_some() {
            return;
        }
        match jobs {
            // Tests and pictures never open the system's dialog, which would wait for a user.
            Jobs::Inline => self.field = Field::new(purpose, false, self.proposed.as_ref()),
            Jobs::Threads(_) => {
                self.typed.clear();
                let proposed = self.proposed.clone();
                self.waiting = Some(Waiting {
                    purpose,
                    task: Task::start(jobs, move |_| {
                        let asked = Instant::now();
                        let paths = system_dialog(purpose, proposed);
                        let took = asked.elapsed();
                        Chosen { paths, took }
                    }),
                });
            }
        }
    }

    /// Pushes the command for the chosen paths, or shows the path field if there was no dialog.
    pub(super) fn poll(&mut self, commands: &mut Vec<Command>) {
        let Some(waiting) = &self.waiting else {
            return;
        };
        let purpose = waiting.purpose;
        let chosen = match waiting.task.poll() {
            TaskOutcome::Pending => return,
            TaskOutcome::Done(chosen) => Some(chosen),
            TaskOutcome::Failed => None,
        };
        self.waiting = None;
        match chosen {
            Some(chosen) if !chosen.paths.is_empty() => {
                commands.extend(command(purpose, chosen.paths));
            }
            Some(chosen) if chosen.took >= TOO_FAST => {}
            // There was no dialog, or its worker died.
            Some(_) | None => {
                self.field = Field::new(purpose, true, self.proposed.as_ref());
                if let Some(field) = self.field.as_mut().filter(|_| !self.typed.is_empty()) {
                    field.path = std::mem::take(&mut self.typed);
                    field.goes_on = true;
                }
            }
        }
    }

    /// Draws the path field while it is open.
    pub(super) fn ui(&mut self, ctx: &egui::Context, context: &mut ViewContext<'_>) {
        let Some(mut field) = self.field.take() else {
            return;
        };
        let id = egui::Id::unique("path");
        let modal = egui::Modal::new(id).show(ctx, |ui| field.ui(ui));
        match modal.inner {
            Some(Answer::Go) => {
                let paths = vec![PathBuf::from(field.path.trim())];
                context.commands.extend(command(field.purpose, paths));
            }
            Some(Answer::Cancel) => {}
            None if modal.should_close() => {}
            None => self.field = Some(field),
        }
    }
}

/// Returns the command for these paths; all purposes but logs take the first path.
fn command(purpose: PathPurpose, paths: Vec<PathBuf>) -> Option<Command> {
    let path = paths.first()?.clone();
    Some(match purpose {
        PathPurpose::OpenLogs | PathPurpose::OpenFolder => Command::OpenAll(paths),
        PathPurpose::AddLogs => Command::Add(paths),
        PathPurpose::ExportInto => Command::ChooseExportFolder(path),
        PathPurpose::OpenReview => Command::OpenFile(FileToOpen::Review(path)),
        PathPurpose::OpenTruth => Command::OpenFile(FileToOpen::Truth(path)),
        PathPurpose::SaveProject => Command::Write(FileToWrite::Project(path)),
        PathPurpose::SaveReview => Command::Write(FileToWrite::Review(path)),
        PathPurpose::ExportBoxesInto => Command::Write(FileToWrite::Boxes(path)),
        PathPurpose::OpenModel => Command::UseModel(path),
        PathPurpose::SaveProfile => Command::Write(FileToWrite::Profile(path)),
        PathPurpose::OpenBaseMap => Command::OpenFile(FileToOpen::BaseMap(path)),
        PathPurpose::OpenReference => Command::CompareWith(path),
        PathPurpose::OpenIsobathArea => Command::OpenFile(FileToOpen::IsobathArea(path)),
        PathPurpose::OpenWaterLevels => Command::OpenFile(FileToOpen::WaterLevels(path)),
        PathPurpose::OpenTrack => Command::OpenFile(FileToOpen::Track(path)),
        PathPurpose::SaveFigure => Command::Write(FileToWrite::Figure(path)),
        PathPurpose::SavePlan => Command::Write(FileToWrite::Plan(path)),
        PathPurpose::PrintInto => Command::PrintInto(path),
        PathPurpose::ExportLog => Command::Write(FileToWrite::Log(path)),
        PathPurpose::ExportPings => Command::Write(FileToWrite::Pings(path)),
    })
}

/// Shows the system's dialog and waits for its end; returns no path if the dialog was cancelled or
/// there is none.
fn system_dialog(purpose: PathPurpose, proposed: Option<PathBuf>) -> Vec<PathBuf> {
    let (title, asked) = purpose.system_dialog();
    let mut dialog = rfd::FileDialog::new().set_title(title);
    let path = match asked {
        AskedPath::Logs => {
            let mut endings = formats::endings_to_show();
            endings.push("bathyscope".to_owned());
            let dialog = dialog
                .add_filter("Sonar logs and projects", &endings)
                .add_filter("All files", &["*"]);
            return dialog.pick_files().unwrap_or_default();
        }
        AskedPath::Folder => dialog.pick_folder(),
        AskedPath::File(filters) => {
            for &(name, endings) in filters {
                dialog = dialog.add_filter(name, endings);
            }
            dialog.pick_file()
        }
        AskedPath::NewFile => {
            if let Some(path) = &proposed {
                let name = path.file_name().unwrap_or_default();
                dialog = dialog.set_file_name(name.to_string_lossy());
                if let Some(folder) = path.parent() {
                    dialog = dialog.set_directory(folder);
                }
            }
            dialog.save_file()
        }
    };
    path.into_iter().collect()
}
