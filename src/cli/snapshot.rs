//! `bathyscope snapshot`: the window's pictures without a window.

use super::settings::{SettingsArgs, check_against};
use super::{output, quiet_driver};
use crate::app::{
    Action, App, Command, Jobs, MapLayer, Mark, Origin, ThemeChoice, View, ViewOptions,
};
use crate::calibration::PingRange;
use crate::geo::CoordinateFormat;
use crate::pipeline::Settings;
use crate::progress::Progress;
use crate::ui::{
    Alone, Shell,
    offscreen::{Studio, write_picture},
};
use std::path::{Path, PathBuf};

/// `bathyscope snapshot SURVEY -o FILE.png`.
#[derive(Debug, clap::Args)]
pub struct SnapshotArgs {
    /// The log; the bundled demo survey when left out
    survey: Option<PathBuf>,
    /// Picture to write
    #[arg(short, long, value_name = "FILE.png")]
    output: PathBuf,
    /// What to draw: one view, or the whole window
    #[arg(long, value_enum, default_value_t = Picture::All)]
    view: Picture,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "1600x1000", value_parser = parse_size)]
    size: [u32; 2],
    /// Side-scan pings that the waterfall shows; the middle one is selected
    #[arg(long, value_name = "A..B", value_parser = parse_pings)]
    pings: Option<PingRange>,
    /// Pixels in a point: 2 draws all text and lines twice as large
    #[arg(long, default_value_t = 1.0, value_name = "FACTOR")]
    scale: f32,
    /// Search for objects first, and draw their boxes
    #[arg(long)]
    objects: bool,
    /// What is known to lie in the survey: boxes are compared with it
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
    /// Layers of the map to draw, comma-separated; those that are not named are left out
    #[arg(long, value_name = "LAYERS", value_enum, value_delimiter = ',')]
    layers: Option<Vec<MapLayer>>,
    /// GeoTIFF of your own to lie under the map
    #[arg(long, value_name = "FILE.tif")]
    base_map: Option<PathBuf>,
    /// What the points are compared with, as `compare` takes it: the layer `residuals` shows the differences
    #[arg(long, value_name = "FILE")]
    reference: Option<PathBuf>,
    /// How positions are written
    #[arg(long, value_enum, default_value_t = Coordinates::Dd)]
    coordinates: Coordinates,
    /// Dark or light
    #[arg(long, value_enum, default_value_t = Theme::Dark)]
    theme: Theme,
    #[command(flatten)]
    settings: SettingsArgs,
}

/// What a picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Picture {
    /// Side-scan picture with the first return
    Waterfall,
    /// Track and depth map
    Map,
    /// 3D point cloud
    Cloud,
    /// The selected ping as a curve
    Profile,
    /// The whole window
    All,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Theme {
    Dark,
    Light,
}

/// How positions are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Coordinates {
    /// Decimal degrees
    Dd,
    /// Degrees and minutes
    Ddm,
    /// Degrees, minutes and seconds
    Dms,
    /// Metres of the UTM zone
    Utm,
}

fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let parsed = text
        .split_once(['x', 'X', '×'])
        .and_then(|(width, height)| Some([width.parse().ok()?, height.parse().ok()?]));
    parsed
        .filter(|size: &[u32; 2]| size.iter().all(|side| (16..=16_384).contains(side)))
        .ok_or_else(|| {
            format!("a size is written WxH in pixels, 16 to 16384 a side, for example 1600x1000; got `{text}`")
        })
}

fn parse_pings(text: &str) -> Result<PingRange, String> {
    PingRange::try_from(text.to_owned())
}

/// Draws the picture and writes it; says on stderr which adapter drew it.
pub fn run(args: SnapshotArgs) -> Result<(), String> {
    quiet_driver::restart_if_noisy();
    let settings = args.settings.resolve()?;
    check_picture(&args.output)?;
    if !args.scale.is_finite() || !(0.5..=8.0).contains(&args.scale) {
        return Err(format!(
            "a picture's scale lies between 0.5 and 8; got {}",
            args.scale
        ));
    }
    let mut app = App::new(Jobs::Threads(std::sync::Arc::new(|| ())));
    app.use_settings(&settings);
    show_as(&mut app.options, &args);
    open(&mut app, &args.survey.map_or(Origin::Demo, Origin::Path))?;
    take_over(&mut app, settings)?;
    select(&mut app, args.pings)?;
    if let Some(truth) = args.truth {
        app.apply(Command::OpenTruth(truth));
        wait(&mut app)?;
    }
    if let Some(path) = args.base_map {
        app.apply(Command::OpenBaseMap(path));
        wait(&mut app)?;
    }
    if let Some(path) = args.reference {
        let layers = app.options.map.layers.clone();
        app.apply(Command::CompareWith(path));
        wait(&mut app)?;
        if args.layers.is_some() {
            // Those that were named, and no other.
            app.options.map.layers = layers;
        }
    }
    if args.objects {
        app.apply(Command::Do(Action::FindObjects));
        wait(&mut app)?;
    }
    let mut shell = Shell::new(app);
    if let Some(alone) = alone(args.view) {
        shell.show_alone(alone);
    }
    if let Some(pings) = args.pings {
        shell.show_pings(pings.start..pings.end);
    }
    let studio = Studio::new()?;
    let picture = studio.draw(&mut shell, args.size, args.scale, &Progress::new())?;
    if let Some(error) = shell.app.notices.iter().find(|notice| notice.is_error) {
        return Err(error.text.clone());
    }
    write_picture(&picture, &args.output)?;
    output::notify(format_args!("drawn by {}", studio.adapter()));
    Ok(())
}

