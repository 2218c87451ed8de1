//! Computes the depth of the ground at every place from swells, roughness, stones, and the shapes
//! that water makes of sand: ripples in patches, scoured pits, mounds and hollows.

use super::arithmetic::{cos, exp, ln, sin};
use super::random::{NoiseField, Random, RandomPurpose, mix, smooth};
use super::scene::{BedKind, BedSettings, Mound, Pit, RippleSettings, Terrace};
use std::f64::consts::PI;

/// Properties of a kind of ground.
struct Character {
    /// Steepest slope that the swells can reach together, degrees.
    slope_deg: f64,
    /// Lengths of the swells, metres.
    wavelengths_m: [f64; 3],
    /// Two sizes of roughness: distance between bumps and standard deviation of their height,
    /// metres.
    roughness_m: [(f64, f64); 2],
    /// True if there are scattered stones.
    stones: bool,
    /// Shape parameter of the texture's gamma distribution: the smaller it is, the more the
    /// strength of neighbouring places differs.
    texture_shape: f64,
}

impl BedKind {
    fn character(self) -> Character {
        match self {
            BedKind::Gentle => Character {
                slope_deg: 4.0,
                wavelengths_m: [40.0, 26.0, 16.0],
                roughness_m: [(0.6, 0.004), (0.0, 0.0)],
                stones: false,
                texture_shape: 5.0,
            },
            BedKind::Steep => Character {
                slope_deg: 20.0,
                wavelengths_m: [24.0, 15.0, 10.0],
                ..BedKind::Gentle.character()
            },
            BedKind::Rough => Character {
                slope_deg: 6.0,
                wavelengths_m: [34.0, 21.0, 13.0],
                // Coarse gravel and cobbles, which rise above the ground by about half of their
                // size. In the real river recording, the first return scatters by 6 to 9 cm over
                // 1.5 m on its boulder fields.
                roughness_m: [(0.9, 0.035), (0.4, 0.012)],
                stones: true,
                texture_shape: 1.0,
            },
        }
    }
}

/// A long sine wave in the ground.
struct Swell {
    amplitude_m: f64,
    /// Wave number: radians per metre east and north.
    wave: [f64; 2],
    phase: f64,
}

/// The ground without objects. Places are metres from the scene's centre.
pub(super) struct SceneBed {
    mean_depth_m: f64,
    swells: Vec<Swell>,
    roughness: Vec<(NoiseField, f64)>,
    stones: Option<Stones>,
    ripples: Option<Ripples>,
    pits: Vec<Pit>,
    mounds: Vec<Mound>,
    texture: NoiseField,
    /// Spread of the texture's natural logarithm.
    texture_spread: f64,
    patches: NoiseField,
    /// Spread of the patches' natural logarithm.
    patch_spread: f64,
    /// Exponent of the cosine in the scattering law of the ground.
    pub scatter_power: f64,
    terrace: Option<Terrace>,
    /// Half extents of the pond east and north, metres, and slope of its bank (rise over run).
    bank: Option<[f64; 3]>,
}

/// Shares of the three swells in the steepest slope.
const SLOPE_SHARES: [f64; 3] = [0.55, 0.3, 0.15];
/// Distance over which the foot of the bank is rounded, metres.
const BANK_FOOT_M: f64 = 0.6;
/// Size of the grains of the texture, metres.
const TEXTURE_M: f64 = 0.4;
/// Size of the patches of finer and coarser sediment, metres, and standard deviation of the natural
/// logarithm of their strength (about 2 dB).
const PATCHES: (f64, f64) = (7.0, 0.45);
/// Size of the patches of ripples, and of the bends of their crests, metres.
const PATCH_M: (f64, f64) = (6.0, 2.5);
/// Bend of a crest, wavelengths (standard deviation).
const BEND: f64 = 0.25;
/// Square of the distance, in radii, beyond which a mound is lower than the last digit of any
/// depth: its height times e to the power of -50.
const FAR: f64 = 100.0;
/// Side of a square cell of the ground with one stone, metres.
const CELL_M: f64 = 1.6;
/// Smallest and largest radius of a stone, metres.
const RADIUS_M: (f64, f64) = (0.08, 0.28);
/// Height of a stone as a share of its radius. River stones rest on their flat side, are about 0.6
/// of their length high, and half of that is in the ground.
const HEIGHT_SHARE: f64 = 0.6;

