//! `bathyscope film`: makes a film of the side-scan of a log as it runs down the screen of a
//! recorder.

use super::status_line::StatusLine;
use super::waterfall_options::{WaterfallArgs, WaterfallLog, parse_size};
use super::{Failure, check_ending, output};
use crate::app::{Command, Orientation, View};
use crate::ui::Shell;
use crate::ui::offscreen::Studio;
use bathyscope_log::support::progress::Progress;
use bathyscope_products::export::avi::{self, AviWriter};
use bathyscope_products::export::write_atomically;
use bathyscope_products::pipeline::Settings;
use image::DynamicImage;
use std::io::{self, BufWriter};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Number of frames after which the size of the whole film is estimated.
const GUESSED_AFTER: usize = 25;

/// `bathyscope film LOG -o FILE.avi`.
#[derive(Debug, clap::Args)]
pub(super) struct FilmArgs {
    #[command(flatten)]
    shown: WaterfallArgs,
    /// Film to write
    #[arg(short, long, value_name = "FILE.avi")]
    output: PathBuf,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = parse_size)]
    size: [u32; 2],
    /// Frames a second
    #[arg(long, default_value_t = 25, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=60))]
    fps: u32,
    /// Times as fast as the boat
    #[arg(long, default_value_t = 8.0, value_name = "FACTOR")]
    speed: f64,
}

/// Draws the film and writes it; prints on stderr how long it is.
pub(super) fn run(args: FilmArgs) -> Result<(), Failure> {
    output::restart_if_noisy();
    check_ending(&args.output, &["avi"], "a film's name ends in .avi")?;
    if !(args.speed > 0.0 && args.speed.is_finite()) {
        return Err(format!("a film's speed lies above 0; got {}", args.speed).into());
    }
    let log = args.shown.open()?;
    let frames = Frames::new(&log, args.size, args.speed / f64::from(args.fps));
    let mut app = log.app;
    // As on a recorder: the newest ping is on top.
    app.view.options.waterfall.orientation = Orientation::Vertical;
    let mut settings = Settings::clone(&app.logs.shown.settings);
    settings.picture.flip = !settings.picture.flip;
    app.apply(Command::Change {
        settings: Box::new(settings),
        label: "direction of the waterfall",
        live: false,
    });
    let mut shell = Shell::new(app);
    shell.show_alone(View::Waterfall);
    let studio = Studio::new()?;
    let status = StatusLine::at("film");
    write(&args.output, args.size, args.fps, &frames, &studio, &mut shell, &status.progress)?;
    drop(status);
    output::notify(format_args!(
        "{} frames, {:.0} s, {:.1} times as fast as the boat; drawn by {}",
        frames.count,
        frames.count as f64 / f64::from(args.fps),
        frames.speed(args.fps),
        studio.adapter()
    ));
    Ok(())
}

/// Pings that each frame shows.
#[derive(Clone, Debug, PartialEq)]
struct Frames {
    first: usize,
    /// Pings in a frame.
    shown: usize,
    /// Pings by which a frame is ahead of the one before.
    step: usize,
    count: usize,
    /// Seconds between two pings.
    interval_s: f64,
}

impl Frames {
    /// Divides a log into frames of a size in pixels. Each frame is `step_s` seconds of the log's
    /// time after the one before, rounded to whole pings.
    fn new(log: &WaterfallLog, [width, height]: [u32; 2], step_s: f64) -> Self {
        let pings = log.pings.end - log.pings.start;
        let shown = log.one_to_one(height, width).round() as usize;
        let shown = shown.clamp(1, pings.max(1));
        let survey = log.app.logs.shown.survey.as_ref();
        let time_s =
            |ping: usize| survey.and_then(|survey| Some(survey.side_scan.get(ping)?.time_s));
        let span_s = time_s(log.pings.end.saturating_sub(1)).zip(time_s(log.pings.start));
        let span_s = span_s.map_or(0.0, |(last, first)| last - first);
        let interval_s = span_s / pings.saturating_sub(1).max(1) as f64;
        // Rounded to whole pings: a picture that moves by three pings, then by four, trembles.
        let step = if interval_s > 0.0 { step_s / interval_s } else { 1.0 };
        let step = (step.round() as usize).clamp(1, pings.max(1));
        Self {
            first: log.pings.start,
            shown,
            step,
            count: (pings - shown.min(pings)).div_ceil(step) + 1,
            interval_s,
        }
    }

    fn pings(&self, frame: usize) -> Range<usize> {
        let start = self.first + frame * self.step;
        start..start + self.shown
    }

    /// Returns the speed of the film as a multiple of the boat's speed.
    fn speed(&self, fps: u32) -> f64 {
        self.step as f64 * self.interval_s * f64::from(fps)
    }
}

fn write(
    path: &Path,
    size: [u32; 2],
    fps: u32,
    frames: &Frames,
    studio: &Studio,
    shell: &mut Shell,
    progress: &Progress,
) -> Result<(), Failure> {
    let mut reel = studio.reel(size, 1.0)?;
    progress.start(frames.count as u64);
    write_atomically(path, |file| {
        let mut film = AviWriter::new(BufWriter::new(file), size, fps)?;
        for frame in 0..frames.count {
            shell.show_pings(frames.pings(frame));
            let picture = reel.draw(shell, progress).map_err(io::Error::other)?;
            film.push(&DynamicImage::ImageRgba8(picture).into_rgb8())?;
            if frame + 1 == GUESSED_AFTER {
                let whole = film.bytes_with_index() * frames.count as u64 / GUESSED_AFTER as u64;
                if whole > avi::LARGEST {
                    let text = "the film would be larger than 2 GB; show fewer pings, faster or in a smaller size";
                    return Err(io::Error::other(text));
                }
            }
            progress.advance(1);
        }
        shell.app.logs.check_files().map_err(io::Error::other)?;
        film.finish().map(drop)
    })?;
    Ok(())
}
