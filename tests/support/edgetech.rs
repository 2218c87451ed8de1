//! Writes small JSF files for tests, field by field as `mod.rs` describes them.

/// Options of a generated file.
#[derive(Clone, Debug)]
pub struct JsfOptions {
    /// Pings of each subsystem.
    pub pings: usize,
    /// Subsystems, each with port and starboard.
    pub subsystems: Vec<u8>,
    /// 0 envelope, 1 analytic signal, others as numbers.
    pub data_format: u16,
    /// Units of the coordinates; 0 for none.
    pub units: u16,
    /// Weighting factors, one ping after another.
    pub weights: Vec<i16>,
    /// Speed of sound, metres a second; 0 for none.
    pub sound_mps: f32,
    /// Samples of a side of a ping.
    pub samples: usize,
    /// Nanoseconds from sample to sample.
    pub interval_ns: u32,
    /// Traces as message 82.
    pub old: bool,
}

impl Default for JsfOptions {
    fn default() -> Self {
        Self {
            pings: 40,
            subsystems: vec![20],
            data_format: 0,
            units: 2,
            weights: vec![0],
            sound_mps: 1480.0,
            samples: 200,
            interval_ns: 166_000,
            old: false,
        }
    }
}

/// Unix seconds of the first ping: `date -u -d "2021-06-05 12:00:00" +%s`.
pub const START_S: i32 = 1_622_894_400;
/// Milliseconds from ping to ping.
pub const PING_MS: usize = 125;
/// Writes into a record.
pub fn put(bytes: &mut [u8], at: usize, field: &[u8]) {
    bytes[at..at + field.len()].copy_from_slice(field);
}

/// A message with its header.
pub fn message(kind: u16, subsystem: u8, channel: u8, body: &[u8]) -> Vec<u8> {
    let mut bytes = vec![0x01, 0x16, 0x0C, 0];
    bytes.extend(kind.to_le_bytes());
    bytes.extend([0, subsystem, channel, 0, 0, 0]);
    bytes.extend((body.len() as u32).to_le_bytes());
    bytes.extend(body);
    bytes
}

/// Value of a sample before its weight: it falls with the range and differs from side to side and
/// ping to ping.
pub fn value(ping: usize, channel: u8, sample: usize) -> u16 {
    ((sample * 7 + ping * 3 + usize::from(channel) * 40) % 1000) as u16
}

/// A whole file: system information, then for each ping a NMEA sentence and the traces of all
/// subsystems.
pub fn jsf(options: &JsfOptions) -> Vec<u8> {
    let mut system = vec![0; 24];
    put(&mut system, 0, &17_i32.to_le_bytes());
    put(&mut system, 20, &31_337_i32.to_le_bytes());
    let mut file = message(182, 0, 0, &system);
    for ping in 0..options.pings {
        let ms = ping * PING_MS;
        let mut nmea = Vec::new();
        nmea.extend((START_S + (ms / 1000) as i32).to_le_bytes());
        nmea.extend(((ms % 1000) as i32).to_le_bytes());
        nmea.extend([2, 0, 0, 0]);
        let minutes = 7.038 + ping as f64 * 1e-4;
        nmea.extend(
            format!("$GPGGA,120000,48{minutes:07.4},N,01131.0000,E,1,08,0.9,5.4,M,46.9,M,,\r\n")
                .bytes(),
        );
        file.extend(message(2002, 100, 0, &nmea));
        for &subsystem in &options.subsystems {
            for channel in 0..2 {
                let body = if options.old {
                    old_trace(options, ping)
                } else {
                    trace(options, ping, subsystem)
                };
                let body = [body, samples(options, ping, channel)].concat();
                let kind = if options.old { 82 } else { 80 };
                file.extend(message(kind, subsystem, channel, &body));
            }
        }
    }
    file
}

fn weight(options: &JsfOptions, ping: usize) -> i16 {
    options.weights[ping % options.weights.len()]
}

