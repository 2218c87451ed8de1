//! Defines the settings of a simulated survey. All of them can be written as TOML; settings that
//! are left out keep their defaults.

use bathyscope_log::named;
use bathyscope_log::survey::MountingSettings;
use serde::{Deserialize, Serialize};

/// Settings of a simulated survey: the ground, the way of the boat, the recorder, its faults, and
/// objects.
///
/// East and north are metres from the scene's centre at `longitude_deg`, `latitude_deg`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Scene {
    /// Longitude of the scene's centre, degrees east.
    pub longitude_deg: f64,
    /// Latitude of the scene's centre, degrees north.
    pub latitude_deg: f64,
    /// Unix time of the first ping, seconds; 0 for a recorder that has no time.
    pub start_unix_s: u32,
    /// Time after which the survey ends, seconds, wherever the boat is then; `None`: the survey
    /// ends at the end of the track.
    pub duration_s: Option<f64>,
    /// The ground.
    pub bed: BedSettings,
    /// Way of the boat.
    pub track: TrackSettings,
    /// Settings of the recorder.
    pub recorder: RecorderSettings,
    /// Mounting of the recorder: the way of the boat is that of the transducer, and the log has the
    /// errors that these settings correct. The clock is wrong by whole seconds.
    pub mounting: MountingSettings,
    /// Faults of the recording and disturbances.
    pub artefacts: Artefacts,
    /// Objects at known places.
    pub objects: Vec<ObjectSettings>,
    /// Shoals of fish.
    pub shoals: Vec<Shoal>,
    /// Clumps of weed, in addition to the bed of weed on the track.
    pub weed_clumps: Vec<WeedClump>,
    /// Number of objects placed at random beside and below the lines, in addition to `objects`.
    pub scattered_objects: u32,
}

/// Character of the ground.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BedKind {
    /// Sand or mud, long swells with slopes up to 4 degrees.
    #[default]
    Gentle,
    /// Ridges and troughs with slopes up to 20 degrees.
    Steep,
    /// Gravel and stones: a few centimetres high, less than a metre long.
    Rough,
}

/// The ground.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BedSettings {
    /// Character of the ground.
    pub kind: BedKind,
    /// Seed of the swells, bumps and stones, so that several surveys can have the same ground;
    /// `None` for the seed of the survey.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// Mean depth of the swells, metres.
    pub mean_depth_m: f64,
    /// A level area, for calibration; `None` for none.
    pub terrace: Option<Terrace>,
    /// Banks around a rectangular pond; `None` for ground without a shore.
    pub bank: Option<Bank>,
    /// Ripples in patches; `None` for none.
    pub ripples: Option<RippleSettings>,
    /// Pits scoured out of the ground.
    pub pits: Vec<Pit>,
    /// Mounds and hollows.
    pub mounds: Vec<Mound>,
    /// Exponent of the cosine, of the angle from the normal of the ground, in the scattering law: 2
    /// is Lambert's law.
    pub scatter_power: f64,
    /// Factor on the differences between patches of finer and coarser sediment: usually 1 (2 dB), 0
    /// for ground of one kind.
    pub patch_factor: f64,
}

/// Law by which a recorder converts power to bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Curve {
    /// Bytes for each decibel.
    #[default]
    Decibel,
    /// Bytes in proportion to the amplitude: dark ground and very bright echoes.
    Amplitude,
    /// Bytes in proportion to the root of the amplitude: between the other two laws.
    Root,
}

/// A level rectangle in the ground.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Terrace {
    /// Centre, metres east.
    pub east_m: f64,
    /// Centre, metres north.
    pub north_m: f64,
    /// Extent from west to east, metres.
    pub length_m: f64,
    /// Extent from south to north, metres.
    pub width_m: f64,
    /// Depth of the terrace, metres.
    pub depth_m: f64,
    /// Width of the slope around the terrace, metres.
    pub edge_m: f64,
}

/// The shore of a rectangular pond.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bank {
    /// Extent of the water from west to east, metres.
    pub length_m: f64,
    /// Extent of the water from south to north, metres.
    pub width_m: f64,
    /// Slope of the bank, degrees.
    pub slope_deg: f64,
}

