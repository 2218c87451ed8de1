//! Prints the objects that the detector proposes in a log:
//! `cargo run --release -p bathyscope-objects --example find -- LOG`.

use bathyscope_log::formats::open;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{HeadingSettings, Projection, navigate};
use bathyscope_objects::{DetectorSettings, find, model::shipped};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args_os().nth(1).ok_or("name a log")?;
    let progress = Progress::new();
    let log = open(path.as_ref(), &progress)?;
    let navigation = navigate(&log, &HeadingSettings::default(), Projection::Enu, &progress)?;
    let (model, settings) = (shipped()?, DetectorSettings::default());
    for object in find(&log, &navigation, &model, &settings, &progress, |_| ())? {
        let class = &model.names()[object.class];
        println!("{class} at ping {}, confidence {:.2}", object.mark.pings.start, object.score);
    }
    Ok(())
}
