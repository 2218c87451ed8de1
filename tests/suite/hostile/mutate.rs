//! Files made wrong, the same ones for the same seed.

use std::ops::Range;

/// SplitMix64: the same cases in every run, and a failure names its seed.
pub(super) struct Random(pub u64);

impl Random {
    pub(super) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ (mixed >> 31)
    }

    pub(super) fn below(&mut self, limit: usize) -> usize {
        (self.next() % limit.max(1) as u64) as usize
    }

    pub(super) fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len())]
    }

    fn range(&mut self, len: usize, longest: usize) -> Range<usize> {
        let start = self.below(len + 1);
        start..(start + self.below(longest) + 1).min(len)
    }
}

/// Numbers that no file should hold, as they are written.
pub(super) const WILD: [&str; 28] = [
    "0.5",
    "2",
    "100",
    "10000",
    "0",
    "-0",
    "1",
    "-1",
    "1e9",
    "-1e9",
    "1e300",
    "-1e300",
    "1e-300",
    "nan",
    "inf",
    "-inf",
    "",
    "1e400",
    "99999999999999999999",
    "4294967296",
    "-2147483649",
    "0.1",
    "1_000",
    "0x10",
    "true",
    "\"a\"",
    "1e5",
    "3.5",
];

/// Returns a text that causes trouble: commands to a terminal, letters that turn others round, very
/// long runs.
fn snippet(random: &mut Random) -> String {
    let plain = [
        "\u{1b}[2J\u{1b}[31m",
        "\u{1b}]0;title\u{7}",
        "\u{9b}6n",
        "\u{202e}",
        "\0",
        "\"",
        "\r",
        "\n",
        ",",
        ";",
        "=",
        "<",
        "]",
        "}",
        "\u{feff}",
        "é",
        "\u{2028}",
    ];
    match random.below(20) {
        0 => "A".repeat(200_000),
        1 => "[".repeat(5_000),
        2 => "{\"a\":".repeat(3_000),
        _ => random.pick(&plain).to_owned(),
    }
}

/// A text with one to four things wrong.
pub(super) fn text(random: &mut Random, sound: &str) -> Vec<u8> {
    let mut bytes = sound.as_bytes().to_vec();
    for _ in 0..random.pick(&[1, 1, 1, 2, 4]) {
        match random.below(9) {
            0..4 => replace_number(random, &mut bytes),
            4 => drop(bytes.drain(random.range(bytes.len(), 40))),
            5 => repeat_line(random, &mut bytes),
            6 => {
                let at = random.below(bytes.len() + 1);
                bytes.splice(at..at, snippet(random).into_bytes());
            }
            7 => bytes.truncate(random.below(bytes.len() + 1)),
            _ => {
                let at = random.below(bytes.len());
                if let Some(byte) = bytes.get_mut(at) {
                    *byte = random.below(256) as u8;
                }
            }
        }
    }
    bytes
}

/// Puts a wild number where some letters of a number are, from wherever it begins.
fn replace_number(random: &mut Random, bytes: &mut Vec<u8>) {
    let from = random.below(bytes.len());
    let is_number = |byte: &u8| byte.is_ascii_digit() || matches!(byte, b'.' | b'-' | b'e');
    let Some(start) = bytes[from..].iter().position(is_number) else {
        return;
    };
    let start = from + start;
    let length = bytes[start..].iter().take_while(|byte| is_number(byte)).count();
    bytes.splice(start..start + length, random.pick(&WILD).bytes());
}

fn repeat_line(random: &mut Random, bytes: &mut Vec<u8>) {
    let lines: Vec<&[u8]> = bytes.split_inclusive(|byte| *byte == b'\n').collect();
    if lines.is_empty() {
        return;
    }
    let line = lines[random.below(lines.len())].to_vec();
    let times = 1 + random.below(2_000);
    bytes.extend(line.repeat(times.min(1 + 1_000_000 / line.len().max(1))));
}

/// Bytes with some written over, cut off or said twice.
pub(super) fn bytes(random: &mut Random, sound: &[u8]) -> Vec<u8> {
    let mut bytes = sound.to_vec();
    let most = random.pick(&[1, 3, 12, 400]);
    let scars = 1 + random.below(most);
    for _ in 0..scars {
        // Half of them in the head, where a file says what it is.
        let reach = if random.below(2) == 0 { 1024 } else { usize::MAX };
        let at = random.below(bytes.len().min(reach));
        let wild = match random.below(5) {
            0 => [0; 8],
            1 => [0xFF; 8],
            2 => random.pick(&[1e30_f64, -1.0, f64::NAN, 1e-30, 5e3]).to_le_bytes(),
            3 => {
                let float = random.pick(&[f32::MAX, f32::NAN, -5.0, 1e-20, 1e6_f32]).to_le_bytes();
                [float, float].concat().try_into().expect("eight bytes")
            }
            _ => random.next().to_le_bytes(),
        };
        let width = random.pick(&[1, 2, 4, 8]);
        for (byte, new) in bytes.iter_mut().skip(at).zip(&wild[..width]) {
            *byte = *new;
        }
    }
    match random.below(8) {
        0 => bytes.truncate(random.below(bytes.len())),
        1 => {
            let twice = bytes[random.range(bytes.len(), 5_000)].to_vec();
            let at = random.below(bytes.len());
            bytes.splice(at..at, twice);
        }
        _ => {}
    }
    bytes
}

/// An SL2 log whose ranges, positions, depths or times jump from frame to frame.
pub(super) fn jumping_sl2(random: &mut Random, sound: &[u8]) -> Vec<u8> {
    let mut bytes = sound.to_vec();
    let which = 1 + random.below(15);
    let span_m = random.pick(&[2, 100, 10_000, 200_000, 20_000_000]);
    let mut at = 8;
    while at + 144 <= bytes.len() {
        let frame = at;
        at += usize::from(u16::from_le_bytes([bytes[at + 28], bytes[at + 29]])).max(144);
        let mut scale = |field: usize, low: f32, high: f32, random: &mut Random| {
            let field = frame + field..frame + field + 4;
            let value = f32::from_le_bytes(bytes[field.clone()].try_into().expect("four bytes"));
            let share = random.below(1000) as f32 / 1000.0;
            let value = value * (low + share * (high - low));
            bytes[field].copy_from_slice(&value.to_le_bytes());
        };
        if which & 1 != 0 {
            scale(40, 1.0, 1.0, random);
            scale(44, 0.3, 3.0, random);
        }
        if which & 2 != 0 {
            scale(64, 0.0, 10.0, random);
        }
        for field in [108, 112].map(|field| frame + field) {
            if which & 4 != 0 {
                let field = field..field + 4;
                let value =
                    i32::from_le_bytes(bytes[field.clone()].try_into().expect("four bytes"));
                let off = random.below(2 * span_m) as i32 - span_m as i32;
                bytes[field].copy_from_slice(&value.wrapping_add(off).to_le_bytes());
            }
        }
        if which & 8 != 0 {
            let time = (random.next() % 10_000_000) as u32;
            bytes[frame + 140..frame + 144].copy_from_slice(&time.to_le_bytes());
        }
    }
    bytes
}
