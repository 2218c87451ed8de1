//! Small SL2 and SL3 logs, one for every trap of the formats.

use super::*;

#[test]
fn composite_frames_are_cut_in_the_middle() {
    let survey = read(handmade::sl2(&handmade::survey_frames(20)));
    assert_eq!(survey.side_scan.len(), 20);
    let data = Frame::new(5, 0).data;
    let port: Vec<u8> = data[..200].iter().rev().copied().collect();
    assert_eq!(outward(&survey, 3, Side::Port), port);
    assert_eq!(outward(&survey, 3, Side::Starboard), data[200..]);
    let span = survey.side_scan[3].port.unwrap();
    assert!((span.far_m - 60.0 * 0.3048).abs() < 1e-5 && span.near_m == 0.0);
}

#[test]
fn sl3_data_begins_where_frame_size_less_packet_says() {
    for header in [168, 180] {
        let mut frames = handmade::survey_frames(10);
        frames.insert(4, Frame::new(8, 90));
        let survey = read(handmade::sl3(&frames, header));
        assert_eq!(survey.side_scan.len(), 10);
        assert_eq!(outward(&survey, 9, Side::Starboard), Frame::new(5, 0).data[200..]);
        assert_eq!(counts(&survey)[2], (ChannelKind::Other(8), 1));
    }
}

#[test]
fn separate_sides_are_joined_by_time_not_by_number() {
    // Starboard began two pings later: frame numbers differ, times do not.
    let mut frames: Vec<Frame> = (0..50)
        .flat_map(|ping| {
            let port = Frame::new(3, ping * 50);
            let starboard = (ping >= 2).then(|| Frame::new(4, ping * 50 + 4));
            [Some(port), starboard].into_iter().flatten()
        })
        .collect();
    frames.remove(40);
    let survey = read(handmade::sl2(&frames));
    assert_eq!(survey.side_scan.len(), 50);
    let both = survey
        .side_scan
        .iter()
        .filter(|ping| ping.port.is_some() && ping.starboard.is_some())
        .count();
    assert_eq!(both, 47);
    assert_eq!(outward(&survey, 10, Side::Port), Frame::new(3, 0).data);
}

#[test]
fn one_side_alone_is_a_survey_too() {
    let frames: Vec<Frame> = (0..9).map(|ping| Frame::new(4, ping * 50)).collect();
    let survey = read(handmade::sl2(&frames));
    assert_eq!(survey.side_scan.len(), 9);
    assert_eq!(survey.side_scan_state, SideScanState::Usable);
    assert!(survey.side_scan.iter().all(|ping| ping.port.is_none() && ping.starboard.is_some()));
}

#[test]
fn range_is_a_matter_of_each_ping() {
    let mut frames = handmade::survey_frames(4);
    frames[7].range_ft = (-100.0, 100.0);
    let survey = read(handmade::sl2(&frames));
    let far_m: Vec<f32> =
        survey.side_scan.iter().map(|ping| ping.starboard.unwrap().far_m).collect();
    assert!((far_m[2] - 18.288).abs() < 1e-4 && (far_m[3] - 30.48).abs() < 1e-4);
    assert_eq!(survey.channels[1].range_m, Some((0.0, 30.48)));
}

#[test]
fn depth_comes_from_the_nearest_sounding_less_the_keel_offset() {
    let mut frames = handmade::survey_frames(100);
    for (index, frame) in frames.iter_mut().enumerate() {
        let is_primary = frame.channel == 0;
        frame.depth_ft = if is_primary { 10.0 + index as f32 } else { 0.0 };
        frame.keel_ft = 2.0;
    }
    let survey = read(handmade::sl2(&frames));
    assert_eq!(survey.soundings.len(), 100);
    let depth_m = survey.side_scan[30].depth_m;
    assert!((depth_m - (10.0 + 60.0 - 2.0) * 0.3048).abs() < 1e-4, "{depth_m}");
    assert!(says(&survey, "keel offset"));
}

/// Distance to starboard and depth of all depths of a swath ping, feet.
fn swath_ft(survey: &Survey, ping: usize) -> Vec<[f64; 2]> {
    let soundings = survey.swath_soundings(&survey.swath[ping]);
    let feet =
        soundings.map(|sounding| [sounding.side.to_starboard(sounding.out_m), sounding.depth_m]);
    feet.map(|pair| pair.map(|metres| (metres / 0.3048 * 1e3).round() / 1e3)).collect()
}