impl SceneBed {
    /// Creates the ground of a scene; `seed` determines its swells and bumps.
    pub(super) fn new(settings: &BedSettings, seed: u64) -> Self {
        let character = settings.kind.character();
        let mut random = Random::new(seed, RandomPurpose::Swells, 0);
        let slope = tangent(character.slope_deg);
        let shares = SLOPE_SHARES.into_iter().zip(character.wavelengths_m);
        let swells = shares
            .map(|(share, wavelength_m)| {
                let number = 2.0 * PI / wavelength_m;
                let direction = random.between(0.0, 2.0 * PI);
                Swell {
                    amplitude_m: share * slope / number,
                    wave: [number * sin(direction), number * cos(direction)],
                    phase: random.between(0.0, 2.0 * PI),
                }
            })
            .collect();
        let roughness = character.roughness_m.iter().enumerate();
        Self {
            mean_depth_m: settings.mean_depth_m,
            swells,
            roughness: roughness
                .filter(|(_, (_, height_m))| *height_m > 0.0)
                .map(|(octave, (spacing_m, height_m))| {
                    let seed = seed.wrapping_add(octave as u64);
                    (NoiseField::new(seed, RandomPurpose::Roughness, *spacing_m), *height_m)
                })
                .collect(),
            stones: character.stones.then(|| Stones::new(seed)),
            ripples: settings.ripples.as_ref().map(|ripples| Ripples::new(ripples, seed)),
            pits: settings.pits.clone(),
            mounds: settings.mounds.clone(),
            texture: NoiseField::new(seed, RandomPurpose::Texture, TEXTURE_M),
            // A log-normal texture with the variance 1 / shape of the gamma distribution of mean 1.
            texture_spread: ln(1.0 + 1.0 / character.texture_shape).sqrt(),
            patches: NoiseField::new(seed, RandomPurpose::Patches, PATCHES.0),
            patch_spread: settings.patch_factor * PATCHES.1,
            scatter_power: settings.scatter_power,
            terrace: settings.terrace.clone(),
            bank: (settings.bank.as_ref())
                .map(|bank| [0.5 * bank.length_m, 0.5 * bank.width_m, tangent(bank.slope_deg)]),
        }
    }

    /// Creates a level, even ground without a shore at the mean depth, on which echo levels are
    /// set.
    pub(super) fn level(settings: &BedSettings) -> Self {
        Self {
            swells: Vec::new(),
            roughness: Vec::new(),
            stones: None,
            ripples: None,
            pits: Vec::new(),
            mounds: Vec::new(),
            texture_spread: 0.0,
            patch_spread: 0.0,
            terrace: None,
            bank: None,
            ..Self::new(settings, 0)
        }
    }

    /// Returns the depth of the ground below the water surface, metres; negative on land.
    pub(super) fn depth_m(&self, east_m: f64, north_m: f64) -> f64 {
        let mut depth = self.mean_depth_m;
        for swell in &self.swells {
            let angle = swell.wave[0] * east_m + swell.wave[1] * north_m + swell.phase;
            depth += swell.amplitude_m * sin(angle);
        }
        if let Some(terrace) = &self.terrace {
            depth += terrace.share(east_m, north_m) * (terrace.depth_m - depth);
        }
        if let Some([half_east, half_north, slope]) = self.bank {
            let inside = soft_min(half_east - east_m.abs(), half_north - north_m.abs(), 4.0);
            depth = soft_min(depth, slope * inside, BANK_FOOT_M);
        }
        for (field, height_m) in &self.roughness {
            depth += height_m * field.at(east_m, north_m);
        }
        if let Some(ripples) = &self.ripples {
            depth -= ripples.height_m(east_m, north_m);
        }
        for pit in &self.pits {
            depth += pit.depth_at_m(east_m, north_m);
        }
        for mound in &self.mounds {
            depth -= mound.height_at_m(east_m, north_m);
        }
        match &self.stones {
            Some(stones) => depth - stones.height_m(east_m, north_m),
            None => depth,
        }
    }