/// Way of the boat: lines in alternating directions along the east axis, then lines along the north
/// axis across them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TrackSettings {
    /// Number of lines along the east axis.
    pub lines: u32,
    /// Number of lines along the north axis.
    pub cross_lines: u32,
    /// Length of a line, metres.
    pub length_m: f64,
    /// Length of a cross line, metres.
    pub cross_length_m: f64,
    /// Distance between neighbouring lines, metres.
    pub spacing_m: f64,
    /// Radius of the turns, metres (tighter where the lines are too close).
    pub turn_radius_m: f64,
    /// Steady turn to starboard along a single line, degrees a metre.
    pub bend_deg_per_m: f64,
    /// Speed over ground, metres a second.
    pub speed_mps: f64,
    /// Side-scan pings a second.
    pub ping_rate_hz: f64,
    /// Fixes a second; each fix is written to every frame until the next fix.
    pub fix_rate_hz: f64,
    /// Corners of a way that replaces the lines, metres east and north; empty for the lines.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub corners_m: Vec<[f64; 2]>,
}

/// Settings of the recorder, which converts echoes to bytes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RecorderSettings {
    /// Slant range of the last side-scan sample, metres.
    pub range_m: f64,
    /// Number of samples on each side.
    pub samples_per_side: u32,
    /// Axis of the side beam below the horizontal, degrees.
    pub beam_axis_deg: f64,
    /// Vertical width of the side beam between its half-power (-3 dB, one way) directions, degrees.
    pub beam_width_deg: f64,
    /// Horizontal (along-track) width of the side beam, degrees.
    pub beam_azimuth_deg: f64,
    /// Distance that the recorder adds to every slant range that it writes, metres: the delay of
    /// its receiver.
    pub range_offset_m: f64,
    /// Length of the pulse: standard deviation of its power, metres of slant range.
    pub pulse_m: f64,
    /// Absorption of sound, dB per kilometre (455 kHz in fresh water of 20 C: 45.6).
    pub absorption_db_per_km: f64,
    /// Range beyond which the time-varied gain is constant, metres.
    pub tvg_limit_m: f64,
    /// Exponent of the range in the time-varied gain: with 3 the ground fades outward, with 5 level
    /// ground is evenly bright.
    pub tvg_power: f64,
    /// Electronic noise, in the unit of the echo power of a square metre of perfect scatterer at 1
    /// m.
    pub electronic_noise: f64,
    /// Sound scattered by the water itself at 1 m, in the unit of `electronic_noise`.
    pub volume_noise: f64,
    /// Byte of a level bottom's edge at the mean depth. At 105, fading raises 2 % of the echoes
    /// there above a ceiling of 120 (2.6 bytes a decibel); in the real river recording, 0.4 %
    /// (port) and 3.7 % (starboard) are at the top of the scale.
    pub bottom_byte: f64,
    /// Bytes for each decibel.
    pub bytes_per_db: f64,
    /// Law by which power is converted to bytes; `bytes_per_db` is used for [`Curve::Decibel`]
    /// only.
    pub curve: Curve,
    /// Standard deviation of the window that levels are smoothed with along the ping before they
    /// are written, samples; 0 for none.
    pub smoothing_samples: f64,
    /// Largest byte of an echo; ring-down may exceed it. The bytes of the published recordings are
    /// below 127.
    pub echo_ceiling: u8,
    /// Number of samples in a frame of the primary and of the down-scan channel.
    pub sonar_samples: u32,
    /// Number of side-scan pings for each ping of the primary and the down-scan channel.
    pub sonar_every: u32,
    /// True if the log has compass headings (with 2 degrees of noise).
    pub compass: bool,
}

