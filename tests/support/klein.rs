//! Writes small SDF files for tests, page by page as `mod.rs` describes them.

/// Options of a generated file.
#[derive(Clone, Debug)]
pub struct SdfOptions {
    /// Pages.
    pub pages: usize,
    /// Versions of the pages, one after another.
    pub versions: Vec<u32>,
    /// Samples of a side.
    pub samples: usize,
    /// Samples a second; 0 writes none.
    pub rate_hz: u32,
    /// True if the low frequency of the System 3000 has samples.
    pub has_low: bool,
    /// Added to the samples.
    pub louder: u32,
}

impl Default for SdfOptions {
    fn default() -> Self {
        Self {
            pages: 40,
            versions: vec![3001],
            samples: 150,
            rate_hz: 2250,
            has_low: false,
            louder: 0,
        }
    }
}

/// The first ping: `date -u -d "2026-03-04 10:00:00" +%s`.
pub const BEGAN_S: f64 = 1_772_618_400.0;
/// Range that is set, metres.
pub const RANGE_M: u32 = 50;

/// A stored sample.
pub fn stored(options: &SdfOptions, page: usize, side: usize, sample: usize) -> u32 {
    options.louder + ((sample * 3 + page * 5 + side * 50) % 250) as u32
}

/// A whole file; a page each 0.1 s.
pub fn sdf(options: &SdfOptions) -> Vec<u8> {
    let version = |page: usize| options.versions[page % options.versions.len()];
    (0..options.pages).flat_map(|page| self::page(options, page, version(page))).collect()
}

fn page(options: &SdfOptions, page: usize, version: u32) -> Vec<u8> {
    let header_length = if version.is_multiple_of(10) { 256 } else { 512 };
    let mut header = vec![0_u8; header_length];
    let mut put = |at: usize, value: &[u8]| header[at..at + value.len()].copy_from_slice(value);
    let number = |value: u32| value.to_le_bytes();
    let time = page / 10;
    let second = page as u32 / 10;
    for (at, value) in [
        (4, version),
        (12, page as u32),
        (16, options.samples as u32),
        (28, RANGE_M),
        (36, 150_000),
        (68, 2026),
        (72, 3),
        (76, 4),
        (80, 10),
        (84, second / 60),
        (88, second % 60),
        (92, 10 * (page as u32 % 10)),
        (180, header_length as u32),
        (224, options.rate_hz),
    ] {
        put(at, &number(value));
    }
    let is_vehicle = matches!(version, 3501 | 3502);
    let [heading, altitude, place] = if is_vehicle { [136, 208, 144] } else { [108, 124, 160] };
    put(heading, &271.5_f32.to_le_bytes());
    put(132, &2.0_f32.to_le_bytes());
    put(altitude, &(8.0 + time as f32 / 10.0).to_le_bytes());
    put(216, &((page % 10) as f32 / 10.0).to_le_bytes());
    let lat_rad = (48.0 + page as f64 * 1e-6).to_radians();
    put(place, &lat_rad.to_le_bytes());
    put(place + 8, &11.5_f64.to_radians().to_le_bytes());
    if is_vehicle {
        put(404, &number(if version == 3501 { 455 } else { 900 }));
    }
    let mut data = Vec::new();
    let bands: &[bool] = match version {
        3000 | 3001 => &[options.has_low, true],
        3501 | 3502 => &[true],
        _ => &[],
    };
    for (has_samples, side) in bands.iter().flat_map(|has| [(*has, 0), (*has, 1)]) {
        let count = if has_samples { options.samples } else { 0 };
        let wide = |value: u32| {
            if is_vehicle {
                value.to_le_bytes().to_vec()
            } else {
                (value as u16).to_le_bytes().to_vec()
            }
        };
        data.extend(wide(count as u32));
        data.extend((0..count).flat_map(|sample| wide(stored(options, page, side, sample))));
    }
    let length = (header.len() + data.len()) as u32;
    header[..4].copy_from_slice(&number(length));
    [vec![0xFF; 4], header, data].concat()
}
