//! Defines the rows of the commands: name, keys, hint and function of each command in one place.
//!
//! A row is `Variant, label, ..., hint => function;`. The keys come before the hint (`key`,
//! beginning with the key that menus show), then the views in which a bare key acts (`acts_in`),
//! and the marks: `repeats` while the key is held, `about_box` for commands that need a visible
//! selected box, `asks` for commands that a bare key only offers. The function is `State` on the
//! state, `Settings` on the settings of the shown log, `Options` on the display options, `Toggle`
//! of a display option, with the name that its checkboxes have, or `Window` for the window; `when`
//! is false where there is nothing to act on.
//!
//! The rows are a macro, so that the table of names (`super::Action`) does not depend on the state:
//! each macro that reads the rows uses only its part of them.

/// Passes the rows of all commands, in the order of the manual, to a macro.
macro_rules! action_rows {
    ($reader:ident) => {
        $reader! {
            /// Logs that are opened.
            File {
                Open, "Open survey…", key("Ctrl+O"), "Opens one log, or several logs as one survey."
                    => Window(WindowAction::OpenLogs);
                OpenFolder, "Open folder…", "Opens all logs of a folder as one survey."
                    => Window(WindowAction::OpenFolder);
                OpenPath, "Open path…", key("Ctrl+Shift+P"), "Opens a log by its path: file or folder."
                    => Window(WindowAction::OpenPath);
                AddLog, "Add survey…", key("Ctrl+Shift+O"), "Adds a log to those that are open: one map, one cloud, one set of products."
                    => Window(WindowAction::AddLogs);
            }
            /// The project file.
            Project {
                SaveProject, "Save project", key("Ctrl+S"), "Saves logs, settings and all decisions in the project file; asks for its name the first time."
                    => Window(WindowAction::SaveProject);
                SaveProjectAs, "Save project as…", key("Ctrl+Shift+S"), "Saves what is open as a project in another file."
                    => Window(WindowAction::SaveProjectAs);
            }
            /// The shown log among the open ones.
            ShownLog {
                FollowRecording, "Follow recording", key("Ctrl+L"), "Shows new pings of this log while the recorder writes them. Press it again to stop and to read the whole log."
                    => State(App::toggle_following);
                ShowTogether, "Show all logs together", "Shows every open log on one map, also those far from the others and those too short."
                    => State(App::show_together), when(|app| app.logs.all().any(|log| log.apart.is_some()));
                CloseLog, "Close this log", key("Ctrl+W"), "Closes the log in the waterfall; the other logs stay open, and undo opens it again."
                    => State(|app| app.close_log(app.logs.shown.id));
            }
            /// The other open logs.
            OtherLogs {
                NextLog, "Next log", key("Ctrl+PageDown"), "Shows the next log of the list in waterfall, profile and panels."
                    => State(|app| app.step_log(1));
                PreviousLog, "Previous log", key("Ctrl+PageUp"), "Shows the previous log of the list in waterfall, profile and panels."
                    => State(|app| app.step_log(-1));
            }
            /// Further files that the map is drawn with.
            MapFiles {
                OpenBaseMap, "Open base map…", "Shows a GeoTIFF of your own under the map: an aerial picture or a chart."
                    => Window(WindowAction::OpenBaseMap);
                CloseBaseMap, "Remove the base map", "Removes the picture under the map."
                    => State(App::close_base_map), when(|app| app.map.base_map.is_some());
                OpenIsobathArea, "Open isobath area…", "Cuts isobaths, depth areas and spot soundings at a shoreline and its islands: polygons from GeoJSON, KML or GPX."
                    => Window(WindowAction::OpenIsobathArea);
                RemoveIsobathArea, "Remove the isobath area", "Shows isobaths wherever there are depths."
                    => State(App::remove_isobath_area), when(|app| app.logs.shown.settings.isobaths.clip.is_some());
            }
            /// Recordings of other instruments over the open survey.
            External {
                OpenWaterLevels, "Open water levels…", "Corrects depths by the readings of a gauge or tide: CSV with time and level_m."
                    => Window(WindowAction::OpenWaterLevels), when(|app| app.logs.shown.survey.is_some());
                RemoveWaterLevels, "Remove the water levels", "Removes the readings; depths are corrected by the water level alone."
                    => Settings("water levels", |settings| settings.water_level = Default::default()), when(|app| app.logs.shown.settings.water_level.file.is_some());
                OpenTrack, "Open external track…", "Uses the positions of another receiver: CSV with time, lon and lat, or GPX."
                    => Window(WindowAction::OpenTrack), when(|app| app.logs.shown.survey.is_some());
                RemoveTrack, "Remove the external track", "Uses the positions of the recorder again."
                    => Settings("external track", |settings| settings.track = Default::default()), when(|app| app.logs.shown.settings.track.file.is_some());
            }
            /// Copies of the shown log.
            LogCopies {
                ExportLog, "Export the log…", "Writes the shown log as XTF, SL2, CSV, Parquet or GPX, with the track, the clock and the sides that the settings give it."
                    => Window(WindowAction::ExportLog), when(|app| app.logs.shown.survey.is_some());
                ExportPings, "Export the visible pings…", "Writes the pings that the waterfall shows as XTF, SL2, CSV, Parquet or GPX."
                    => Window(WindowAction::ExportPings), when(|app| app.logs.shown.survey.is_some());
            }
            /// Products and pictures.
            Export {
                Export, "Export products…", key("Ctrl+E"), "Writes the chosen products into a folder."
                    => Window(WindowAction::Export), when(|app| app.logs.shown.products.is_some());
                PrintView, "Print view…", key("Ctrl+Shift+E"), "Draws a view as a PNG at print resolution, with scales and legend."
                    => Window(WindowAction::PrintView), when(|app| app.logs.shown.products.is_some());
            }
            /// The folder that was written last.
            Exported {
                OpenExported, "Open folder", "Opens the folder that was written last in the system's file manager."
                    => Window(WindowAction::OpenExported), when(|app| app.written_into.is_some());
            }
            /// The end of the program.
            Quit {
                Quit, "Quit", key("Ctrl+Q"), "Closes the window."
                    => Window(WindowAction::Quit);
            }
            /// Undo and redo.
            Undo {
                Undo, "Undo", key("Ctrl+Z"), repeats(), "Reverts the last change."
                    => State(App::undo);
                Redo, "Redo", key("Ctrl+Shift+Z"), repeats(), "Applies the last reverted change again."
                    => State(App::redo);
            }
            /// The list of changes.
            History {
                History, "History…", key("Ctrl+H"), "Lists the changes; a click on a step goes back or forward to it."
                    => Window(WindowAction::History);
            }
            /// The demo, commands, messages and the manual.
            Help {
                OpenDemo, "Open the demo survey", "Opens the simulated pond that comes with the program."
                    => State(|app| app.load([LogOrigin::Demo].into_iter(), OpenMode::Instead));
                Tour, "Tour of the six steps", "Opens the demo survey unless a survey is open, and says in a sentence what each step is for."
                    => State(App::start_tour);
                EndTour, "End the tour", "Ends the tour of the six steps."
                    => State(|app| app.view.has_tour = false), when(|app| app.view.has_tour);
                Palette, "Run a command…", key("Ctrl+P"), key("Ctrl+K"), "Finds a command or a setting by name."
                    => Window(WindowAction::Palette);
                Notices, "Notices…", key("F9"), "Lists all messages since the program was started, the newest first."
                    => Window(WindowAction::Notices);
                Manual, "Manual…", key("F1"), "Shows the manual, with a search: how to, keys, settings and files."
                    => Window(WindowAction::Manual);
            }
            /// Steps of the work, in working order.
            WorkSteps {
                StepLogs, "Step 1: Logs", key("Alt+1"), "Opens the step in which logs are opened, listed and compared in height."
                    => Window(WindowAction::OpenStep(WorkStep::Logs));
                StepBottom, "Step 2: Bottom", key("Alt+2"), "Opens the step in which the first return of the bottom is found and edited."
                    => Window(WindowAction::OpenStep(WorkStep::Bottom));
                StepCorrect, "Step 3: Calibrate and correct", key("Alt+3"), "Opens the step of scale, draft, water level, sound speed, positions, mounting and excluded stretches."
                    => Window(WindowAction::OpenStep(WorkStep::Correct));
                StepMap, "Step 4: Map", key("Alt+4"), "Opens the step of depth map, isobaths, mosaic, outliers and survey planning."
                    => Window(WindowAction::OpenStep(WorkStep::Map));
                StepObjects, "Step 5: Objects", key("Alt+5"), "Opens the step in which objects are found."
                    => Window(WindowAction::OpenStep(WorkStep::Objects));
                StepExport, "Step 6: Check and export", key("Alt+6"), "Opens the step in which the points are compared with soundings, and files are written."
                    => Window(WindowAction::OpenStep(WorkStep::Export));
            }
            /// Keyboard to a view, by a digit.
            Focus {
                FocusWaterfall, "Waterfall", key("1"), acts_in(KeyScope::Boxes), "Moves the keyboard to the waterfall."
                    => Window(WindowAction::Focus(View::Waterfall));
                FocusMap, "Map", key("2"), acts_in(KeyScope::Boxes), "Moves the keyboard to the map."
                    => Window(WindowAction::Focus(View::Map));
                FocusCloud, "3D cloud", key("3"), acts_in(KeyScope::Boxes), "Moves the keyboard to the 3D cloud."
                    => Window(WindowAction::Focus(View::Cloud));
            }
            /// Arrangement of the views.
            Layout {
                LayoutSurvey, "Layout: survey", "Waterfall above, map and 3D cloud below."
                    => Window(WindowAction::Arrange(LayoutPreset::Survey));
                LayoutReview, "Layout: review", "A large waterfall above, profile and map below."
                    => Window(WindowAction::Arrange(LayoutPreset::Review));
                LayoutLargeMap, "Layout: map", "A large map, with 3D cloud and waterfall beside it."
                    => Window(WindowAction::Arrange(LayoutPreset::Map));
                LayoutObjects, "Layout: objects", "Waterfall above, table of objects and map below."
                    => Window(WindowAction::Arrange(LayoutPreset::Objects));
                LayoutWaterfall, "Layout: waterfall only", "Shows the waterfall alone."
                    => Window(WindowAction::Arrange(LayoutPreset::Only(View::Waterfall)));
                LayoutMap, "Layout: map only", "Shows the map alone."
                    => Window(WindowAction::Arrange(LayoutPreset::Only(View::Map)));
                LayoutCloud, "Layout: 3D cloud only", "Shows the 3D cloud alone."
                    => Window(WindowAction::Arrange(LayoutPreset::Only(View::Cloud)));
            }
            /// Views, panels and the window.
            Window {
                FocusObjects, "Objects", key("4"), key("Ctrl+T"), acts_in(KeyScope::Boxes), "Moves the keyboard to the table of objects; Up and Down select a row, Enter zooms to the object."
                    => Window(WindowAction::Focus(View::Objects));
                FocusProfile, "Profile", key("5"), acts_in(KeyScope::Boxes), "Moves the keyboard to the profile of the selected ping."
                    => Window(WindowAction::Focus(View::Profile));
                FullScreen, "Full screen", key("F11"), "Shows the window on the whole screen; F11 or Escape ends it."
                    => Window(WindowAction::FullScreen);
                Maximise, "Maximise view", key("Shift+F11"), "Shows the focused view alone, or all views again."
                    => Window(WindowAction::Maximise);
                FocusPanels, "Keyboard to the panels", key("F6"), "Moves the keyboard to the left panel, then to the right panel, then back to the views."
                    => Window(WindowAction::FocusPanels);
                StepsPanel, "Panel of steps on or off", key("F7"), "Shows or hides the left panel: the survey and the processing steps."
                    => Window(WindowAction::StepsPanel);
                DetailsPanel, "Panel of details on or off", key("F8"), "Shows or hides the right panel, which shows what is selected and the review of boxes."
                    => Window(WindowAction::DetailsPanel);
            }
            /// Cameras of the views.
            Camera {
                Fit, "Fit view", key("F"), acts_in(KeyScope::Views), "Shows everything in the focused view."
                    => Window(WindowAction::Fit);
                ZoomIn, "Zoom in", key("+"), key("="), acts_in(KeyScope::Views), repeats(), "Enlarges the focused view."
                    => Window(WindowAction::ZoomIn);
                ZoomOut, "Zoom out", key("-"), acts_in(KeyScope::Views), repeats(), "Reduces the focused view."
                    => Window(WindowAction::ZoomOut);
                TopView, "3D: from above", key("7"), acts_in(KeyScope::Cloud), "Looks down on the cloud."
                    => Window(WindowAction::TopView);
                SideView, "3D: from the south", key("8"), acts_in(KeyScope::Cloud), "Looks at the cloud from the side."
                    => Window(WindowAction::SideView);
            }
            /// Contents of the 3D view.
            Cloud3d {
                NextCloudColour, "3D: next colours", key("Shift+C"), acts_in(KeyScope::Cloud), "Colours the points by side, depth, echo level or slant range, or by log where there are several."
                    => State(|app| app.view.options.cloud.colour = app.view.options.cloud.colour.next(app.logs.count() > 1));
                Points3d, "3D: points on or off", key("Shift+P"), acts_in(KeyScope::Cloud), "Shows or hides the points in 3D."
                    => Toggle("Points", |options| &mut options.cloud.points);
                ClipBox3d, "3D: clip box on or off", key("Shift+X"), acts_in(KeyScope::Cloud), "Shows only what lies in a box; its faces can be dragged, its ends typed."
                    => Options(|options| options.cloud.toggle_clip());
                Cut3d, "3D: cross-section on or off", key("Shift+Q"), acts_in(KeyScope::Cloud), "Hides what lies in front of the line of the depth profile."
                    => State(App::toggle_cut);
                Water3d, "3D: water surface on or off", key("Shift+W"), acts_in(KeyScope::Cloud), "Shows or hides the water surface in 3D, with the boat's track on it."
                    => Toggle("Water surface and track", |options| &mut options.cloud.water);
                Bottom3d, "3D: bottom on or off", key("Shift+V"), acts_in(KeyScope::Cloud), "Shows or hides the depth map in 3D as a shaded surface."
                    => Toggle("Bottom", |options| &mut options.cloud.bottom);
                NextBottomColour, "3D: next colours of the bottom", key("Shift+M"), acts_in(KeyScope::Cloud), "Colours the bottom in 3D by depth, mosaic, uncertainty, distance to the nearest depth, source of the depth, or hardness."
                    => Options(next_bottom_colour);
                BottomIsobaths, "3D: isobaths on or off", "Shows or hides isobaths on the bottom in 3D."
                    => Toggle("Isobaths on the bottom", |options| &mut options.cloud.isobaths);
                TurnLight, "3D: turn the light", key("Shift+L"), acts_in(KeyScope::Cloud), "Turns the light on the bottom clockwise by 45 degrees."
                    => Options(|options| options.cloud.turn_light());
                OutlierPreview, "Outlier preview", key("O"), acts_in(KeyScope::Cloud), "Shows the points that the depth map does not use: outliers, above-bottom returns and others."
                    => Toggle("Outliers", |options| &mut options.cloud.outlier_preview);
            }
            /// Gain, filters and directions of the waterfall.
            Levels {
                LevelsReset, "Reset waterfall levels", "Resets gain, filters and levels of this log's waterfall."
                    => Settings("levels of the waterfall", |settings| settings.picture = settings.picture.reset());
                GainNormalised, "Gain normalised or as recorded", key("Y"), acts_in(KeyScope::Waterfall), "Divides the levels of the waterfall by the mean of the log at the same range and angle, or shows them as recorded."
                    => Settings("gain of the waterfall", |settings| exchange(&mut settings.picture.gain, [Gain::Recorded, Gain::Empirical]));
                StripeFilter, "Stripe filter on or off", "Brings pings that are brighter or darker than their neighbours to the level of these."
                    => Settings("stripe filter", |settings| toggle(&mut settings.picture.stripe_filter));
                Despeckle, "Despeckle on or off", "Shows each echo of the waterfall as the median of its neighbourhood."
                    => Settings("despeckling", |settings| toggle(&mut settings.picture.despeckle));
                FlipAlong, "Flip the waterfall along the track", "Draws later pings to the left, or above."
                    => Settings("direction of the waterfall", |settings| toggle(&mut settings.picture.flip));
                StarboardFirst, "Draw starboard first", "Draws starboard in the place of port, for the picture alone; the data stay as they are."
                    => Settings("side that comes first", |settings| toggle(&mut settings.picture.starboard_first));
            }
            /// Picture of the waterfall.
            WaterfallPicture {
                GroundRange, "Slant or ground range", key("G"), acts_in(KeyScope::Waterfall), "Shows the waterfall by slant range, or by distance on level ground."
                    => Toggle("Ground range", |options| &mut options.waterfall.ground_range);
                WaterColumn, "Water column on or off", key("Shift+G"), acts_in(KeyScope::Waterfall), "Shows or hides echoes before the first return; by distance on the ground there are none."
                    => Toggle("Water column", |options| &mut options.waterfall.water_column);
                OneToOne, "Waterfall: equal scales", key("Z"), acts_in(KeyScope::Waterfall), "Shows a metre along the track as long as a metre across, or lets the two scales differ."
                    => Window(WindowAction::OneToOne);
                NextChannel, "Next channel of the waterfall", key("I"), acts_in(KeyScope::Waterfall), "Shows side-scan, then each down-looking channel of the log, beside the side-scan and alone."
                    => State(|app| app.view.options.waterfall.next_channel(app.logs.shown.survey.as_deref()));
                RangeLines, "Range lines on or off", "Shows or hides the range lines of the waterfall."
                    => Toggle("Range lines", |options| &mut options.waterfall.range_lines);
                FirstReturnLine, "First return on or off", key("B"), acts_in(KeyScope::Waterfall), "Shows or hides the first return in the waterfall."
                    => Toggle("First return", |options| &mut options.waterfall.first_return);
                DepthLine, "Recorded depth on or off", key("Ctrl+B"), "Shows or hides the recorded depth in the waterfall."
                    => Toggle("Recorded depth", |options| &mut options.waterfall.depth_line);
            }
            /// Layers of the map.
            MapLayers {
                BaseMapLayer, "Layer: base map", "Shows or hides your own picture under the map."
                    => Options(|options| options.map.layers.toggle(MapLayer::BaseMap));
                DepthMapLayer, "Layer: depth map", "Shows or hides the interpolated depths on the map."
                    => Options(|options| options.map.layers.toggle(MapLayer::DepthMap));
                HillShadeLayer, "Layer: hill-shade", "Shows or hides the relief, lit from the side, on the map."
                    => Options(|options| options.map.layers.toggle(MapLayer::HillShade));
                MosaicLayer, "Layer: mosaic", "Shows or hides the side-scan mosaic on the map."
                    => Options(|options| options.map.layers.toggle(MapLayer::Mosaic));
                IsobathLayer, "Layer: isobaths", "Shows or hides the isobaths on the map."
                    => Options(|options| options.map.layers.toggle(MapLayer::Isobaths));
                PointLayer, "Layer: points", "Shows or hides the points of the cloud on the map."
                    => Options(|options| options.map.layers.toggle(MapLayer::Points));
                ResidualLayer, "Layer: residuals", "Shows or hides the difference of each point from a reference."
                    => Options(|options| options.map.layers.toggle(MapLayer::Residuals));
                TrackLayer, "Layer: track", "Shows or hides the boat's track on the map."
                    => Options(|options| options.map.layers.toggle(MapLayer::Track));
                BoxLayer, "Layer: boxes", "Shows or hides the objects on the map."
                    => Options(|options| options.map.layers.toggle(MapLayer::Boxes));
                Swipe, "Swipe between layers", key("W"), acts_in(KeyScope::Map), "Divides the map by a line that can be dragged: mosaic to the left, depths to the right."
                    => Options(|options| options.map.swipe.toggle(&mut options.map.layers));
                Graticule, "Graticule on or off", "Shows or hides coordinate lines on the map."
                    => Toggle("Graticule", |options| &mut options.map.graticule);
            }
            /// Colours of port and starboard.
            Colours {
                SideColours, "Side colours: at sea or in the paper", "Draws port red and starboard green as at sea, or port blue and starboard red as in the paper."
                    => Options(|options| exchange(&mut options.side_colours, [SideColours::Paper, SideColours::Maritime]));
            }
            /// Formats of positions.
            Coordinates {
                CoordinatesDegrees, "Coordinates: decimal degrees", "Writes positions as 36.877100° N 111.516300° W."
                    => Options(|options| options.coordinates = CoordinateFormat::Degrees);
                CoordinatesMinutes, "Coordinates: degrees and minutes", "Writes positions as 36° 52.6260' N 111° 30.9780' W."
                    => Options(|options| options.coordinates = CoordinateFormat::Minutes);
                CoordinatesSeconds, "Coordinates: degrees, minutes and seconds", "Writes positions as 36° 52' 37.56\" N 111° 30' 58.68\" W."
                    => Options(|options| options.coordinates = CoordinateFormat::Seconds);
                CoordinatesUtm, "Coordinates: UTM metres", "Writes positions as UTM 12N 453987.7 E 4081363.2 N, in the zone of the survey's start."
                    => Options(|options| options.coordinates = CoordinateFormat::Utm);
            }
            /// Units of lengths and speeds.
            Units {
                UnitsMetres, "Units: metres", "Writes lengths, depths and areas in metres."
                    => Options(|options| options.units.length = LengthUnit::Metres);
                UnitsFeet, "Units: feet", "Writes lengths, depths and areas in feet."
                    => Options(|options| options.units.length = LengthUnit::Feet);
                UnitsFathoms, "Units: fathoms", "Writes lengths and depths in fathoms of six feet, areas in feet."
                    => Options(|options| options.units.length = LengthUnit::Fathoms);
                SpeedMetres, "Speeds: metres a second", "Writes speeds in metres per second."
                    => Options(|options| options.units.speed = SpeedUnit::MetresPerSecond);
                SpeedKnots, "Speeds: knots", "Writes speeds in knots."
                    => Options(|options| options.units.speed = SpeedUnit::Knots);
            }
            /// Direction of the waterfall, and the theme.
            Look {
                Orientation, "Turn the waterfall", key("V"), acts_in(KeyScope::Waterfall), "Draws time to the right, or downward."
                    => Options(|options| exchange(&mut options.waterfall.orientation, [Orientation::Horizontal, Orientation::Vertical]));
                Theme, "Light or dark", key("L"), acts_in(KeyScope::Views), "Switches between the light and the dark theme."
                    => Options(|options| exchange(&mut options.theme, [ThemeChoice::Dark, ThemeChoice::Light]));
            }
            /// Mounting of the recorder of the shown log.
            Mounting {
                SwapSides, "Exchange port and starboard", key("Shift+S"), acts_in(KeyScope::Views), asks(), "Takes what was recorded as port for starboard, in every view and product: for a recorder with exchanged sides."
                    => Settings("sides of the recorder", |settings| toggle(&mut settings.mounting.swap_sides)), when(|app| app.logs.shown.survey.is_some());
                ApplySoundingLag, "Apply the sounding lag", "Takes soundings as much earlier as the first returns show them to be late (mounting.sounding_lag_s)."
                    => State(App::apply_sounding_lag), when(|app| app.logs.shown.sounding_lag().is_some());
                UseMounting, "Make the mounting the default", "Makes the mounting of this log the default of its recorder; it applies to the other open logs of that recorder and to those opened later."
                    => State(App::use_mounting), when(|app| app.logs.shown.survey.is_some());
                ForgetMounting, "Remove the default mounting", "Removes the default; open logs keep their mounting."
                    => State(App::forget_mounting), when(|app| app.usual_mounting().is_some());
            }
            /// Results of the processing.
            Processing {
                Update, "Update results", key("Ctrl+R"), "Runs the steps whose results are missing or out of date."
                    => State(|app| { app.findings.reference_comparison.resume(); app.process(); });
                Cancel, "Cancel processing", "Stops the step that is running; the last result stays."
                    => State(|app| _ = app.cancel());
            }
            /// Settings that belong together.
            Presets {
                PresetRecommended, "Preset: recommended", "Takes the settings that measure best on surveys of known truth."
                    => State(|app| app.use_preset(Preset::Recommended));
                PresetPublished, "Preset: published", "Takes the paper's settings to the digit."
                    => State(|app| app.use_preset(Preset::Published));
            }
            /// First return of the bottom.
            Bottom {
                ThresholdDown, "Lower the threshold", key("["), acts_in(KeyScope::Waterfall), repeats(), "Lowers the threshold by 0.01."
                    => Settings("threshold", |settings| nudge_threshold(settings, -0.01));
                ThresholdUp, "Raise the threshold", key("]"), acts_in(KeyScope::Waterfall), repeats(), "Raises the threshold by 0.01."
                    => Settings("threshold", |settings| nudge_threshold(settings, 0.01));
                DrawBottom, "Draw the bottom", key("M"), acts_in(KeyScope::Waterfall), "Drag in the waterfall to draw the first return. Ctrl: mark as missing. Alt: restore the automatic pick. Up and Down move it at the selected ping."
                    => State(|app| app.take_tool(Tool::Bottom));
                BottomBothSides, "Draw the bottom on both sides", "Draws the bottom on both sides at the same ranges."
                    => Toggle("Both sides", |options| &mut options.waterfall.bottom_both_sides);
                AcceptBottom, "Accept as bottom", "Drag along first returns above the recorded depth to accept them as bottom. Alt: undo the acceptance."
                    => State(|app| app.take_tool(Tool::Accept));
                ForgetBottom, "Remove the bottom edits", "Removes all bottom edits of this log; the first returns are the automatic ones again."
                    => Settings("bottom", |settings| settings.bottom = Default::default()), when(|app| !app.logs.shown.settings.bottom.is_empty());
            }
            /// Scale of the slant ranges.
            Scale {
                Calibrate, "Calibrate on a stretch", key("C"), acts_in(KeyScope::WaterfallAndMap), "Drag along the waterfall or the track, or click a numbered stretch, to propose a stretch for the scale; nothing changes yet."
                    => State(App::take_calibration_tool);
                UseScale, "Use this scale", "Scales the slant ranges of this log by the proposed stretch; its depths change."
                    => State(App::use_scale), when(|app| app.logs.shown.proposed_stretch().is_some());
                UseFlatterStretch, "Use the flatter stretch", "Scales the slant ranges by the flatter stretch that was found while the log is followed."
                    => State(App::use_offered_stretch), when(|app| app.logs.all().any(|log| log.calibrating.offered.is_some()));
                KeepRecordedRange, "Keep the recorded range", "Uses the range that the recorder wrote, and drops the proposed stretch."
                    => State(App::keep_recorded_range), when(|app| app.logs.shown.can_keep_recorded_range());
                DropProposal, "Drop the proposed stretch", "Drops the proposed stretch; the scale stays as it is."
                    => State(|app| app.logs.shown.calibrating.drop_proposal()), when(|app| app.logs.shown.proposed_stretch().is_some());
            }
            /// Stretches and soundings that do not count.
            Exclusions {
                Exclude, "Exclude stretches", key("K"), acts_in(KeyScope::WaterfallAndMap), "Drag along the waterfall or a track to exclude pings from all products. Ctrl: always include. Shift: trust the soundings, too. Alt: reset. A click includes a stretch again."
                    => State(|app| app.take_tool(Tool::Exclude));
                IncludeAgain, "Include the stretch again", key("Shift+K"), acts_in(KeyScope::WaterfallAndMap), "Includes the excluded stretch at the selected ping again."
                    => State(App::include_again);
                TrustSoundings, "Trust the soundings", "Counts the soundings around the selected ping that were taken for those of a lost bottom or for a fault of the sounder."
                    => State(App::trust_soundings);
                LeaveOutContradicted, "Leave out contradicted soundings", "Excludes the soundings that other logs show to be false."
                    => State(App::leave_out_contradicted), when(|app| app.height_offsets().is_some_and(FoundHeights::is_contradicted));
            }
            /// Heights and positions of logs that cross.
            SeveralLogs {
                ApplyHeights, "Apply heights", "Levels the logs: adds the height offsets that crossings show to their elevations (height_offset_m)."
                    => State(App::apply_heights), when(|app| app.height_offsets().is_some());
                ComparePositions, "Compare positions", "Finds from crossings over slopes how far the positions of each log are off, and how late they are."
                    => State(App::match_positions);
                ApplyPositions, "Apply positions", "Applies shifts (position_shift) and latencies (mounting.latency_s) that exceed twice their standard error."
                    => State(App::apply_positions), when(|app| app.findings.positions.as_ref().is_some_and(FoundPositions::tells));
            }
            /// Measurements on the map and in the waterfall.
            Measuring {
                MeasureDistance, "Measure distance", key("D"), acts_in(KeyScope::WaterfallAndMap), "Click corners on the map or the waterfall to measure a length on the ground."
                    => State(|app| app.take_measuring_tool(MeasurementKind::Distance));
                MeasureArea, "Measure area", key("Shift+D"), acts_in(KeyScope::WaterfallAndMap), "Click corners on the map or the waterfall to measure area and perimeter on the ground."
                    => State(|app| app.take_measuring_tool(MeasurementKind::Area));
                DepthProfile, "Depth profile along a line", key("P"), acts_in(KeyScope::WaterfallAndMap), "Click corners on the map to see the depths along a line."
                    => State(|app| app.take_measuring_tool(MeasurementKind::Profile));
                EndFigure, "End the measurement", key("Enter"), acts_in(KeyScope::WaterfallAndMap), "Ends the line or the area; the next corner begins another."
                    => State(App::end_figure);
                TakeCornerBack, "Remove the last corner", key("Backspace"), acts_in(KeyScope::WaterfallAndMap), repeats(), "Removes the last corner of the measurement."
                    => State(App::take_corner_back);
                UseShadow, "Use as the box's height", key("Shift+H"), acts_in(KeyScope::BoxesInWaterfall), "Gives the measured height to the selected box, or to the box of the shadow; again, removes it."
                    => State(App::use_shadow);
                RemoveFigure, "Remove the measurement", "Removes the measurement."
                    => State(App::remove_figure), when(|app| app.map.measuring.figure.is_some());
                SaveFigure, "Save the measurement…", "Writes the measurement as GeoJSON, or its corners (the depths of a profile) as CSV."
                    => Window(WindowAction::SaveFigure);
                SaveProfile, "Save the depth profile…", "Writes distance, position and depth along the line as CSV."
                    => Window(WindowAction::SaveProfile);
                CopyProfile, "Copy the depth profile", "Copies distance, position and depth along the line as CSV."
                    => Window(WindowAction::CopyProfile);
            }
            /// Further commands of the measuring tools.
            MeasuringByKey {
                HeightFromShadow, "Height from shadow", key("H"), acts_in(KeyScope::Waterfall), "Drag in the waterfall from the top of the object to the end of its shadow to measure its height."
                    => State(|app| app.take_measuring_tool(MeasurementKind::Height));
                SetCorner, "Set a corner", key("X"), acts_in(KeyScope::WaterfallAndMap), "Sets a corner of the measurement at the pointer, or at the cross that the arrow keys move."
                    => Window(WindowAction::SetCorner);
                LeaveTool, "Put the tool away", key("Escape"), acts_in(KeyScope::Views), "Puts the tool away; without a tool, deselects the box, removes the measurement or deselects the ping."
                    => State(App::leave_current_tool);
            }
            /// Planned survey lines.
            Planning {
                PlanLines, "Plan lines", key("Shift+N"), acts_in(KeyScope::Map), "Proposes survey lines where they reduce the uncertainty most, in the given time; their ends can be dragged on the map."
                    => State(App::plan_lines);
                RemoveLine, "Remove the planned line", "Removes the planned line that was clicked on the map."
                    => State(App::remove_line), when(|app| app.map.planning.selected.is_some());
                RemovePlan, "Remove the planned lines", "Removes all planned lines."
                    => State(|app| app.set_lines(None, "planned lines")), when(|app| app.map.planning.lines.is_some());
                SavePlan, "Save the planned lines…", "Writes the planned lines for a plotter or an autopilot: GPX, KML, .plan (QGroundControl) or .waypoints (Mission Planner)."
                    => Window(WindowAction::SavePlan), when(|app| app.map.planning.lines.is_some());
            }
            /// Comparison with a reference.
            Comparing {
                CompareWith, "Compare with…", "Compares the points with a reference: points from a file, a GeoTIFF, or another log of the same water."
                    => Window(WindowAction::OpenReference), when(|app| app.logs.shown.products.is_some());
                CloseReference, "Close the reference", "Compares side-scan with the soundings of the survey again."
                    => State(App::leave_reference), when(|app| app.map.comparing.reference.is_some());
            }
            /// Steps along the survey.
            Pings {
                PreviousPing, "Previous ping", key("Left"), acts_in(KeyScope::Views), repeats(), "Selects the ping before."
                    => State(|app| app.step(-1));
                NextPing, "Next ping", key("Right"), acts_in(KeyScope::Views), repeats(), "Selects the ping after."
                    => State(|app| app.step(1));
                Back25, "Back 25 pings", key("Shift+Left"), acts_in(KeyScope::Views), repeats(), "Selects the ping 25 earlier."
                    => State(|app| app.step(-25));
                Forward25, "Forward 25 pings", key("Shift+Right"), acts_in(KeyScope::Views), repeats(), "Selects the ping 25 later."
                    => State(|app| app.step(25));
                FirstPing, "First ping", key("Home"), acts_in(KeyScope::Views), "Selects the first ping."
                    => State(|app| app.step(isize::MIN));
                LastPing, "Last ping", key("End"), acts_in(KeyScope::Views), "Selects the last ping."
                    => State(|app| app.step(isize::MAX));
                NextPass, "Next pass over the selected place", key("Shift+T"), acts_in(KeyScope::Views), "Shows the selected place in the next pass that saw it, in any visible log."
                    => State(App::next_pass);
                Play, "Play or pause", key("Space"), acts_in(KeyScope::Views), "Moves along the survey ping by ping, or stops."
                    => Window(WindowAction::Play);
                PlayFaster, "Play faster", key("Ctrl+Up"), "Plays faster, up to 30 times the speed of the boat."
                    => Window(WindowAction::PlayFaster);
                PlaySlower, "Play slower", key("Ctrl+Down"), "Plays more slowly, down to the speed of the boat."
                    => Window(WindowAction::PlaySlower);
            }
            /// Search for objects.
            Detector {
                FindObjects, "Find objects", "Searches the side-scan of all visible logs with the detector; decisions about boxes stay."
                    => State(App::detect), when(|app| app.logs.shown.products.is_some());
            }
            /// Models of the detector.
            Models {
                ChooseModel, "Choose a model…", "Uses a detector of your own: YOLO in the ONNX format."
                    => Window(WindowAction::OpenModel);
                ShippedModel, "Use the shipped model", "Uses the detector that comes with the program."
                    => State(|app| app.findings.search.use_model(None));
            }
            /// Boxes of the detector and of the analyst.
            Boxes {
                Boxes, "Boxes on or off", key("Shift+B"), acts_in(KeyScope::Views), "Shows or hides all boxes in the waterfall, on the map and in 3D."
                    => State(App::toggle_boxes), when(|app| app.logs.has_boxes());
                NextBox, "Next box", key("Tab"), acts_in(KeyScope::Boxes), repeats(), "Selects the next box of the queue; after the last box of a log, the first of the next log."
                    => State(|app| app.step_box(1)), when(|app| app.logs.has_boxes());
                PreviousBox, "Previous box", key("Shift+Tab"), acts_in(KeyScope::Boxes), repeats(), "Selects the previous box of the queue."
                    => State(|app| app.step_box(-1)), when(|app| app.logs.has_boxes());
                NewBox, "New box", key("N"), acts_in(KeyScope::Waterfall), "The next drag in the waterfall draws a box."
                    => State(|app| app.take_tool(Tool::Draw)), when(|app| app.logs.shown.survey.is_some());
                MarkTarget, "Mark target", key("T"), acts_in(KeyScope::Waterfall), "Marks a point without size: the next click in the waterfall, or T again at the pointer, the cross or the selected place."
                    => State(App::point_tool), when(|app| app.logs.shown.survey.is_some());
            }
            /// Decisions about boxes and objects.
            Decisions {
                AcceptBox, "Accept box", key("A"), acts_in(KeyScope::Boxes), about_box(), "Marks the box as an object, and selects the next undecided box."
                    => State(|app| app.decide(Edit::Accept)), when(|app| app.logs.has_boxes());
                RejectBox, "Reject box", key("R"), acts_in(KeyScope::Boxes), about_box(), "Marks the box as no object, and selects the next undecided box."
                    => State(|app| app.decide(Edit::Reject)), when(|app| app.logs.has_boxes());
                UndecideBox, "Mark as undecided", key("U"), acts_in(KeyScope::Boxes), about_box(), "Removes the decision about the selected box."
                    => State(|app| app.edit_selected(Edit::Undecide)), when(|app| app.logs.has_boxes());
                AcceptObject, "Accept object", key("Shift+A"), acts_in(KeyScope::Boxes), about_box(), "Accepts all boxes that show this object, in all logs, and selects the next undecided box."
                    => State(|app| app.decide_object(Edit::Accept, "accept object")), when(|app| app.logs.has_boxes());
                RejectObject, "Reject object", key("Shift+R"), acts_in(KeyScope::Boxes), about_box(), "Rejects all boxes that show this object, in all logs, and selects the next undecided box."
                    => State(|app| app.decide_object(Edit::Reject, "reject object")), when(|app| app.logs.has_boxes());
                UndecideObject, "Mark object as undecided", key("Shift+U"), acts_in(KeyScope::Boxes), about_box(), "Removes the decisions about all boxes that show this object, in all logs."
                    => State(|app| _ = app.edit_object(Edit::Undecide, "mark object as undecided")), when(|app| app.logs.has_boxes());
            }
            /// The selected box.
            SelectedBox {
                NextSighting, "Next sighting", key("J"), acts_in(KeyScope::Boxes), repeats(), "Shows the next box of the same object, in any log."
                    => State(App::step_sighting), when(|app| app.logs.has_boxes());
                FlyToBox, "Fly to the box", key("Shift+F"), acts_in(KeyScope::Boxes), "Zooms to the selected box in the waterfall, on the map and in 3D."
                    => State(App::fly_to_selected), when(|app| app.logs.has_boxes());
                ZoomToBoxes, "Zoom to boxes on or off", key("Shift+Z"), acts_in(KeyScope::Boxes), "Shows each next box of the queue at one sample per screen point, or at the scale that the waterfall has."
                    => State(App::toggle_zoom_to_boxes), when(|app| app.logs.has_boxes());
                NameBox, "Name the box", key("F2"), "Moves the keyboard to the name of the selected box; Enter keeps the name, Tab goes to class and remarks."
                    => Window(WindowAction::NameBox), when(|app| app.logs.has_boxes());
                EditBox, "Edit box", key("E"), acts_in(KeyScope::BoxesInWaterfall), "Drag or arrow keys move the selected box, Ctrl with arrows its right and lower edges; a drag at an edge moves that edge."
                    => State(|app| app.take_tool(Tool::Edit)), when(|app| app.logs.has_boxes());
                NextEdge, "Next edge of the box", key("Shift+E"), acts_in(KeyScope::BoxesInWaterfall), "Chooses what the arrow keys move: near edge, border of echo and shadow, end of the shadow, first ping, last ping, or the box."
                    => State(App::next_edge), when(|app| app.logs.has_boxes());
                FindEdges, "Find the edges of the box", "Removes the edges that were set by hand, and finds echo and shadow in the box again."
                    => State(|app| app.edit_selected(Edit::FindEdges)), when(|app| app.logs.has_boxes());
                SwapSide, "Swap the side of the box", key("S"), acts_in(KeyScope::BoxesInWaterfall), about_box(), "Moves the selected box from port to starboard, or from starboard to port."
                    => State(|app| app.edit_selected(Edit::SwapSide)), when(|app| app.logs.has_boxes());
                RemoveBox, "Remove box", key("Delete"), acts_in(KeyScope::Boxes), about_box(), "Removes a box that was drawn; rejects a box that a detector proposed."
                    => State(App::remove_box), when(|app| app.logs.has_boxes());
            }
            /// Files of a review.
            ReviewFiles {
                OpenReview, "Open review…", "Opens decisions about the boxes of this log."
                    => Window(WindowAction::OpenReview), when(|app| app.logs.shown.survey.is_some());
                SaveReview, "Save review", "Saves the decisions about boxes in a sidecar file of each log."
                    => Window(WindowAction::SaveReview), when(|app| app.logs.has_boxes());
                ExportBoxes, "Export boxes…", "Writes reviewed boxes for training, and the positions of the objects, into a folder."
                    => Window(WindowAction::ExportBoxes), when(|app| app.logs.has_boxes());
            }
            /// Comparison of boxes with known objects.
            Truth {
                OpenTruth, "Open known objects…", "Opens the objects that are known to lie in this log, to compare boxes with them: a table of objects or a review."
                    => Window(WindowAction::OpenTruth), when(|app| app.logs.shown.survey.is_some());
                ForgetTruth, "Close the known objects", "Stops the comparison of boxes with the known objects."
                    => State(App::forget_truth), when(|app| app.logs.shown.reviewing.judging.source().is_some());
                NextMistake, "Next mistake", key("."), acts_in(KeyScope::Boxes), repeats(), "Shows the next false alarm or missed object; known objects must be open."
                    => State(|app| app.step_mistake(1)), when(|app| app.logs.shown.reviewing.judging.source().is_some());
                PreviousMistake, "Previous mistake", key(","), acts_in(KeyScope::Boxes), repeats(), "Shows the previous false alarm or missed object."
                    => State(|app| app.step_mistake(-1)), when(|app| app.logs.shown.reviewing.judging.source().is_some());
            }
        }
    };
}

pub(in crate::app) use action_rows;
