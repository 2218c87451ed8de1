//! Writes small svlog files for tests, packet by packet as `mod.rs` describes them.

/// Options of a generated file.
#[derive(Clone, Debug)]
pub struct SvlogOptions {
    /// Pings of each side.
    pub pings: usize,
    /// Samples of a side of a ping.
    pub samples: usize,
    /// Channel numbers of port and starboard.
    pub channels: [u8; 2],
    /// Pings of one side that come in a row.
    pub in_a_row: usize,
    /// Positions: 109 NMEA, 150 MAVLink, 0 none.
    pub positions: u16,
    /// Beginning of the range, millimetres.
    pub start_mm: u32,
    /// Least and most decibels, one ping after another.
    pub powers_db: Vec<[f32; 2]>,
    /// Decibels from ping to ping.
    pub louder_db: f64,
    /// Milliseconds that the port transducer was switched on earlier.
    pub port_earlier_ms: u32,
}

impl Default for SvlogOptions {
    fn default() -> Self {
        Self {
            pings: 40,
            samples: 200,
            channels: [0, 1],
            in_a_row: 1,
            positions: 109,
            start_mm: 0,
            powers_db: vec![[-90.0, -40.0]],
            louder_db: 0.0,
            port_earlier_ms: 0,
        }
    }
}

/// Start of the recording, Unix seconds: `date -u -d "2026-03-04 10:00:00" +%s`.
pub const BEGAN_S: f64 = 1_772_618_400.0;
/// Clock of the sonar at the first ping, milliseconds.
pub const FIRST_MS: u32 = 75_000;
/// Milliseconds from ping to ping.
pub const PING_MS: usize = 50;
/// Length of the range, millimetres.
pub const LENGTH_MM: u32 = 30_000;

/// A packet with its sum.
pub fn packet(id: u16, device: u8, payload: &[u8]) -> Vec<u8> {
    let mut bytes = b"BR".to_vec();
    bytes.extend((payload.len() as u16).to_le_bytes());
    bytes.extend(id.to_le_bytes());
    bytes.extend([device, 0]);
    bytes.extend(payload);
    let sum = bytes.iter().fold(0_u16, |sum, byte| sum.wrapping_add(u16::from(*byte)));
    bytes.extend(sum.to_le_bytes());
    bytes
}

/// Decibels of a sample before [`SvlogOptions::louder_db`]: they rise and fall between -85 and -45,
/// whatever the scale of the ping.
pub fn decibels(ping: usize, side: usize, sample: usize) -> f64 {
    -84.95 + ((sample * 3 + ping * 5 + side * 50) % 400) as f64 / 10.0
}

/// The samples of a side of a ping as they are stored.
pub fn stored(options: &SvlogOptions, ping: usize, side: usize) -> Vec<u16> {
    let [least, most] = options.powers_db[ping % options.powers_db.len()].map(f64::from);
    let louder_db = options.louder_db * ping as f64;
    let value = |sample| {
        let share = (decibels(ping, side, sample) + louder_db - least) / (most - least);
        (share.clamp(0.0, 1.0) * 65_535.0).round() as u16
    };
    (0..options.samples).map(value).collect()
}

/// A whole file: a description of the session, then profiles with positions between them.
pub fn svlog(options: &SvlogOptions) -> Vec<u8> {
    let uptime_s = f64::from(FIRST_MS) / 1000.0;
    let session = format!(
        "{{\n \"session_id\": 1, \"session_uptime\": 0.5, \"os_uptime\": {uptime_s}, \"process_uptime\": 12.0, \"timestamp\": \"2026-03-04T10:00:00.000+00:00\"}}"
    );
    let mut file = packet(10, 0, session.as_bytes());
    let row = options.in_a_row.max(1);
    for first in (0..options.pings).step_by(row) {
        let pings = first..(first + row).min(options.pings);
        file.extend(position(options, first));
        for side in 0..2 {
            for ping in pings.clone() {
                file.extend(profile(options, ping, side));
            }
        }
    }
    file
}

fn position(options: &SvlogOptions, ping: usize) -> Vec<u8> {
    let ms = ping * PING_MS;
    match options.positions {
        109 => {
            let minutes = 7.038 + ping as f64 * 1e-4;
            let seconds = ms as f64 / 1000.0;
            let gga = format!(
                "$GPGGA,1000{seconds:06.3},48{minutes:07.4},N,01131.0000,E,1,08,0.9,5.4,M,46.9,M,,\r\n"
            );
            [packet(109, 3, b"$HEHDT,271.5,T\r\n"), packet(109, 3, gga.as_bytes())].concat()
        }
        150 => {
            // The autopilot was switched on 60 s later than the sonar.
            let boot_ms = 15_000 + ms;
            let lat = 481_173_000 + 20 * ping;
            let message = format!(
                "{{\"header\": {{\"system_id\": 1, \"component_id\": 1, \"sequence\": 7}}, \"message\": {{\"type\": \"GLOBAL_POSITION_INT\", \"time_boot_ms\": {boot_ms}, \"lat\": {lat}, \"lon\": 115166667, \"alt\": 1500, \"relative_alt\": 100, \"vx\": 100, \"vy\": 0, \"vz\": 0, \"hdg\": 9025}}}}"
            );
            packet(150, 3, message.as_bytes())
        }
        _ => Vec::new(),
    }
}

fn profile(options: &SvlogOptions, ping: usize, side: usize) -> Vec<u8> {
    let [least_db, most_db] = options.powers_db[ping % options.powers_db.len()];
    let earlier_ms = if side == 0 { options.port_earlier_ms } else { 0 };
    let mut payload = Vec::new();
    for field in [
        ping as u32,
        options.start_mm,
        LENGTH_MM,
        FIRST_MS + earlier_ms + (ping * PING_MS) as u32,
        450_000,
    ] {
        payload.extend(field.to_le_bytes());
    }
    for field in [5_u16, options.samples as u16, 14_800] {
        payload.extend(field.to_le_bytes());
    }
    payload.extend([options.channels[side], 0]);
    let looks_deg = if side == 0 { -90.0 } else { 90.0 };
    for field in [0.000_125_f32, 74.55, most_db, least_db, looks_deg, 0.0] {
        payload.extend(field.to_le_bytes());
    }
    for value in stored(options, ping, side) {
        payload.extend(value.to_le_bytes());
    }
    packet(2198, 1 + side as u8, &payload)
}
