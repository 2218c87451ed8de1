//! Reads the files that an archive keeps of its logs: rows in Parquet files, records, the table of
//! offsets.

use super::projects::held_as;
use super::{say, scratch};
use bathyscope_log::formats::parquet_table::{Column, Values, write_parquet};
use bathyscope_products::archive::readers;
use bathyscope_products::pipeline::Settings;

pub(super) fn rows(bytes: &[u8]) {
    scratch::with_file("rows.parquet", bytes, |path| {
        readers::rows(path).iter().for_each(say);
    });
}

/// A table with the columns of points, and one with those of pings and echoes.
pub(super) fn row_seeds() -> Vec<Vec<u8>> {
    let doubles = |name| Column::doubles(name, [1.5, -2.25, 3.0].into_iter());
    let floats = |name| Column::floats(name, [0.5_f32, -0.25, 0.0].into_iter());
    let wholes = |name| Column::wholes(name, [Some(1), None, Some(3)].into_iter());
    let flags = |name| Column::flags(name, [true, false, true].into_iter());
    let write = |columns: Vec<Column>| {
        let write = |file| write_parquet(file, &columns, &[]).expect("a table");
        scratch::written("seed.parquet", write)
    };
    let mut points: Vec<Column> = ["x", "y", "depth_m", "weight", "time_s"].map(doubles).into();
    points.extend(["velocity_x_mps", "velocity_y_mps"].map(floats));
    points.push(wholes("sounding"));
    let numbers = [
        "x",
        "y",
        "starboard_x",
        "starboard_y",
        "altitude_m",
        "depth_m",
        "behind_m",
        "ahead_m",
        "port_near_m",
        "port_sample_m",
        "starboard_near_m",
        "starboard_sample_m",
        "time_s",
    ];
    let mut pings: Vec<Column> = numbers.map(doubles).into();
    pings.extend(["port_samples", "starboard_samples", "ping"].map(wholes));
    pings.extend(["halo", "left_out"].map(flags));
    pings.push(Column::new("time", Values::Time(vec![Some(1), None, Some(3)])));
    let numbers = [
        "x",
        "y",
        "starboard_x",
        "starboard_y",
        "velocity_x_mps",
        "velocity_y_mps",
        "transducer_m",
        "time_s",
        "port_near_m",
        "port_sample_m",
        "starboard_near_m",
        "starboard_sample_m",
        "gain",
    ];
    let mut echoes: Vec<Column> = numbers.map(doubles).into();
    echoes.extend(["ping", "chunk", "range_setting", "gain_segment"].map(wholes));
    echoes.push(flags("weed"));
    let bytes = |name| Column::new(name, Values::Bytes(vec![vec![1, 2, 3], vec![], vec![7]]));
    echoes.extend(["port", "starboard"].map(bytes));
    [points, pings, echoes].map(write).into()
}

pub(super) fn records(bytes: &[u8]) {
    held_as("archive/record", bytes, |path| {
        readers::records(path).iter().for_each(say);
    });
}

pub(super) fn record_seeds() -> Vec<Vec<u8>> {
    let offsets = "name,log,offset_m,standard_error_m,ties,group,pinned,east_m,north_m,shift_error_m,latency_s,latency_error_s,level_factor,level_ties\n\
        pond,0a1b,0.25,0.01,3,1,0,0.5,-0.25,0.1,0.2,0.05,1.1,2\nlake,ff,0,0,0,2,1,0,0,,0,,1,0\n";
    let mut seeds = readers::record_seeds(&Settings::default());
    seeds.push(offsets.to_owned());
    seeds.into_iter().map(String::into_bytes).collect()
}
