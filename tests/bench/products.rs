//! Every product of a survey of ten lines and 100 000 pings: what each costs beside tracking it,
//! and memory over the survey's own.

use crate::lines::ten_lines;
use crate::resources::{peak_from_here_mb, peak_mb, processor_s};
use bathyscope_bottom::first_return;
use bathyscope_log::support::progress::Progress;
use bathyscope_objects::objects::SurveyReview;
use bathyscope_products::outputs::{self, Order, Product, RunFolder};
use bathyscope_products::pipeline::{self, Derived, ProcessedLog, Settings};
use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

const PINGS_A_LINE: f64 = 10_000.0;

/// One group of products after the other, then all of them with the report.
pub(super) fn run() {
    let progress = Progress::new();
    let survey = ten_lines(PINGS_A_LINE);
    let settings = Settings::default();
    let products = pipeline::run(&survey, &settings, None, &progress, |_| ());
    let products = products.expect("not cancelled");
    let before = processor_s();
    let returns = first_return::detect(&survey, &settings.image, &settings.first_return, &progress);
    black_box(returns.expect("not cancelled"));
    let tracked_s = processor_s() - before;
    println!(
        "{} pings tracked: {tracked_s:.2} s of processor; mosaic at {} m",
        survey.side_scan.len(),
        settings.mosaic.cell_m
    );
    let folder = tempfile::tempdir().expect("a temporary folder");
    let measured = |name: &str, work: &dyn Fn()| {
        let (before_mb, before, began) = (peak_from_here_mb(), processor_s(), Instant::now());
        work();
        let taken_s = processor_s() - before;
        let more_mb = peak_mb().zip(before_mb).map_or(f64::NAN, |(peak, before)| peak - before);
        println!(
            "{name:18} {taken_s:6.2} s of processor, {:6.2} s on the clock, {:5.1} of tracking; {more_mb:4.0} MB at the peak",
            began.elapsed().as_secs_f64(),
            taken_s / tracked_s
        );
    };
    let logs = [ProcessedLog { survey: Arc::new(survey), products }];
    let write = |requested: &[Product]| {
        let order = Order {
            logs: &logs,
            derived: &Derived::default(),
            requested,
            reference: None,
            search: None,
            review: &SurveyReview::default(),
            corrections: &[],
        };
        let run = RunFolder::begin(folder.path()).expect("a folder to write into");
        outputs::write(&order, run, &progress, |_| ()).expect("a folder to write into")
    };
    measured("tables, records", &|| drop(write(&[])));
    for product in Product::ALL {
        measured(&format!("{product:?}"), &|| drop(write(&[product])));
    }
    measured("all, with report", &|| drop(write(&Product::ALL)));
}
