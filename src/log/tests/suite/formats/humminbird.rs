//! Small Humminbird recordings: every family, and files that are missing or damaged.

use super::*;

fn read(files: Vec<(PathBuf, Vec<u8>)>) -> Survey {
    formats::open_files(files, &Progress::new()).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn every_family_and_byte_order() {
    for (solix, little, format) in [
        (false, false, "Humminbird"),
        (true, false, "Humminbird Solix"),
        (true, true, "Humminbird Solix"),
    ] {
        let survey = read(handmade::humminbird(40, solix, little));
        assert_eq!(survey.source.format, format);
        assert_eq!(survey.side_scan.len(), 40);
        assert_eq!(survey.soundings.len(), 40);
        assert_eq!(survey.start_unix_s, Some(1.6e9));
        assert!((survey.side_scan[0].depth_m - 3.1).abs() < 1e-6);
        assert_eq!(survey.channels[1].sample_count, (300, 302));
        assert!((survey.track.fixes[0].cog_rad - std::f32::consts::FRAC_PI_2).abs() < 1e-6);
        assert_eq!(outward(&survey, 5, Side::Port)[..4], [0, 1, 2, 3]);
    }
}

#[test]
fn a_missing_or_damaged_dat_costs_the_start_time_only() {
    let mut files = handmade::humminbird(40, false, false);
    files[0].1.fill(0);
    let survey = read(files.clone());
    assert_eq!((survey.side_scan.len(), survey.start_unix_s), (40, None));
    assert!(says(&survey, "DAT file is damaged"));
    files.remove(0);
    let survey = read(files);
    assert_eq!((survey.side_scan.len(), survey.start_unix_s), (40, None));
    assert!(says(&survey, "DAT file is missing"));
}

#[test]
fn a_recording_copied_out_of_its_folder_opens_by_its_only_dat() {
    let mut files = handmade::humminbird(40, false, false);
    for (path, _) in &mut files {
        *path = PathBuf::from("copy").join(path.file_name().expect("a file"));
    }
    files[0].0 = PathBuf::from("copy/test.DAT");
    for first in 0..files.len() {
        let mut files = files.clone();
        files.swap(0, first);
        let survey = read(files);
        assert_eq!((survey.side_scan.len(), survey.start_unix_s), (40, Some(1.6e9)));
    }
}

#[test]
fn a_dat_alone_says_what_is_missing() {
    let files = vec![(PathBuf::from("Rec00007.DAT"), handmade::dat(false))];
    let error = formats::open_files(files, &Progress::new()).unwrap_err();
    assert!(matches!(&error, OpenError::Broken { .. }), "{error}");
    assert!(error.to_string().contains("B00n.SON"), "{error}");
}

#[test]
fn a_lost_port_ping_leaves_its_starboard_half() {
    let mut files = handmade::humminbird(40, false, false);
    let ping = files[2].1.len() / 40;
    files[2].1.drain(ping * 7..ping * 8);
    let survey = read(files);
    assert_eq!(survey.side_scan.len(), 40);
    assert_eq!(survey.side_scan.iter().filter(|ping| ping.port.is_none()).count(), 1);
}

#[test]
fn a_folder_of_recordings_opens_the_first_and_names_the_rest() {
    let mut files: Vec<(PathBuf, Vec<u8>)> = handmade::humminbird(20, false, false)
        .into_iter()
        .map(|(path, bytes)| (Path::new("RECORD").join(path), bytes))
        .collect();
    files.push((PathBuf::from("RECORD/Rec00008.DAT"), handmade::dat(false)));
    let folder = tempfile::tempdir().expect("a folder");
    for (path, bytes) in &files {
        let path = folder.path().join(path);
        std::fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
        std::fs::write(path, bytes).expect("a file");
    }
    let survey = formats::open(&folder.path().join("RECORD"), &Progress::new()).unwrap();
    assert_eq!(survey.side_scan.len(), 20);
    assert!(says(&survey, "other recordings (1)"));
}
