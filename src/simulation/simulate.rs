//! Simulates a survey from a scene and a seed.

use super::artefacts::{ArtefactPlan, Fishes, Trouble};
use super::bed::SceneBed;
use super::echo::{Echo, ObjectEcho};
use super::listener::{WeedBed, World};
use super::objects;
use super::path::{BoatPose, Path};
use super::random::{Random, RandomPurpose};
use super::recorder::{GRAIN, Receiver};
use super::scene::Scene;
use super::truth::{self, ObjectPass, ObjectTruth, PingTruth, SideTruth};
use super::visibility::{Trace, visible_part};
use bathyscope_log::formats::lowrance::write::{Sl2Frame, Sl2Writer};
use bathyscope_log::support::geo::{
    LocalFrame, LonLat, lowrance_mercator, lowrance_mercator_inverse,
};
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::Side;
use rayon::prelude::*;
use std::io::{self, Write};

/// A simulated survey: the log and the truth about it.
pub struct Simulated {
    /// One entry per recorded side-scan ping, in the order of the log.
    pub pings: Vec<PingTruth>,
    /// The objects on the ground.
    pub objects: Vec<ObjectTruth>,
    /// Local coordinate frame of the survey: its origin is the first recorded fix, so it equals the
    /// frame of the opened log.
    pub frame: LocalFrame,
    frames: Vec<Sl2Frame>,
    start_unix_s: u32,
    world: World,
    scene_frame: LocalFrame,
}

/// Temperature of the water, degrees Celsius, for which the default absorption holds.
const WATER_C: f32 = 20.0;
/// Number of pings between two checks for cancellation.
const CHUNK: usize = 64;

/// Simulates a scene with a seed. The scene should have passed [`Scene::check`].
///
/// # Errors
/// When `progress` was cancelled.
pub fn simulate(scene: &Scene, seed: u64, progress: &Progress) -> Result<Simulated, Cancelled> {
    let run = SimulationRun::new(scene, seed);
    let count = scene.pings_along(&run.path).ceil() as u64;
    progress.start(count);
    let mut received = Vec::new();
    for first in (0..count).step_by(CHUNK) {
        progress.check()?;
        let last = (first + CHUNK as u64).min(count);
        let chunk: Vec<ReceivedPing> =
            (first..last).into_par_iter().filter_map(|ping| run.ping(ping)).collect();
        received.extend(chunk);
        progress.advance(last - first);
    }
    Ok(run.finish(received))
}

impl Simulated {
    /// Writes the log as SL2.
    ///
    /// # Errors
    /// When writing fails.
    pub fn write_sl2(&self, out: &mut impl Write) -> io::Result<()> {
        let mut writer = Sl2Writer::new(out, self.start_unix_s, Some(WATER_C))?;
        self.frames.iter().try_for_each(|frame| writer.push(frame))
    }

    /// Returns the log as SL2 in memory.
    pub fn sl2_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        // Writing to memory fails only for a log beyond the format's 4 GiB, which `Scene::check`
        // refuses.
        self.write_sl2(&mut bytes).ok();
        bytes
    }

    /// Returns the true depth of the ground (objects included, weed not) at a place in the survey's
    /// local coordinate frame, metres; negative on land.
    pub fn bed_depth_m(&self, east_m: f64, north_m: f64) -> f64 {
        let position = self.frame.to_lon_lat(east_m, north_m);
        let [east, north] = self.scene_frame.to_enu(position);
        self.world.depth_m(east, north)
    }

    /// Returns the true scattering strength of the ground, without objects, at a place in the
    /// survey's local coordinate frame, as a factor of about 1.
    pub fn bed_strength(&self, east_m: f64, north_m: f64) -> f64 {
        let position = self.frame.to_lon_lat(east_m, north_m);
        let [east, north] = self.scene_frame.to_enu(position);
        self.world.bed.strength(east, north)
    }
}

/// Data of a simulation that all pings share.
pub(super) struct SimulationRun<'a> {
    pub scene: &'a Scene,
    pub seed: u64,
    path: Path,
    pub plan: ArtefactPlan<'a>,
    pub world: World,
    shoals: Vec<Fishes>,
    pub scene_frame: LocalFrame,
    frame: LocalFrame,
    /// The receivers at the usual and at the changed range.
    receivers: [Receiver<'a>; 2],
}

/// A recorded ping with the truth about it.
pub(super) struct ReceivedPing {
    /// Number of the ping, with missing pings counted.
    pub ping: u64,
    pub truth: PingTruth,
    seen: Vec<(Side, ObjectEcho)>,
    traces: Vec<Trace>,
    /// Recorded samples: port from far to near, then starboard from near to far.
    pub composite: Vec<u8>,
    pub range_m: f64,
}

