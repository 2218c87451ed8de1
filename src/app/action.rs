//! The command table: one place for names, hints and keys; menus, palette, key handling and F1 read it.

/// A key combination, as text that the window turns into its own key type: `Ctrl+Shift+Z`, `[`, `F11`.
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

            /// What it does, in a sentence.
            pub fn hint(self) -> &'static str {
                match self { $(Action::$variant => $hint,)* }
            }
        }
    };
}

actions! {
    Open, "Open survey…", Some("Ctrl+O"), "Opens one log or several as one survey: SL2, SL3, Humminbird DAT or SON, XTF.";
    AddLog, "Add survey…", Some("Ctrl+Shift+O"), "Opens a log beside those that are open: one map, one cloud, one set of products.";
    CloseLog, "Close this log", Some("Ctrl+W"), "Closes the log that the waterfall shows; the other logs stay open, and undo opens it again.";
    NextLog, "Next log", Some("Ctrl+PageDown"), "Shows the next log of the list in waterfall, profile and panels.";
    PreviousLog, "Previous log", Some("Ctrl+PageUp"), "Shows the log before it in the list.";
    OpenFolder, "Open folder…", None, "Opens all logs of a folder as one survey.";
    OpenPath, "Open path…", Some("Ctrl+Shift+P"), "Opens a log by its path: file or folder.";
    FollowRecording, "Follow recording", Some("Ctrl+L"), "Shows new pings of this log as the recorder writes them; again, ends it with results of the whole log.";
    OpenDemo, "Open the demo survey", None, "Opens the simulated pond that comes with the program.";
    OpenBaseMap, "Open base map…", None, "Shows a GeoTIFF of your own under the map: an aerial picture or a chart.";
    CloseBaseMap, "Remove the base map", None, "Takes the picture under the map away.";
    OpenIsobathArea, "Open isobath area…", None, "Ends isobaths, the areas between them and spot soundings at a shoreline and its islands: polygons of GeoJSON, KML or GPX.";
    RemoveIsobathArea, "Remove the isobath area", None, "Shows isobaths wherever there are depths again.";
    OpenWaterLevels, "Open water levels…", None, "Takes the readings of a gauge or tide off the depths: CSV with time and level_m.";
    RemoveWaterLevels, "Remove the water levels", None, "Leaves the readings of the water's height again.";
    OpenTrack, "Open external track…", None, "Takes the boat's places from another receiver: CSV with time, lon and lat, or GPX.";
    RemoveTrack, "Remove the external track", None, "Takes the boat's places from the recorder again.";
    Export, "Export products…", Some("Ctrl+E"), "Writes points, track, depth maps, isobaths and mosaic into a folder.";
    CompareWith, "Compare with…", None, "Holds the points against a reference: points of a file, a GeoTIFF, or another log over the same water.";
    CloseReference, "Leave the reference", None, "Compares side-scan with the survey's own soundings again.";
    PrintView, "Print view…", Some("Ctrl+Shift+E"), "Draws a view as a PNG at print resolution, with its scales and legend.";
    Quit, "Quit", Some("Ctrl+Q"), "Closes the window.";
    OpenReview, "Open review…", None, "Opens the decisions about this log's boxes.";
    SaveProject, "Save project", Some("Ctrl+S"), "Writes logs, settings and all decisions into the project's file; asks for its name at first.";
    SaveProjectAs, "Save project as…", Some("Ctrl+Shift+S"), "Keeps what is open as a project in another file.";
    SaveReview, "Save review", None, "Writes the decisions about the boxes into a sidecar file of the log; of several logs each into its own.";
    TakeUpUnsaved, "Take up unsaved decisions", None, "Takes the decisions that were not saved when this log was last open.";
    ExportBoxes, "Export boxes…", None, "Writes the reviewed boxes for training and the objects' places into a folder.";
    OpenTruth, "Open truth…", None, "Opens what is known to lie in this log: a table of objects that was simulated, or a review.";
    ForgetTruth, "Leave the truth", None, "Compares the boxes with no truth any more.";
    Undo, "Undo", Some("Ctrl+Z"), "Takes back the last change of settings or boxes.";
    Redo, "Redo", Some("Ctrl+Shift+Z"), "Applies again what was taken back.";
    History, "History…", Some("Ctrl+H"), "Lists what was changed, step by step; a click on a step goes there, back or forward.";
    Notices, "Notices…", Some("F9"), "Lists what the program has said since it was started, the newest first, with what can be done about it.";
    Palette, "Run a command…", Some("Ctrl+P"), "Finds a command by name.";
    Manual, "Manual…", Some("F1"), "Shows the manual: how to, keys, settings and files, with a search.";
    Update, "Update results", Some("Ctrl+R"), "Runs the steps whose results are missing or older than their settings.";
    Cancel, "Cancel processing", None, "Stops the step that is running; the last result stays.";
    FocusWaterfall, "Waterfall", Some("1"), "Moves the keyboard to the waterfall.";
    FocusMap, "Map", Some("2"), "Moves the keyboard to the map.";
    FocusCloud, "3D cloud", Some("3"), "Moves the keyboard to the 3D cloud.";
    FullScreen, "Full screen", Some("F11"), "Gives the window the whole screen; F11 again, or Escape, gives it back.";
    Maximise, "Maximise view", Some("Shift+F11"), "Gives the whole centre to the focused view, or gives it back.";
    FocusPanels, "Keyboard to the panels", Some("F6"), "Moves the keyboard to the panel of steps, from there to that of details, and back to the views; Tab goes on in a panel, Enter or Space presses.";
    StepsPanel, "Panel of steps on or off", Some("F7"), "Shows or hides the panel left of the views: the survey and the paper's steps.";
    DetailsPanel, "Panel of details on or off", Some("F8"), "Shows or hides the panel right of the views: review, selection and profile.";
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
    NextCloudColour, "3D: next colours", Some("Shift+C"), "Colours the points by side, depth, echo level, slant range, and by log where there are several.";
    Bottom3d, "3D: bottom on or off", Some("Shift+V"), "Shows or hides the depth map as a lit body in 3D.";
    NextBottomColour, "3D: next colours of the bottom", Some("Shift+M"), "Colours the bottom in 3D by depth, by the mosaic, by uncertainty, by the distance to the nearest depth, by what depths rest on, and by hardness.";
    BottomIsobaths, "3D: isobaths on or off", None, "Shows or hides lines of equal depth on the bottom in 3D.";
    TurnLight, "3D: turn the light", Some("Shift+L"), "Lets the light on the bottom come from an eighth of a turn farther clockwise.";
    Points3d, "3D: points on or off", Some("Shift+P"), "Shows or hides the points in 3D.";
    ClipBox3d, "3D: clip box on or off", Some("Shift+X"), "Draws in 3D what lies in a box alone, whose faces are dragged and whose ends are typed.";
    Cut3d, "3D: cross-section on or off", Some("Shift+Q"), "Cuts the 3D view along the line of the depth profile: what stands in front of it is left out.";
    Water3d, "3D: water surface on or off", Some("Shift+W"), "Shows or hides in 3D where the water's surface is, with the boat's track on it.";
    LevelsReset, "Reset waterfall levels", None, "Puts gain, filters and levels of this log's waterfall back.";
    GainNormalised, "Gain normalised or as recorded", Some("Y"), "Divides the levels of the waterfall by the log's own mean at their range and angle, or shows them as recorded.";
    StripeFilter, "Stripe filter on or off", None, "Brings pings of the waterfall that are brighter or darker than those about them to their level.";
    Despeckle, "Despeckle on or off", None, "Shows each echo of the waterfall as the median of those about it.";
    GroundRange, "Slant or ground range", Some("G"), "Shows the waterfall over the slant range, or over the distance on level ground.";
    WaterColumn, "Water column on or off", Some("Shift+G"), "Shows or hides what lies before the first return in the waterfall; on the ground there is none.";
    OneToOne, "Waterfall: one to one", Some("Z"), "A metre along the track as long as a metre across, by the boat's speed; again, stretched freely.";
    NextChannel, "Next channel of the waterfall", Some("I"), "Shows side-scan, then the log's channels that look down: each beside the side-scan and alone.";
    FlipAlong, "Flip the waterfall along the track", None, "Later pings to the left, or above; with starboard first as well, a line that was run back lies as the one beside it.";
    StarboardFirst, "Draw starboard first", None, "Draws starboard where port is and port where starboard is, or the other way round again; the data stay as they are.";
    SwapSides, "Exchange port and starboard", Some("Shift+S"), "The recorder has its sides the wrong way round: what it recorded as port is starboard, in every view and product.";
    UseMounting, "Use the mounting for all logs of this recorder", None, "Keeps how this log's recorder is mounted as its default: other open logs of it take it over, and so does every log of it that is opened for the first time.";
    ForgetMounting, "Forget the mounting of this recorder", None, "Takes its default away; open logs stay as they are.";
    RangeLines, "Range lines on or off", None, "Shows or hides the range lines of the waterfall.";
    BaseMapLayer, "Layer: base map", None, "Shows or hides the picture of your own under the map.";
    DepthMapLayer, "Layer: depth map", None, "Shows or hides the interpolated depths on the map.";
    HillShadeLayer, "Layer: hill-shade", None, "Shows or hides the relief lit from the side on the map.";
    MosaicLayer, "Layer: mosaic", None, "Shows or hides the side-scan mosaic on the map.";
    IsobathLayer, "Layer: isobaths", None, "Shows or hides the lines of equal depth on the map.";
    PointLayer, "Layer: points", None, "Shows or hides the points of the cloud on the map.";
    ResidualLayer, "Layer: residuals", None, "Shows or hides on the map how each point differs from a reference.";
    TrackLayer, "Layer: track", None, "Shows or hides the boat's track on the map.";
    BoxLayer, "Layer: boxes", None, "Shows or hides the objects on the map.";
    Boxes, "Boxes on or off", Some("Shift+B"), "Hides all boxes, in the waterfall, on the map and in 3D, to see what lies under them; again, shows them.";
    SideColours, "Side colours: paper or maritime", None, "Starboard red and port blue, or port red and starboard green.";
    Swipe, "Swipe between layers", Some("W"), "Divides the map: the mosaic left and the depths right of a line that can be dragged.";
    Graticule, "Graticule on or off", None, "Shows or hides the lines of round coordinates on the map.";
    CoordinatesDegrees, "Coordinates: decimal degrees", None, "Writes positions as 36.877100° N 111.516300° W.";
    CoordinatesMinutes, "Coordinates: degrees and minutes", None, "Writes positions as 36° 52.6260' N 111° 30.9780' W.";
    CoordinatesSeconds, "Coordinates: degrees, minutes and seconds", None, "Writes positions as 36° 52' 37.56\" N 111° 30' 58.68\" W.";
    CoordinatesUtm, "Coordinates: UTM metres", None, "Writes positions as UTM 12N 453987.7 E 4081363.2 N, in the zone of the survey's start.";
    UnitsMetres, "Units: metres", None, "Writes lengths, depths and areas in metres.";
    UnitsFeet, "Units: feet", None, "Writes lengths, depths and areas in feet.";
    UnitsFathoms, "Units: fathoms", None, "Writes lengths and depths in fathoms of six feet, areas in feet.";
    SpeedMetres, "Speeds: metres a second", None, "Writes the boat's speed in metres a second.";
    SpeedKnots, "Speeds: knots", None, "Writes the boat's speed in knots.";
    Play, "Play or pause", Some("Space"), "Runs along the survey ping by ping.";
    PlayFaster, "Play faster", Some("Ctrl+Up"), "Runs along the survey faster, up to 30 times as fast as the boat.";
    PlaySlower, "Play slower", Some("Ctrl+Down"), "Runs along the survey more slowly, down to the boat's own pace.";
    PreviousPing, "Previous ping", Some("Left"), "Selects the ping before.";
    NextPing, "Next ping", Some("Right"), "Selects the ping after.";
    Back25, "Back 25 pings", Some("Shift+Left"), "Selects the ping 25 earlier.";
    Forward25, "Forward 25 pings", Some("Shift+Right"), "Selects the ping 25 later.";
    FirstPing, "First ping", Some("Home"), "Selects the first ping.";
    LastPing, "Last ping", Some("End"), "Selects the last ping.";
    NextPass, "Next pass over the selected place", Some("Shift+T"), "Goes from the selected place to the same place in the next pass of the visible logs that saw it.";
    ThresholdDown, "Lower the threshold", Some("["), "Lowers the threshold by 0.01.";
    ThresholdUp, "Raise the threshold", Some("]"), "Raises the threshold by 0.01.";
    FirstReturnLine, "First return on or off", Some("B"), "Shows or hides the first return in the waterfall.";
    DepthLine, "Recorded depth on or off", Some("Ctrl+B"), "Shows or hides the recorded depth in the waterfall.";
    FindObjects, "Find objects", None, "Searches the side-scan of all visible logs with the detector; what was decided about boxes stays.";
    ChooseModel, "Choose a model…", None, "Takes a detector of your own: YOLO as ONNX.";
    ShippedModel, "Use the shipped model", None, "Takes the detector that comes with the program.";
    NextBox, "Next box", Some("Tab"), "Selects the next box in the queue; after the last one of a log, the first of the next log.";
    PreviousBox, "Previous box", Some("Shift+Tab"), "Selects the box before in the queue.";
    AcceptBox, "Accept box", Some("A"), "There is an object: on to the next undecided box.";
    RejectBox, "Reject box", Some("R"), "There is nothing: on to the next undecided box.";
    UndecideBox, "Take the decision back", Some("U"), "Makes the selected box undecided again.";
    AcceptObject, "Accept object", Some("Shift+A"), "There is an object: accepts all boxes that show it, in all logs, and goes on to the next undecided box.";
    RejectObject, "Reject object", Some("Shift+R"), "There is nothing: rejects all boxes that show the object, in all logs, and goes on to the next undecided box.";
    UndecideObject, "Take the decisions on the object back", Some("Shift+U"), "Makes all boxes that show the object undecided again, in all logs.";
    NextSighting, "Next sighting", Some("J"), "Shows the next box of the same object, in whichever log saw it.";
    FlyToBox, "Fly to the box", Some("Shift+F"), "Enlarges the selected box in the waterfall, on the map and in 3D: it fills about a third of each.";
    ZoomToBoxes, "Boxes one to one on or off", Some("Shift+Z"), "Shows each next box of the queue with a sample of the picture to a point of the screen, smaller where it does not fit; or in the scale that the waterfall has.";
    NameBox, "Name the box", Some("F2"), "Moves the keyboard to the name of the selected box; Enter keeps it, Tab goes on to its class and remarks.";
    NextMistake, "Next mistake", Some("."), "Shows the next false alarm or missed object; truth must be known.";
    PreviousMistake, "Previous mistake", Some(","), "Shows the false alarm or missed object before.";
    EditBox, "Edit box", Some("E"), "Drag or the arrow keys move the selected box, Ctrl+arrows its right and lower edges. A drag of an edge moves that edge: of the echo, between echo and shadow, or at the end of the shadow.";
    NextEdge, "Next edge of the box", Some("Shift+E"), "Has the arrow keys move one edge of the selected box: near edge, border of echo and shadow, end of the shadow, first ping, last ping, and then the box again.";
    FindEdges, "Find the edges of the box", None, "Leaves the edges of echo and shadow that were drawn by hand, and has them found in the box again.";
    NewBox, "New box", Some("N"), "The next drag in the waterfall draws a box.";
    MarkTarget, "Mark target", Some("T"), "The next click in the waterfall marks a point: a place without size. T once more marks it at the pointer, at the cross that the arrow keys move, or at the selected place.";
    SwapSide, "Swap the side of the box", Some("S"), "Moves the selected box from port to starboard or back.";
    RemoveBox, "Remove box", Some("Delete"), "Removes a box drawn by hand; rejects one that a model proposed.";
    DrawBottom, "Draw the bottom", Some("M"), "A drag in the waterfall draws the first return, with Ctrl it marks that there is none, with Alt it removes the edit. Up and Down make it shallower and deeper at the selected ping.";
    BottomBothSides, "Draw the bottom on both sides", None, "What is drawn on one side is drawn on the other at the same ranges.";
    ForgetBottom, "Forget the drawn bottom", None, "Takes the first returns that were found again, everywhere.";
    LeaveOut, "Leave stretches out", Some("K"), "A drag along the waterfall, or along a track on the map, leaves its pings out of every product; with Ctrl they count whatever is found there, with Alt nothing is said of them any more. A click on a left-out stretch takes it back in.";
    TakeBackIn, "Take the stretch back in", Some("Shift+K"), "Has the left-out stretch at the selected ping count again.";
    LeaveTool, "Leave the tool", Some("Escape"), "Lays the tool down; without a tool, deselects the box, or else removes the measurement.";
    MeasureDistance, "Measure distance", Some("D"), "Click corners on the map or the waterfall: the length of the line on the ground, slant range taken off.";
    MeasureArea, "Measure area", Some("Shift+D"), "Click corners on the map or the waterfall: area and perimeter on the ground, slant range taken off.";
    DepthProfile, "Depth profile along a line", Some("P"), "Click corners on the map: the depths of the map along the line.";
    HeightFromShadow, "Height from shadow", Some("H"), "Drag in the waterfall from the object's top, where its shadow begins, to the end of the shadow: its height above the bottom.";
    UseShadow, "Use as the box's height", Some("Shift+H"), "The measured shadow tells the height of the selected box, or of the box that it was measured in. Where the box has such a height, it is left for that of the box's own shadow.";
    SetCorner, "Set a corner", Some("X"), "With a measuring tool in hand: a corner at the pointer, or at the cross that the arrow keys move.";
    TakeCornerBack, "Take the last corner back", Some("Backspace"), "Removes the corner that was set last.";
    EndFigure, "End the measurement", Some("Enter"), "Closes the line or the area; the next corner begins another one.";
    RemoveFigure, "Remove the measurement", None, "Takes what was measured away.";
    SaveFigure, "Save the measurement…", None, "Writes what was measured as GeoJSON, or its corners (the depths of a profile) as CSV.";
    SaveProfile, "Save the depth profile…", None, "Writes distance, position and depth along the line as CSV.";
    CopyProfile, "Copy the depth profile", None, "Copies distance, position and depth along the line as CSV.";
    PlanLines, "Plan lines", Some("Shift+N"), "Proposes lines to sail next, where they mend most of the survey in the time of the panel Where to sail next; their ends can be dragged on the map.";
    RemoveLine, "Remove the planned line", None, "Takes the planned line away that was clicked on the map.";
    RemovePlan, "Remove the planned lines", None, "Takes all planned lines away.";
    SavePlan, "Save the planned lines…", None, "Writes the planned lines for a plotter or an autopilot: GPX, KML, .plan (QGroundControl) or .waypoints (Mission Planner).";
    CalibrateHere, "Calibrate here", Some("C"), "Uses the stretch around the selected ping as the flat spot.";
    CalibrationReset, "Calibrate at the flattest stretch", None, "Removes the picked stretch.";
    OutlierPreview, "Outlier preview", Some("O"), "Shows the points that do not count for the map: outliers, above-bottom returns and others.";
    Theme, "Light or dark", Some("L"), "Switches between the light and the dark theme.";
    Orientation, "Turn the waterfall", Some("V"), "Time to the right, or down the screen.";
    PresetRecommended, "Preset: recommended", None, "Takes the settings that measure best on surveys of known truth.";
    PresetPublished, "Preset: published", None, "Takes the paper's settings to the digit.";
}

impl Action {
    /// A second key for it, where other programs have another one for the same, or the key is another one on many keyboards.
    pub fn second_key(self) -> Option<Keys> {
        match self {
            Action::Palette => Some("Ctrl+K"),
            // On many keyboards + is = with Shift.
            Action::ZoomIn => Some("="),
            _ => None,
        }
    }

    /// All its keys, the one that menus show first.
    pub fn all_keys(self) -> impl Iterator<Item = Keys> {
        self.keys().into_iter().chain(self.second_key())
    }

    /// Whether a held key goes on doing it: stepping, and walking through the history. Everything else is done once per press;
    /// a held A would otherwise accept box after box before any of them has been looked at.
    pub fn repeats(self) -> bool {
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