    /// Returns the scattering strength of a place, as a factor with a mean of about 1.
    pub(super) fn strength(&self, east_m: f64, north_m: f64) -> f64 {
        let texture = self.texture_spread * self.texture.at(east_m, north_m);
        let patches = self.patch_spread * self.patches.at(east_m, north_m);
        let variance =
            self.texture_spread * self.texture_spread + self.patch_spread * self.patch_spread;
        exp(texture + patches - 0.5 * variance)
    }
}

/// Ripples over the ground.
struct Ripples {
    amplitude_m: f64,
    /// Wave number: radians per metre east and north.
    wave: [f64; 2],
    patches: NoiseField,
    bends: NoiseField,
}

impl Ripples {
    /// Creates ripples; `seed` determines their patches and bends.
    fn new(settings: &RippleSettings, seed: u64) -> Self {
        let number = 2.0 * PI / settings.wavelength_m;
        let direction = settings.heading_deg.to_radians();
        Self {
            amplitude_m: 0.5 * settings.height_m,
            wave: [number * sin(direction), number * cos(direction)],
            patches: NoiseField::new(seed, RandomPurpose::Ripples, PATCH_M.0),
            bends: NoiseField::new(seed.wrapping_add(1), RandomPurpose::Ripples, PATCH_M.1),
        }
    }

    /// Returns the height of the ripples at a place, metres; the mean is 0.
    fn height_m(&self, east_m: f64, north_m: f64) -> f64 {
        let share = smooth(0.8 + 0.8 * self.patches.at(east_m, north_m));
        if share == 0.0 {
            return 0.0;
        }
        let bend = 2.0 * PI * BEND * self.bends.at(east_m, north_m);
        let phase = self.wave[0] * east_m + self.wave[1] * north_m + bend;
        let crest = sin(phase);
        // Narrow crests, wide troughs.
        share * self.amplitude_m * (crest + 0.4 * crest * crest - 0.2)
    }
}

impl Mound {
    /// Returns the height that is added to the ground at a place, metres.
    pub fn height_at_m(&self, east_m: f64, north_m: f64) -> f64 {
        let (east, north) = (east_m - self.east_m, north_m - self.north_m);
        let off = (east * east + north * north) / (self.radius_m * self.radius_m);
        if off > FAR { 0.0 } else { self.height_m * exp(-0.5 * off) }
    }
}

impl Pit {
    /// Returns the depth of the pit at a place below the ground around it, metres; negative on the
    /// rim of scoured-out sand.
    fn depth_at_m(&self, east_m: f64, north_m: f64) -> f64 {
        let (east, north) = (east_m - self.east_m, north_m - self.north_m);
        let off = (east * east + north * north) / (self.radius_m * self.radius_m);
        if off < 1.0 {
            return self.depth_m * (1.0 - off) * (1.0 - off);
        }
        // The rim is a ring half a radius wide, and highest midway.
        let rim = (off - 1.0) * (2.25 - off);
        if rim > 0.0 { -0.4 * self.depth_m * rim * rim } else { 0.0 }
    }
}

/// Scattered stones.
struct Stones {
    key: u64,
}

impl Stones {
    /// Creates stones; `seed` determines their places and sizes.
    fn new(seed: u64) -> Self {
        Self { key: mix(seed ^ mix(RandomPurpose::Stones as u64)) }
    }

