//! The command table: one place for names, hints and keys; menus, palette, key handling and F1 read
//! it.

use bathyscope_log::formats::formats_to_open;
use std::sync::LazyLock;

/// A key combination, as text that the window turns into its own key type: `Ctrl+Shift+Z`, `[`,
/// `F11`.
pub type Keys = &'static str;

macro_rules! actions {
    ($($variant:ident, $label:literal, $keys:expr, $hint:literal;)*) => {
        /// A command without arguments.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Action {
            $(#[doc = $hint] $variant,)*
        }

        impl Action {
            /// All actions, in the order of the manual.
            pub const ALL: &'static [Action] = &[$(Action::$variant,)*];

            /// Name in menus and the palette.
            pub fn label(self) -> &'static str {
                match self { $(Action::$variant => $label,)* }
            }

            /// Its key, if it has one.
            pub fn keys(self) -> Option<Keys> {
                match self { $(Action::$variant => $keys,)* }
            }

            /// Returns the description of the command, without what is known only at run time.
            fn plain_hint(self) -> &'static str {
                match self { $(Action::$variant => $hint,)* }
            }
        }
    };
}

actions! {
    Open, "Open survey…", Some("Ctrl+O"), "Opens one log, or several logs as one survey.";
    AddLog, "Add survey…", Some("Ctrl+Shift+O"), "Adds a log to those that are open: one map, one cloud, one set of products.";
    CloseLog, "Close this log", Some("Ctrl+W"), "Closes the log in the waterfall; the other logs stay open, and undo opens it again.";
    NextLog, "Next log", Some("Ctrl+PageDown"), "Shows the next log of the list in waterfall, profile and panels.";
    PreviousLog, "Previous log", Some("Ctrl+PageUp"), "Shows the previous log of the list in waterfall, profile and panels.";
    ShowTogether, "Show all logs together", None, "Shows every open log on one map, also those far from the others and those too short.";
    OpenFolder, "Open folder…", None, "Opens all logs of a folder as one survey.";
    OpenPath, "Open path…", Some("Ctrl+Shift+P"), "Opens a log by its path: file or folder.";
    FollowRecording, "Follow recording", Some("Ctrl+L"), "Shows new pings of this log while the recorder writes them. Press it again to stop and to read the whole log.";
    OpenDemo, "Open the demo survey", None, "Opens the simulated pond that comes with the program.";
    OpenBaseMap, "Open base map…", None, "Shows a GeoTIFF of your own under the map: an aerial picture or a chart.";
    CloseBaseMap, "Remove the base map", None, "Removes the picture under the map.";
    OpenIsobathArea, "Open isobath area…", None, "Cuts isobaths, depth areas and spot soundings at a shoreline and its islands: polygons from GeoJSON, KML or GPX.";
    RemoveIsobathArea, "Remove the isobath area", None, "Shows isobaths wherever there are depths.";
    OpenWaterLevels, "Open water levels…", None, "Corrects depths by the readings of a gauge or tide: CSV with time and level_m.";
    RemoveWaterLevels, "Remove the water levels", None, "Removes the readings; depths are corrected by the water level alone.";
    OpenTrack, "Open external track…", None, "Uses the positions of another receiver: CSV with time, lon and lat, or GPX.";
    RemoveTrack, "Remove the external track", None, "Uses the positions of the recorder again.";
    Export, "Export products…", Some("Ctrl+E"), "Writes the chosen products into a folder.";
    ExportLog, "Export the log…", None, "Writes the shown log as XTF, SL2, CSV, Parquet or GPX, with the track, the clock and the sides that the settings give it.";
    ExportPings, "Export the visible pings…", None, "Writes the pings that the waterfall shows as XTF, SL2, CSV, Parquet or GPX.";
    OpenExported, "Open folder", None, "Opens the folder that was written last in the system's file manager.";
    CompareWith, "Compare with…", None, "Compares the points with a reference: points from a file, a GeoTIFF, or another log of the same water.";
    CloseReference, "Close the reference", None, "Compares side-scan with the soundings of the survey again.";
    PrintView, "Print view…", Some("Ctrl+Shift+E"), "Draws a view as a PNG at print resolution, with scales and legend.";
    Quit, "Quit", Some("Ctrl+Q"), "Closes the window.";
    OpenReview, "Open review…", None, "Opens decisions about the boxes of this log.";
    SaveProject, "Save project", Some("Ctrl+S"), "Saves logs, settings and all decisions in the project file; asks for its name the first time.";
    SaveProjectAs, "Save project as…", Some("Ctrl+Shift+S"), "Saves what is open as a project in another file.";
    SaveReview, "Save review", None, "Saves the decisions about boxes in a sidecar file of each log.";
    TakeUpUnsaved, "Restore unsaved decisions", None, "Restores decisions that were not saved when this log was last open.";
    ExportBoxes, "Export boxes…", None, "Writes reviewed boxes for training, and the positions of the objects, into a folder.";
    OpenTruth, "Open known objects…", None, "Opens the objects that are known to lie in this log, to compare boxes with them: a table of objects or a review.";
    ForgetTruth, "Close the known objects", None, "Stops the comparison of boxes with the known objects.";
    Undo, "Undo", Some("Ctrl+Z"), "Reverts the last change.";
    Redo, "Redo", Some("Ctrl+Shift+Z"), "Applies the last reverted change again.";
    History, "History…", Some("Ctrl+H"), "Lists the changes; a click on a step goes back or forward to it.";
    Notices, "Notices…", Some("F9"), "Lists all messages since the program was started, the newest first.";
    Palette, "Run a command…", Some("Ctrl+P"), "Finds a command or a setting by name.";
    Manual, "Manual…", Some("F1"), "Shows the manual, with a search: how to, keys, settings and files.";
    Update, "Update results", Some("Ctrl+R"), "Runs the steps whose results are missing or out of date.";
    Cancel, "Cancel processing", None, "Stops the step that is running; the last result stays.";
    FocusWaterfall, "Waterfall", Some("1"), "Moves the keyboard to the waterfall.";
    FocusMap, "Map", Some("2"), "Moves the keyboard to the map.";
    FocusCloud, "3D cloud", Some("3"), "Moves the keyboard to the 3D cloud.";
    FocusObjects, "Objects", Some("4"), "Moves the keyboard to the table of objects; Up and Down select a row, Enter zooms to the object.";
    FullScreen, "Full screen", Some("F11"), "Shows the window on the whole screen; F11 or Escape ends it.";
    Maximise, "Maximise view", Some("Shift+F11"), "Shows the focused view alone, or all views again.";
    FocusPanels, "Keyboard to the panels", Some("F6"), "Moves the keyboard to the left panel, then to the right panel, then back to the views.";
    StepsPanel, "Panel of steps on or off", Some("F7"), "Shows or hides the left panel: the survey and the processing steps.";
    DetailsPanel, "Panel of details on or off", Some("F8"), "Shows or hides the right panel: review, selection and profile.";
    LayoutSurvey, "Layout: survey", None, "Waterfall above, map and 3D cloud below.";
    LayoutReview, "Layout: review", None, "A large waterfall above, map and 3D cloud below.";
    LayoutWaterfall, "Layout: waterfall only", None, "Shows the waterfall alone.";
    LayoutMap, "Layout: map only", None, "Shows the map alone.";
    LayoutCloud, "Layout: 3D cloud only", None, "Shows the 3D cloud alone.";
    Fit, "Fit view", Some("F"), "Shows everything in the focused view.";
    ZoomIn, "Zoom in", Some("+"), "Enlarges the focused view.";
    ZoomOut, "Zoom out", Some("-"), "Reduces the focused view.";
    TopView, "3D: from above", Some("7"), "Looks down on the cloud.";
    SideView, "3D: from the south", Some("8"), "Looks at the cloud from the side.";
    NextCloudColour, "3D: next colours", Some("Shift+C"), "Colours the points by side, depth, echo level or slant range, or by log where there are several.";
    Bottom3d, "3D: bottom on or off", Some("Shift+V"), "Shows or hides the depth map in 3D as a shaded surface.";
    NextBottomColour, "3D: next colours of the bottom", Some("Shift+M"), "Colours the bottom in 3D by depth, mosaic, uncertainty, distance to the nearest depth, source of the depth, or hardness.";
    BottomIsobaths, "3D: isobaths on or off", None, "Shows or hides isobaths on the bottom in 3D.";
    TurnLight, "3D: turn the light", Some("Shift+L"), "Turns the light on the bottom clockwise by 45 degrees.";
    Points3d, "3D: points on or off", Some("Shift+P"), "Shows or hides the points in 3D.";
    ClipBox3d, "3D: clip box on or off", Some("Shift+X"), "Shows only what lies in a box; its faces can be dragged, its ends typed.";
    Cut3d, "3D: cross-section on or off", Some("Shift+Q"), "Hides what lies in front of the line of the depth profile.";
    Water3d, "3D: water surface on or off", Some("Shift+W"), "Shows or hides the water surface in 3D, with the boat's track on it.";
    LevelsReset, "Reset waterfall levels", None, "Resets gain, filters and levels of this log's waterfall.";
    GainNormalised, "Gain normalised or as recorded", Some("Y"), "Divides the levels of the waterfall by the mean of the log at the same range and angle, or shows them as recorded.";
    StripeFilter, "Stripe filter on or off", None, "Brings pings that are brighter or darker than their neighbours to the level of these.";
    Despeckle, "Despeckle on or off", None, "Shows each echo of the waterfall as the median of its neighbourhood.";
    GroundRange, "Slant or ground range", Some("G"), "Shows the waterfall by slant range, or by distance on level ground.";
    WaterColumn, "Water column on or off", Some("Shift+G"), "Shows or hides echoes before the first return; by distance on the ground there are none.";
    OneToOne, "Waterfall: equal scales", Some("Z"), "Shows a metre along the track as long as a metre across, or lets the two scales differ.";
    NextChannel, "Next channel of the waterfall", Some("I"), "Shows side-scan, then each down-looking channel of the log, beside the side-scan and alone.";
    FlipAlong, "Flip the waterfall along the track", None, "Draws later pings to the left, or above.";
    StarboardFirst, "Draw starboard first", None, "Draws starboard in the place of port, for the picture alone; the data stay as they are.";
    SwapSides, "Exchange port and starboard", Some("Shift+S"), "Takes what was recorded as port for starboard, in every view and product: for a recorder with exchanged sides.";
    UseMounting, "Make the mounting the default", None, "Makes the mounting of this log the default of its recorder; it applies to the other open logs of that recorder and to those opened later.";
    ForgetMounting, "Remove the default mounting", None, "Removes the default; open logs keep their mounting.";
    RangeLines, "Range lines on or off", None, "Shows or hides the range lines of the waterfall.";
    BaseMapLayer, "Layer: base map", None, "Shows or hides your own picture under the map.";
    DepthMapLayer, "Layer: depth map", None, "Shows or hides the interpolated depths on the map.";
    HillShadeLayer, "Layer: hill-shade", None, "Shows or hides the relief, lit from the side, on the map.";
    MosaicLayer, "Layer: mosaic", None, "Shows or hides the side-scan mosaic on the map.";
    IsobathLayer, "Layer: isobaths", None, "Shows or hides the isobaths on the map.";
    PointLayer, "Layer: points", None, "Shows or hides the points of the cloud on the map.";
    ResidualLayer, "Layer: residuals", None, "Shows or hides the difference of each point from a reference.";
    TrackLayer, "Layer: track", None, "Shows or hides the boat's track on the map.";
    BoxLayer, "Layer: boxes", None, "Shows or hides the objects on the map.";
    Boxes, "Boxes on or off", Some("Shift+B"), "Shows or hides all boxes in the waterfall, on the map and in 3D.";
    SideColours, "Side colours: paper or maritime", None, "Draws starboard red and port blue (as the paper), or port red and starboard green.";
    Swipe, "Swipe between layers", Some("W"), "Divides the map by a line that can be dragged: mosaic to the left, depths to the right.";
    Graticule, "Graticule on or off", None, "Shows or hides coordinate lines on the map.";
    CoordinatesDegrees, "Coordinates: decimal degrees", None, "Writes positions as 36.877100° N 111.516300° W.";
    CoordinatesMinutes, "Coordinates: degrees and minutes", None, "Writes positions as 36° 52.6260' N 111° 30.9780' W.";
    CoordinatesSeconds, "Coordinates: degrees, minutes and seconds", None, "Writes positions as 36° 52' 37.56\" N 111° 30' 58.68\" W.";
    CoordinatesUtm, "Coordinates: UTM metres", None, "Writes positions as UTM 12N 453987.7 E 4081363.2 N, in the zone of the survey's start.";
    UnitsMetres, "Units: metres", None, "Writes lengths, depths and areas in metres.";
    UnitsFeet, "Units: feet", None, "Writes lengths, depths and areas in feet.";
    UnitsFathoms, "Units: fathoms", None, "Writes lengths and depths in fathoms of six feet, areas in feet.";
    SpeedMetres, "Speeds: metres a second", None, "Writes speeds in metres per second.";
    SpeedKnots, "Speeds: knots", None, "Writes speeds in knots.";
    Play, "Play or pause", Some("Space"), "Moves along the survey ping by ping, or stops.";
    PlayFaster, "Play faster", Some("Ctrl+Up"), "Plays faster, up to 30 times the speed of the boat.";
    PlaySlower, "Play slower", Some("Ctrl+Down"), "Plays more slowly, down to the speed of the boat.";
    PreviousPing, "Previous ping", Some("Left"), "Selects the ping before.";
    NextPing, "Next ping", Some("Right"), "Selects the ping after.";
    Back25, "Back 25 pings", Some("Shift+Left"), "Selects the ping 25 earlier.";
    Forward25, "Forward 25 pings", Some("Shift+Right"), "Selects the ping 25 later.";
    FirstPing, "First ping", Some("Home"), "Selects the first ping.";
    LastPing, "Last ping", Some("End"), "Selects the last ping.";
    NextPass, "Next pass over the selected place", Some("Shift+T"), "Shows the selected place in the next pass that saw it, in any visible log.";
    ThresholdDown, "Lower the threshold", Some("["), "Lowers the threshold by 0.01.";
    ThresholdUp, "Raise the threshold", Some("]"), "Raises the threshold by 0.01.";
    FirstReturnLine, "First return on or off", Some("B"), "Shows or hides the first return in the waterfall.";
    DepthLine, "Recorded depth on or off", Some("Ctrl+B"), "Shows or hides the recorded depth in the waterfall.";
    FindObjects, "Find objects", None, "Searches the side-scan of all visible logs with the detector; decisions about boxes stay.";
    ChooseModel, "Choose a model…", None, "Uses a detector of your own: YOLO in the ONNX format.";
    ShippedModel, "Use the shipped model", None, "Uses the detector that comes with the program.";
    NextBox, "Next box", Some("Tab"), "Selects the next box of the queue; after the last box of a log, the first of the next log.";
    PreviousBox, "Previous box", Some("Shift+Tab"), "Selects the previous box of the queue.";
    AcceptBox, "Accept box", Some("A"), "Marks the box as an object, and selects the next undecided box.";
    RejectBox, "Reject box", Some("R"), "Marks the box as no object, and selects the next undecided box.";
    UndecideBox, "Mark as undecided", Some("U"), "Removes the decision about the selected box.";
    AcceptObject, "Accept object", Some("Shift+A"), "Accepts all boxes that show this object, in all logs, and selects the next undecided box.";
    RejectObject, "Reject object", Some("Shift+R"), "Rejects all boxes that show this object, in all logs, and selects the next undecided box.";
    UndecideObject, "Mark object as undecided", Some("Shift+U"), "Removes the decisions about all boxes that show this object, in all logs.";
    NextSighting, "Next sighting", Some("J"), "Shows the next box of the same object, in any log.";
    FlyToBox, "Fly to the box", Some("Shift+F"), "Zooms to the selected box in the waterfall, on the map and in 3D.";
    ZoomToBoxes, "Zoom to boxes on or off", Some("Shift+Z"), "Shows each next box of the queue at one sample per screen point, or at the scale that the waterfall has.";
    NameBox, "Name the box", Some("F2"), "Moves the keyboard to the name of the selected box; Enter keeps the name, Tab goes to class and remarks.";
    NextMistake, "Next mistake", Some("."), "Shows the next false alarm or missed object; known objects must be open.";
    PreviousMistake, "Previous mistake", Some(","), "Shows the previous false alarm or missed object.";
    EditBox, "Edit box", Some("E"), "Drag or arrow keys move the selected box, Ctrl with arrows its right and lower edges; a drag at an edge moves that edge.";
    NextEdge, "Next edge of the box", Some("Shift+E"), "Chooses what the arrow keys move: near edge, border of echo and shadow, end of the shadow, first ping, last ping, or the box.";
    FindEdges, "Find the edges of the box", None, "Removes the edges that were set by hand, and finds echo and shadow in the box again.";
    NewBox, "New box", Some("N"), "The next drag in the waterfall draws a box.";
    MarkTarget, "Mark target", Some("T"), "Marks a point without size: the next click in the waterfall, or T again at the pointer, the cross or the selected place.";
    SwapSide, "Swap the side of the box", Some("S"), "Moves the selected box from port to starboard, or from starboard to port.";
    RemoveBox, "Remove box", Some("Delete"), "Removes a box that was drawn; rejects a box that a detector proposed.";
    DrawBottom, "Draw the bottom", Some("M"), "Drag in the waterfall to draw the first return. Ctrl: mark as missing. Alt: restore the automatic pick. Up and Down move it at the selected ping.";
    BottomBothSides, "Draw the bottom on both sides", None, "Draws the bottom on both sides at the same ranges.";
    AcceptBottom, "Accept as bottom", None, "Drag along first returns above the recorded depth to accept them as bottom. Alt: undo the acceptance.";
    ForgetBottom, "Remove the bottom edits", None, "Removes all bottom edits of this log; the first returns are the automatic ones again.";
    Exclude, "Exclude stretches", Some("K"), "Drag along the waterfall or a track to exclude pings from all products. Ctrl: always include. Shift: trust the soundings, too. Alt: reset. A click includes a stretch again.";
    IncludeAgain, "Include the stretch again", Some("Shift+K"), "Includes the excluded stretch at the selected ping again.";
    TrustSoundings, "Trust the soundings", None, "Counts the soundings around the selected ping that were taken for those of a lost bottom or for a fault of the sounder.";
    LeaveTool, "Put the tool away", Some("Escape"), "Puts the tool away; without a tool, deselects the box or removes the measurement.";
    MeasureDistance, "Measure distance", Some("D"), "Click corners on the map or the waterfall to measure a length on the ground.";
    MeasureArea, "Measure area", Some("Shift+D"), "Click corners on the map or the waterfall to measure area and perimeter on the ground.";
    DepthProfile, "Depth profile along a line", Some("P"), "Click corners on the map to see the depths along a line.";
    HeightFromShadow, "Height from shadow", Some("H"), "Drag in the waterfall from the top of the object to the end of its shadow to measure its height.";
    UseShadow, "Use as the box's height", Some("Shift+H"), "Gives the measured height to the selected box, or to the box of the shadow; again, removes it.";
    SetCorner, "Set a corner", Some("X"), "Sets a corner of the measurement at the pointer, or at the cross that the arrow keys move.";
    TakeCornerBack, "Remove the last corner", Some("Backspace"), "Removes the last corner of the measurement.";
    EndFigure, "End the measurement", Some("Enter"), "Ends the line or the area; the next corner begins another.";
    RemoveFigure, "Remove the measurement", None, "Removes the measurement.";
    SaveFigure, "Save the measurement…", None, "Writes the measurement as GeoJSON, or its corners (the depths of a profile) as CSV.";
    SaveProfile, "Save the depth profile…", None, "Writes distance, position and depth along the line as CSV.";
    CopyProfile, "Copy the depth profile", None, "Copies distance, position and depth along the line as CSV.";
    PlanLines, "Plan lines", Some("Shift+N"), "Proposes survey lines where they reduce the uncertainty most, in the given time; their ends can be dragged on the map.";
    RemoveLine, "Remove the planned line", None, "Removes the planned line that was clicked on the map.";
    RemovePlan, "Remove the planned lines", None, "Removes all planned lines.";
    SavePlan, "Save the planned lines…", None, "Writes the planned lines for a plotter or an autopilot: GPX, KML, .plan (QGroundControl) or .waypoints (Mission Planner).";
    ApplyHeights, "Apply heights", None, "Levels the logs: adds the height offsets that crossings show to their elevations (height_offset_m).";
    LeaveOutContradicted, "Leave out contradicted soundings", None, "Excludes the soundings that other logs show to be false.";
    ComparePositions, "Compare positions", None, "Finds from crossings over slopes how far the positions of each log are off, and how late they are.";
    ApplyPositions, "Apply positions", None, "Applies shifts (position_shift) and latencies (mounting.latency_s) that exceed twice their standard error.";
    ApplySoundingLag, "Apply the sounding lag", None, "Takes soundings as much earlier as the first returns show them to be late (mounting.sounding_lag_s).";
    Calibrate, "Calibrate on a stretch", Some("C"), "Drag along the waterfall or the track, or click a numbered stretch, to propose a stretch for the scale; nothing changes yet.";
    UseScale, "Use this scale", None, "Scales the slant ranges of this log by the proposed stretch; its depths change.";
    KeepRecordedRange, "Keep the recorded range", None, "Uses the range that the recorder wrote, and drops the proposed stretch.";
    DropProposal, "Drop the proposed stretch", None, "Drops the proposed stretch; the scale stays as it is.";
    UseFlatterStretch, "Use the flatter stretch", None, "Scales the slant ranges by the flatter stretch that was found while the log is followed.";
    OutlierPreview, "Outlier preview", Some("O"), "Shows the points that the depth map does not use: outliers, above-bottom returns and others.";
    Theme, "Light or dark", Some("L"), "Switches between the light and the dark theme.";
    Orientation, "Turn the waterfall", Some("V"), "Draws time to the right, or downward.";
    PresetRecommended, "Preset: recommended", None, "Takes the settings that measure best on surveys of known truth.";
    PresetPublished, "Preset: published", None, "Takes the paper's settings to the digit.";
}

