//! The table of settings: a row a key. Checks, knobs, tooltips, help and manual come from it.
//!
//! Where a range is not that of the quantity's own nature, the reason stands beside it.

use super::table::Control::{Drag, LogSlider, Slider};
use super::table::{Choice, Kind, Named, Number, Numeric, Row, choose, name_of};
use crate::survey::WATER_LEVELS_M;

/// A number in the settings, with all that a row says of it.
macro_rules! number {
    ($($field:ident).+, $unit:literal, [$least:expr, $most:expr], $step:literal, $decimals:literal, $control:ident) => {
        number!($($field).+, $unit, [$least, $most], $step, $decimals, $control, None)
    };
    ($($field:ident).+, $unit:literal, [$least:expr, $most:expr], $step:literal, $decimals:literal, $control:ident, $without:expr) => {
        Kind::Number(Number {
            unit: $unit,
            range: [$least, $most],
            step: $step,
            decimals: $decimals,
            control: $control,
            without: $without,
            get: |settings| Numeric::get(&settings.$($field).+),
            set: |settings, value| Numeric::set(&mut settings.$($field).+, value),
        })
    };
}

/// One of several names: each with its label and what it means.
macro_rules! choice {
    ($($field:ident).+, [$($value:literal, $label:literal, $meaning:literal;)+]) => {
        choice!($($field).+, [$($value, $label, $meaning;)+], "")
    };
    ($($field:ident).+, [$($value:literal, $label:literal, $meaning:literal;)+], $others:literal) => {
        Kind::Choice(Choice {
            others: $others,
            names: &[$(Named { value: $value, label: $label, meaning: $meaning }),+],
            get: |settings| name_of(&settings.$($field).+),
            set: |settings, name| choose(&mut settings.$($field).+, name),
        })
    };
}

/// The rows as statics, each to be named by the panel that shows it, and the list of all.
macro_rules! rows {
    ($($id:ident: $key:literal, $label:literal, $name:literal, $hint:literal, $kind:expr;)+) => {
        $(
            #[doc = concat!("`", $key, "`: ", $hint)]
            pub static $id: Row = Row { key: $key, label: $label, name: $name, hint: $hint, kind: $kind };
        )+
        /// All settings, in the order of the manual. The bottom edits are none: they are made of strokes.
        pub static ROWS: &[&Row] = &[$(&$id),+];
    };
}

