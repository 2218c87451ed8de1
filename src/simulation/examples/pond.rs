//! Writes the log of a simulated pond and prints its greatest depth under the boat: `cargo run
//! --release -p bathyscope-simulation --example pond -- FILE.sl2`.

use bathyscope_log::support::progress::Progress;
use bathyscope_simulation::{Scene, simulate};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args_os().nth(1).ok_or("name the file to write")?;
    let simulated = simulate(&Scene::with_pings(2000), 7, &Progress::new())?;
    std::fs::write(path, simulated.sl2_bytes())?;
    let deepest_m = simulated.pings.iter().map(|ping| ping.depth_m).fold(0.0, f64::max);
    println!("{} pings, the deepest over {deepest_m:.2} m", simulated.pings.len());
    Ok(())
}