impl Action {
    /// Returns a sentence that describes the command.
    pub fn hint(self) -> &'static str {
        static OPEN: LazyLock<String> = LazyLock::new(|| {
            let plain = Action::Open.plain_hint().trim_end_matches('.');
            format!("{plain}: {}.", formats_to_open())
        });
        match self {
            Action::Open => &OPEN,
            _ => self.plain_hint(),
        }
    }

    /// A second key for it, where other programs have another one for the same, or the key is
    /// another one on many keyboards.
    pub(crate) fn second_key(self) -> Option<Keys> {
        match self {
            Action::Palette => Some("Ctrl+K"),
            // A digit names the class of the selected box.
            Action::FocusObjects => Some("Ctrl+T"),
            // On many keyboards + is = with Shift.
            Action::ZoomIn => Some("="),
            _ => None,
        }
    }

    /// All its keys, the one that menus show first.
    pub fn all_keys(self) -> impl Iterator<Item = Keys> {
        self.keys().into_iter().chain(self.second_key())
    }

    /// Returns `true` where a held key repeats the action: stepping, undo and redo. All others act
    /// once a press; a held A would otherwise accept box after box before any was looked at.
    pub(crate) fn repeats(self) -> bool {
        matches!(
            self,
            Action::ZoomIn
                | Action::ZoomOut
                | Action::PreviousPing
                | Action::NextPing
                | Action::Back25
                | Action::Forward25
                | Action::ThresholdDown
                | Action::ThresholdUp
                | Action::NextBox
                | Action::PreviousBox
                | Action::NextSighting
                | Action::NextMistake
                | Action::PreviousMistake
                | Action::TakeCornerBack
                | Action::Undo
                | Action::Redo
        )
    }
}

#[cfg(test)]
mod tests {
    use super::Action;
    use std::collections::HashMap;

    #[test]
    fn no_two_actions_share_a_key() {
        let mut taken = HashMap::new();
        for action in Action::ALL {
            for keys in action.all_keys() {
                let other = taken.insert(keys, action.label());
                assert_eq!(other, None, "{keys} is {} and {other:?}", action.label());
            }
        }
    }
}
