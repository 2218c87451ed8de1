//! Writes small RSD files, of what the reader's module says about the format.

/// The element of a side-scan ping, and where it looks, as peers found it in recordings.
pub const TILT_DEG: f32 = 60.0;
/// The file header is padded to this length.
pub const HEADER: usize = 20_480;
/// Seconds from 31 December 1989 to 25 March 2025, both 0 h UTC (`date -u -d 2025-03-25 +%s` is
/// 1742860800).
pub const GARMIN_S: u32 = 1_111_795_200;
/// The same moment in Unix seconds.
pub const START_UNIX_S: f64 = 1_742_860_800.0;

/// A channel of the file header: number and band in hertz.
pub type Band = (u32, u32, u32);

/// A ping to write.
#[derive(Clone, Debug)]
pub struct Ping {
    pub channel: Option<u32>,
    pub beam: Option<u32>,
    pub tilt_deg: Option<f32>,
    pub sequence: u32,
    pub time_ms: u32,
    pub bottom_mm: Option<i32>,
    pub range_mm: Option<[i32; 2]>,
    /// Latitude and longitude, degrees.
    pub place_deg: Option<[f64; 2]>,
    pub samples: Vec<u16>,
    /// Bytes a sample.
    pub width: usize,
    /// Samples that the record says it has, where that is another number.
    pub stated_samples: Option<u32>,
    /// A checksum between fields and samples.
    pub has_checksum: bool,
    /// A byte a sample behind the samples.
    pub has_shade: bool,
    /// Depths are unsigned integers.
    pub unsigned: bool,
    /// Twelve bytes behind the record.
    pub has_trailer: bool,
}

impl Default for Ping {
    fn default() -> Self {
        Self {
            channel: Some(1),
            beam: Some(1),
            tilt_deg: None,
            sequence: 0,
            time_ms: 0,
            bottom_mm: Some(8_000),
            range_mm: Some([0, 40_000]),
            place_deg: None,
            samples: Vec::new(),
            width: 2,
            stated_samples: None,
            has_checksum: false,
            has_shade: false,
            unsigned: false,
            has_trailer: true,
        }
    }
}

