//! `bathyscope snapshot`: draws the pictures of the window without opening a window.

use super::settings::SettingsArgs;
use super::waterfall_options::{GeometryArgs, open, parse_size, requested_pings, take_over, wait};
use super::{Failure, check_ending, output};
use crate::app::{
    Action, App, CloudColour, Command, FileToOpen, Jobs, LogOrigin, LogPlace, MapLayer,
    ThemeChoice, View, ViewOptions,
};
use crate::ui::{
    Shell,
    offscreen::{Studio, write_picture},
};
use bathyscope_bottom::calibration::PingRange;
use bathyscope_log::support::geo::CoordinateFormat;
use bathyscope_log::support::progress::Progress;
use bathyscope_products::pipeline::BottomColour;
use std::path::{Path, PathBuf};

/// `bathyscope snapshot SURVEY -o FILE.png`.
#[derive(Debug, clap::Args)]
pub(super) struct SnapshotArgs {
    /// The log; the bundled demo survey when left out
    survey: Option<PathBuf>,
    /// Picture to write
    #[arg(short, long, value_name = "FILE.png")]
    output: PathBuf,
    /// View to draw, or the whole window
    #[arg(long, value_enum, default_value_t = Picture::All)]
    view: Picture,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "1600x1000", value_parser = parse_size)]
    size: [u32; 2],
    /// Side-scan pings that the waterfall shows; the middle one is selected
    #[arg(long, value_name = "A..B")]
    pings: Option<PingRange>,
    #[command(flatten)]
    geometry: GeometryArgs,
    /// Pixels in a point: 2 draws all text and lines twice as large
    #[arg(long, default_value_t = 1.0, value_name = "FACTOR")]
    scale: f32,
    /// Search for objects first, and draw their boxes
    #[arg(long)]
    objects: bool,
    /// Objects known to lie in the survey, with which boxes are compared
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
    /// Layers of the map to draw, comma-separated; those that are not named are left out
    #[arg(long, value_name = "LAYERS", value_enum, value_delimiter = ',')]
    layers: Option<Vec<MapLayer>>,
    /// Quantity that the colours of the 3D points show
    #[arg(long, value_enum, default_value_t)]
    colours: CloudColour,
    /// Quantity that the colours of the bottom in 3D show; `none` leaves it out
    #[arg(long, value_enum, default_value_t)]
    bottom: ShownBottom,
    /// Leave the points out of the 3D view: the bottom alone
    #[arg(long)]
    no_points: bool,
    /// GeoTIFF of your own to lie under the map
    #[arg(long, value_name = "FILE.tif")]
    base_map: Option<PathBuf>,
    /// Reference that the points are compared with, as `compare` takes it: the layer `residuals`
    /// shows the differences
    #[arg(long, value_name = "FILE")]
    reference: Option<PathBuf>,
    /// Notation of positions
    #[arg(long, value_enum, default_value_t = Coordinates::Dd)]
    coordinates: Coordinates,
    /// Dark or light
    #[arg(long, value_enum, default_value_t = Theme::Dark)]
    theme: Theme,
    #[command(flatten)]
    settings: SettingsArgs,
}

/// View in a picture.
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

/// The bottom in 3D.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
enum ShownBottom {
    /// Depth
    #[default]
    Depth,
    /// Strength of the side-scan's echo
    Mosaic,
    /// Uncertainty of the depth
    Uncertainty,
    /// Distance to the nearest depth
    Distance,
    /// The source of the depth: a sounding, a first return, or depths around
    Source,
    /// Brightness of the bed itself (with surface.swath)
    Hardness,
    /// No bottom: the points alone
    None,
}

impl ShownBottom {
    fn colour(self) -> Option<BottomColour> {
        match self {
            Self::Depth => Some(BottomColour::Depth),
            Self::Mosaic => Some(BottomColour::Mosaic),
            Self::Uncertainty => Some(BottomColour::Uncertainty),
            Self::Distance => Some(BottomColour::Distance),
            Self::Source => Some(BottomColour::Source),
            Self::Hardness => Some(BottomColour::Hardness),
            Self::None => None,
        }
    }
}

/// Notation of positions.
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

/// Draws the picture and writes it; prints on stderr which adapter drew it.
pub(super) fn run(args: SnapshotArgs) -> Result<(), Failure> {
    output::restart_if_noisy();
    let settings = args.settings.resolve()?;
    check_ending(&args.output, &["png"], "a picture's name ends in .png")?;
    if !args.scale.is_finite() || !(0.5..=8.0).contains(&args.scale) {
        return Err(format!("a picture's scale lies between 0.5 and 8; got {}", args.scale).into());
    }
    let mut app = App::new(Jobs::Threads(std::sync::Arc::new(|| ())));
    app.use_settings(&settings);
    show_as(&mut app.view.options, &args);
    args.geometry.apply(&mut app);
    open(&mut app, &args.survey.map_or(LogOrigin::Demo, LogOrigin::Path))?;
    take_over(&mut app, settings)?;
    select(&mut app, args.pings)?;
    let files = [args.truth.map(FileToOpen::Truth), args.base_map.map(FileToOpen::BaseMap)];
    for file in files.into_iter().flatten() {
        app.apply(Command::OpenFile(file));
        wait(&mut app)?;
    }
    if let Some(path) = args.reference {
        let layers = app.view.options.map.layers.clone();
        app.apply(Command::CompareWith(path));
        wait(&mut app)?;
        if args.layers.is_some() {
            // Only the layers that were named.
            app.view.options.map.layers = layers;
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
    if let Some(error) = shell.app.notices.shown().iter().find(|notice| notice.is_error) {
        return Err(error.text.clone().into());
    }
    shell.app.logs.check_files()?;
    write_picture(&picture, &args.output)?;
    output::notify(format_args!("drawn by {}", studio.adapter()));
    Ok(())
}

/// Sets the display options that the arguments name.
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
    options.cloud.colour = args.colours;
    options.cloud.points = !args.no_points;
    let bottom = args.bottom.colour();
    options.cloud.bottom = bottom.is_some();
    options.cloud.bottom_colour = bottom.unwrap_or_default();
    if let Some(layers) = &args.layers {
        for layer in MapLayer::ALL {
            let stack = &mut options.map.layers;
            stack.set_visible(layer, layers.contains(&layer));
        }
    }
}

/// Draws the window and each view of a survey into `folder`; returns the files' names and the name
/// of the adapter that drew them.
pub(super) fn draw_into(
    origin: &LogOrigin,
    folder: &Path,
) -> Result<(Vec<&'static str>, String), Failure> {
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
        shell.app.logs.check_files()?;
        write_picture(&picture, &folder.join(name))?;
    }
    Ok((PICTURES.iter().map(|(name, ..)| *name).collect(), studio.adapter()))
}

fn alone(picture: Picture) -> Option<View> {
    match picture {
        Picture::Waterfall => Some(View::Waterfall),
        Picture::Map => Some(View::Map),
        Picture::Cloud => Some(View::Cloud),
        Picture::Profile => Some(View::Profile),
        Picture::All => None,
    }
}

/// Selects the middle one of the requested pings, or of the pings of the log, so that the profile
/// and the selection are not empty.
fn select(app: &mut App, pings: Option<PingRange>) -> Result<(), Failure> {
    let survey = app.logs.shown.survey.clone().unwrap_or_default();
    let pings = requested_pings(&survey, pings)?;
    if !survey.side_scan.is_empty() {
        let middle = (pings.start + pings.end) / 2;
        app.apply(Command::Select(Some(LogPlace::ping(middle))));
    }
    Ok(())
}