/// Faults of the recording and disturbances. The default has most of them, in the amounts seen in
/// the field.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Artefacts {
    /// True for Rayleigh speckle.
    pub speckle: bool,
    /// Factor on the ring-down of the transducer: 1 as measured, 0 for none.
    pub ring_down: f64,
    /// Slow wander of the gain along the track, dB (standard deviation).
    pub gain_wander_db: f64,
    /// Share of pings with a fish in the water column.
    pub fish: f64,
    /// Share of pings that another sounder disturbs.
    pub interference: f64,
    /// Diameter of the weed bed on the track, metres; 0 for none.
    pub weed_m: f64,
    /// Factor on the gain along ten metres of the track; 1 for none.
    pub gain_drop: f64,
    /// Strength of the second bottom echo at twice the depth, dB below the first; 0 for none.
    pub second_echo_db: f64,
    /// Amplitude of the roll, degrees.
    pub roll_deg: f64,
    /// Noise of the recorded depth, metres (standard deviation).
    pub depth_noise_m: f64,
    /// Factor on the recorded depth: 1 for a sounder that measures the ground under the boat,
    /// another value where it measures something else.
    pub depth_scale: f64,
    /// Added to the recorded depth, metres: a draft or keel offset that the log does not state.
    pub depth_offset_m: f64,
    /// Slow wander of the fixes, the error of satellite positions, metres east and north (standard
    /// deviation each), relative to the error of the first fix.
    pub position_m: f64,
    /// Share of pings that are missing in the log.
    pub dropouts: f64,
    /// Factor on the recorded range along a fifth of the track; 1 for none.
    pub range_change: f64,
    /// Slant range at which the water surface returns an echo, metres: the depth of a towed
    /// transducer; 0 for none.
    pub surface_m: f64,
    /// Share of the samples in which a pebble or a shell glints.
    pub glints: f64,
}

/// Kind of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ObjectKind {
    /// A rounded, bumpy boulder.
    Rock,
    /// A crate or block with steep sides and a flat top.
    Block,
    /// A pipe or drum that lies on its side.
    Cylinder,
    /// A tyre that lies flat: a ring.
    Tyre,
    /// A sunken boat, open or keel up; its bow points along the heading.
    Boat,
    /// A tree trunk with branches, tapering and bent.
    Log,
    /// A body: head, torso and limbs.
    Effigy,
}

named! {
    /// All kinds, in the order of the classes of a detector.
    pub ObjectKind {
        Rock: "rock",
        Block: "block",
        Cylinder: "cylinder",
        Tyre: "tyre",
        Boat: "boat",
        Log: "log",
        Effigy: "effigy",
    }
}

/// An object on the ground.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObjectSettings {
    /// Kind of the object.
    pub kind: ObjectKind,
    /// Centre, metres east.
    pub east_m: f64,
    /// Centre, metres north.
    pub north_m: f64,
    /// Extent along the heading, metres.
    pub length_m: f64,
    /// Extent across the heading, metres.
    pub width_m: f64,
    /// Height above the ground if the object were not buried, metres.
    pub height_m: f64,
    /// Heading, the direction of the object's length, degrees clockwise from north.
    #[serde(default)]
    pub heading_deg: f64,
    /// Part of the height that has sunk into the ground, metres.
    #[serde(default)]
    pub buried_m: f64,
    /// Strength of the object's echoes over that of the ground, dB; `None` for 6. Metal has more,
    /// wood and rubber less.
    #[serde(default)]
    pub strength_db: Option<f64>,
}

/// Ripples of sand.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RippleSettings {
    /// Distance between crests, metres.
    pub wavelength_m: f64,
    /// Height of a crest above a trough, metres.
    pub height_m: f64,
    /// Direction across the crests, degrees clockwise from north.
    pub heading_deg: f64,
}

/// A round pit with a low rim.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pit {
    /// Centre, metres east.
    pub east_m: f64,
    /// Centre, metres north.
    pub north_m: f64,
    /// Radius of the pit without the rim, metres.
    pub radius_m: f64,
    /// Depth of the middle of the pit below the ground around, metres.
    pub depth_m: f64,
}

/// A round mound, or a hollow, without an edge: the ground rises by `height_m exp(-d^2 / (2
/// radius_m^2))` at the distance d.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mound {
    /// Centre, metres east.
    pub east_m: f64,
    /// Centre, metres north.
    pub north_m: f64,
    /// Distance from the centre at which the mound has 0.61 of its height and is steepest, metres.
    pub radius_m: f64,
    /// Height of the middle above the ground around, metres; negative for a hollow.
    pub height_m: f64,
}

