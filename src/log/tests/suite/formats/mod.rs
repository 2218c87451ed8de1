//! Logs are read as they are: the real ones to the counts of their README, small handmade ones for
//! every trap of the formats.

mod cases;
mod humminbird;
mod lowrance;
mod real;
mod refused;
mod xtf;

use bathyscope_log::formats::{self, OpenError};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{ChannelKind, SampleOrder, Side, SideScanState, Survey, Warning};
use bathyscope_test_support::handmade::{self, Frame};
use std::path::{Path, PathBuf};

fn open(file: &str) -> Option<Survey> {
    let path = bathyscope_test_support::real_data()?.join(file);
    Some(formats::open(&path, &Progress::new()).unwrap_or_else(|error| panic!("{error}")))
}

fn read(bytes: Vec<u8>) -> Survey {
    formats::open_bytes("pond.sl2", bytes, &Progress::new())
        .unwrap_or_else(|error| panic!("{error}"))
}

fn counts(survey: &Survey) -> Vec<(ChannelKind, usize)> {
    survey.channels.iter().map(|channel| (channel.kind, channel.ping_count)).collect()
}

fn says(survey: &Survey, words: &str) -> bool {
    survey.warnings.iter().any(|warning| warning.text.contains(words))
}

fn depth_span_m(survey: &Survey) -> (f32, f32) {
    survey.soundings.iter().fold((f32::MAX, f32::MIN), |(low, high), sounding| {
        (low.min(sounding.depth_m), high.max(sounding.depth_m))
    })
}

fn outward(survey: &Survey, ping: usize, side: Side) -> Vec<u8> {
    let mut samples = Vec::new();
    survey.samples(ping, side).expect("samples").copy_outward(&mut samples);
    samples
}
