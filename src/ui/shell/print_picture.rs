//! Draws the picture of a printed view off screen, while the window can be used.

use super::printing::map_scale;
use super::{Shell, Views};
use crate::app::{App, Command, Paper, Sheet, ThemeChoice, View};
use crate::ui::offscreen::{PictureError, Studio, write_picture};
use bathyscope_log::support::progress::Progress;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

impl Shell {
    /// Starts drawing the chosen view, as it looks now, into a file.
    pub(super) fn print_into(&mut self, path: PathBuf) {
        let view = self.printing.view.unwrap_or(View::Map);
        let is_png = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png"));
        if !is_png {
            let text = format!("a picture's name ends in .png: {}", path.display());
            return self.app.apply(Command::Notify(text));
        }
        let options = &self.app.view.options.print;
        let sheet = options.sheet(self.views.size(view));
        let mut copy = self.app.for_picture();
        if options.light {
            copy.view.options.theme = ThemeChoice::Light;
        }
        let scale = scale(&self.app, view, sheet, &self.views);
        let text = self.app.print_text(view, scale, SystemTime::now());
        let mut shell = Shell::new(copy);
        shell.views = self.views.for_picture(&self.app);
        shell.show_alone(view);
        shell.text_around = Some(text);
        self.app.write(move |progress| draw(shell, view, sheet, &path, progress));
    }
}

/// Returns a sentence about the scale of a printed view.
fn scale(app: &App, view: View, sheet: Sheet, views: &Views) -> String {
    let is_paper = app.view.options.print.paper != Paper::Pixels;
    match view {
        View::Map => match map_scale(sheet, views).filter(|_| is_paper) {
            Some(denominator) => {
                let paper = app.view.options.print.paper.name();
                format!(
                    "Scale about 1 : {denominator:.0} on {paper}; the scale bar is right at any size."
                )
            }
            None => "The scale bar gives the scale.".to_owned(),
        },
        View::Waterfall => {
            let across = if app.view.options.waterfall.ground_range {
                "distance on level ground"
            } else {
                "slant range"
            };
            format!(
                "Range lines give the scale across the track, {across}; ping and time that along it."
            )
        }
        View::Cloud => format!(
            "Perspective view: the axes give the scale, elevations x{}.",
            app.view.options.cloud.vertical_exaggeration
        ),
        View::Objects | View::Profile => String::new(),
    }
}

/// Draws a view on a separate graphics device, and writes it; returns a sentence about the written
/// file.
fn draw(
    mut shell: Shell,
    view: View,
    sheet: Sheet,
    path: &Path,
    progress: &Progress,
) -> Result<String, PictureError> {
    let studio = Studio::new()?;
    let picture = studio.draw(&mut shell, sheet.size_px, sheet.pixels_per_point, progress)?;
    if let Some(error) = shell.app.notices.shown().iter().find(|notice| notice.is_error) {
        return Err(PictureError::Notice(error.text.clone()));
    }
    progress.check()?;
    write_picture(&picture, path)?;
    let [width, height] = sheet.size_px;
    Ok(format!(
        "Drew the {} in {width} x {height} pixels: {}",
        view.title().to_lowercase(),
        path.display()
    ))
}
