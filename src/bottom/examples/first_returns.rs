//! Prints the sample of the first return of each ping, port and starboard:
//! `cargo run --release -p bathyscope-bottom --example first_returns -- LOG`.

use bathyscope_bottom::first_return::{FirstReturnSettings, ImageSettings, detect};
use bathyscope_log::formats::open;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::Side;
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args_os().nth(1).ok_or("name a log")?;
    let progress = Progress::new();
    let log = open(path.as_ref(), &progress)?;
    let (image, settings) = (ImageSettings::default(), FirstReturnSettings::default());
    let returns = detect(&log, &image, &settings, &progress)?;
    let sample = |side: Side, ping: usize| returns.side(side)[ping].sample;
    for ping in 0..log.side_scan.len() {
        println!("{ping}: {:?}", Side::BOTH.map(|side| sample(side, ping)));
    }
    Ok(())
}
