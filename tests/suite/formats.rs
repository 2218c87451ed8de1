//! Every real recording is read as its README says.

use crate::support;
use bathyscope::formats;
use bathyscope::progress::Progress;
use bathyscope::survey::{ChannelKind, SideScanState, Survey};

fn open(file: &str) -> Option<Survey> {
    let path = support::real_data()?.join(file);
    Some(formats::open(&path, &Progress::new()).unwrap_or_else(|error| panic!("{error}")))
}

fn counts(survey: &Survey) -> Vec<(ChannelKind, usize)> {
    survey
        .channels
        .iter()
        .map(|channel| (channel.kind, channel.ping_count))
        .collect()
}

#[test]
fn the_river_survey_is_whole() {
    let Some(survey) = open("humminbird-glen-canyon/Rec00001.DAT") else {
        return;
    };
    assert_eq!(
        counts(&survey),
        [
            (ChannelKind::Primary, 1727),
            (ChannelKind::Secondary, 1726),
            (ChannelKind::Port, 3453),
            (ChannelKind::Starboard, 3453),
        ]
    );
    assert_eq!(survey.side_scan.len(), 3453);
    assert_eq!(survey.side_scan_state, SideScanState::Usable);
    let both =
        |ping: &&bathyscope::survey::SidePing| ping.port.is_some() && ping.starboard.is_some();
    assert_eq!(survey.side_scan.iter().filter(both).count(), 3453);
}

#[test]
fn a_log_without_side_scan_opens_and_says_so() {
    let Some(survey) = open("lowrance/river-downscan-only.sl2") else {
        return;
    };
    assert_eq!(
        counts(&survey),
        [
            (ChannelKind::Primary, 325),
            (ChannelKind::Secondary, 330),
            (ChannelKind::DownScan, 653),
        ]
    );
    assert_eq!(survey.side_scan_state, SideScanState::Absent);
}
