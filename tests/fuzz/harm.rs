//! Damages recordings: cut short, a byte changed, a field of a record's header set to an extreme.

use bathyscope_test_support::records::{FieldKind, RecordLayout};
use std::fmt;
use std::ops::Range;

/// Bytes from one cut to the next.
const BETWEEN_CUTS: usize = 997;
/// Changed bytes, and changed fields, of one recording.
const CHANGED_BYTES: u64 = 10_000;
const CHANGED_FIELDS: u64 = 1_000;

/// Something wrong with a file.
#[derive(Clone, Debug)]
pub(super) enum Harm {
    /// It ends at this offset.
    Cut(usize),
    /// Other bytes stand at a place.
    Changed {
        /// Offset of the first changed byte.
        at: usize,
        /// The other bytes.
        bytes: Vec<u8>,
    },
}

impl fmt::Display for Harm {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Harm::Cut(at) => write!(out, "cut at {at}"),
            Harm::Changed { at, bytes } => write!(out, "{bytes:02x?} at {at}"),
        }
    }
}

impl Harm {
    /// The bytes that are wrong or gone.
    pub(super) fn place(&self, length: usize) -> Range<u64> {
        match self {
            Harm::Cut(at) => *at as u64..length as u64,
            Harm::Changed { at, bytes } => *at as u64..(at + bytes.len()) as u64,
        }
    }

    /// Applies the harm to a file.
    pub(super) fn apply(&self, file: &mut Vec<u8>) {
        match self {
            Harm::Cut(at) => file.truncate(*at),
            Harm::Changed { at, bytes } => file[*at..at + bytes.len()].copy_from_slice(bytes),
        }
    }

    /// Undoes a change; a cut stays.
    pub(super) fn undo(&self, file: &mut [u8], whole: &[u8]) {
        if let Harm::Changed { at, bytes } = self {
            let range = *at..at + bytes.len();
            file[range.clone()].copy_from_slice(&whole[range]);
        }
    }
}

/// Returns all harms of a file, one in `each` of them; the cuts first and from the end, so that the
/// file only shrinks.
pub(super) fn harms(
    bytes: &[u8],
    layout: Option<RecordLayout>,
    records: &[Range<u64>],
    each: usize,
) -> Vec<Harm> {
    let cuts = (0..bytes.len()).step_by(BETWEEN_CUTS).rev().map(Harm::Cut);
    let changed = (1..=CHANGED_BYTES).filter_map(|seed| changed_byte(bytes, seed));
    let fields =
        (1..=CHANGED_FIELDS).filter_map(|seed| changed_field(bytes, layout?, records, seed));
    let all = cuts.step_by(each).chain(changed.step_by(each));
    all.chain(fields.step_by(each)).collect()
}

fn changed_byte(bytes: &[u8], seed: u64) -> Option<Harm> {
    let mut random = Random(seed);
    let at = random.below(bytes.len())?;
    let other = bytes[at] ^ (1 + random.below(255)? as u8);
    Some(Harm::Changed { at, bytes: vec![other] })
}

fn changed_field(
    bytes: &[u8],
    layout: RecordLayout,
    records: &[Range<u64>],
    seed: u64,
) -> Option<Harm> {
    let mut random = Random(seed);
    let record = &records[random.below(records.len())?];
    let (offset, kind) = layout.fields[random.below(layout.fields.len())?];
    let at = record.start as usize + offset;
    let now = bytes.get(at..at + kind.width())?;
    let mut field = match kind {
        FieldKind::Whole(width) => whole_number(&mut random, now, layout.big_endian, width)?,
        FieldKind::Float(4) => float(&mut random)?.to_le_bytes().to_vec(),
        FieldKind::Float(_) => f64::from(float(&mut random)?).to_le_bytes().to_vec(),
    };
    if layout.big_endian {
        field.reverse();
    }
    (field != now).then_some(Harm::Changed { at, bytes: field })
}

/// An extreme, or a number near the one that stands there; its least significant byte first.
fn whole_number(
    random: &mut Random,
    now: &[u8],
    big_endian: bool,
    width: usize,
) -> Option<Vec<u8>> {
    let mut value = [0; 8];
    for (index, byte) in now.iter().enumerate() {
        value[if big_endian { width - 1 - index } else { index }] = *byte;
    }
    let value = u64::from_le_bytes(value);
    let most = u64::MAX >> (64 - 8 * width);
    let extremes = [
        0,
        1,
        most,
        most >> 1,
        (most >> 1) + 1,
        value.wrapping_add(1),
        value.wrapping_sub(1),
        value.wrapping_mul(2),
        value / 2,
        value.wrapping_add(1000),
        value.wrapping_sub(1000),
        most - 7,
    ];
    let chosen = extremes[random.below(extremes.len())?];
    Some(chosen.to_le_bytes()[..width].to_vec())
}

fn float(random: &mut Random) -> Option<f32> {
    const EXTREMES: [f32; 14] = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        1e-30,
        1e30,
        -1e30,
        5e3,
        1e6,
        f32::MAX,
        f32::MIN,
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
    ];
    Some(EXTREMES[random.below(EXTREMES.len())?])
}

/// SplitMix64: the same harms in every run.
struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> Option<usize> {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (mixed ^ (mixed >> 31)).checked_rem(limit as u64).map(|at| at as usize)
    }
}
