//! Everything the window can ask for.

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
use bathyscope_products::pipeline::{Preset, Settings};
use std::ops::Range;
use std::path::PathBuf;

/// A request of the analyst. Applied by [`super::App::apply`]; those of the window alone (layout,
/// dialogs) pass through it and are carried out by the shell.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// One of the commands of the table: menu, palette or key.
    Do(Action),
    /// A command given by a bare key: its change is reported, with undo.
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
    /// Open several logs in the place of those that are open; the first of them is shown.
    OpenAll(Vec<PathBuf>),
    /// Open these beside the logs that are open; the first of them is shown.
    Add(Vec<PathBuf>),
    /// Show another of the open logs in waterfall, profile and panels.
    ShowLog(LogId),
    /// Write the project into its file.
    SaveProject,
    /// Close a log.
    CloseLog(LogId),
    /// Move a log down the list by a number of places, or up where it is negative.
    MoveLog(LogId, isize),
    /// Include a log in maps, clouds and products, or exclude it.
    SetLogVisible(LogId, bool),
    /// Hold the height of a log when heights are applied; of none the mean of all.
    HoldHeight(Option<LogId>),
    /// Show a log, and a place of it in all views.
    RevealIn(LogId, LogPlace),
    /// Go to the state after a number of steps of the history, undone steps included.
    GoToStep(usize),
    /// Open the bundled demo survey.
    OpenDemo,
    /// Change processing settings. One undo step ends with the first change that is not `live`.
    Change {
        /// The new settings.
        settings: Box<Settings>,
        /// Name of the change in the undo menu: `threshold`, `preset`.
        label: &'static str,
        /// The analyst is still dragging.
        live: bool,
    },
    /// Take all settings of a preset.
    UsePreset(Preset),
    /// Propose these side-scan pings for the scale; nothing changes yet.
    ProposeStretch(PingRange),
    /// Change how things are shown.
    Show(Box<ViewOptions>),
    /// Set the place under the pointer; `None` when the pointer left.
    Hover(Option<LogPlace>),
    /// Select, without moving any view.
    Select(Option<LogPlace>),
    /// Select, and bring the place into all other views.
    Reveal(LogPlace),
    /// Look for the passes that saw a position, for the menu of the map.
    FindPasses(LonLat),
    /// Show a place in the first pass that saw it.
    ShowPlace(LonLat),
    /// The waterfall shows these pings now.
    Visible(Range<usize>),
    /// Residuals are in view: compare the points, if that is not done.
    CompareWithReference,
    /// Compare the points with a file of points (with its columns, perhaps: `FILE:x,y,z`) or
    /// against another log.
    CompareWith(PathBuf),
    /// Take the reference of a point from elsewhere.
    MatchBy {
        /// Method that finds the reference of a point.
        by: ReferenceBy,
        /// Largest distance of the nearest point, metres.
        radius_m: f64,
    },
    /// Bring the control of a setting into view, by its key, and move the keyboard to it.
    ShowSetting(&'static str),
    /// Move the keyboard focus to a view.
    Focus(View),
    /// Take this folder in the dialog of the products.
    ChooseExportFolder(PathBuf),
    /// Decide about a box or correct it. One undo step ends with the first edit that is not `live`.
    Edit {
        /// The decision or correction.
        edit: Edit,
        /// The analyst is still dragging.
        live: bool,
    },
    /// Mark a point where a sample lies.
    MarkTarget(LogPlace),
    /// Decide about a box of any log, or write about it.
    EditIn(LogId, Edit),
    /// The classes that boxes are given became these.
    SetClasses(Vec<String>),
    /// A class has another name, in the list and for all boxes of all logs.
    RenameClass {
        /// Its name.
        from: String,
        /// Its new name.
        to: String,
    },
    /// Select a box and bring it into all views, or select none.
    SelectBox(Option<BoxId>),
    /// Show the log of a box, if it is another one, and bring the box into all views.
    SelectLogBox(LogBox),
    /// Select a box, in whichever log, and enlarge it in all views.
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
    /// Accept the first returns of these pings, the first and the last, as bottom where they were
    /// found, or take that back.
    AcceptBottom {
        /// The side.
        side: Side,
        /// First and last ping.
        pings: [usize; 2],
        /// True if they are accepted.
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
    /// Change the planned lines, or what they are planned for.
    Plan(PlanRequest),
    /// Draw on the map, or take the depths along what is drawn.
    Measure(Measure),
    /// Draw the view that was chosen to be printed into a file.
    PrintInto(PathBuf),
    /// Notify the analyst in a sentence.
    Notify(String),
    /// Forget a notice.
    Dismiss(usize),
}

/// Kind and path of a file or folder to write.
#[derive(Clone, Debug, PartialEq)]
pub enum FileToWrite {
    /// The ticked products, into a folder.
    Products(PathBuf),
    /// Reviewed boxes and objects, into a folder.
    Boxes(PathBuf),
    /// The shown log, in the format of the ending.
    Log(PathBuf),
    /// The visible pings of the shown log, in the format of the ending.
    Pings(PathBuf),
    /// The planned lines: GPX, KML, QGroundControl or Mission Planner by the ending.
    Plan(PathBuf),
    /// The measured figure: GeoJSON, or CSV by the ending.
    Figure(PathBuf),
    /// The depth profile.
    Profile(PathBuf),
    /// The review of boxes.
    Review(PathBuf),
    /// The reviews of all logs that differ from their files.
    Reviews,
    /// The open logs as a project, which is kept in this file from now on.
    Project(PathBuf),
}

/// Kind and path of a file to read for the open survey.
#[derive(Clone, Debug, PartialEq)]
pub enum FileToOpen {
    /// A picture of the analyst's own to lie under the map.
    BaseMap(PathBuf),
    /// Polygons that isobaths end at.
    IsobathArea(PathBuf),
    /// Readings of the water's height, to be taken off the depths.
    WaterLevels(PathBuf),
    /// A track to lie over the recorder's.
    Track(PathBuf),
    /// A table that was dropped: water levels or a track, as its columns say.
    Table(PathBuf),
    /// The review of the open survey's boxes.
    Review(PathBuf),
    /// The objects known to lie in the open survey, or in the survey that is being opened.
    Truth(PathBuf),
}
