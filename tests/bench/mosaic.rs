//! The mosaic: time beside tracking the same survey, and memory as its cells become smaller.

use crate::lines::ten_lines;
use crate::resources::{peak_from_here_mb, peak_mb, processor_s};
use bathyscope_bottom::first_return;
use bathyscope_log::support::progress::Progress;
use bathyscope_objects::objects::SurveyReview;
use bathyscope_products::outputs::{self, Order, Product, RunFolder};
use bathyscope_products::pipeline::{self, Derived, ProcessedLog, Products, Settings};
use std::hint::black_box;
use std::sync::Arc;

const PINGS_A_LINE: f64 = 3000.0;
const CELLS_M: [f64; 5] = [0.4, 0.2, 0.1, 0.05, 0.02];

/// Ten lines side by side. Each step has four times the cells of the one before; memory must not
/// follow.
pub(super) fn run() {
    let progress = Progress::new();
    let survey = Arc::new(ten_lines(PINGS_A_LINE));
    let mut settings = Settings::default();
    let mut products =
        pipeline::run(&survey, &settings, None, &progress, |_| ()).expect("not cancelled");

    let before = processor_s();
    let returns = first_return::detect(&survey, &settings.image, &settings.first_return, &progress);
    black_box(returns.expect("not cancelled"));
    let tracked_s = processor_s() - before;
    println!("{} pings tracked: {tracked_s:.2} s of processor", survey.side_scan.len());

    let folder = tempfile::tempdir().expect("a temporary folder");
    let write = |products: &Products, requested: &[Product]| {
        let log = ProcessedLog { survey: survey.clone(), products: products.clone() };
        let order = Order {
            logs: std::slice::from_ref(&log),
            derived: &Derived::default(),
            requested,
            reference: None,
            search: None,
            review: &SurveyReview::default(),
            corrections: &[],
        };
        let run = RunFolder::begin(folder.path()).expect("a folder to write into");
        let before = processor_s();
        outputs::write(&order, run, &progress, |_| ()).expect("a whole set of files");
        processor_s() - before
    };
    // What every run writes.
    let always_s = write(&products, &[]);
    for cell_m in CELLS_M {
        settings.mosaic.cell_m = cell_m;
        products.settings = Arc::new(settings.clone());
        let before_mb = peak_from_here_mb();
        let taken_s = write(&products, &[Product::Mosaic]) - always_s;
        let more_mb = peak_mb().zip(before_mb).map_or(f64::NAN, |(peak, before)| peak - before);
        println!(
            "mosaic, its hash and its record at {cell_m:4} m: {taken_s:6.2} s of processor, {:5.1} of tracking; {more_mb:4.0} MB at the peak",
            taken_s / tracked_s
        );
    }
}
