//! Tests that damaged and hostile files are read as far as possible, without a panic, a hang, or
//! memory by a stated size.

use super::{file, open, pings};
use bathyscope_test_support::Random;
use bathyscope_test_support::garmin::{HEADER, Ping, record, structure};

/// Returns a file with two pings of each channel and few samples.
fn small() -> Vec<u8> {
    let mut some = pings(2);
    some.iter_mut().for_each(|ping| ping.samples.truncate(9));
    file(&some)
}

fn assert_bounded(bytes: Vec<u8>) {
    let length = bytes.len();
    if let Ok(survey) = open(bytes) {
        let records = survey.side_scan.len() + survey.track.fixes.len() + survey.soundings.len();
        assert!(records < length, "{records} of {length} bytes");
        let spans = survey.side_scan.iter().flat_map(|ping| [ping.port, ping.starboard]);
        for span in spans.flatten() {
            assert!(span.offset + u64::from(span.count) <= length as u64);
            assert!(span.far_m.is_finite() && span.near_m >= 0.0);
        }
        for fix in survey.track.fixes.iter() {
            assert!(fix.position.lat_deg.abs() < 90.0 && fix.time_s.is_finite());
        }
    }
}

#[test]
fn a_file_may_be_cut_anywhere() {
    let bytes = small();
    // All places within the padding of the header are alike.
    let header = (0..HEADER).filter(|end| *end < 400 || end % 997 == 0);
    for end in header.chain(HEADER..bytes.len()) {
        assert_bounded(bytes[..end].to_vec());
    }
    let some = open(bytes[..bytes.len() - 200].to_vec()).expect("what is left");
    assert!(!some.side_scan.is_empty());
}

#[test]
fn any_bytes_may_be_wrong() {
    let bytes = small();
    let mut random = Random(7);
    for _ in 0..4_000 {
        let mut harmed = bytes.clone();
        for _ in 0..=random.below(12) {
            // Damages the header's fields, or the records.
            let (from, to) = match random.below(4) {
                0 => (0, 300),
                _ => (HEADER, harmed.len()),
            };
            let at = from + random.below(to - from);
            harmed[at] = [0, 0x7F, 0x80, 0xFF, random.below(256) as u8][random.below(5)];
        }
        assert_bounded(harmed);
    }
}

#[test]
fn stated_sizes_of_four_gigabytes_are_not_believed() {
    let mut bytes = small();
    let long = Ping { has_trailer: false, ..pings(1).remove(0) };
    let magic_field = (0, 0xB7E9_DA86_u32.to_le_bytes().to_vec());
    // Huge sizes of bodies, and a state with a huge count of fields.
    for fields in [
        [(4, vec![0xFF; 4]), (5, vec![0; 4])],
        [(4, vec![0xFF, 0xFF, 0xFF, 0x7F]), (1, vec![0xFF; 5])],
    ] {
        let mut all = vec![magic_field.clone()];
        all.extend(fields);
        bytes.extend(structure(&all));
        bytes.extend([1; 40]);
    }
    // Headers with a field, and with a count of fields, of this size.
    bytes.extend([6, 4, 0x86, 0xDA, 0xE9, 0xB7, 0x0F, 0xFF, 0xFF, 0xFF, 0xFF, 0x0F]);
    bytes.extend([0xFF, 4, 0x86, 0xDA, 0xE9, 0xB7, 0xFF, 0xFF, 0xFF, 0xFF, 0x0F]);
    // Huge numbers of samples, and of fields in a body.
    let stated = Ping { stated_samples: Some(u32::MAX), ..long.clone() };
    bytes.extend(stated.record());
    let mut body = long.body();
    body[0] = 0x7F;
    bytes.extend(record(&long, &body));
    bytes.extend(long.record());
    let survey = open(bytes.clone()).expect("the sound records");
    assert_eq!(survey.side_scan.len(), 3);
    assert_bounded(bytes);
    // Only magic numbers, and only records with a body of two bytes or a huge stated size.
    let magic = [6, 4, 0x86, 0xDA, 0xE9, 0xB7];
    assert_bounded(magic.iter().copied().cycle().take(1 << 20).collect());
    let tiny = [&[2][..], &magic[1..], &[4 << 3 | 1, 2, 0, 0, 0, 0, 0, 0]].concat();
    assert_bounded(tiny.iter().copied().cycle().take(1 << 20).collect());
    let lying = [&[2][..], &magic[1..], &[4 << 3 | 4, 0xFF, 0xFF, 0xFF, 0xFF, 0, 0, 0, 0]].concat();
    assert_bounded(lying.iter().copied().cycle().take(1 << 20).collect());
}
