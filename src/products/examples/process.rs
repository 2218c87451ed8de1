//! Writes all products of a log: `cargo run --release -p bathyscope-products --example process --
//! LOG FOLDER`.

use bathyscope_log::formats::open;
use bathyscope_log::support::progress::Progress;
use bathyscope_objects::objects::SurveyReview;
use bathyscope_products::outputs::{Order, Product, RunFolder, write};
use bathyscope_products::pipeline::{Derived, ProcessedLog, Settings, run};
use std::error::Error;
use std::sync::Arc;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1);
    let (path, folder) =
        (arguments.next().ok_or("name a log")?, arguments.next().ok_or("name a folder")?);
    let progress = Progress::new();
    let survey = Arc::new(open(path.as_ref(), &progress)?);
    let products = run(&survey, &Settings::default(), None, &progress, |_| ())?;
    let order = Order {
        logs: &[ProcessedLog { survey, products }],
        derived: &Derived::default(),
        requested: &Product::ALL,
        reference: None,
        search: None,
        review: &SurveyReview::default(),
        corrections: &[],
    };
    let written = write(&order, RunFolder::begin(folder.as_ref())?, &progress, |_| ())?;
    println!("{} files", written.file_count);
    Ok(())
}