impl<'a> SimulationRun<'a> {
    fn new(scene: &'a Scene, seed: u64) -> Self {
        let path = Path::new(&scene.track);
        let scene_frame = LocalFrame::new(LonLat::new(scene.longitude_deg, scene.latitude_deg));
        let start = path.at(0.0);
        let [x, y] = mercator(&scene_frame, start.antenna(&scene.mounting));
        let range_m = scene.recorder.range_m;
        Self {
            scene,
            seed,
            plan: ArtefactPlan::new(scene, &path, seed),
            world: World {
                bed: SceneBed::new(&scene.bed, scene.bed.seed.unwrap_or(seed)),
                objects: objects::place(scene, &path, seed),
                weed: weed(scene, &path, seed),
            },
            shoals: (scene.shoals.iter().zip(seed..))
                .map(|(shoal, seed)| Fishes::new(shoal, seed))
                .collect(),
            frame: LocalFrame::new(lowrance_mercator_inverse(f64::from(x), f64::from(y))),
            scene_frame,
            path,
            receivers: [
                Receiver::new(scene, range_m),
                Receiver::new(scene, range_m * scene.artefacts.range_change),
            ],
        }
    }

    /// Returns the recorded time of a ping, whole milliseconds.
    pub(super) fn milliseconds(&self, ping: u64) -> i32 {
        (ping as f64 * 1000.0 / self.scene.track.ping_rate_hz).round() as i32
    }

    pub(super) fn pose_at(&self, time_s: f64) -> BoatPose {
        self.path.at(time_s * self.scene.track.speed_mps)
    }

    /// Simulates one ping; `None` when the ping is missing in the log.
    fn ping(&self, ping: u64) -> Option<ReceivedPing> {
        let time_s = f64::from(self.milliseconds(ping)) / 1000.0;
        let travelled_m = time_s * self.scene.track.speed_mps;
        let trouble = self.plan.at(ping, time_s, travelled_m);
        // The first ping is never missing: it defines the survey's origin.
        if trouble.missing && ping > 0 {
            return None;
        }
        let pose = self.pose_at(time_s);
        let changed = trouble.range_m != self.scene.recorder.range_m;
        let receiver = &self.receivers[usize::from(changed)];
        let sides = Side::BOTH.map(|side| self.side(ping, pose, side, &trouble, receiver));
        let [(port, left), (starboard, right)] = &sides;
        let [left, right] =
            if self.scene.mounting.swap_sides { [right, left] } else { [left, right] };
        let mut composite: Vec<u8> = left.iter().rev().copied().collect();
        composite.extend(right);
        let echoes = || Side::BOTH.into_iter().zip([port, starboard]);
        let position = self.scene_frame.to_lon_lat(pose.east_m, pose.north_m);
        let [east_m, north_m] = self.frame.to_enu(position);
        Some(ReceivedPing {
            ping,
            truth: PingTruth {
                time_s,
                position,
                east_m,
                north_m,
                heading_rad: pose.heading_rad,
                depth_m: self.world.depth_m(pose.east_m, pose.north_m),
                metres_per_sample: receiver.metres_per_sample,
                port: side_truth(port),
                starboard: side_truth(starboard),
            },
            seen: echoes()
                .flat_map(|(side, echo)| echo.seen.iter().map(move |seen| (side, *seen)))
                .collect(),
            traces: echoes()
                .flat_map(|(side, echo)| traces(echo, side, &trouble, receiver))
                .collect(),
            composite,
            range_m: receiver.range_m,
        })
    }

    fn side(
        &self,
        ping: u64,
        pose: BoatPose,
        side: Side,
        trouble: &Trouble,
        receiver: &Receiver,
    ) -> (Echo, Vec<u8>) {
        // Rolling to starboard turns the starboard beam down and the port beam up.
        let roll_rad = side.to_starboard(trouble.roll_rad);
        let echo = receiver.listen(&self.world, pose, side, roll_rad);
        let mut random = Random::new(self.seed, RandomPurpose::Speckle, 2 * ping + side as u64);
        let mut fish = Vec::from_iter(self.fish(trouble, side, echo.first_return_m));
        fish.extend(self.surface(ping));
        for shoal in &self.shoals {
            let depth_m = self.world.depth_m(pose.east_m, pose.north_m);
            fish.extend(shoal.echoes(pose, side, &receiver.beam, depth_m));
        }
        let bytes = receiver.record(&echo, trouble, &fish, &mut random);
        (echo, bytes)
    }

    /// Returns the slant range (metres) and strength (dB) of a fish nearer than the ground; `None`
    /// where this side insonifies none.
    fn fish(&self, trouble: &Trouble, side: Side, first_return_m: f64) -> Option<[f64; 2]> {
        let fish = trouble.fish.filter(|fish| fish.side == side)?;
        let range_m = fish.range_m(self.true_depth_m(fish.first_ping));
        (range_m < first_return_m).then_some([range_m, fish.strength_db])
    }

    /// Returns the slant range (metres) and strength (dB) of the water surface over a towed
    /// transducer; `None` for a transducer at the surface.
    fn surface(&self, ping: u64) -> Option<[f64; 2]> {
        let surface_m = self.scene.artefacts.surface_m;
        let mut random = Random::new(self.seed, RandomPurpose::Wander, ping);
        let [wave, strength] = random.normal_pair();
        (surface_m > 0.0)
            .then_some([surface_m + SURFACE_WAVES_M * wave, SURFACE_DB + 3.0 * strength])
    }