fn samples(options: &JsfOptions, ping: usize, channel: u8) -> Vec<u8> {
    let mut bytes = Vec::new();
    for sample in 0..options.samples {
        // The same volts at any weight, as far as its bits reach.
        let volts = f64::from(value(ping, channel, sample));
        let stored = volts * 2.0_f64.powi(i32::from(weight(options, ping)));
        match options.data_format {
            1 | 9 => {
                // 3, 4, 5 make a right angle.
                bytes.extend(((stored * 0.6) as i16).to_le_bytes());
                bytes.extend(((-stored * 0.8) as i16).to_le_bytes());
            }
            _ => bytes.extend((stored as u16).to_le_bytes()),
        }
    }
    bytes
}

fn trace(options: &JsfOptions, ping: usize, subsystem: u8) -> Vec<u8> {
    let ms = ping * PING_MS;
    let mut bytes = vec![0; 240];
    put(&mut bytes, 0, &(START_S + (ms / 1000) as i32).to_le_bytes());
    put(&mut bytes, 8, &(ping as u32).to_le_bytes());
    put(&mut bytes, 28, &1_i16.to_le_bytes());
    put(&mut bytes, 30, &0x407F_u16.to_le_bytes());
    put(&mut bytes, 34, &options.data_format.to_le_bytes());
    let [x, y] = match options.units {
        // 11.5 degrees east, 48.1 north, going north.
        2 => [6_900_000, 28_860_000 + 3 * ping as i32],
        1 => [412_000_000, 2_000_000_000 + 500 * ping as i32],
        3 => [4_120_000, 47_300_000 + 5 * ping as i32],
        4 => [41_200_000, 473_000_000 + 50 * ping as i32],
        _ => [0, 0],
    };
    put(&mut bytes, 80, &x.to_le_bytes());
    put(&mut bytes, 84, &y.to_le_bytes());
    put(&mut bytes, 88, &options.units.to_le_bytes());
    put(&mut bytes, 114, &(options.samples as u16).to_le_bytes());
    put(&mut bytes, 16, &(((options.samples >> 16) as u16) << 8).to_le_bytes());
    put(&mut bytes, 116, &options.interval_ns.to_le_bytes());
    let middle: u16 = if subsystem == 20 { 12_000 } else { 41_000 };
    put(&mut bytes, 126, &(middle - 500).to_le_bytes());
    put(&mut bytes, 128, &(middle + 500).to_le_bytes());
    put(&mut bytes, 136, &3000_i32.to_le_bytes());
    put(&mut bytes, 144, &(6500 + 10 * ping as i32).to_le_bytes());
    put(&mut bytes, 148, &options.sound_mps.to_le_bytes());
    put(&mut bytes, 168, &weight(options, ping).to_le_bytes());
    put(&mut bytes, 172, &(1250 + ping as u16).to_le_bytes());
    put(&mut bytes, 192, &123_i16.to_le_bytes());
    put(&mut bytes, 194, &41_i16.to_le_bytes());
    let today_ms = 43_200_000 + ms as u32;
    put(&mut bytes, 200, &today_ms.to_le_bytes());
    put(&mut bytes, 220, &1_u16.to_le_bytes());
    bytes
}

fn old_trace(options: &JsfOptions, ping: usize) -> Vec<u8> {
    let ms = ping * PING_MS;
    let seconds = ms / 1000;
    let mut bytes = vec![0; 80];
    put(&mut bytes, 4, &(ping as u32).to_le_bytes());
    put(&mut bytes, 8, &1_u16.to_le_bytes());
    put(&mut bytes, 12, &(options.samples as u32).to_le_bytes());
    put(&mut bytes, 16, &options.interval_ns.to_le_bytes());
    put(&mut bytes, 24, &weight(options, ping).to_le_bytes());
    put(&mut bytes, 36, &options.data_format.to_le_bytes());
    put(&mut bytes, 40, &(43_200_000 + ms as u32).to_le_bytes());
    // 5 June 2021 is day 156.
    for (at, field) in [2021, 156, 12, seconds / 60, seconds % 60].into_iter().enumerate() {
        put(&mut bytes, 44 + 2 * at, &(field as u16).to_le_bytes());
    }
    bytes
}
