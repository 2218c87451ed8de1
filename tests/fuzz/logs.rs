//! Logs of recorders: opened whole, and as they grow.

use super::{check_finite, say};
use bathyscope_log::formats::{open_as_format, open_growing, open_tail};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Bytes, Side, SideSpan, Survey, SurveyVersions};
use bathyscope_test_support::cerulean::{SvlogOptions, svlog as svlog_file};
use bathyscope_test_support::edgetech::{JsfOptions, jsf as jsf_file};
use bathyscope_test_support::garmin::{self as garmin_writer, GARMIN_S, Ping, TILT_DEG};
use bathyscope_test_support::handmade::{self, Frame};
use bathyscope_test_support::klein::{SdfOptions, sdf as sdf_file};
use bathyscope_test_support::nmea::{DepthIn, NmeaOptions, Stamp, nmea as nmea_file};
use image::{GrayImage, ImageFormat, Luma};
use std::io::Cursor;
use std::path::PathBuf;
use std::sync::Arc;

/// Samples of a side in the seeds.
const SAMPLES: usize = 60;

pub(super) fn sl2(bytes: &[u8]) {
    one_file("sl2", bytes);
}

pub(super) fn sl3(bytes: &[u8]) {
    one_file("sl3", bytes);
}

pub(super) fn rsd(bytes: &[u8]) {
    one_file("RSD", bytes);
}

pub(super) fn xtf(bytes: &[u8]) {
    one_file("xtf", bytes);
}

pub(super) fn jsf(bytes: &[u8]) {
    one_file("jsf", bytes);
}

pub(super) fn svlog(bytes: &[u8]) {
    one_file("svlog", bytes);
}

pub(super) fn slg(bytes: &[u8]) {
    one_file("slg", bytes);
}

pub(super) fn sdf(bytes: &[u8]) {
    one_file("sdf", bytes);
}

pub(super) fn nmea(bytes: &[u8]) {
    one_file("nmea", bytes);
}

/// Tables are read by their name only.
pub(super) fn soundings(bytes: &[u8]) {
    open("csv", vec![(PathBuf::from("log.csv"), bytes.to_vec())]);
}

fn one_file(ending: &str, bytes: &[u8]) {
    open(ending, vec![(PathBuf::from("log"), bytes.to_vec())]);
}

fn open(ending: &str, files: Vec<(PathBuf, Vec<u8>)>) {
    match open_as_format(ending, files, &Progress::new()) {
        Some(Ok(survey)) => walk(&survey),
        Some(Err(error)) => say(&error),
        None => {}
    }
}

/// The DAT and two SON files of a recording: their lengths as two u16, then the files.
pub(super) fn humminbird(bytes: &[u8]) {
    let (lengths, files) = bytes.split_at(bytes.len().min(4));
    let length = |at: usize| match lengths.get(at..at + 2) {
        Some(two) => usize::from(u16::from_le_bytes([two[0], two[1]])),
        None => 0,
    };
    let (dat, sons) = files.split_at(length(0).min(files.len()));
    let (port, starboard) = sons.split_at(length(2).min(sons.len()));
    let parts =
        [("Rec00007.DAT", dat), ("Rec00007/B002.SON", port), ("Rec00007/B003.SON", starboard)];
    open("DAT", parts.map(|(name, bytes)| (PathBuf::from(name), bytes.to_vec())).into());
}

/// A picture and its table: the length of the table as u16, then both.
pub(super) fn picture(bytes: &[u8]) {
    let (length, files) = bytes.split_at(bytes.len().min(2));
    let length = match length {
        &[low, high] => usize::from(u16::from_le_bytes([low, high])),
        _ => 0,
    };
    let (table, picture) = files.split_at(length.min(files.len()));
    let files = [("log.png", picture), ("log.csv", table)];
    let files = files.map(|(name, bytes)| (PathBuf::from(name), bytes.to_vec()));
    open("png", files.into());
}

