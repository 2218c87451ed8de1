//! Small logs written byte by byte from the format notes, not by Bathyscope's own records.

use std::path::PathBuf;

/// A Lowrance frame to write.
#[derive(Clone, Debug)]
pub struct Frame {
    pub channel: u16,
    pub time_ms: i32,
    pub clock: u32,
    pub range_ft: (f32, f32),
    pub depth_ft: f32,
    pub keel_ft: f32,
    pub xy_m: (i32, i32),
    pub heading_rad: f32,
    pub data: Vec<u8>,
}

impl Frame {
    pub fn new(channel: u16, time_ms: i32) -> Self {
        Self {
            channel,
            time_ms,
            clock: time_ms.cast_unsigned(),
            range_ft: if channel == 5 { (-60.0, 60.0) } else { (0.0, 60.0) },
            depth_ft: 10.0,
            keel_ft: 0.0,
            xy_m: (-9_000_000 + time_ms / 1000, 3_400_000),
            heading_rad: 0.0,
            data: (0..400).map(|index| (index % 251) as u8 + 1).collect(),
        }
    }
}

/// Pairs of distance outward and depth, feet.
type Pairs<'a> = &'a [[f32; 2]];

impl Frame {
    /// A frame of StructureScan 3D: a header of 76 bytes, then the pairs of port, of starboard, and
    /// the unreliable ones, here all to port.
    pub fn of_swath(time_ms: i32, [port, starboard, unreliable]: [Pairs<'_>; 3]) -> Self {
        let bytes = |pairs: Pairs<'_>| 8 * pairs.len() as i32;
        let numbers = [76, bytes(port), bytes(starboard), bytes(unreliable), 0, bytes(unreliable)];
        let mut data: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        data.resize(76, 0);
        let pairs = port.iter().chain(starboard).chain(unreliable);
        data.extend(pairs.flatten().flat_map(|value| value.to_le_bytes()));
        Self { data, ..Self::new(9, time_ms) }
    }
}

fn put(bytes: &mut [u8], at: usize, value: &[u8]) {
    bytes[at..at + value.len()].copy_from_slice(value);
}

/// An SL2 file of format version 1.
pub fn sl2(frames: &[Frame]) -> Vec<u8> {
    let mut file = vec![2, 0, 1, 0, 0x80, 0x0C, 0, 0];
    for (index, frame) in frames.iter().enumerate() {
        let mut header = [0_u8; 144];
        put(&mut header, 0, &(file.len() as u32).to_le_bytes());
        put(&mut header, 28, &(144 + frame.data.len() as u16).to_le_bytes());
        put(&mut header, 32, &frame.channel.to_le_bytes());
        put(&mut header, 34, &(frame.data.len() as u16).to_le_bytes());
        put(&mut header, 36, &(index as u32).to_le_bytes());
        put(&mut header, 40, &frame.range_ft.0.to_le_bytes());
        put(&mut header, 44, &frame.range_ft.1.to_le_bytes());
        put(&mut header, 53, &[3]);
        put(&mut header, 60, &frame.clock.to_le_bytes());
        put(&mut header, 64, &frame.depth_ft.to_le_bytes());
        put(&mut header, 68, &frame.keel_ft.to_le_bytes());
        for at in [80, 84, 88, 92] {
            put(&mut header, at, &(-1.0_f32).to_le_bytes());
        }
        put(&mut header, 100, &5.0_f32.to_le_bytes());
        put(&mut header, 108, &frame.xy_m.0.to_le_bytes());
        put(&mut header, 112, &frame.xy_m.1.to_le_bytes());
        put(&mut header, 128, &frame.heading_rad.to_le_bytes());
        put(&mut header, 140, &frame.time_ms.to_le_bytes());
        file.extend_from_slice(&header);
        file.extend_from_slice(&frame.data);
    }
    file
}

/// An SL3 file; headers are 128 bytes on channels 7 and 8, `long_header` (168, or 180 in frame
/// version 13) on the others. On channel 9 the packet is shorter than the data, as units write it.
pub fn sl3(frames: &[Frame], long_header: usize) -> Vec<u8> {
    let mut file = vec![3, 0, 2, 0, 0x80, 0x0C, 1, 0];
    for (index, frame) in frames.iter().enumerate() {
        let header_len = if matches!(frame.channel, 7 | 8) { 128 } else { long_header };
        let mut header = vec![0_u8; header_len];
        put(&mut header, 0, &(file.len() as u32).to_le_bytes());
        let version: u32 = if long_header == 180 { 13 } else { 10 };
        put(&mut header, 4, &version.to_le_bytes());
        put(&mut header, 8, &((header_len + frame.data.len()) as u16).to_le_bytes());
        put(&mut header, 12, &frame.channel.to_le_bytes());
        put(&mut header, 16, &(index as u32).to_le_bytes());
        put(&mut header, 20, &frame.range_ft.0.to_le_bytes());
        put(&mut header, 24, &frame.range_ft.1.to_le_bytes());
        put(&mut header, 40, &frame.clock.to_le_bytes());
        let packet = match frame.channel {
            9 => frame.data.len().saturating_sub(76),
            _ => frame.data.len(),
        };
        put(&mut header, 44, &(packet as u32).to_le_bytes());
        put(&mut header, 48, &frame.depth_ft.to_le_bytes());
        put(&mut header, 52, &3_u16.to_le_bytes());
        put(&mut header, 84, &5.0_f32.to_le_bytes());
        put(&mut header, 92, &frame.xy_m.0.to_le_bytes());
        put(&mut header, 96, &frame.xy_m.1.to_le_bytes());
        put(&mut header, 112, &frame.heading_rad.to_le_bytes());
        put(&mut header, 124, &frame.time_ms.to_le_bytes());
        file.extend_from_slice(&header);
        file.extend_from_slice(&frame.data);
    }
    file
}

/// `count` side-scan frames, each after a primary one, 50 ms apart.
pub fn survey_frames(count: i32) -> Vec<Frame> {
    (0..count).flat_map(|ping| [Frame::new(0, ping * 50), Frame::new(5, ping * 50 + 10)]).collect()
}

/// One Humminbird ping. `wide` writes the tags that Helix units add; `little` swaps the numbers.
pub fn son_ping(
    beam: u8,
    record: u32,
    time_ms: u32,
    samples: usize,
    wide: bool,
    little: bool,
) -> Vec<u8> {
    let number = |value: u32| {
        if little { value.to_le_bytes() } else { value.to_be_bytes() }
    };
    let mut ping = vec![0xC0, 0xDE, 0xAB, 0x21];
    let mut tag = |tag: u8, value: u32| {
        ping.push(tag);
        ping.extend_from_slice(&number(value));
    };
    tag(0x80, record);
    tag(0x81, time_ms);
    tag(0x82, (-12_414_199 + time_ms.cast_signed() / 1000).cast_unsigned());
    tag(0x83, 4_396_652);
    tag(0x84, 1 << 16 | 900);
    tag(0x85, 1 << 16 | 20);
    if wide {
        tag(0x86, 0x2100_2121);
    }
    tag(0x87, 31);
    tag(0x92, 455_000);
    ping.extend_from_slice(&[0x50, beam, 0x51, 10, 0xA0]);
    ping.extend_from_slice(&number(samples as u32));
    ping.push(0x21);
    ping.extend((0..samples).map(|index| (index % 250) as u8));
    ping
}

/// A DAT of 64 bytes (big-endian) or 96 (Solix, little-endian).
pub fn dat(solix: bool) -> Vec<u8> {
    let mut dat = vec![0_u8; if solix { 96 } else { 64 }];
    let number = |value: u32| {
        if solix { value.to_le_bytes() } else { value.to_be_bytes() }
    };
    put(&mut dat, 0, &[0xC1, u8::from(solix)]);
    put(&mut dat, 20, &number(1_600_000_000));
    put(&mut dat, 32, b"R00007.SON");
    dat
}

/// The files of a recording of `count` pings a side; the DAT first.
pub fn humminbird(count: u32, solix: bool, little: bool) -> Vec<(PathBuf, Vec<u8>)> {
    let son = |beam: u8| {
        let ping = |index| {
            son_ping(
                beam,
                index * 3 + u32::from(beam),
                index * 45,
                300 + (index as usize / 10) % 3,
                solix,
                little,
            )
        };
        (0..count).flat_map(ping).collect::<Vec<u8>>()
    };
    let mut files = vec![(PathBuf::from("Rec00007.DAT"), dat(solix))];
    files.extend((1..4).map(|beam| (PathBuf::from(format!("Rec00007/B00{beam}.SON")), son(beam))));
    files
}

/// An XTF file of `pings` pings of two channels with `width` bytes a sample; `units` 0 metres, 3
/// degrees.
pub fn xtf(pings: usize, width: usize, units: u16, origin: (f64, f64), altitude_m: f32) -> Vec<u8> {
    let mut file = xtf_header(&[0.0; 2], width, units);
    for ping in 0..pings {
        file.extend(xtf_ping(ping, 2, width, origin, altitude_m));
    }
    file
}

/// An XTF file of two frequencies: 100 kHz to 25 m, and 400 kHz to 12.5 m.
pub fn xtf_of_two_frequencies(pings: usize) -> Vec<u8> {
    let mut file = xtf_header(&[100.0, 100.0, 400.0, 400.0], 1, 3);
    for ping in 0..pings {
        file.extend(xtf_ping(ping, 4, 1, (-73.6, 42.7), 5.0));
    }
    file
}

fn xtf_header(frequencies_khz: &[f32], width: usize, units: u16) -> Vec<u8> {
    let mut file = vec![0_u8; 1024];
    file[0] = 0x7B;
    put(&mut file, 164, &units.to_le_bytes());
    put(&mut file, 166, &(frequencies_khz.len() as u16).to_le_bytes());
    for (index, khz) in frequencies_khz.iter().enumerate() {
        let at = 256 + 128 * index;
        put(&mut file, at, &[1 + (index % 2) as u8, index as u8]);
        put(&mut file, at + 6, &(width as u16).to_le_bytes());
        put(&mut file, at + 32, &khz.to_le_bytes());
    }
    file
}

/// An XTF file of a multibeam sonar: a bathymetry packet a ping, an attitude packet with each other
/// one, no side-scan.
pub fn xtf_bathymetry(pings: usize) -> Vec<u8> {
    let mut file = vec![0_u8; 1024];
    file[0] = 0x7B;
    put(&mut file, 164, &3_u16.to_le_bytes());
    put(&mut file, 168, &1_u16.to_le_bytes());
    put(&mut file, 256, &[3, 0]);
    let packet = |kind: u8, size: usize| {
        let mut bytes = vec![0_u8; size];
        put(&mut bytes, 0, &0xFACE_u16.to_le_bytes());
        put(&mut bytes, 2, &[kind]);
        put(&mut bytes, 10, &(size as u32).to_le_bytes());
        bytes
    };
    for ping in 0..pings {
        let mut bathymetry = packet(2, 256 + 36 + 2 * 101);
        put(&mut bathymetry, 14, &1998_u16.to_le_bytes());
        put(&mut bathymetry, 16, &[6, 1, 12, 0, (ping / 10) as u8]);
        file.extend(bathymetry);
        if ping % 2 == 0 {
            file.extend(packet(3, 64));
        }
    }
    file
}

fn xtf_ping(
    ping: usize,
    channels: u16,
    width: usize,
    origin: (f64, f64),
    altitude_m: f32,
) -> Vec<u8> {
    const SAMPLES: usize = 200;
    let mut bytes = vec![0_u8; 256];
    let size = 256 + usize::from(channels) * (64 + SAMPLES * width);
    put(&mut bytes, 0, &0xFACE_u16.to_le_bytes());
    put(&mut bytes, 4, &channels.to_le_bytes());
    put(&mut bytes, 10, &(size as u32).to_le_bytes());
    put(&mut bytes, 14, &2020_u16.to_le_bytes());
    let hundredths = ping * 10;
    put(
        &mut bytes,
        16,
        &[
            6,
            1,
            12,
            (hundredths / 6000) as u8,
            (hundredths / 100 % 60) as u8,
            (hundredths % 100) as u8,
        ],
    );
    let step = if origin.0.abs() > 180.0 { 0.5 } else { 5e-6 };
    put(&mut bytes, 160, &(origin.1 + ping as f64 * step).to_le_bytes());
    put(&mut bytes, 168, &origin.0.to_le_bytes());
    put(&mut bytes, 196, &altitude_m.to_le_bytes());
    put(&mut bytes, 212, &90.0_f32.to_le_bytes());
    for channel in 0..channels {
        let mut header = [0_u8; 64];
        put(&mut header, 0, &channel.to_le_bytes());
        let range_m: f32 = if channel < 2 { 25.0 } else { 12.5 };
        put(&mut header, 4, &range_m.to_le_bytes());
        put(&mut header, 42, &(SAMPLES as u32).to_le_bytes());
        bytes.extend_from_slice(&header);
        for sample in 0..SAMPLES {
            match width {
                1 => bytes.push(sample as u8),
                _ => bytes.extend_from_slice(&((sample * 20) as u16).to_le_bytes()),
            }
        }
    }
    bytes
}