pub fn varuint(mut value: u32) -> Vec<u8> {
    let mut bytes = Vec::new();
    while value >= 0x80 {
        bytes.push(value as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
    bytes
}

/// A count, and each field behind its key.
pub fn structure(fields: &[(u32, Vec<u8>)]) -> Vec<u8> {
    let mut bytes = varuint(fields.len() as u32);
    for (number, value) in fields {
        if value.len() < 7 {
            bytes.extend(varuint(number << 3 | value.len() as u32));
        } else {
            bytes.extend(varuint(number << 3 | 7));
            bytes.extend(varuint(value.len() as u32));
        }
        bytes.extend(value);
    }
    bytes
}

fn array(items: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = varuint(items.len() as u32);
    for item in items {
        bytes.extend(varuint(item.len() as u32));
        bytes.extend(item);
    }
    bytes
}

/// The file header with its padding.
pub fn header(garmin_s: u32, bands: &[Band]) -> Vec<u8> {
    let mut channels = varuint(bands.len() as u32);
    for &(number, low_hz, high_hz) in bands {
        let band = structure(&[(0, vec![1]), (1, varuint(low_hz)), (2, varuint(high_hz))]);
        let element = structure(&[(0, vec![1]), (1, band), (2, vec![3])]);
        channels.extend(structure(&[
            (0, array(&[varuint(number)])),
            (1, (HEADER as u64).to_le_bytes().to_vec()),
            (2, array(&[element])),
        ]));
    }
    let unit = structure(&[
        (0, 1234_u16.to_le_bytes().to_vec()),
        (1, 123_u32.to_le_bytes().to_vec()),
        (2, 4040_u16.to_le_bytes().to_vec()),
        (3, garmin_s.to_le_bytes().to_vec()),
    ]);
    let mut file = structure(&[
        (0, 0xD926_4B7C_u32.to_le_bytes().to_vec()),
        (1, 1_u16.to_le_bytes().to_vec()),
        (2, (bands.len() as u32).to_le_bytes().to_vec()),
        (3, vec![8]),
        (5, unit),
        (6, channels),
    ]);
    file.resize(HEADER, 0);
    file
}

/// A record with this body; without one it only says that a channel begins.
pub fn record(ping: &Ping, body: &[u8]) -> Vec<u8> {
    let mut state = vec![(0, vec![if body.is_empty() { 1 } else { 2 }])];
    state.extend(ping.channel.map(|channel| (1, array(&[varuint(channel)]))));
    let size = match u16::try_from(body.len()) {
        Ok(size) => size.to_le_bytes().to_vec(),
        Err(_) => (body.len() as u32).to_le_bytes().to_vec(),
    };
    let mut bytes = structure(&[
        (0, 0xB7E9_DA86_u32.to_le_bytes().to_vec()),
        (1, structure(&state)),
        (2, ping.sequence.to_le_bytes().to_vec()),
        (3, vec![0xFF; 4]),
        (4, size),
        (5, ping.time_ms.to_le_bytes().to_vec()),
    ]);
    bytes.extend([0xAB; 4]);
    bytes.extend(body);
    if ping.has_trailer {
        let length = bytes.len() as u32 + 12;
        bytes.extend(0xF98E_ACBC_u32.to_le_bytes());
        bytes.extend(length.to_le_bytes());
        bytes.extend([0xCD; 4]);
    }
    bytes
}

impl Ping {
    /// The record of the ping.
    pub fn record(&self) -> Vec<u8> {
        record(self, &self.body())
    }

    /// Its fields and samples.
    pub fn body(&self) -> Vec<u8> {
        let mut bytes = structure(&self.fields());
        if self.has_checksum {
            bytes.extend([0xEF; 4]);
        }
        for sample in &self.samples {
            bytes.extend(&sample.to_le_bytes()[..self.width]);
        }
        if self.has_shade {
            bytes.resize(bytes.len() + self.samples.len(), 0x77);
        }
        bytes
    }

    fn depth(&self, millimetres: i32) -> Vec<u8> {
        let signed = (millimetres << 1 ^ millimetres >> 31).cast_unsigned();
        varuint(if self.unsigned { millimetres.cast_unsigned() } else { signed })
    }

    fn fields(&self) -> Vec<(u32, Vec<u8>)> {
        let count = self.stated_samples.unwrap_or(self.samples.len() as u32);
        let units = |degrees: f64| (degrees * (4_294_967_296.0 / 360.0)).round() as i64 as i32;
        let mut fields = Vec::new();
        fields.extend(self.channel.map(|channel| (0, varuint(channel))));
        fields.extend(self.bottom_mm.map(|bottom| (1, self.depth(bottom))));
        fields.extend(self.bottom_mm.map(|bottom| (2, self.depth(bottom))));
        if let Some([near, far]) = self.range_mm {
            fields.extend([(3, self.depth(near)), (4, self.depth(far))]);
        }
        fields.extend([(5, vec![0x55]), (6, vec![2])]);
        fields.push((7, count.to_le_bytes().to_vec()));
        fields.push((8, vec![u8::from(self.has_shade)]));
        if let Some(place_deg) = self.place_deg {
            let [lat, lon] = place_deg.map(|degrees| units(degrees).to_le_bytes().to_vec());
            fields.extend([(9, lat), (10, lon)]);
        }
        fields.push((11, 14.5_f32.to_le_bytes().to_vec()));
        fields.extend(self.beam.map(|beam| (12, varuint(beam))));
        if let Some(tilt) = self.tilt_deg {
            let where_to =
                structure(&[(0, tilt.to_le_bytes().to_vec()), (1, 1.5_f32.to_le_bytes().to_vec())]);
            let beam = structure(&[(0, vec![50]), (1, vec![1]), (5, where_to)]);
            fields.push((13, beam));
            fields.push((14, varuint(self.sequence)));
        }
        fields
    }
}
