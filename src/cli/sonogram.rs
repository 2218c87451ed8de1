//! `bathyscope sonogram`: draws the side-scan picture of a log in pages, with its scales.

use super::status_line::StatusLine;
use super::waterfall_options::{WaterfallArgs, parse_size};
use super::{Failure, output};
use crate::app::View;
use crate::ui::Shell;
use crate::ui::offscreen::{Studio, write_picture};
use bathyscope_bottom::calibration::PingRange;
use bathyscope_log::support::progress::Progress;
use bathyscope_products::export::make_folder;
use std::path::PathBuf;

/// Most pages: a larger number is taken for a mistake.
const MOST_PAGES: usize = 10_000;
/// Narrowest page, pixels: the last page holds the remaining pings.
const NARROWEST: u32 = 160;

/// `bathyscope sonogram LOG -o DIR`.
#[derive(Debug, clap::Args)]
pub(super) struct SonogramArgs {
    #[command(flatten)]
    shown: WaterfallArgs,
    /// Folder of the pages, NAME_0001.png and so on
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Width and height of a page in pixels
    #[arg(long, value_name = "WxH", default_value = "1600x800", value_parser = parse_size)]
    size: [u32; 2],
    /// Pings of a page; as many as make a metre along as long as one across when left out
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(16..))]
    page_pings: Option<u32>,
}

/// Draws the pages and writes them; prints on stderr which adapter drew them.
pub(super) fn run(args: SonogramArgs) -> Result<(), Failure> {
    output::restart_if_noisy();
    let log = args.shown.open()?;
    let [width, height] = args.size;
    let one_to_one = || (log.one_to_one(width, height).round() as usize).max(16);
    let page = args.page_pings.map_or_else(one_to_one, |pings| pings as usize);
    let pages = pages(log.pings, page)?;
    make_folder(&args.output)?;
    let (mut shell, name) = (Shell::new(log.app), log.name);
    shell.show_alone(View::Waterfall);
    let studio = Studio::new()?;
    let status = StatusLine::at("sonogram");
    status.progress.start(pages.len() as u64);
    for (number, pings) in pages.iter().enumerate() {
        let share = (pings.end - pings.start) as f64 / page as f64;
        let width = ((f64::from(width) * share).round() as u32).max(NARROWEST.min(width));
        shell.show_pings(pings.start..pings.end);
        let picture = studio.draw(&mut shell, [width, height], 1.0, &Progress::new())?;
        shell.app.logs.check_files()?;
        let file = format!("{name}_{:04}.png", number + 1);
        write_picture(&picture, &args.output.join(file))?;
        status.progress.advance(1);
    }
    drop(status);
    output::notify(format_args!(
        "{} pages of {page} pings, drawn by {}",
        pages.len(),
        studio.adapter()
    ));
    Ok(())
}

/// Divides the pings into pages.
fn pages(pings: PingRange, page: usize) -> Result<Vec<PingRange>, Failure> {
    let count = (pings.end - pings.start).div_ceil(page);
    if count > MOST_PAGES {
        return Err(format!(
            "that makes {count} pages; ask for more pings a page, {MOST_PAGES} pages are the most"
        )
        .into());
    }
    let starts = (pings.start..pings.end).step_by(page);
    let pages = starts.map(|start| PingRange { start, end: (start + page).min(pings.end) });
    Ok(pages.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_hold_every_ping_once() {
        let all = PingRange { start: 100, end: 1250 };
        let made = pages(all, 500).expect("pages");
        let made: Vec<_> = made.iter().map(|page| (page.start, page.end)).collect();
        assert_eq!(made, [(100, 600), (600, 1100), (1100, 1250)]);
        let many = PingRange { start: 0, end: 1_000_000 };
        assert!(pages(many, 16).is_err());
    }
}