/// A log of any format in three steps: some of it, a little more, all. The first two bytes say
/// where it was cut.
pub(super) fn growing(bytes: &[u8]) {
    let [first, second, log @ ..] = bytes else {
        return;
    };
    let part = |share: u8| log[..log.len() * usize::from(share) / 256].to_vec();
    let held = |bytes: Vec<u8>| vec![(PathBuf::from("log"), Bytes::Held(Arc::new(bytes)))];
    let progress = Progress::new();
    let mut survey = match open_growing(held(part(*first.min(second))), &progress) {
        Ok(survey) => survey,
        Err(error) => return say(&error),
    };
    walk(&survey);
    let mut versions = SurveyVersions::default();
    for bytes in [part(*first.max(second)), log.to_vec()] {
        let Some(seam) = survey.seam() else { return };
        let tail = match open_tail(&survey, &seam, held(bytes), &progress) {
            Ok(tail) => tail,
            Err(error) => return say(&error),
        };
        let Some(longer) = survey.extended(tail, &seam, &mut versions) else {
            return;
        };
        walk(&longer);
        survey = longer;
    }
}

/// Looks at all pings with all their samples, at all depths, positions and warnings.
fn walk(survey: &Survey) {
    let mut levels = Vec::new();
    let mut read = |span: &SideSpan| {
        let samples = survey.samples_of(span);
        let samples = samples.expect("the samples of a ping lie in its file");
        samples.copy_outward(&mut levels);
        assert_eq!(levels.len(), span.count as usize);
        check_finite([span.near_m, span.far_m].map(f64::from));
    };
    for ping in survey.side_scan.iter() {
        for side in Side::BOTH {
            ping.side(side).into_iter().for_each(&mut read);
        }
    }
    let down = survey.echograms.iter().flat_map(|echogram| echogram.pings.iter());
    down.for_each(|ping| read(&ping.span));
    for ping in survey.swath.iter() {
        let depths = survey.swath_soundings(ping);
        check_finite(depths.flat_map(|sounding| [sounding.out_m, sounding.depth_m]));
    }
    check_times(survey.swath.iter().map(|ping| ping.time_s));
    check_times(survey.side_scan.iter().map(|ping| ping.time_s));
    for echogram in &survey.echograms {
        check_times(echogram.pings.iter().map(|ping| ping.time_s));
    }
    check_times(survey.soundings.iter().map(|sounding| sounding.time_s));
    check_finite(survey.soundings.iter().map(|sounding| f64::from(sounding.depth_m)));
    check_times(survey.track.fixes.iter().map(|fix| fix.time_s));
    for fix in survey.track.fixes.iter() {
        check_finite([fix.position.lon_deg, fix.position.lat_deg]);
    }
    for warning in &survey.warnings {
        assert!(!warning.text.is_empty());
        if let Some((file, offset)) = warning.place {
            assert!(offset <= survey.bytes[file].len() as u64, "{}", warning.text);
        }
    }
}

/// Times rise, and are numbers.
fn check_times(times_s: impl Iterator<Item = f64>) {
    let mut last_s = f64::MIN;
    for time_s in times_s {
        assert!(time_s >= last_s && time_s.is_finite(), "{time_s} s comes after {last_s} s");
        last_s = time_s;
    }
}

/// Frames state where they begin.
pub(super) fn repair_sl2(bytes: &mut [u8]) {
    repair_offsets(bytes, 28);
}

/// Does the same as [`repair_sl2`] for SL3.
pub(super) fn repair_sl3(bytes: &mut [u8]) {
    repair_offsets(bytes, 8);
}

fn repair_offsets(bytes: &mut [u8], size_at: usize) {
    let mut at = 8;
    while let Some(header) = bytes.get_mut(at..at + 128) {
        header[..4].copy_from_slice(&(at as u32).to_le_bytes());
        let size = u16::from_le_bytes([header[size_at], header[size_at + 1]]);
        at += usize::from(size).max(128);
    }
}

/// Packets end with the sum of their bytes.
pub(super) fn repair_svlog(bytes: &mut [u8]) {
    let mut at = 0;
    while let Some(&[b'B', b'R', low, high]) = bytes.get(at..at + 4) {
        let end = at + 8 + usize::from(u16::from_le_bytes([low, high]));
        let Some(packet) = bytes.get_mut(at..end + 2) else {
            return;
        };
        let (summed, sum) = packet.split_at_mut(end - at);
        let all = summed.iter().fold(0_u16, |all, byte| all.wrapping_add(u16::from(*byte)));
        sum.copy_from_slice(&all.to_le_bytes());
        at = end + 2;
    }
}