/// A shoal of fish that stays in place while the boat passes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shoal {
    /// Centre, metres east.
    pub east_m: f64,
    /// Centre, metres north.
    pub north_m: f64,
    /// Depth of the centre below the water surface, metres.
    pub depth_m: f64,
    /// Radius within which most of the fish are, metres.
    pub radius_m: f64,
    /// Number of fish.
    pub count: u32,
    /// Strength of a fish over that of a level bottom's edge, dB.
    pub strength_db: f64,
}

/// A clump of water weed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WeedClump {
    /// Centre, metres east.
    pub east_m: f64,
    /// Centre, metres north.
    pub north_m: f64,
    /// Diameter of the clump, metres.
    pub diameter_m: f64,
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            longitude_deg: -82.110,
            latitude_deg: 29.410,
            start_unix_s: 1_634_000_000,
            duration_s: None,
            bed: BedSettings::default(),
            track: TrackSettings::default(),
            recorder: RecorderSettings::default(),
            mounting: MountingSettings::default(),
            artefacts: Artefacts::default(),
            objects: Vec::new(),
            shoals: Vec::new(),
            weed_clumps: Vec::new(),
            scattered_objects: 4,
        }
    }
}

impl Default for BedSettings {
    fn default() -> Self {
        Self {
            kind: BedKind::Gentle,
            seed: None,
            mean_depth_m: 2.6,
            terrace: Some(Terrace {
                east_m: 8.0,
                north_m: 0.0,
                length_m: 10.0,
                width_m: 20.0,
                depth_m: 2.5,
                edge_m: 6.0,
            }),
            bank: None,
            ripples: None,
            pits: Vec::new(),
            mounds: Vec::new(),
            scatter_power: 2.0,
            patch_factor: 1.0,
        }
    }
}

impl Default for TrackSettings {
    fn default() -> Self {
        Self {
            lines: 2,
            cross_lines: 2,
            length_m: 40.0,
            cross_length_m: 40.0,
            spacing_m: 10.0,
            turn_radius_m: 4.0,
            bend_deg_per_m: 0.0,
            speed_mps: 2.7,
            ping_rate_hz: 20.0,
            fix_rate_hz: 10.0,
            corners_m: Vec::new(),
        }
    }
}

impl Default for RecorderSettings {
    fn default() -> Self {
        Self {
            range_m: 12.0,
            samples_per_side: 1400,
            beam_axis_deg: 45.0,
            beam_width_deg: 58.0,
            beam_azimuth_deg: 0.9,
            range_offset_m: 0.0,
            pulse_m: 0.017,
            absorption_db_per_km: 45.6,
            tvg_limit_m: 6.0,
            tvg_power: 3.0,
            electronic_noise: 4e-11,
            volume_noise: 6e-11,
            bottom_byte: 105.0,
            bytes_per_db: 2.6,
            curve: Curve::Decibel,
            smoothing_samples: 0.0,
            echo_ceiling: 120,
            sonar_samples: 400,
            sonar_every: 2,
            compass: false,
        }
    }
}

impl Default for Artefacts {
    fn default() -> Self {
        Self {
            speckle: true,
            ring_down: 1.0,
            gain_wander_db: 1.0,
            fish: 0.03,
            interference: 0.015,
            weed_m: 8.0,
            gain_drop: 0.15,
            second_echo_db: 20.0,
            roll_deg: 2.0,
            depth_noise_m: 0.03,
            depth_scale: 1.0,
            depth_offset_m: 0.0,
            position_m: 0.0,
            dropouts: 0.005,
            range_change: 1.25,
            surface_m: 0.0,
            glints: 0.0,
        }
    }
}

impl Artefacts {
    /// Returns the settings of a recording without faults: speckle and ring-down only.
    pub fn none() -> Self {
        Self {
            gain_wander_db: 0.0,
            fish: 0.0,
            interference: 0.0,
            weed_m: 0.0,
            gain_drop: 1.0,
            second_echo_db: 0.0,
            roll_deg: 0.0,
            depth_noise_m: 0.0,
            dropouts: 0.0,
            range_change: 1.0,
            ..Self::default()
        }
    }
}