/// A log with three frames of StructureScan 3D after other frames.
fn swath_frames() -> Vec<Frame> {
    let mut frames = handmade::survey_frames(5);
    let pairs = |at: f32| [[at, 20.0], [at + 10.0, 22.0]];
    frames.extend((0..3).map(|ping| {
        let [port, starboard] = [1.0, 5.0].map(pairs);
        let unreliable = [[3.0, 7.0]; 4];
        Frame::of_swath(300 + 50 * ping, [&port, &starboard, &unreliable])
    }));
    frames
}

#[test]
fn depths_across_the_track_are_those_of_port_and_starboard() {
    for header in [168, 180] {
        let survey = read(handmade::sl3(&swath_frames(), header));
        assert_eq!(survey.swath.len(), 3);
        let expected = [[-1.0, 20.0], [-11.0, 22.0], [5.0, 20.0], [15.0, 22.0]];
        assert_eq!(swath_ft(&survey, 2), expected);
        assert!((survey.swath[2].time_s - 0.4).abs() < 1e-9);
        assert!(says(
            &survey,
            "3 frames of StructureScan 3D with 12 depths across the track; 12 more that the unit marks as unreliable"
        ));
        let channel = counts(&survey)[2];
        assert_eq!(channel, (ChannelKind::Swath, 3));
        assert_eq!(survey.side_scan.len(), 5);
        assert_eq!(survey.soundings.len(), 5, "no depth of channel 9");
    }
}

#[test]
fn damaged_depths_across_the_track_are_left_out_and_named() {
    let mut frames = swath_frames();
    let at = |bytes: &mut Vec<u8>, at: usize, value: [u8; 4]| {
        bytes[at..at + 4].copy_from_slice(&value);
    };
    let [first, second, third] = [10, 11, 12];
    at(&mut frames[first].data, 76, f32::NAN.to_le_bytes());
    at(&mut frames[first].data, 76 + 12, 1e9_f32.to_le_bytes());
    at(&mut frames[second].data, 4, (-8_i32).to_le_bytes());
    at(&mut frames[third].data, 8, 12_i32.to_le_bytes());
    let bytes = handmade::sl3(&frames, 168);
    let survey = read(bytes.clone());
    assert_eq!(survey.swath.len(), 1);
    assert_eq!(swath_ft(&survey, 0), [[5.0, 20.0], [15.0, 22.0]]);
    let starts = frames.iter().scan(8_u64, |next, frame| {
        let start = *next;
        *next += 168 + frame.data.len() as u64;
        Some(start)
    });
    let starts: Vec<u64> = starts.collect();
    for (frame, words) in [
        (first, "2 of 4 depths in a frame"),
        (second, "not hold as many depths"),
        (third, "not hold as many depths"),
    ] {
        let place = Some((0, starts[frame]));
        let is_it = |warning: &&Warning| warning.place == place && warning.text.contains(words);
        assert!(survey.warnings.iter().any(|warning| is_it(&warning)), "{words}");
    }
    // Cut anywhere in its last frames: whole ones are kept.
    for end in (starts[first] as usize..bytes.len()).step_by(7) {
        let cut = read(bytes[..end].to_vec());
        assert!(cut.swath.len() <= 1 && cut.side_scan.len() == 5);
    }
}

#[test]
fn a_frame_that_counts_more_depths_than_it_has_bytes_is_dropped() {
    for (field, value) in [(0, 0_i32), (0, 1 << 20), (4, 1 << 16), (12, i32::MAX)] {
        let mut frames = swath_frames();
        frames[11].data[field..field + 4].copy_from_slice(&value.to_le_bytes());
        let survey = read(handmade::sl3(&frames, 168));
        assert_eq!(survey.swath.len(), 2, "{field} {value}");
    }
    let mut frames = swath_frames();
    frames[11].data.truncate(20);
    assert_eq!(read(handmade::sl3(&frames, 168)).swath.len(), 2);
}

#[test]
fn depth_comes_from_another_channel_where_the_primary_has_none() {
    let mut frames: Vec<Frame> =
        (0..60).flat_map(|ping| [0, 2, 5].map(|channel| Frame::new(channel, ping * 50))).collect();
    for frame in &mut frames {
        frame.depth_ft = if frame.channel == 2 { 8.0 } else { 0.0 };
    }
    let survey = read(handmade::sl2(&frames));
    assert_eq!(survey.soundings.len(), 60);
    assert!((survey.side_scan[9].depth_m - 8.0 * 0.3048).abs() < 1e-5);
}