fn frames() -> Vec<Frame> {
    let frame = |channel: u16, ping: i32| Frame {
        data: (0..SAMPLES).map(|index| (index % 251) as u8 + 1).collect(),
        ..Frame::new(channel, 50 * ping + i32::from(channel))
    };
    let ping = |ping| [0, 1, 2, 3, 4, 5].map(|channel| frame(channel, ping));
    (0..3).flat_map(ping).collect()
}

pub(super) fn sl2_seeds() -> Vec<Vec<u8>> {
    vec![
        handmade::sl2(&frames()),
        handmade::sl2(&[Frame::new(5, 0), Frame::new(5, 50), Frame::new(0, 70)]),
    ]
}

pub(super) fn sl3_seeds() -> Vec<Vec<u8>> {
    let mut with_raw = frames();
    with_raw.extend([Frame::new(7, 200), Frame::new(8, 210)]);
    let pairs = |at: f32| [[at, 12.0], [at + 6.0, 13.0]];
    let swath = |ping: i32| {
        let [port, starboard, unreliable] = [1.0, 2.0, 9.0].map(pairs);
        Frame::of_swath(300 + 50 * ping, [&port, &starboard, &unreliable])
    };
    let mut with_swath = frames();
    with_swath.extend((0..3).map(swath));
    vec![
        handmade::sl3(&frames(), 168),
        handmade::sl3(&with_raw, 180),
        handmade::sl3(&with_swath, 168),
    ]
}

/// The file header is not padded: the records are found by their number, wherever they begin.
pub(super) fn rsd_seeds() -> Vec<Vec<u8>> {
    let bands = [(2, 150_000, 240_000), (4, 425_000, 485_000), (5, 425_000, 485_000)];
    let channels = [(4, 2, Some(-TILT_DEG)), (5, 3, Some(TILT_DEG)), (2, 1, None)];
    let file = |width: usize, has_trailer: bool| {
        let mut bytes = garmin_writer::header(GARMIN_S, &bands);
        let end = bytes.iter().rposition(|byte| *byte != 0).map_or(0, |at| at + 8);
        bytes.truncate(end);
        for ping in 0..4 {
            for (channel, beam, tilt_deg) in channels {
                let garmin_ping = Ping {
                    channel: Some(channel),
                    beam: Some(beam),
                    tilt_deg,
                    sequence: ping,
                    time_ms: 500 + 100 * ping + channel,
                    bottom_mm: Some(8_000),
                    place_deg: Some([43.125, -83.434]),
                    samples: (0..SAMPLES as u16).collect(),
                    width,
                    has_trailer,
                    ..Ping::default()
                };
                bytes.extend(garmin_ping.record());
            }
        }
        bytes
    };
    vec![file(2, true), file(1, false)]
}

pub(super) fn xtf_seeds() -> Vec<Vec<u8>> {
    vec![
        handmade::xtf(3, 1, 3, (-73.6, 42.7), 5.0),
        handmade::xtf(3, 2, 0, (400_000.0, 4_700_000.0), 5.0),
        handmade::xtf_bathymetry(2),
    ]
}

pub(super) fn jsf_seeds() -> Vec<Vec<u8>> {
    let of = |data_format: u16, old: bool, subsystems: Vec<u8>| {
        jsf_file(&JsfOptions {
            pings: 3,
            subsystems,
            data_format,
            samples: SAMPLES,
            old,
            ..JsfOptions::default()
        })
    };
    vec![of(0, false, vec![20]), of(1, false, vec![20, 21]), of(0, true, vec![20])]
}

pub(super) fn svlog_seeds() -> Vec<Vec<u8>> {
    let of = |positions: u16| {
        svlog_file(&SvlogOptions {
            pings: 4,
            samples: SAMPLES,
            positions,
            ..SvlogOptions::default()
        })
    };
    vec![of(109), of(150)]
}