/// Takes over how things are to be shown.
fn show_as(options: &mut ViewOptions, args: &SnapshotArgs) {
    options.theme = match args.theme {
        Theme::Dark => ThemeChoice::Dark,
        Theme::Light => ThemeChoice::Light,
    };
    options.coordinates = match args.coordinates {
        Coordinates::Dd => CoordinateFormat::Degrees,
        Coordinates::Ddm => CoordinateFormat::Minutes,
        Coordinates::Dms => CoordinateFormat::Seconds,
        Coordinates::Utm => CoordinateFormat::Utm,
    };
    if let Some(layers) = &args.layers {
        for layer in MapLayer::ALL {
            let stack = &mut options.map.layers;
            stack.set_visible(layer, layers.contains(&layer));
        }
    }
}

/// Draws the window and each view of a survey into `folder`; the files' names and the adapter that drew them.
pub fn draw_into(origin: &Origin, folder: &Path) -> Result<(Vec<&'static str>, String), String> {
    const PICTURES: [(&str, Picture, [u32; 2]); 4] = [
        ("window.png", Picture::All, [1600, 1000]),
        ("waterfall.png", Picture::Waterfall, [1600, 800]),
        ("map.png", Picture::Map, [1000, 800]),
        ("cloud.png", Picture::Cloud, [1000, 800]),
    ];
    let mut app = App::new(Jobs::Threads(std::sync::Arc::new(|| ())));
    open(&mut app, origin)?;
    select(&mut app, None)?;
    let mut shell = Shell::new(app);
    let studio = Studio::new()?;
    for (name, view, size) in PICTURES {
        if let Some(alone) = alone(view) {
            shell.show_alone(alone);
        }
        let picture = studio.draw(&mut shell, size, 1.0, &Progress::new())?;
        write_picture(&picture, &folder.join(name))?;
    }
    Ok((
        PICTURES.iter().map(|(name, ..)| *name).collect(),
        studio.adapter(),
    ))
}

fn alone(picture: Picture) -> Option<Alone> {
    match picture {
        Picture::Waterfall => Some(Alone::View(View::Waterfall)),
        Picture::Map => Some(Alone::View(View::Map)),
        Picture::Cloud => Some(Alone::View(View::Cloud)),
        Picture::Profile => Some(Alone::Profile),
        Picture::All => None,
    }
}

/// Opens the log and waits for all results.
fn open(app: &mut App, origin: &Origin) -> Result<(), String> {
    app.apply(match origin {
        Origin::Path(path) => Command::Open(path.clone()),
        Origin::Demo => Command::OpenDemo,
    });
    wait(app)
}

/// Takes over what the settings say of this survey only: its flat spot, its water, its track. A freshly opened log has
/// forgotten it: in the window, it belonged to the log before.
fn take_over(app: &mut App, settings: Settings) -> Result<(), String> {
    if settings == *app.log.settings {
        return Ok(());
    }
    if let Some(survey) = &app.log.survey {
        check_against(survey, &settings)?;
    }
    app.apply(Command::Change {
        settings: Box::new(settings),
        label: "settings",
        live: false,
    });
    wait(app)
}

fn wait(app: &mut App) -> Result<(), String> {
    while !app.is_idle() {
        std::thread::sleep(std::time::Duration::from_millis(2));
        app.poll();
    }
    match app.notices.iter().find(|notice| notice.is_error) {
        Some(error) => Err(error.text.clone()),
        None => Ok(()),
    }
}

/// Selects the middle of the pings asked for, or of the log, so that the profile and the selection show something.
fn select(app: &mut App, pings: Option<PingRange>) -> Result<(), String> {
    let count = app
        .log
        .survey
        .as_ref()
        .map_or(0, |survey| survey.side_scan.len());
    let pings = pings.unwrap_or(PingRange {
        start: 0,
        end: count,
    });
    if pings.end > count {
        return Err(format!(
            "the log has {count} side-scan pings; pings {}..{} were asked for",
            pings.start, pings.end
        ));
    }
    if count > 0 {
        let middle = (pings.start + pings.end) / 2;
        app.apply(Command::Select(Some(Mark::ping(middle))));
    }
    Ok(())
}

/// Refuses a name that is no picture's before any work, a mistyped log's among them: that log would be replaced.
fn check_picture(path: &Path) -> Result<(), String> {
    let suffix = path.extension().unwrap_or_default();
    if suffix.eq_ignore_ascii_case("png") {
        return Ok(());
    }
    Err(format!("a picture's name ends in .png: {}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_width_times_height() {
        assert_eq!(parse_size("640x480"), Ok([640, 480]));
        for wrong in ["640", "0x10", "axb", "99999x10"] {
            assert!(parse_size(wrong).is_err(), "{wrong}");
        }
    }
}
