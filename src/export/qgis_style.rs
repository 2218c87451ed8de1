//! `NAME.qml` beside `NAME.tif`: colours that QGIS takes up when it opens the raster.

use super::{ExportError, write_aside};
use crate::printable::xml;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

/// Writes the style of a raster of one band in metres: `colour` of a share of the way from the least to the greatest value, in
/// `steps` even steps, linear between them. What is not known is clear.
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
    let text = text(&items, [least_m, most_m]);
    write_aside(path, |mut file| file.write_all(text.as_bytes()))
}

fn text(items: &str, [least_m, most_m]: [f64; 2]) -> String {
    let mut text = String::new();
    // Writing into text cannot fail.
    write!(
        text,
        r#"<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>
<qgis styleCategories="Symbology" version="3.22.0">
  <pipe>
    <rasterrenderer alphaBand="-1" band="1" classificationMax="{most_m}" classificationMin="{least_m}" nodataColor="" opacity="1" type="singlebandpseudocolor">
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
    <brightnesscontrast brightness="0" contrast="0" gamma="1"/>
    <huesaturation colorizeOn="0" grayscaleMode="0" saturation="0"/>
    <rasterresampler maxOversampling="2" zoomedInResampler="bilinear"/>
  </pipe>
  <blendMode>0</blendMode>
</qgis>
"#
    )
    .ok();
    text
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
}