pub(super) fn humminbird_seeds() -> Vec<Vec<u8>> {
    let son = |beam: u8, little: bool| {
        let ping =
            |index: u32| handmade::son_ping(beam, index, 45 * index, SAMPLES, little, little);
        (0..5).flat_map(ping).collect::<Vec<u8>>()
    };
    let of = |solix: bool| {
        let (dat, port, starboard) = (handmade::dat(solix), son(2, solix), son(3, solix));
        let lengths = [dat.len(), port.len()].map(|length| (length as u16).to_le_bytes());
        [lengths.concat(), dat, port, starboard].concat()
    };
    vec![of(false), of(true)]
}

/// Blocks with one word of flags each, and zeros for the fields that it names.
pub(super) fn slg_seeds() -> Vec<Vec<u8>> {
    const SIZE: u8 = 160;
    let block = |flags: u16| {
        let mut block = flags.to_le_bytes().to_vec();
        block.resize(usize::from(SIZE), 0);
        block
    };
    let header = vec![1, 0, 0, 0, SIZE, 0, 0, 0, 0, 0];
    let blocks = [0x0200, 0x0600, 0x0E70, 0xFFFF].map(block);
    vec![[header, blocks.concat()].concat()]
}

pub(super) fn sdf_seeds() -> Vec<Vec<u8>> {
    let of = |versions: Vec<u32>, has_low: bool| {
        sdf_file(&SdfOptions {
            pages: 2,
            samples: SAMPLES,
            versions,
            has_low,
            ..SdfOptions::default()
        })
    };
    vec![of(vec![3001], true), of(vec![3501, 5001], false)]
}

pub(super) fn nmea_seeds() -> Vec<Vec<u8>> {
    let of = |depth_in: DepthIn, stamp: Stamp| {
        nmea_file(&NmeaOptions {
            seconds: 4,
            depth_in,
            stamp,
            heading: Some((120.0, "HDG")),
            ..NmeaOptions::default()
        })
    };
    vec![of(DepthIn::Dpt, Stamp::None), of(DepthIn::Dbt, Stamp::Tag)]
}

pub(super) fn soundings_seeds() -> Vec<Vec<u8>> {
    let named = "time;lon;lat;depth_ft\n2024-05-01T10:00:00Z;8,5;47,25;12,5\n2024-05-01T10:00:01Z;8,5001;47,25;12,7\n";
    let deeper = "47.25,8.5,3.81,1714557600000\n47.2501,8.5,3.9,1714557601000\n";
    [named, deeper].map(|text| text.as_bytes().to_vec()).into()
}

pub(super) fn picture_seeds() -> Vec<Vec<u8>> {
    let of = |format: ImageFormat, table: &str| {
        let picture = GrayImage::from_fn(9, 3, |x, y| Luma([(20 * x + y) as u8]));
        let mut bytes = Cursor::new(Vec::new());
        let written = picture.write_to(&mut bytes, format);
        written.expect("a picture");
        let length = (table.len() as u16).to_le_bytes();
        [&length, table.as_bytes(), &bytes.into_inner()].concat()
    };
    let rows = "time,lon,lat,range_m,depth_m\n0,8.5,47.25,20,4\n1,8.5001,47.25,20,4.1\n1,8.5002,47.25,20,\n";
    let numbered = "row;range_ft;min_range_ft\n1;60,5;2\n3;60,5;2\n";
    vec![of(ImageFormat::Png, rows), of(ImageFormat::Jpeg, numbered)]
}

pub(super) fn growing_seeds() -> Vec<Vec<u8>> {
    let long = |channel: u16, ping: i32| Frame {
        data: vec![7; 20],
        ..Frame::new(channel, 1000 * ping + i32::from(channel))
    };
    let minute: Vec<Frame> = (0..14).flat_map(|ping| [long(0, ping), long(5, ping)]).collect();
    let jsf = JsfOptions { pings: 14, samples: 10, ..JsfOptions::default() };
    let svlog = SvlogOptions { pings: 30, samples: 10, ..SvlogOptions::default() };
    let mut logs = vec![handmade::sl2(&minute), handmade::sl3(&minute, 168)];
    logs.extend([jsf_file(&jsf), svlog_file(&svlog)]);
    logs.extend(xtf_seeds().into_iter().chain(rsd_seeds()).chain(sl2_seeds()));
    logs.into_iter().map(|log| [vec![100, 180], log].concat()).collect()
}