#[test]
fn unix_time_only_where_it_is_one() {
    for (clock, expected) in [(1_600_000_000, Some(1.6e9)), (u32::MAX, None), (1_317_703, None)] {
        let mut frames = handmade::survey_frames(5);
        frames[0].clock = clock;
        assert_eq!(read(handmade::sl2(&frames)).start_unix_s, expected);
    }
}

#[test]
fn the_end_may_be_cut_or_dirty_and_the_last_whole_frame_is_kept() {
    let whole = handmade::sl2(&handmade::survey_frames(10));
    let with = |tail: &[u8]| read([&whole, tail].concat());
    for tail in [&[0_u8, 0][..], &[0xAB; 500], &[0; 5000]] {
        let survey = with(tail);
        assert_eq!(survey.side_scan.len(), 10);
        let place = Some((0, whole.len() as u64));
        // Two stray bytes are no part of a frame: nothing is lost with them.
        let is_told = survey.warnings.iter().any(|warning| warning.place == place);
        assert_eq!(is_told, tail.len() > 3);
    }
    // The next frame was begun: its header, and then a part of its data.
    let longer = handmade::sl2(&handmade::survey_frames(11));
    for begun in [10, 144, 500] {
        let survey = read(longer[..whole.len() + begun].to_vec());
        assert_eq!(survey.side_scan.len(), 10);
        assert!(says(&survey, "cut inside its last frame"));
    }
}

#[test]
fn a_lost_byte_costs_one_frame() {
    let mut bytes = handmade::sl2(&handmade::survey_frames(60));
    bytes.remove(8 + 544 * 51 + 300);
    let survey = read(bytes);
    assert_eq!(survey.side_scan.len(), 60 - 1);
    assert!(says(&survey, "the next begins after 543"));
}

#[test]
fn a_frame_size_of_zero_costs_one_frame() {
    let mut bytes = handmade::sl2(&handmade::survey_frames(60));
    let frame = 8 + 544 * 51;
    bytes[frame + 28..frame + 30].fill(0);
    let survey = read(bytes);
    assert_eq!(survey.side_scan.len(), 60 - 1);
    assert!(survey.warnings.iter().any(|warning| warning.place == Some((0, frame as u64))));
}

#[test]
fn a_frame_size_that_ends_where_the_next_frame_does_costs_one_frame() {
    let mut bytes = handmade::sl2(&handmade::survey_frames(60));
    let frame = 8 + 544 * 51;
    bytes[frame + 28..frame + 30].copy_from_slice(&1088_u16.to_le_bytes());
    let survey = read(bytes);
    assert_eq!(survey.side_scan.len(), 60 - 1);
    assert!(says(&survey, "the next begins after 544"));
}

#[test]
fn many_gaps_become_few_warnings() {
    let mut bytes = handmade::sl2(&handmade::survey_frames(500));
    for frame in (0..500).map(|index| 8 + 1088 * index) {
        bytes[frame] ^= 0xFF;
    }
    let survey = read(bytes);
    assert_eq!(survey.side_scan.len(), 500);
    assert!(survey.warnings.len() < 40 && says(&survey, "480 more gaps"));
}

#[test]
fn after_a_restart_the_pings_stay_in_file_order() {
    let mut frames = handmade::survey_frames(100);
    for frame in &mut frames {
        frame.time_ms += 900_000;
    }
    frames.extend(handmade::survey_frames(50));
    let survey = read(handmade::sl2(&frames));
    assert_eq!(survey.side_scan.len(), 150);
    let offsets: Vec<u64> = survey.side_scan.iter().map(|ping| ping.port.unwrap().offset).collect();
    assert!(offsets.is_sorted());
    assert!(survey.side_scan.is_sorted_by(|a, b| a.time_s <= b.time_s));
    assert!(says(&survey, "set back"));
}

#[test]
fn noise_is_named_even_with_a_good_header() {
    let mut frames = handmade::survey_frames(30);
    frames
        .iter_mut()
        .filter(|frame| frame.channel == 5)
        .for_each(|frame| frame.range_ft = (-5.0, 5.0));
    let survey = read(handmade::sl2(&frames));
    assert!(matches!(survey.side_scan_state, SideScanState::Noise { .. }));
    assert!(!survey.has_side_scan());
}

#[test]
fn a_fix_thrown_far_away_is_dropped() {
    let mut frames = handmade::survey_frames(30);
    frames[1].xy_m = (-9_000_000, 17);
    let survey = read(handmade::sl2(&frames));
    assert!(survey.track.fixes.iter().all(|fix| fix.position.lat_deg > 20.0));
    assert!(says(&survey, "kilometres"));
}