    /// Returns the true depth under the boat at a ping, metres.
    pub(super) fn true_depth_m(&self, ping: u64) -> f64 {
        let pose = self.pose_at(f64::from(self.milliseconds(ping)) / 1000.0);
        self.world.depth_m(pose.east_m, pose.north_m)
    }

    fn finish(self, mut received: Vec<ReceivedPing>) -> Simulated {
        Simulated {
            objects: self.object_truth(&received),
            frames: self.frames(&mut received),
            pings: received.into_iter().map(|ping| ping.truth).collect(),
            frame: self.frame,
            start_unix_s: recorded_start_s(self.scene),
            world: self.world,
            scene_frame: self.scene_frame,
        }
    }

    fn object_truth(&self, received: &[ReceivedPing]) -> Vec<ObjectTruth> {
        let mut objects: Vec<ObjectTruth> = self
            .world
            .objects
            .iter()
            .map(|placed| {
                let object = &placed.settings;
                let position = self.scene_frame.to_lon_lat(object.east_m, object.north_m);
                let [east_m, north_m] = self.frame.to_enu(position);
                ObjectTruth {
                    kind: object.kind,
                    position,
                    east_m,
                    north_m,
                    length_m: object.length_m,
                    width_m: object.width_m,
                    height_m: (object.height_m - object.buried_m).max(0.0),
                    heading_deg: object.heading_deg,
                    sightings: Vec::new(),
                }
            })
            .collect();
        for (ping, received_ping) in received.iter().enumerate() {
            for (side, seen) in &received_ping.seen {
                truth::note(&mut objects[seen.object].sightings, ping, *side, seen);
            }
        }
        let spacing_m = self.scene.track.speed_mps / self.scene.track.ping_rate_hz;
        for (index, object) in objects.iter_mut().enumerate() {
            for sighting in &mut object.sightings {
                let middle_m = 0.5 * (sighting.near_m + sighting.far_m);
                let spread_m = self.receivers[0].beam.spread_at_m(middle_m);
                sighting.spread_pings = (spread_m / spacing_m).round() as usize;
                sighting.shown = visible_part(&pass(received, index, sighting), spacing_m, GRAIN);
            }
        }
        objects
    }
}

/// Returns the start time of the log by the recorder's clock, Unix seconds; 0 for a recorder that
/// has no time.
fn recorded_start_s(scene: &Scene) -> u32 {
    match scene.start_unix_s {
        0 => 0,
        start_s => (f64::from(start_s) - scene.mounting.clock_offset_s).round() as u32,
    }
}

/// Height of the waves over a towed transducer, metres (standard deviation).
const SURFACE_WAVES_M: f64 = 0.02;
/// Strength of the water surface over that of a level bottom's edge, dB.
const SURFACE_DB: f64 = -8.0;
/// Largest distance of weed behind the first return of the ground at which the weed still changes
/// the edge of the ground, metres.
const WEED_MARGIN_M: f64 = 0.1;

/// Creates the bed of weed on the track, and the clumps that the scene lists.
fn weed(scene: &Scene, path: &Path, seed: u64) -> Vec<WeedBed> {
    let clumps = scene.weed_clumps.iter().zip(seed.wrapping_add(1)..);
    let clumps = clumps
        .map(|(clump, seed)| WeedBed::at([clump.east_m, clump.north_m], clump.diameter_m, seed));
    WeedBed::new(scene.artefacts.weed_m, path, seed).into_iter().chain(clumps).collect()
}

/// Returns the changes in the levels of one side by each object that the beam met.
fn traces(echo: &Echo, side: Side, trouble: &Trouble, receiver: &Receiver) -> Vec<Trace> {
    let without = echo.without.iter();
    without
        .filter_map(|(object, without)| {
            receiver.trace([&echo.power, without], trouble, side, *object)
        })
        .collect()
}

/// Returns the traces of one object in the pings of a pass, with the index of each ping.
fn pass<'a>(
    received: &'a [ReceivedPing],
    object: usize,
    sighting: &ObjectPass,
) -> Vec<(usize, &'a Trace)> {
    // The outer rays of the beam are sqrt(3) standard deviations from the middle.
    let margin = 2 * sighting.spread_pings + 1;
    let first = sighting.first_ping.saturating_sub(margin);
    let end = (sighting.last_ping + margin + 1).min(received.len());
    let pings = (first..end).zip(&received[first..end]);
    let traces =
        pings.flat_map(|(ping, received)| received.traces.iter().map(move |trace| (ping, trace)));
    traces.filter(|(_, trace)| trace.object == object && trace.side == sighting.side).collect()
}

fn side_truth(echo: &Echo) -> SideTruth {
    SideTruth {
        first_return_m: echo.first_return_m,
        weed: echo.canopy_m < echo.first_return_m + WEED_MARGIN_M,
    }
}

/// Returns the Lowrance Mercator metres, rounded to whole metres, of a place in a local coordinate
/// frame.
pub(super) fn mercator(frame: &LocalFrame, pose: BoatPose) -> [i32; 2] {
    lowrance_mercator(frame.to_lon_lat(pose.east_m, pose.north_m))
        .map(|metres| metres.round() as i32)
}
