//! Writes `NAME.qml` beside `NAME.tif`: colours that QGIS applies when it opens the raster.

use super::{ExportError, write_bytes};
use bathyscope_log::support::printable::xml;
use std::path::Path;

/// Writes the style of a raster of one band in metres. `colour` returns the colour of a share of
/// the range from the least to the greatest value; the colours of `steps` even steps are
/// interpolated linearly. Cells without a value are transparent.
pub fn qgis_style(
    path: &Path,
    [least_m, most_m]: [f64; 2],
    steps: usize,
    colour: impl Fn(f32) -> [u8; 3],
) -> Result<(), ExportError> {
    let items = (0..=steps).map(|step| {
        let share = step as f64 / steps.max(1) as f64;
        let value_m = least_m + (most_m - least_m) * share;
        let [red, green, blue] = colour(share as f32);
        format!(
            "          <item alpha=\"255\" color=\"#{red:02x}{green:02x}{blue:02x}\" label=\"{}\" value=\"{value_m}\"/>\n",
            xml(&format!("{value_m:.2} m"))
        )
    });
    let items: String = items.collect();
    let renderer = format!(
        r#"    <rasterrenderer alphaBand="-1" band="1" classificationMax="{most_m}" classificationMin="{least_m}" nodataColor="" opacity="1" type="singlebandpseudocolor">
      <rasterTransparency/>
      <minMaxOrigin>
        <limits>None</limits>
        <extent>WholeRaster</extent>
        <statAccuracy>Exact</statAccuracy>
      </minMaxOrigin>
      <rastershader>
        <colorrampshader classificationMode="1" clip="0" colorRampType="INTERPOLATED" maximumValue="{most_m}" minimumValue="{least_m}">
{items}        </colorrampshader>
      </rastershader>
    </rasterrenderer>
"#
    );
    write_style(path, &renderer, "bilinear")
}

/// A class of a raster: its number, name and colour.
pub(super) type Class = (u8, &'static str, [u8; 3]);

/// Writes the style of a raster of classes. Cells of no class are transparent.
pub(crate) fn qgis_classes(path: &Path, classes: &[Class]) -> Result<(), ExportError> {
    let entries = classes.iter().map(|(number, name, [red, green, blue])| {
        format!(
            "        <paletteEntry alpha=\"255\" color=\"#{red:02x}{green:02x}{blue:02x}\" label=\"{}\" value=\"{number}\"/>\n",
            xml(name)
        )
    });
    let entries: String = entries.collect();
    let renderer = format!(
        r#"    <rasterrenderer alphaBand="-1" band="1" nodataColor="" opacity="1" type="paletted">
      <rasterTransparency/>
      <colorPalette>
{entries}      </colorPalette>
    </rasterrenderer>
"#
    );
    write_style(path, &renderer, "nearest neighbour")
}

fn write_style(path: &Path, renderer: &str, enlarged: &str) -> Result<(), ExportError> {
    let text = format!(
        r#"<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>
<qgis styleCategories="Symbology" version="3.22.0">
  <pipe>
{renderer}    <brightnesscontrast brightness="0" contrast="0" gamma="1"/>
    <huesaturation colorizeOn="0" grayscaleMode="0" saturation="0"/>
    <rasterresampler maxOversampling="2" zoomedInResampler="{enlarged}"/>
  </pipe>
  <blendMode>0</blendMode>
</qgis>
"#
    );
    write_bytes(path, text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_style_runs_from_the_least_to_the_greatest_value() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("depth.qml");
        let colour = |share: f32| [(255.0 * share) as u8, 0, 16];
        qgis_style(&path, [1.5, 6.5], 10, colour).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(text.matches("<item ").count(), 11);
        assert!(text.contains("color=\"#000010\" label=\"1.50 m\" value=\"1.5\""));
        assert!(text.contains("color=\"#ff0010\" label=\"6.50 m\" value=\"6.5\""));
        assert!(text.contains("classificationMax=\"6.5\" classificationMin=\"1.5\""));
    }

    #[test]
    fn a_class_has_its_number_name_and_colour() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("source.qml");
        qgis_classes(&path, &[(1, "a & b", [0, 255, 16]), (3, "c", [1, 2, 3])]).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.contains("color=\"#00ff10\" label=\"a &amp; b\" value=\"1\""));
        assert_eq!(text.matches("<paletteEntry ").count(), 2);
        assert!(text.contains("type=\"paletted\"") && text.contains("nearest neighbour"));
    }
}
