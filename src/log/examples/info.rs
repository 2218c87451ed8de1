//! Prints what is in a log: `cargo run --release -p bathyscope-log --example info -- FILE`.

use bathyscope_log::formats::open;
use bathyscope_log::support::progress::Progress;
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args_os().nth(1).ok_or("name a log")?;
    let log = open(path.as_ref(), &Progress::new())?;
    for channel in &log.channels {
        println!("{:?}: {} pings", channel.kind, channel.ping_count);
    }
    println!("{} soundings, {} fixes", log.soundings.len(), log.track.fixes.len());
    for warning in &log.warnings {
        println!("warning: {}", warning.text);
    }
    Ok(())
}