rows! {
    PROJECTION: "projection", "Plane", "plane", "The plane that the cloud is built in.",
        choice!(projection, [
            "enu", "local metres", "Metres on the ground, east and north of the first fix.";
            "mercator", "Mercator (published)", "Pseudo-Mercator metres: stretched by 1 / cos(latitude).";
        ]);
    CRS: "crs", "System", "coordinate system", "The coordinate system of GeoTIFF, LAZ, XYZ and shapefiles.",
        choice!(crs, [
            "utm", "UTM", "Metres in the zone of the first fix.";
            "wgs84", "WGS84", "Longitude and latitude, degrees.";
            "web_mercator", "web Mercator", "What maps of the web are drawn in.";
        ], "EPSG:NUMBER");
    // The deepest hulls of survey vessels draw less; what is towed deeper has a depth that changes.
    DRAFT: "draft_m", "Draft", "draft",
        "How deep the transducer hangs below the water's surface: added to every depth.",
        number!(draft_m, "m", [0.0, 20.0], 0.01, 2, LogSlider);
    WATER_LEVEL: "water_level_m", "Water level", "water level",
        "Height of the water over the level that depths should count from: taken off every depth. With readings, the height of their zero.",
        number!(water_level_m, "m", [*WATER_LEVELS_M.start(), *WATER_LEVELS_M.end()], 0.01, 2, Drag);
    WATER_LEVEL_FILE: "water_level.file", "Readings", "readings of the water level",
        "Readings of the water's height over time; the water level above is that of their zero.",
        Kind::Text("a file");
    HEIGHT_OFFSET: "height_offset_m", "Height offset", "height offset",
        "Added to every elevation of the log, so that it agrees with others of its survey where they cross.",
        number!(height_offset_m, "m", [-100.0, 100.0], 0.01, 2, Drag);
    // From ice-cold fresh water to the brine of the Dead Sea and the deepest sea, with room for another unit's mistake to be seen.
    SOUND_SPEED: "sound_speed.m_s", "Sound speed", "sound speed",
        "Speed of sound in this water, as measured.",
        number!(sound_speed.m_s, "m/s", [1300.0, 1800.0], 1.0, 1, Slider, Some("computed from temperature and salinity where the temperature is given, else ranges stay as the recorder computed them"));
    TEMPERATURE: "sound_speed.temperature_c", "Water", "water temperature",
        "Temperature of the water, which with salinity gives the speed of sound (Chen and Millero 1977).",
        number!(sound_speed.temperature_c, "°C", [0.0, 40.0], 0.1, 1, Slider, Some("the speed of sound is not computed"));
    SALINITY: "sound_speed.salinity_psu", "Salinity", "salinity",
        "Practical salinity: 0 in fresh water, 35 in the ocean.",
        number!(sound_speed.salinity_psu, "", [0.0, 40.0], 0.5, 1, Slider);
    SOUND_SPEED_DEPTH: "sound_speed.depth_m", "At depth", "depth of the temperature",
        "Depth that temperature and salinity stand for: half the water's depth where they are the same throughout.",
        number!(sound_speed.depth_m, "m", [0.0, 10_000.0], 0.1, 1, LogSlider);
    // No recorder assumes a speed that its waters do not have: 4600 to 5250 feet a second.
    RECORDER_SPEED: "sound_speed.recorder_m_s", "Recorder", "recorder's sound speed",
        "The speed of sound that the recorder computed ranges with: 1500 m/s in most, 1463 m/s in some for fresh water.",
        number!(sound_speed.recorder_m_s, "m/s", [1400.0, 1600.0], 1.0, 0, Slider);
    SAMPLES: "image.samples", "Image", "image", "What a sample of the picture is.",
        choice!(image.samples, [
            "bytes", "recorded bytes", "One sample a byte.";
            "words", "int32 words (published)", "Four bytes read as one number, as the published code does: 700 columns of 2800.";
        ]);
    METHOD: "first_return.method", "Method", "method", "How the first return is found.",
        choice!(first_return.method, [
            "tracker", "tracker", "The bottom edge as one line, among the samples that reach the threshold.";
            "threshold", "threshold", "The first sample that reaches the threshold, as in the paper.";
        ]);
    THRESHOLD: "first_return.threshold", "Threshold", "threshold",
        "Normalised intensity that a sample must reach to count as a return; the paper uses 0.30. Keys [ and ] in the window.",
        number!(first_return.threshold, "", [0.0, 1.0], 0.01, 2, Slider);
    // The longest pulses ring for a few metres; to ignore more would hide the bottom of the waters that are surveyed.
    DEAD_ZONE: "first_return.dead_zone_m", "Dead zone", "dead zone",
        "Slant range around the transducer that is ignored: its ring-down.",
        number!(first_return.dead_zone_m, "m", [0.0, 10.0], 0.05, 2, LogSlider);
    // On a slope of 45 degrees in 30 m of water the first return comes 9 m early.
    ABOVE_BOTTOM_MARGIN: "first_return.above_bottom_margin_m", "Above bottom", "above-bottom margin",
        "A return nearer than the recorded depth by more than this is flagged as an above-bottom return (weed, fish or another obstacle).",
        number!(first_return.above_bottom_margin_m, "m", [0.0, 10.0], 0.05, 2, LogSlider);
    MIN_CONFIDENCE: "first_return.min_confidence", "Least conf.", "least confidence",
        "The point of a first return that is less sure than this is not kept. Confidence is the chance that a return lies within 25 cm of the nearest ground, as measured on simulated ponds.",
        number!(first_return.min_confidence, "", [0.0, 1.0], 0.05, 2, Slider);
    BOTTOM_LINE: "first_return.bottom_line", "Bottom line", "bottom line",
        "Which bottom water column, ground range, gain and mosaic follow. Points and calibration are those of the first returns, whatever the line; bottom edits stay on top.",
        choice!(first_return.bottom_line, [
            "search", "first return", "The first return of each side.";
            "recorded", "recorded depth", "The recorder's own depth, the same on both sides; the first return where the recorder had lost the bottom.";
        ]);
    SCALE: "calibration.mode", "Scale", "scale", "Which scale turns samples into metres.",
        choice!(calibration.mode, [
            "header", "recorded range", "The range that the recorder states for each ping.";
            "flat_spot", "flat spot (PPD)", "Pixels per metre measured at a flat stretch, PPD = p / d.";
        ]);
    FLAT_SPOT: "calibration.pings", "Flat spot", "flat spot",
        "Side-scan pings that PPD is measured on, B left out. Without any, the best-ranked flat stretch.",
        Kind::Text("A..B");
    PPD_REACH: "calibration.ppd", "PPD holds", "reach of PPD",
        "What the flat spot's scale is for pings of another recorded range.",
        choice!(calibration.ppd, [
            "factor", "on recorded range", "The flat spot corrects the recorded range by a factor, so it holds for pings of another range too.";
            "constant", "one constant", "The same pixels per metre for all pings, as published: wrong where the range was changed.";
        ]);
    OFFSET: "calibration.offset", "Offset", "offset",
        "What is done about a constant between first-return ranges and recorded depths.",
        choice!(calibration.offset, [
            "auto", "where it fits", "Taken off where it is one that a pulse, a filter or a draft causes; ranges of survey-grade logs stay as they are.";
            "fit", "also survey-grade", "As before, and on survey-grade logs too.";
            "none", "none", "Ranges stay as they are.";
        ]);
    GEOMETRY: "cloud.geometry", "Geometry", "geometry", "Where a first return is placed.",
        choice!(cloud.geometry, [
            "slope", "slope", "The first return lies where the bottom is square to the beam.";
            "nadir", "nadir", "z = r, y = 0: the first return is straight below.";
            "self_consistent", "self-consistent", "As published, with PPD measured so that the depth at the flat spot is reproduced.";
            "published", "published", "z = r cos(α2), y = r sin(α2), as printed in the paper.";
        ]);
    // From 60 degrees on the depth would be less than half of the range: no first return is that far out.
    ALPHA2: "cloud.alpha2_deg", "Angle α2", "angle",
        "α2 of the paper: angle of the first return from the vertical; 16 degrees in the published code.",
        number!(cloud.alpha2_deg, "°", [0.0, 60.0], 0.5, 1, Slider);
    DOWN_SCAN: "cloud.down_scan", "Soundings", "soundings of the cloud", "Which recorded depths are kept.",
        choice!(cloud.down_scan, [
            "locked", "with bottom", "Those at which the recorder had the bottom.";
            "all", "all (published)", "All of them.";
        ]);
    HEADING: "heading.source", "Heading", "heading", "Where the heading of a ping comes from.",
        choice!(heading.source, [
            "track_fit", "track fit", "A line fitted to the fixes in a time window around the ping.";
            "cog", "recorded course", "Course over ground as the recorder stored it.";
            "compass", "compass", "The recorded compass heading, where the boat had one.";
            "steps", "fix to fix (published)", "h = p(i+1) − p(i): most steps are zero, and those pings give no point.";
        ]);
    HEADING_WINDOW: "heading.window_s", "Window", "heading window",
        "Width of the time window that the heading line is fitted over.",
        number!(heading.window_s, "s", [0.2, 120.0], 0.1, 1, LogSlider);
    TRACK_FILE: "track.file", "Track", "track",
        "Places of another receiver, RTK or an autopilot, in place of the recorder's.",
        Kind::Text("a file, CSV or GPX");
    // A clock may be hours off by its time zone and years by its date.
    TRACK_OFFSET: "track.offset_s", "Time offset", "time offset",
        "Added to the times of the track: how far its clock is behind that of the recorder.",
        number!(track.offset_s, "s", [-1e9, 1e9], 0.01, 2, Drag);
    SWAP_SIDES: "mounting.swap_sides", "Sides", "sides of the recorder",
        "Whether the recorder has port and starboard the other way round: a transducer mounted back to front, or two cables exchanged. Every result follows.",
        choice!(mounting.swap_sides, [
            "false", "as recorded", "Port is what was recorded as port.";
            "true", "exchanged", "Port is what was recorded as starboard.";
        ]);
    // The longest survey vessels are a hundred metres; a tow is no mounting.
    ANTENNA_FORWARD: "mounting.forward_m", "Forward", "transducer forward of the antenna",
        "From the antenna whose positions are used to the transducer, along the boat, positive forward: moves every ping, by the heading in force.",
        number!(mounting.forward_m, "m", [-200.0, 200.0], 0.01, 2, Drag);
    ANTENNA_RIGHT: "mounting.right_m", "Starboard", "transducer to starboard of the antenna",
        "From the antenna whose positions are used to the transducer, across the boat, positive to starboard.",
        number!(mounting.right_m, "m", [-100.0, 100.0], 0.01, 2, Drag);
    HEADING_OFFSET: "mounting.heading_offset_deg", "Compass", "heading offset",
        "Added to the recorded compass heading: how the compass is turned on the boat, and the magnetic variation. Courses and headings of the track are those of the boat's motion and stay as they are.",
        number!(mounting.heading_offset_deg, "°", [-180.0, 180.0], 0.1, 1, Drag);
    // More than ten days is another log.
    CLOCK_OFFSET: "mounting.clock_offset_s", "Clock", "clock of the log",
        "Added to the log's times where they are UTC, in every product and where water levels or an external track are looked up: how far the recorder's clock is behind UTC.",
        number!(mounting.clock_offset_s, "s", [-864_000.0, 864_000.0], 0.01, 2, Drag);
    // A receiver that is later than this has lost its fix.
    LATENCY: "mounting.latency_s", "Latency", "latency of positions",
        "How much later the recorded positions are than the echoes recorded with them: a receiver needs time to find a position, and the recorder to take it over. Crossings over a slope show it; the report says how much.",
        number!(mounting.latency_s, "s", [-10.0, 10.0], 0.01, 2, Drag);
    // Receivers without corrections are off by metres; more is another place.
    SHIFT_EAST: "position_shift.east_m", "Shift east", "shift of positions to the east",
        "Added to every position of the log: receivers without corrections are off by a metre or two. Crossings with other logs over a slope show how far; Compare positions finds it.",
        number!(position_shift.east_m, "m", [-20.0, 20.0], 0.01, 2, Drag);
    SHIFT_NORTH: "position_shift.north_m", "Shift north", "shift of positions to the north",
        "Added to every position of the log, to the north.",
        number!(position_shift.north_m, "m", [-20.0, 20.0], 0.01, 2, Drag);
    SOURCE_CRS: "source.crs", "Metres of", "system of the log's metres",
        "The coordinate system of a log whose positions are metres of a system that it does not name, as XTF may have them. Without one they lie around longitude 0, latitude 0.",
        Kind::Text("EPSG:NUMBER");
    MAX_TURN: "left_out.max_turn_deg_s", "Turns from", "turns left out",
        "Stretches in which the boat turns faster than this are left out of every result.",
        number!(left_out.max_turn_deg_s, "°/s", [0.1, 360.0], 0.1, 1, LogSlider, Some("no turn is left out"));
    MIN_SPEED: "left_out.min_speed_mps", "Stops below", "stops left out",
        "Stretches in which the boat is slower than this are left out of every result.",
        number!(left_out.min_speed_mps, "m/s", [0.01, 20.0], 0.01, 2, LogSlider, Some("no stop is left out"));
    MIN_DURATION: "left_out.min_duration_s", "Shortest", "shortest turn or stop left out",
        "Shorter turns and stops stay in; and the way between two of them that is shorter goes with them.",
        number!(left_out.min_duration_s, "s", [0.0, 3600.0], 0.1, 1, LogSlider);
    LEFT_OUT_LOG: "left_out.log", "Log", "log of the stretches",
        "The log that the stretches were named for; over another they are not applied.",
        Kind::Text("size and hash of a log");
    STRETCHES: "left_out.stretches", "Stretches", "stretches left out",
        "Stretches of one log that are left out of every result, or kept although a turn or a stop is found there.",
        Kind::Text("[{ pings = [A, B], reason = \"turn | stop | bad | drawn | kept\" }, ...], or time_s in place of pings");
    // Between the spacing of the densest points and the width of the largest swath.
    RADIUS: "outliers.radius_m", "Radius", "outlier radius",
        "Radius of the sphere around a point; 3.011 m in the paper.",
        number!(outliers.radius_m, "m", [0.01, 100.0], 0.001, 3, LogSlider);
    MIN_NEIGHBOURS: "outliers.min_neighbors", "Neighbours", "outlier neighbours",
        "A point stays when its sphere holds more than this many points, itself included; 10 in the paper.",
        number!(outliers.min_neighbors, "", [1.0, 10_000.0], 1.0, 0, LogSlider);
    DETECTOR_MODEL: "detector.model", "Model", "detector's model",
        "The network that searches for objects. Without one, that of the program.",
        Kind::Text("a file, ONNX");
    DETECTOR_SCORE: "detector.score", "Score", "detector's score",
        "Least confidence of a box.",
        number!(detector.score, "", [0.0, 1.0], 0.01, 2, Slider, Some("the model's own"));
    DETECTOR_IOU: "detector.iou", "Overlap", "detector's overlap",
        "Overlap above which the less sure of two boxes is dropped.",
        number!(detector.iou, "", [0.0, 1.0], 0.01, 2, Slider, Some("the model's own"));
    DETECTOR_NAME: "detector.name_score", "Named from", "detector's score of a name",
        "Confidence from which a box is named; below it the class is a guess, and the box is an object.",
        number!(detector.name_score, "", [0.0, 1.0], 0.01, 2, Slider, Some("the model's own"));
    PICTURE_GAIN: "picture.gain", "Gain", "gain of the waterfall", "How levels of the waterfall are made even across the track.",
        choice!(picture.gain, [
            "empirical", "gain-normalised", "Divided by the log's own mean at that range and angle, as in the mosaic; shadows stay dark.";
            "recorded", "as recorded", "The recorder's own levels.";
        ]);
    // Spreading of intensity is 20 log r one way; nobody applies more than both ways twice over, or takes more than that back.
    PICTURE_SPREADING: "picture.spreading_db", "Spreading", "gain for spreading",
        "k of the time-varied gain k log10 r + 2 α r: dB for each tenfold slant range.",
        number!(picture.spreading_db, "dB", [-80.0, 80.0], 0.5, 1, Slider);
    // At 1.2 MHz sea water takes 0.5 dB a metre.
    PICTURE_ABSORPTION: "picture.absorption_db_m", "Absorption", "gain for absorption",
        "α of the time-varied gain k log10 r + 2 α r: dB for each metre, there and back.",
        number!(picture.absorption_db_m, "dB/m", [-1.0, 1.0], 0.005, 3, Slider);
    PICTURE_BALANCE: "picture.balance_db", "Balance", "balance of the sides",
        "How much starboard is brightened against port; below 0, port against starboard.",
        number!(picture.balance_db, "dB", [-40.0, 40.0], 0.1, 1, Slider);
    PICTURE_STRIPES: "picture.stripe_filter", "Stripes", "stripe filter",
        "Pings that are brighter or darker than those about them.",
        choice!(picture.stripe_filter, [
            "false", "as recorded", "Pings are shown as they are.";
            "true", "filtered", "Each ping is brought to the median level of the pings about it.";
        ]);
    PICTURE_DESPECKLE: "picture.despeckle", "Speckle", "despeckling",
        "Single bright and dark echoes.",
        choice!(picture.despeckle, [
            "false", "as recorded", "Echoes are shown as they are.";
            "true", "removed", "Each echo is the median of the 3 x 3 about it, on the screen's own scale.";
        ]);
    // With the greatest gain the brightest byte becomes 8000.
    PICTURE_BLACK: "picture.black", "Black", "black point",
        "Level that is shown as black; 255 is the largest byte.",
        number!(picture.black, "", [0.0, 10_000.0], 0.5, 1, Drag, Some("the level that 1 % of the log's echoes lie below"));
    PICTURE_WHITE: "picture.white", "White", "white point",
        "Level that is shown as white; 255 is the largest byte.",
        number!(picture.white, "", [0.5, 10_000.0], 0.5, 1, Drag, Some("a little above what 99 % of the log's echoes lie below"));
    PICTURE_GAMMA: "picture.gamma", "Gamma", "gamma of the waterfall",
        "Exponent 1 / gamma between black and white: above 1 lifts the dark.",
        number!(picture.gamma, "", [0.2, 5.0], 0.05, 2, LogSlider);
    PICTURE_FLIP: "picture.flip", "Along", "direction of the waterfall",
        "Which way the pings of the waterfall run.",
        choice!(picture.flip, [
            "false", "forward", "Later pings to the right, or below.";
            "true", "flipped", "Later pings to the left, or above.";
        ]);
    PICTURE_FIRST: "picture.starboard_first", "First", "side that comes first",
        "On which side of the waterfall port is drawn. The data stay as they are: a recorder that has its sides the wrong way round is put right by `mounting.swap_sides`.",
        choice!(picture.starboard_first, [
            "false", "port first", "Port is above, or to the left.";
            "true", "starboard first", "Starboard is above, or to the left.";
        ]);
    MOSAIC_CELL: "mosaic.cell_m", "File's cell", "cell of the mosaic",
        "Side of a cell of mosaic.tif; on the map the mosaic is as fine as the screen.",
        number!(mosaic.cell_m, "m", [0.01, 100.0], 0.01, 2, LogSlider);
    MOSAIC_COLOURS: "mosaic.colours", "Colours", "colours of the mosaic",
        "Colours of the mosaic, on the map and in the file.",
        choice!(mosaic.colours, [
            "grey", "grey", "Black to white.";
            "copper", "copper", "Black to copper.";
        ]);
    OVERLAP: "mosaic.overlap", "Overlap", "overlap",
        "What is shown where several passes saw the ground.",
        choice!(mosaic.overlap, [
            "later", "later on top", "The later pass lies over the earlier.";
            "brighter", "brighter on top", "The brighter echo counts: objects stay, shadows are lost.";
            "middle", "middle on top", "The pass in the middle of whose swath the ground lies: weak ends show only where there is nothing else.";
            "blend", "blend", "The mean, weighted towards the middle of each swath: objects and shadows fade.";
        ]);
    GAIN: "mosaic.gain", "Gain", "gain", "How levels are made even across the track.",
        choice!(mosaic.gain, [
            "empirical", "gain-normalised", "Divided by the survey's own mean at that range and angle; shadows stay dark.";
            "recorded", "as recorded", "The recorder's own levels.";
        ]);
    WATER_COLUMN: "mosaic.water_column", "Water column", "water column", "Echoes before the first return.",
        choice!(mosaic.water_column, [
            "false", "removed", "Slant ranges are turned into distances on the ground by the altitude.";
            "true", "kept", "Slant ranges are taken for distances on the ground.";
        ]);
    NADIR_GAP: "mosaic.nadir_gap_deg", "Nadir gap", "nadir gap",
        "Ground nearer than this angle from straight down is left out; 0 fills the gap under the boat.",
        number!(mosaic.nadir_gap_deg, "°", [0.0, 60.0], 1.0, 0, Slider);
    // The quickest boat turns once in a few seconds: from there on nothing is left out.
    MOST_TURN: "mosaic.most_turn_deg_s", "Turns from", "turn rate",
        "Pings where the boat turns faster are left out: their far ends sweep over the ground.",
        number!(mosaic.most_turn_deg_s, "°/s", [0.1, 360.0], 0.1, 1, LogSlider);
    SURFACE_METHOD: "surface.method", "Between depths", "method between depths",
        "How the depth between soundings and side-scan points is found.",
        choice!(surface.method, [
            "linear", "triangles", "Linear on the planes of the Delaunay triangles between depths: through every one of them.";
            "natural", "natural neighbours", "Sibson's: smooth but at the depths themselves. Slower.";
            "inverse_distance", "inverse distance", "Mean of the nearest depths by inverse distance squared: smooth, draws towards the mean.";
        ]);
    SURFACE_CELL: "surface.cell_m", "Cell", "cell of the depth map",
        "Side of a cell of the depth map.",
        number!(surface.cell_m, "m", [0.01, 1000.0], 0.01, 2, LogSlider, Some("chosen from the spacing of the depths"));
    // Beyond a kilometre from any depth nothing is interpolated, it is invented.
    MAX_GAP: "surface.max_gap_m", "Gap", "gap of the depth map", "No value farther than this from a depth.",
        number!(surface.max_gap_m, "m", [0.1, 1000.0], 0.1, 1, LogSlider);
    MAX_SIDE: "surface.max_side", "Most cells", "most cells of the depth map",
        "Most cells along the longer side: where a cell would make more of them, or more than 20 million in all, it is larger.",
        number!(surface.max_side, "", [16.0, 32_768.0], 1.0, 0, LogSlider);
    // Only the one against the other counts: 0 to 1 has every share.
    DOWN_SCAN_WEIGHT: "surface.down_scan_weight", "Soundings", "weight of soundings",
        "What a sounding counts where several depths fall into one cell; 0 leaves soundings out.",
        number!(surface.down_scan_weight, "", [0.0, 1.0], 0.05, 2, Slider);
    SIDE_SCAN_WEIGHT: "surface.side_scan_weight", "Side-scan", "weight of side-scan points",
        "What a side-scan point counts where it meets a sounding, which counts 1; 0 leaves side-scan points out.",
        number!(surface.side_scan_weight, "", [0.0, 1.0], 0.05, 2, Slider);
    SURFACE_ABOVE_BOTTOM: "surface.above_bottom", "Above bottom", "above-bottom returns in the depth map",
        "Whether all side-scan points above the recorded depth count: their depth may be that of weed or fish.",
        choice!(surface.above_bottom, [
            "false", "left out", "Only those of long stretches count: a field of boulders, no clump of weed, fish or object.";
            "true", "counts", "All of them count.";
        ]);
    LONGEST_ABOVE_BOTTOM: "surface.longest_above_bottom_m", "Longest", "longest above-bottom stretch",
        "Side-scan points above the recorded depth count where most first returns of both sides lie above it for longer than this along the track.",
        number!(surface.longest_above_bottom_m, "m", [0.0, 100_000.0], 1.0, 0, LogSlider);
    SWATH: "surface.swath", "Echo levels", "depths from echo levels",
        "Whether depths between the lines come from the levels of the side-scan echoes: a bed that faces the boat is brighter. Inferred, not measured.",
        choice!(surface.swath, [
            "auto", "where they predict soundings", "Used where soundings that are left out for a test are predicted with them; an archive of many logs does not use them.";
            "off", "off", "Depths between the lines are interpolated alone.";
            "always", "always", "Used wherever they can be read, whatever the test says.";
        ]);
    RELIEF: "surface.relief", "Echoes", "ground of echoes and objects",
        "What echoes and objects are placed on: the bottom that the log measured, where it did, or a level one.",
        choice!(surface.relief, [
            "true", "measured bottom", "By the depths that the log measured across the track; on where it measured none, as deep as it last was.";
            "false", "level bottom", "As deep everywhere as under the boat.";
        ]);
    // Finer than a millimetre no depth is known.
    INTERVAL: "isobaths.interval_m", "Interval", "isobath interval",
        "Depth from one isobath to the next, counted from depth 0. Every fifth is thick.",
        number!(isobaths.interval_m, "m", [0.001, 1000.0], 0.01, 2, LogSlider, Some("1, 2 or 5 times a power of ten that makes about ten isobaths"));
    LEVELS: "isobaths.depths_m", "Depths", "depths of the isobaths",
        "Depths of the isobaths; when there are any, the interval does not count.",
        Kind::Numbers { unit: "m", range: [-10_000.0, 12_000.0], get: |settings| &settings.isobaths.depths_m };
    ISOBATH_UNIT: "isobaths.unit", "Unit", "unit of the isobaths",
        "What the depths of isobaths are round in, and written in along the lines and at spot soundings.",
        choice!(isobaths.unit, [
            "metres", "metres", "Metres.";
            "feet", "feet", "International feet of 0.3048 m.";
            "fathoms", "fathoms", "Fathoms of six feet.";
        ]);
    SMOOTH: "isobaths.smooth", "Smoothing", "isobath smoothing",
        "How often the corners of isobaths are cut; 0 leaves them as measured.",
        number!(isobaths.smooth, "", [0.0, 8.0], 1.0, 0, Slider);
    SHOAL_SAFE: "isobaths.shoal_safe", "Shoals", "isobaths at shoals",
        "Whether an isobath may lie so that a depth shallower than it is on its deep side.",
        choice!(isobaths.shoal_safe, [
            "false", "as the map", "Lines run through the depth map, which is the mean of the depths that meet in a cell.";
            "true", "never understated", "Every depth that is shallower than a line lies on its shallow side: lines give way to deeper water, and are smoothed that way alone.";
        ]);
    SPOT_RADIUS: "isobaths.spot_radius_m", "Spot soundings", "distance of spot soundings",
        "No spot sounding is nearer to another than this; the shoalest is kept, and of its surroundings no other.",
        number!(isobaths.spot_radius_m, "m", [0.1, 100_000.0], 1.0, 1, LogSlider, Some("a round distance, a fortieth of the map's diagonal"));
    CLIP: "isobaths.clip", "Area", "area of the isobaths",
        "The area that isobaths, the areas between them and spot soundings end at: a shoreline with its islands, as GeoJSON, KML or GPX. Without one they are wherever there are depths.",
        Kind::Text("a file");
    POINTS_LAS: "points.las", "Plain LAS", "plain LAS",
        "Whether the kept points are written as plain LAS beside LAZ, for programs that cannot unpack LAZ.",
        choice!(points.las, [
            "false", "LAZ alone", "points/cloud.copc.laz alone.";
            "true", "LAZ and LAS", "points/cloud.las too: the same points, four to five times as large.";
        ]);
    REPORT_PROPOSALS: "report.proposals", "Proposals", "proposals in the report",
        "Whether proposals that nobody has decided about have a section of their own in the report, as accepted and added targets have.",
        choice!(report.proposals, [
            "false", "left out", "Only what was accepted or added has a section.";
            "true", "shown", "Undecided proposals come after the targets.";
        ]);
}
