//! Table of settings, a row for each key, from which checks, controls, tooltips, help and manual
//! are made.
//!
//! If a range is not given by the nature of the quantity, a comment states the reason.

use super::table::Control::{Drag, LogSlider, Slider};
use super::table::{
    Named, Number, Numeric, SettingChoice, SettingKind, SettingRow, SettingScope, choose, name_of,
};
use bathyscope_log::survey::WATER_LEVELS_M;

/// Makes the kind of a row whose setting is a number.
macro_rules! number {
    ($($field:ident).+, $unit:literal, [$least:expr, $most:expr], $step:literal, $decimals:literal, $control:ident) => {
        number!($($field).+, $unit, [$least, $most], $step, $decimals, $control, None)
    };
    ($($field:ident).+, $unit:literal, [$least:expr, $most:expr], $step:literal, $decimals:literal, $control:ident, $without:expr) => {
        SettingKind::Number(Number {
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

/// Makes the kind of a row whose setting is one of several names, each with its label and meaning.
macro_rules! choice {
    ($($field:ident).+, [$($value:literal, $label:literal, $meaning:literal;)+]) => {
        choice!($($field).+, [$($value, $label, $meaning;)+], "")
    };
    ($($field:ident).+, [$($value:literal, $label:literal, $meaning:literal;)+], $others:literal) => {
        SettingKind::Choice(SettingChoice {
            others: $others,
            names: &[$(Named { value: $value, label: $label, meaning: $meaning }),+],
            get: |settings| name_of(&settings.$($field).+),
            set: |settings, name| choose(&mut settings.$($field).+, name),
        })
    };
}

/// Names the scope of a row; settings are those of the survey unless the row says otherwise.
macro_rules! scope {
    () => {
        SettingScope::Survey
    };
    ($scope:ident) => {
        SettingScope::$scope
    };
}

/// Makes a static for each row, which a panel names to show it, and the list of all rows. A row
/// names its scope in brackets if that is not the survey.
macro_rules! rows {
    ($($id:ident $(($scope:ident))?: $key:literal, $label:literal, $name:literal, $hint:literal, $kind:expr;)+) => {
        $(
            #[doc = concat!("`", $key, "`: ", $hint)]
            pub static $id: SettingRow = SettingRow { key: $key, label: $label, name: $name, hint: $hint, scope: scope!($($scope)?), kind: $kind };
        )+
        /// All settings, in the order of the manual, without the bottom edits, which consist of
        /// strokes.
        pub static ROWS: &[&SettingRow] = &[$(&$id),+];
    };
}

rows! {
    PROJECTION: "projection", "Plane", "plane", "The plane that the cloud is built in.",
        choice!(projection, [
            "enu", "local metres", "Metres on the ground, east and north of the first fix.";
            "mercator", "Mercator (paper)", "Pseudo-Mercator metres, which are longer than metres on the ground by 1 / cos(latitude).";
        ]);
    CRS: "crs", "System", "coordinate system", "The coordinate system of GeoTIFF, LAZ, XYZ and shapefiles.",
        choice!(crs, [
            "utm", "UTM", "Metres in the zone of the first fix.";
            "wgs84", "WGS84", "Longitude and latitude, degrees.";
            "web_mercator", "web Mercator", "The projection of web maps.";
        ], "EPSG:NUMBER");
    // The deepest hulls of survey vessels draw less; the depth of a towed transducer is not
    // constant.
    DRAFT (UsuallyOneLog): "draft_m", "Draft", "draft",
        "Depth of the transducer below the water surface; added to every depth.",
        number!(draft_m, "m", [0.0, 20.0], 0.01, 2, LogSlider);
    WATER_LEVEL (UsuallyOneLog): "water_level_m", "Water level", "water level",
        "Height of the water above the level that depths count from; subtracted from every depth. With readings, the height of their zero.",
        number!(water_level_m, "m", [*WATER_LEVELS_M.start(), *WATER_LEVELS_M.end()], 0.01, 2, Drag);
    WATER_LEVEL_FILE (UsuallyOneLog): "water_level.file", "Readings", "readings of the water level",
        "Water heights over time; the setting above is the height of their zero.",
        SettingKind::Text("a file");
    HEIGHT_OFFSET (OneLog): "height_offset_m", "Height offset", "height offset",
        "Added to every elevation of the log, so that it agrees with other logs where they cross.",
        number!(height_offset_m, "m", [-100.0, 100.0], 0.01, 2, Drag);
    // From ice-cold fresh water to the brine of the Dead Sea and the deepest sea, with a margin in
    // which a wrong unit is noticed.
    SOUND_SPEED: "sound_speed.m_s", "Sound speed", "sound speed",
        "Measured speed of sound in this water.",
        number!(sound_speed.m_s, "m/s", [1300.0, 1800.0], 1.0, 1, Slider, Some("computed from temperature and salinity where the temperature is given, else ranges stay as the recorder computed them"));
    TEMPERATURE: "sound_speed.temperature_c", "Water", "water temperature",
        "Temperature of the water, which with salinity gives the speed of sound (Chen and Millero 1977).",
        number!(sound_speed.temperature_c, "°C", [0.0, 40.0], 0.1, 1, Slider, Some("the speed of sound is not computed"));
    SALINITY: "sound_speed.salinity_psu", "Salinity", "salinity",
        "Practical salinity: 0 in fresh water, 35 in the ocean.",
        number!(sound_speed.salinity_psu, "", [0.0, 40.0], 0.5, 1, Slider);
    SOUND_SPEED_DEPTH: "sound_speed.depth_m", "At depth", "depth of the temperature",
        "Depth at which temperature and salinity hold: half the water depth where they are the same everywhere.",
        number!(sound_speed.depth_m, "m", [0.0, 10_000.0], 0.1, 1, LogSlider);
    // Recorders assume only speeds that occur in water: 4600 to 5250 feet a second.
    RECORDER_SPEED: "sound_speed.recorder_m_s", "Recorder", "recorder's sound speed",
        "Speed of sound that the recorder uses for its ranges: 1500 m/s in most recorders, 1463 m/s in some for fresh water.",
        number!(sound_speed.recorder_m_s, "m/s", [1400.0, 1600.0], 1.0, 0, Slider);
    SAMPLES: "image.samples", "Sample format", "image", "How the bytes of a ping become samples.",
        choice!(image.samples, [
            "bytes", "bytes", "One sample a byte.";
            "words", "int32 words", "Four bytes read as one number, as the code of the paper does: 700 columns from 2800 bytes.";
        ]);
    METHOD: "first_return.method", "Method", "method", "How the first return is found.",
        choice!(first_return.method, [
            "tracker", "tracker", "A continuous line along the bottom edge, through samples that reach the threshold.";
            "threshold", "threshold", "The first sample that reaches the threshold, as in the paper.";
        ]);
    THRESHOLD: "first_return.threshold", "Threshold", "threshold",
        "Normalised intensity that a sample must reach to count as a return; 0.30 in the paper (Pulido et al.).",
        number!(first_return.threshold, "", [0.0, 1.0], 0.01, 2, Slider);
    // The longest pulses ring for a few metres; a larger dead zone would hide the bottom of shallow
    // waters.
    DEAD_ZONE: "first_return.dead_zone_m", "Dead zone", "dead zone",
        "Slant range near the transducer that is ignored, because of its ring-down.",
        number!(first_return.dead_zone_m, "m", [0.0, 10.0], 0.05, 2, LogSlider);
    // On a slope of 45 degrees in 30 m of water the first return comes 9 m early.
    ABOVE_BOTTOM_MARGIN: "first_return.above_bottom_margin_m", "Shallower by", "above-bottom margin",
        "A first return that is nearer than the recorded depth by more than this is an above-bottom return: weed, fish or an obstacle.",
        number!(first_return.above_bottom_margin_m, "m", [0.0, 10.0], 0.05, 2, LogSlider);
    MIN_CONFIDENCE: "first_return.min_confidence", "Min. confidence", "minimum confidence",
        "First returns below this confidence give no point. Confidence is the chance that a first return lies within 25 cm of the nearest ground, measured on simulated ponds.",
        number!(first_return.min_confidence, "", [0.0, 1.0], 0.05, 2, Slider);
    BOTTOM_LINE: "first_return.bottom_line", "Bottom line", "bottom line",
        "The bottom that water column, ground range, gain and mosaic use. Points and calibration always use the first returns.",
        choice!(first_return.bottom_line, [
            "search", "first return", "The first return of each side.";
            "recorded", "recorded depth", "The depth of the recorder, the same on both sides; the first return where the recorder lost the bottom.";
        ]);
    SCALE: "calibration.mode", "Scale", "scale", "What turns samples into metres of slant range.",
        choice!(calibration.mode, [
            "header", "recorded range", "The range that the recorder states for each ping.";
            "flat_spot", "flat stretch", "Pixels per metre on a flat stretch: first return divided by recorded depth (PPD = p / d of Pulido et al.).";
        ]);
    FLAT_SPOT (OneLog): "calibration.pings", "Flat stretch", "flat stretch",
        "Side-scan pings of the flat stretch, from A to the ping before B. Without them, the best-ranked flat stretch.",
        SettingKind::Text("A..B");
    PPD_REACH: "calibration.ppd", "Other ranges", "scale at other ranges",
        "How the scale of the flat stretch applies to pings with another range setting.",
        choice!(calibration.ppd, [
            "factor", "factor", "The flat stretch gives a factor for the recorded range, which holds for pings of every range.";
            "constant", "constant", "The same pixels per metre for all pings, as in the paper: wrong where the range was changed.";
        ]);
    OFFSET: "calibration.offset", "Range offset", "range offset",
        "Whether a constant difference between first-return ranges and recorded depths is subtracted.",
        choice!(calibration.offset, [
            "auto", "automatic", "Subtracted where pulse, filter or draft explain it; not on survey-grade logs.";
            "fit", "also survey-grade", "Subtracted on survey-grade logs as well.";
            "none", "none", "Ranges stay as they are.";
        ]);
    GEOMETRY: "cloud.geometry", "Geometry", "geometry", "Where a first return is placed.",
        choice!(cloud.geometry, [
            "slope", "slope", "At the point of the bottom that is perpendicular to the beam.";
            "nadir", "nadir", "Straight below the boat: z = r, y = 0.";
            "self_consistent", "self-consistent", "As in the paper, with a PPD that reproduces the depth at the flat stretch.";
            "published", "paper", "z = r cos(α2), y = r sin(α2), as in the paper.";
        ]);
    // Above 60 degrees the depth would be less than half of the range: no first return comes from
    // so far to the side.
    ALPHA2: "cloud.alpha2_deg", "Angle α2", "angle",
        "Angle of the first return from the vertical, α2 of the paper; 16 degrees in its code.",
        number!(cloud.alpha2_deg, "°", [0.0, 60.0], 0.5, 1, Slider);
    DOWN_SCAN: "cloud.down_scan", "Soundings", "soundings of the cloud", "Which recorded depths are kept.",
        choice!(cloud.down_scan, [
            "locked", "with bottom", "Those for which the recorder found the bottom.";
            "all", "all (paper)", "All of them.";
        ]);
    HEADING: "heading.source", "Heading", "heading", "Where the heading of a ping comes from.",
        choice!(heading.source, [
            "track_fit", "track fit", "A line fitted to the fixes in a time window around the ping.";
            "cog", "recorded course", "Course over ground as the recorder stored it.";
            "compass", "compass", "The recorded compass heading, where there is one.";
            "steps", "fix to fix (paper)", "h = p(i+1) − p(i): most steps are zero, and these pings give no point.";
        ]);
    HEADING_WINDOW: "heading.window_s", "Window", "heading window",
        "Width of the time window that the heading line is fitted over.",
        number!(heading.window_s, "s", [0.2, 120.0], 0.1, 1, LogSlider);
    TRACK_FILE (OneLog): "track.file", "Track", "track",
        "Positions of another receiver (RTK, autopilot) in place of those of the recorder.",
        SettingKind::Text("a file, CSV or GPX");
    // A clock may be wrong by hours because of its time zone, and by years because of its date.
    TRACK_OFFSET (OneLog): "track.offset_s", "Time offset", "time offset",
        "Added to the times of the track; positive where its clock is behind the recorder's.",
        number!(track.offset_s, "s", [-1e9, 1e9], 0.01, 2, Drag);
    SWAP_SIDES (OneLog): "mounting.swap_sides", "Sides", "sides of the recorder",
        "Whether port and starboard are exchanged: a transducer that is mounted backwards, or exchanged cables.",
        choice!(mounting.swap_sides, [
            "false", "as recorded", "Port is what was recorded as port.";
            "true", "exchanged", "Port is what was recorded as starboard.";
        ]);
    // The longest survey vessels are a hundred metres long; a towed transducer is not covered by
    // these settings.
    ANTENNA_FORWARD (OneLog): "mounting.forward_m", "Forward", "transducer forward of the antenna",
        "Distance from the antenna to the transducer along the boat, positive forward.",
        number!(mounting.forward_m, "m", [-200.0, 200.0], 0.01, 2, Drag);
    ANTENNA_RIGHT (OneLog): "mounting.right_m", "Starboard", "transducer to starboard of the antenna",
        "Distance from the antenna to the transducer across the boat, positive to starboard.",
        number!(mounting.right_m, "m", [-100.0, 100.0], 0.01, 2, Drag);
    HEADING_OFFSET (OneLog): "mounting.heading_offset_deg", "Compass", "heading offset",
        "Added to the compass heading: misalignment of the compass plus magnetic variation. Headings from the track do not change.",
        number!(mounting.heading_offset_deg, "°", [-180.0, 180.0], 0.1, 1, Drag);
    // With an offset of more than ten days, the log is of another survey.
    CLOCK_OFFSET (OneLog): "mounting.clock_offset_s", "Clock", "clock of the log",
        "Added to the times of the log; positive where the clock of the recorder is behind UTC.",
        number!(mounting.clock_offset_s, "s", [-864_000.0, 864_000.0], 0.01, 2, Drag);
    // A receiver with a larger delay has lost its fix.
    LATENCY (OneLog): "mounting.latency_s", "Latency", "latency of positions",
        "Delay of recorded positions behind the echoes. Compare positions finds it at crossings over a slope.",
        number!(mounting.latency_s, "s", [-10.0, 10.0], 0.01, 2, Drag);
    // No sounder averages over a longer time.
    SOUNDING_LAG (OneLog): "mounting.sounding_lag_s", "Sounding lag", "lag of the soundings",
        "Delay of recorded depths behind the echoes, of a sounder that averages. First returns show it where the bottom slopes along the track.",
        number!(mounting.sounding_lag_s, "s", [0.0, 10.0], 0.01, 2, Drag);
    // Receivers without corrections are wrong by metres; a larger shift means another place.
    SHIFT_EAST (OneLog): "position_shift.east_m", "Shift east", "shift of positions to the east",
        "Added to every position of the log, to the east. Compare positions finds it at crossings with other logs.",
        number!(position_shift.east_m, "m", [-20.0, 20.0], 0.01, 2, Drag);
    SHIFT_NORTH (OneLog): "position_shift.north_m", "Shift north", "shift of positions to the north",
        "Added to every position of the log, to the north.",
        number!(position_shift.north_m, "m", [-20.0, 20.0], 0.01, 2, Drag);
    SOURCE_CRS: "source.crs", "Metres of", "system of the log's metres",
        "Coordinate system of positions in metres, where the log does not name it, as XTF logs may not. Without it, positions are drawn at longitude 0, latitude 0.",
        SettingKind::Text("EPSG:NUMBER");
    SOURCE_FREQUENCY: "source.frequency_khz", "Frequency", "frequency of the side-scan",
        "Which side-scan is shown where a log holds several frequencies: the one nearest to this.",
        number!(source.frequency_khz, "kHz", [1.0, 10_000.0], 1.0, 0, Drag, Some("as recorded first"));
    MAX_TURN: "excluded.max_turn_deg_s", "Turns from", "turns to exclude",
        "Stretches in which the boat turns faster than this are excluded from every result.",
        number!(excluded.max_turn_deg_s, "°/s", [0.1, 360.0], 0.1, 1, LogSlider, Some("no turn is excluded"));
    MIN_SPEED: "excluded.min_speed_mps", "Stops below", "stops to exclude",
        "Stretches in which the boat is slower than this are excluded from every result.",
        number!(excluded.min_speed_mps, "m/s", [0.01, 20.0], 0.01, 2, LogSlider, Some("no stop is excluded"));
    MIN_DURATION: "excluded.min_duration_s", "Shortest", "shortest turn or stop to exclude",
        "Shorter turns and stops are not excluded; a shorter stretch between two of them is excluded with them.",
        number!(excluded.min_duration_s, "s", [0.0, 3600.0], 0.1, 1, LogSlider);
    EXCLUDED_LOG (OneLog): "excluded.log", "Log", "log of the stretches",
        "The log that the stretches belong to; they are not applied to another log.",
        SettingKind::Text("size and hash of a log");
    STRETCHES (OneLog): "excluded.stretches", "Stretches", "excluded stretches",
        "Stretches of one log that are excluded from every result, or kept although a turn or a stop is there; trusted: the soundings count, too, that were taken for false.",
        SettingKind::Text("[{ pings = [A, B], reason = \"turn | stop | bad | drawn | kept\", trusted = false }, ...], or time_s in place of pings");
    // Limits: the spacing of the densest points and the width of the largest swath.
    RADIUS: "outliers.radius_m", "Radius", "outlier radius",
        "Radius of the sphere around a point; 3.011 m in the paper (Pulido et al.).",
        number!(outliers.radius_m, "m", [0.01, 100.0], 0.001, 3, LogSlider);
    MIN_NEIGHBOURS: "outliers.min_neighbors", "Neighbours", "outlier neighbours",
        "A point is kept when its sphere holds more points than this, itself included; 10 in the paper.",
        number!(outliers.min_neighbors, "", [1.0, 10_000.0], 1.0, 0, LogSlider);
    DETECTOR_MODEL: "detector.model", "Model", "detector's model",
        "The network that searches for objects. Without one, the network of the program.",
        SettingKind::Text("a file, ONNX");
    DETECTOR_SCORE: "detector.score", "Score", "detector's score",
        "Least score of a box.",
        number!(detector.score, "", [0.0, 1.0], 0.01, 2, Slider, Some("the model's own"));
    DETECTOR_IOU: "detector.iou", "Overlap", "detector's overlap",
        "Of two boxes that overlap by more than this (IoU), the one with the lower score is dropped.",
        number!(detector.iou, "", [0.0, 1.0], 0.01, 2, Slider, Some("the model's own"));
    DETECTOR_NAME: "detector.name_score", "Class from", "detector's score of a name",
        "Minimum score for a class name; below it the box is called an object.",
        number!(detector.name_score, "", [0.0, 1.0], 0.01, 2, Slider, Some("the model's own"));
    OBJECT_CLASSES: "review.classes", "Classes", "classes of objects",
        "Classes of boxes, in the order of the keys 1 to 9 and of the class numbers in training labels.",
        SettingKind::Text("a list of names");
    PICTURE_GAIN (UsuallyOneLog): "picture.gain", "Gain", "gain of the waterfall", "Whether levels of the waterfall are normalised across the track.",
        choice!(picture.gain, [
            "empirical", "gain-normalised", "Divided by the mean of the log at the same range and angle, as in the mosaic; shadows stay dark.";
            "recorded", "as recorded", "The recorder's own levels.";
        ]);
    // Spreading of intensity is 20 log r one way; the limits are twice the gain for both ways.
    PICTURE_SPREADING (UsuallyOneLog): "picture.spreading_db", "Spreading", "gain for spreading",
        "k of the time-varied gain k log10 r + 2 α r: dB for each tenfold slant range.",
        number!(picture.spreading_db, "dB", [-80.0, 80.0], 0.5, 1, Slider);
    // In sea water the absorption at 1.2 MHz is 0.5 dB a metre.
    PICTURE_ABSORPTION (UsuallyOneLog): "picture.absorption_db_m", "Absorption", "gain for absorption",
        "α of the time-varied gain k log10 r + 2 α r: dB for each metre, there and back.",
        number!(picture.absorption_db_m, "dB/m", [-1.0, 1.0], 0.005, 3, Slider);
    PICTURE_BALANCE (UsuallyOneLog): "picture.balance_db", "Balance", "balance of the sides",
        "Gain of starboard over port; negative values brighten port.",
        number!(picture.balance_db, "dB", [-40.0, 40.0], 0.1, 1, Slider);
    PICTURE_STRIPES (UsuallyOneLog): "picture.stripe_filter", "Stripes", "stripe filter",
        "Correction of pings that are brighter or darker than their neighbours.",
        choice!(picture.stripe_filter, [
            "false", "as recorded", "Pings are shown as they are.";
            "true", "filtered", "Each ping gets the median level of its neighbours.";
        ]);
    PICTURE_DESPECKLE (UsuallyOneLog): "picture.despeckle", "Speckle", "despeckling",
        "Removal of single bright and dark echoes.",
        choice!(picture.despeckle, [
            "false", "as recorded", "Echoes are shown as they are.";
            "true", "removed", "Each echo is the median of 3 x 3 echoes, at the resolution of the screen.";
        ]);
    // At the greatest gain the largest byte becomes 8000.
    PICTURE_BLACK (UsuallyOneLog): "picture.black", "Black", "black point",
        "Level that is shown as black; 255 is the largest byte.",
        number!(picture.black, "", [0.0, 10_000.0], 0.5, 1, Drag, Some("the 1st percentile of the echoes"));
    PICTURE_WHITE (UsuallyOneLog): "picture.white", "White", "white point",
        "Level that is shown as white; 255 is the largest byte.",
        number!(picture.white, "", [0.5, 10_000.0], 0.5, 1, Drag, Some("a little above the 99th percentile of the echoes"));
    PICTURE_GAMMA (UsuallyOneLog): "picture.gamma", "Gamma", "gamma of the waterfall",
        "Exponent 1 / gamma between black and white: above 1 brightens dark echoes.",
        number!(picture.gamma, "", [0.2, 5.0], 0.05, 2, LogSlider);
    PICTURE_FLIP (UsuallyOneLog): "picture.flip", "Along", "direction of the waterfall",
        "Direction of time in the waterfall.",
        choice!(picture.flip, [
            "false", "forward", "Later pings to the right, or below.";
            "true", "flipped", "Later pings to the left, or above.";
        ]);
    PICTURE_FIRST (UsuallyOneLog): "picture.starboard_first", "First", "side that comes first",
        "Side on which port is drawn. The data do not change; `mounting.swap_sides` corrects a recorder with exchanged sides.",
        choice!(picture.starboard_first, [
            "false", "port first", "Port is above, or to the left.";
            "true", "starboard first", "Starboard is above, or to the left.";
        ]);
    MOSAIC_CELL: "mosaic.cell_m", "Cell size", "cell of the mosaic",
        "Cell size of mosaic.tif; the map draws the mosaic at the resolution of the screen.",
        number!(mosaic.cell_m, "m", [0.01, 100.0], 0.01, 2, LogSlider);
    MOSAIC_COLOURS: "mosaic.colours", "Colours", "colours of the mosaic",
        "Colours of the mosaic, on the map and in the file.",
        choice!(mosaic.colours, [
            "grey", "grey", "Black to white.";
            "copper", "copper", "Black to copper.";
        ]);
    OVERLAP: "mosaic.overlap", "Overlap", "overlap",
        "Which pass is drawn where several passes saw the ground.",
        choice!(mosaic.overlap, [
            "later", "later on top", "The later pass.";
            "brighter", "brighter on top", "The brighter echo: keeps objects, loses shadows.";
            "middle", "middle on top", "The pass that saw the ground nearest to the middle of its swath: weak far ranges are drawn only where there is no other pass.";
            "blend", "blend", "The mean, weighted towards the middle of each swath: weakens objects and shadows.";
        ]);
    GAIN: "mosaic.gain", "Gain", "gain", "Whether levels are normalised across the track.",
        choice!(mosaic.gain, [
            "empirical", "gain-normalised", "Divided by the mean of the survey at the same range and angle; shadows stay dark.";
            "recorded", "as recorded", "The recorder's own levels.";
        ]);
    WATER_COLUMN: "mosaic.water_column", "Water column", "water column", "Echoes before the first return.",
        choice!(mosaic.water_column, [
            "false", "removed", "Slant ranges become distances on the ground, by the altitude.";
            "true", "kept", "Slant ranges are drawn as distances on the ground.";
        ]);
    NADIR_GAP: "mosaic.nadir_gap_deg", "Nadir gap", "nadir gap",
        "Ground within this angle from straight down is not drawn; 0 fills the gap under the boat.",
        number!(mosaic.nadir_gap_deg, "°", [0.0, 60.0], 1.0, 0, Slider);
    // The quickest boat turns once in a few seconds: with the upper limit no ping is excluded.
    MOST_TURN: "mosaic.most_turn_deg_s", "Turns from", "turn rate",
        "Pings at higher turn rates are not drawn, since their far ranges sweep over the ground.",
        number!(mosaic.most_turn_deg_s, "°/s", [0.1, 360.0], 0.1, 1, LogSlider);
    SURFACE_METHOD: "surface.method", "Interpolation", "method between depths",
        "Method of interpolation between soundings and side-scan points.",
        choice!(surface.method, [
            "linear", "triangles", "Linear on Delaunay triangles: passes through every depth.";
            "natural", "natural neighbours", "Sibson's method: passes through every depth, smooth between them, slower.";
            "inverse_distance", "inverse distance", "Mean of the nearest depths by inverse distance squared: smooth, flattens shoals and deeps.";
        ]);
    SURFACE_CELL: "surface.cell_m", "Cell size", "cell of the depth map",
        "Cell size of the depth map.",
        number!(surface.cell_m, "m", [0.01, 1000.0], 0.01, 2, LogSlider, Some("chosen from the spacing of the depths"));
    // More than a kilometre from any depth, a value would be invented, not interpolated.
    MAX_GAP: "surface.max_gap_m", "Largest gap", "gap of the depth map", "The map ends at this distance from the nearest depth.",
        number!(surface.max_gap_m, "m", [0.1, 1000.0], 0.1, 1, LogSlider);
    MAX_SIDE: "surface.max_side", "Most cells", "most cells of the depth map",
        "Most cells along the longer side. Cells become larger where there would be more, or more than 20 million in all.",
        number!(surface.max_side, "", [16.0, 32_768.0], 1.0, 0, LogSlider);
    // Only the ratio of the two weights has an effect: 0 to 1 covers every ratio.
    DOWN_SCAN_WEIGHT: "surface.down_scan_weight", "Soundings", "weight of soundings",
        "Weight of a sounding, and of a depth of StructureScan 3D, where several depths lie in one cell; 0 does not use them.",
        number!(surface.down_scan_weight, "", [0.0, 1.0], 0.05, 2, Slider);
    SIDE_SCAN_WEIGHT: "surface.side_scan_weight", "Side-scan", "weight of side-scan points",
        "Weight of a side-scan point where it shares a cell with a sounding; 0 does not use side-scan points.",
        number!(surface.side_scan_weight, "", [0.0, 1.0], 0.05, 2, Slider);
    SURFACE_ABOVE_BOTTOM: "surface.above_bottom", "Above bottom", "above-bottom returns in the depth map",
        "Whether the map uses all side-scan points above the recorded depth, which may be weed or fish.",
        choice!(surface.above_bottom, [
            "false", "not used", "Only those of long stretches are used: a field of boulders, but no weed, fish or object.";
            "true", "used", "All of them are used.";
        ]);
    LONGEST_ABOVE_BOTTOM: "surface.longest_above_bottom_m", "Long stretch", "longest above-bottom stretch",
        "Side-scan points above the recorded depth are used where most first returns of their side alone lie above it for longer than this.",
        number!(surface.longest_above_bottom_m, "m", [0.0, 100_000.0], 1.0, 0, LogSlider);
    SWATH: "surface.swath", "Echo levels", "depths from echo levels",
        "Whether depths between the lines come from echo levels: a bed that faces the boat is brighter. They are inferred, not measured.",
        choice!(surface.swath, [
            "auto", "automatic", "Used where they predict withheld soundings; an archive of many logs does not use them.";
            "off", "off", "Depths between the lines are interpolated only.";
            "always", "always", "Used wherever they can be read.";
        ]);
    RELIEF: "surface.relief", "Echo placement", "ground of echoes and objects",
        "The bottom on which echoes and objects are placed.",
        choice!(surface.relief, [
            "true", "measured bottom", "The depths that the log measured across the track; beyond them the last one.";
            "false", "level bottom", "The depth under the boat.";
        ]);
    // No depth is known to better than a millimetre.
    INTERVAL: "isobaths.interval_m", "Interval", "isobath interval",
        "Depth difference between isobaths, from depth 0. Every fifth is thick.",
        number!(isobaths.interval_m, "m", [0.001, 1000.0], 0.01, 2, LogSlider, Some("a round interval that gives about ten isobaths, no finer than the error"));
    LEVELS: "isobaths.depths_m", "Depths", "depths of the isobaths",
        "Depths of the isobaths, in place of the interval.",
        SettingKind::Numbers { unit: "m", range: [-10_000.0, 12_000.0], get: |settings| &settings.isobaths.depths_m };
    ISOBATH_UNIT: "isobaths.unit", "Unit", "unit of the isobaths",
        "Unit of isobath depths, of their labels and of spot soundings.",
        choice!(isobaths.unit, [
            "metres", "metres", "Metres.";
            "feet", "feet", "International feet of 0.3048 m.";
            "fathoms", "fathoms", "Fathoms of six feet.";
        ]);
    SMOOTH: "isobaths.smooth", "Smoothing", "isobath smoothing",
        "Number of smoothing passes over the isobaths; 0 leaves them as computed.",
        number!(isobaths.smooth, "", [0.0, 8.0], 1.0, 0, Slider);
    SHOAL_SAFE: "isobaths.shoal_safe", "Shoals", "isobaths at shoals",
        "Whether isobaths keep every shallower depth on their shallow side.",
        choice!(isobaths.shoal_safe, [
            "false", "as the map", "Isobaths follow the depth map, the median depth of each cell.";
            "true", "shoal-safe", "Isobaths move to deeper water until every shallower depth lies on their shallow side.";
        ]);
    SPOT_RADIUS: "isobaths.spot_radius_m", "Spot soundings", "distance of spot soundings",
        "Minimum distance between spot soundings; the shoalest within it is kept.",
        number!(isobaths.spot_radius_m, "m", [0.1, 100_000.0], 1.0, 1, LogSlider, Some("a round distance, about 1/40 of the diagonal of the map"));
    CLIP: "isobaths.clip", "Area", "area of the isobaths",
        "Shoreline with islands (GeoJSON, KML or GPX) at which isobaths, depth areas and spot soundings end.",
        SettingKind::Text("a file");
    POINTS_LAS: "points.las", "Plain LAS", "plain LAS",
        "Whether the points are also written as LAS, for programs that cannot read LAZ.",
        choice!(points.las, [
            "false", "LAZ only", "points/cloud.copc.laz only.";
            "true", "LAZ and LAS", "points/cloud.las too: the same points, four to five times as large.";
        ]);
    REPORT_PROPOSALS: "report.proposals", "Proposals", "proposals in the report",
        "Whether undecided proposals have a section in the report, as accepted objects have.",
        choice!(report.proposals, [
            "false", "not shown", "Only accepted and added objects have a section.";
            "true", "shown", "Undecided proposals follow the accepted objects.";
        ]);
}
