//! Defines the commands that the window can send to the app.

use super::planning::PlanRequest;
use super::{
    Action, BottomStroke, ExclusionEdit, KeyFocus, Keys, LogBox, LogId, LogPlace, Measure,
    MistakeSort, Nudge, ReferenceBy, View, ViewOptions,
};
use bathyscope_bottom::calibration::PingRange;
use bathyscope_log::support::geo::LonLat;
use bathyscope_log::survey::{LogPart, Side};
use bathyscope_objects::review::{BoxId, Edit, Queue};
use bathyscope_objects::truth::Mistake;
use bathyscope_products::pipeline::settings::ControlValue;
use bathyscope_products::pipeline::{Preset, Settings};
use std::ops::Range;
use std::path::PathBuf;

/// A request of the analyst, carried out by [`super::App::apply`]; commands of the window alone
/// (layout, dialogs) have no effect there and are carried out by the window.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Carry out a command of the table, from a menu, the palette or a key.
    Do(Action),
    /// Carry out the command of a bare key, and report its change, with undo.
    ByKey {
        /// The key, as the table of commands writes it.
        keys: Keys,
        /// The command.
        command: Box<Command>,
        /// View or panel that had the keyboard.
        focus: KeyFocus,
    },
    /// Open a log.
    Open(PathBuf),
    /// Open several logs and close those that are open; the first of the new ones is shown.
    OpenAll(Vec<PathBuf>),
    /// Open these logs beside those that are open; the first of the new ones is shown.
    Add(Vec<PathBuf>),
    /// Show another of the open logs in waterfall, profile and panels.
    ShowLog(LogId),
    /// Save the project in its file.
    SaveProject,
    /// Close a log.
    CloseLog(LogId),
    /// Move a log down the list by a number of places, or up if the number is negative.
    MoveLog(LogId, isize),
    /// Include a log in maps, clouds and products, or exclude it.
    SetLogVisible(LogId, bool),
    /// Keep the height of this log when heights are applied; `None` keeps the mean height of all
    /// logs.
    HoldHeight(Option<LogId>),
    /// Show a log, and a place of it in all views.
    RevealIn(LogId, LogPlace),
    /// Go to the state after a number of steps of the history, undone steps included.
    GoToStep(usize),
    /// Open the bundled demo survey.
    OpenDemo,
    /// Change several processing settings at once. One undo step ends with the first change that is
    /// not `live`.
    Change {
        /// The new settings.
        settings: Box<Settings>,
        /// Name of the change in the undo menu: `threshold`, `preset`.
        label: &'static str,
        /// True while the analyst is still dragging.
        live: bool,
    },
    /// Give a setting of the shown log a value of its control. One undo step ends with the first
    /// change that is not `live`.
    Set {
        /// Key of the setting.
        key: &'static str,
        /// The new value.
        value: ControlValue,
        /// True while the analyst is still dragging.
        live: bool,
    },
    /// Use all settings of a preset.
    UsePreset(Preset),
    /// Propose these side-scan pings for the scale; nothing changes yet.
    ProposeStretch(PingRange),
    /// Change the display options.
    Show(Box<ViewOptions>),
    /// Set the place under the pointer; `None` when the pointer has left.
    Hover(Option<LogPlace>),
    /// Select a place without moving any view.
    Select(Option<LogPlace>),
    /// Select a place and bring it into all other views.
    Reveal(LogPlace),
    /// Find the passes that saw a position, for the menu of the map.
    FindPasses(LonLat),
    /// Show a place in the first pass that saw it.
    ShowPlace(LonLat),
    /// Report the pings that the waterfall shows now.
    Visible(Range<usize>),
    /// Compare the points with the reference, because residuals are visible, unless that is done.
    CompareWithReference,
    /// Compare the points with a file of points (optionally with its columns: `FILE:x,y,z`) or with
    /// another log.
    CompareWith(PathBuf),
    /// Change the method that finds the reference of a point.
    MatchBy {
        /// Method that finds the reference of a point.
        by: ReferenceBy,
        /// Largest distance of the nearest point, metres.
        radius_m: f64,
    },
    /// Bring the control of a setting into view, by its key, and move the keyboard to it.
    ShowSetting(&'static str),
    /// Open a section of the panel of steps, by its title, and move the keyboard to it.
    ShowSection(&'static str),
    /// Move the keyboard focus to a view.
    Focus(View),
    /// Choose this folder in the dialog of the products.
    ChooseExportFolder(PathBuf),
    /// Decide about a box or correct it. One undo step ends with the first edit that is not `live`.
    Edit {
        /// The decision or correction.
        edit: Edit,
        /// True while the analyst is still dragging.
        live: bool,
    },
    /// Mark a target at the place of a sample.
    MarkTarget(LogPlace),
    /// Apply a decision, a correction or a remark to a box of any log.
    EditIn(LogId, Edit),
    /// Set the classes that boxes can have.
    SetClasses(Vec<String>),
    /// Rename a class, in the list and for all boxes of all logs.
    RenameClass {
        /// Present name of the class.
        from: String,
        /// New name of the class.
        to: String,
    },
    /// Select a box and bring it into all views, or select none.
    SelectBox(Option<BoxId>),
    /// Show the log of a box, if it is another one, and bring the box into all views.
    SelectLogBox(LogBox),
    /// Select a box of any log, and enlarge it in all views.
    FlyTo(LogBox),
    /// Move the selected box by keys.
    Nudge(Nudge),
    /// Sort and filter the boxes.
    LineUp(Box<Queue>),
    /// Search for objects with the model in this file from now on.
    UseModel(PathBuf),
    /// Exclude a part of a log from every result, or include it again.
    Exclude {
        /// The log.
        log: LogId,
        /// The part of the log.
        part: LogPart,
        /// The change of its exclusion.
        edit: ExclusionEdit,
    },
    /// Accept the first returns of these pings as bottom where they were found, or undo that.
    AcceptBottom {
        /// The side.
        side: Side,
        /// First and last ping, both included.
        pings: [usize; 2],
        /// True to accept them, false to undo that.
        accept: bool,
    },
    /// Draw the bottom over the waterfall.
    DrawBottom(BottomStroke),
    /// Move the bottom at the selected ping outward by a number of samples.
    NudgeBottom(i32),
    /// Show a false alarm or a missed object in all views.
    ShowMistake(Mistake),
    /// Sort the list of mistakes.
    SortMistakes(MistakeSort),
    /// Write a file or a folder.
    Write(FileToWrite),
    /// Read a file for the open survey.
    OpenFile(FileToOpen),
    /// Change the planned lines, or the settings that they are planned with.
    Plan(PlanRequest),
    /// Draw on the map, or compute the depths along the drawn line.
    Measure(Measure),
    /// Draw the view that was chosen for printing into a file.
    PrintInto(PathBuf),
    /// Notify the analyst with a sentence.
    Notify(String),
    /// Remove a notice.
    Dismiss(usize),
}

/// Kind and path of a file or folder to write.
#[derive(Clone, Debug, PartialEq)]
pub enum FileToWrite {
    /// The ticked products, into a folder.
    Products(PathBuf),
    /// Reviewed boxes and objects, into a folder.
    Boxes(PathBuf),
    /// The shown log, in the format of the file name's ending.
    Log(PathBuf),
    /// The visible pings of the shown log, in the format of the file name's ending.
    Pings(PathBuf),
    /// The planned lines: GPX, KML, QGroundControl or Mission Planner by the file name's ending.
    Plan(PathBuf),
    /// The measured figure: GeoJSON or CSV by the file name's ending.
    Figure(PathBuf),
    /// The depth profile.
    Profile(PathBuf),
    /// The review of boxes.
    Review(PathBuf),
    /// The reviews of all logs that differ from their files.
    Reviews,
    /// The open logs as a project, which is saved in this file from now on.
    Project(PathBuf),
}

/// Kind and path of a file to read for the open survey.
#[derive(Clone, Debug, PartialEq)]
pub enum FileToOpen {
    /// The analyst's own picture, shown under the map.
    BaseMap(PathBuf),
    /// Polygons at which isobaths end.
    IsobathArea(PathBuf),
    /// Readings of the water's height, which are subtracted from the depths.
    WaterLevels(PathBuf),
    /// A track that replaces the track of the recorder.
    Track(PathBuf),
    /// A dropped table of water levels or of a track; its columns determine which.
    Table(PathBuf),
    /// The review of the open survey's boxes.
    Review(PathBuf),
    /// The objects known to lie in the open survey, or in the survey that is being opened.
    Truth(PathBuf),
}