    /// Returns the height of a stone's surface above the ground at a place, metres; 0 between
    /// stones.
    fn height_m(&self, east_m: f64, north_m: f64) -> f64 {
        let (column, row) = ((east_m / CELL_M).floor(), (north_m / CELL_M).floor());
        let place = (column as i64 as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)
            ^ (row as i64 as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
        let bits = mix(self.key ^ place);
        // Three numbers between 0 and 1 from the same 64 bits; small stones are more common than
        // large ones.
        let share = |shift: u32| ((bits >> shift) & 0xf_ffff) as f64 / f64::from(1 << 20);
        let size = share(40);
        let radius = RADIUS_M.0 + (RADIUS_M.1 - RADIUS_M.0) * size * size;
        let room = CELL_M - 2.0 * radius;
        let east = east_m - column * CELL_M - radius - room * share(0);
        let north = north_m - row * CELL_M - radius - room * share(20);
        let off = (east * east + north * north) / (radius * radius);
        HEIGHT_SHARE * radius * (1.0 - off).max(0.0).sqrt()
    }
}

impl Terrace {
    /// Returns 1 on the terrace, 0 away from it, and values between on the slope around it.
    fn share(&self, east_m: f64, north_m: f64) -> f64 {
        let beyond = |offset: f64, extent: f64| (offset.abs() - 0.5 * extent) / self.edge_m;
        let east = 1.0 - smooth(beyond(east_m - self.east_m, self.length_m));
        let north = 1.0 - smooth(beyond(north_m - self.north_m, self.width_m));
        east * north
    }
}

fn tangent(degrees: f64) -> f64 {
    let angle = degrees.to_radians();
    sin(angle) / cos(angle)
}

/// Returns the smaller of two numbers, with a smooth transition where they are within about `width`
/// of each other.
fn soft_min(a: f64, b: f64, width: f64) -> f64 {
    0.5 * (a + b - ((a - b) * (a - b) + width * width).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;

    fn steepest_deg(bed: &SceneBed) -> f64 {
        let mut steepest = 0.0_f64;
        for i in -200..200 {
            for j in -200..200 {
                let (east, north) = (f64::from(i) * 0.3, f64::from(j) * 0.3);
                let here = bed.depth_m(east, north);
                let rise_east = bed.depth_m(east + 0.3, north) - here;
                let rise_north = bed.depth_m(east, north + 0.3) - here;
                steepest = steepest.max(rise_east.hypot(rise_north) / 0.3);
            }
        }
        steepest.atan().to_degrees()
    }

    #[test]
    fn steep_ground_comes_close_to_twenty_degrees_and_stays_below() {
        let mut settings = Scene::steep().bed;
        settings.terrace = None;
        for seed in 0..5 {
            let steepest = steepest_deg(&SceneBed::new(&settings, seed));
            assert!((15.0..22.0).contains(&steepest), "{seed}: {steepest}");
        }
    }

    #[test]
    fn a_mound_rises_by_its_height_and_a_hollow_sinks() {
        let plain = Scene::gentle().bed;
        let mound =
            |east_m: f64, height_m: f64| Mound { east_m, north_m: 3.0, radius_m: 1.5, height_m };
        let settings =
            BedSettings { mounds: vec![mound(5.0, 0.4), mound(-20.0, -0.3)], ..plain.clone() };
        let [flat, with] = [&plain, &settings].map(|bed| SceneBed::new(bed, 3));
        let rise = |east: f64, north: f64| flat.depth_m(east, north) - with.depth_m(east, north);
        // The whole height at the centre, exp(-1/2) of it a radius away, and 0 far away.
        for (east_m, north_m, expected_m) in
            [(5.0, 3.0, 0.4), (5.0, 4.5, 0.4 * 0.606_530_66), (-20.0, 3.0, -0.3), (40.0, 40.0, 0.0)]
        {
            let rise_m = rise(east_m, north_m);
            assert!((rise_m - expected_m).abs() < 1e-6, "{east_m}: {rise_m}");
        }
    }

    #[test]
    fn terrace_is_level() {
        let settings = Scene::steep().bed;
        let terrace = settings.terrace.clone().expect("a terrace");
        let bed = SceneBed::new(&settings, 4);
        for step in -10..=10 {
            let depth = bed.depth_m(terrace.east_m + 0.49 * f64::from(step), terrace.north_m);
            assert!((depth - terrace.depth_m).abs() < 0.02, "{depth}");
        }
    }

    #[test]
    fn stones_cover_a_small_share_of_the_ground_and_stay_low() {
        let stones = Stones::new(5);
        let (mut covered, mut highest) = (0, 0.0_f64);
        let places = 400;
        for i in 0..places {
            for j in 0..places {
                let height = stones.height_m(f64::from(i) * 0.05 - 9.0, f64::from(j) * 0.05 - 9.0);
                covered += usize::from(height > 0.0);
                highest = highest.max(height);
            }
        }
        let share = covered as f64 / f64::from(places * places);
        assert!((0.02..0.08).contains(&share), "{share}");
        assert!((0.12..0.17).contains(&highest), "{highest}");
    }
}
