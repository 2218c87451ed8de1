//! Writes styles of QGIS (QML): `NAME.qml` beside `NAME.tif`, the colours that QGIS applies when it
//! opens the raster, and the styles of vector layers for the table of styles in a GeoPackage.

use super::{ExportError, write_bytes};
use bathyscope_bottom::presentation::colours::Rgb;
use bathyscope_log::support::printable::xml;
use std::path::Path;

/// Writes the style of a raster of one band in metres. `colour` returns the colour of a share of
/// the range from the least to the greatest value; the colours of `steps` even steps are
/// interpolated linearly. Cells without a value are transparent.
pub fn qgis_style(
    path: &Path,
    [least_m, most_m]: [f64; 2],
    steps: usize,
    colour: impl Fn(f32) -> Rgb,
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

/// Writes the style of a raster of classes, each with its number, name and colour. Cells of no
/// class are transparent.
pub(crate) fn qgis_classes(
    path: &Path,
    classes: &[(u8, &'static str, Rgb)],
) -> Result<(), ExportError> {
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

/// Dark blue of lines and depth figures, as on charts.
const DEPTH_INK: Rgb = [28, 62, 110];
/// Near-black of the figures of soundings.
const FIGURE_INK: Rgb = [16, 22, 32];
/// Red that is legible on a map and on a picture of the earth.
const RED: Rgb = [214, 39, 40];
const DARK_RED: Rgb = [140, 16, 20];
const GREY: Rgb = [90, 90, 90];
const WHITE: Rgb = [255, 255, 255];
/// Widths of lines, millimetres of the sheet.
const FINE_MM: f64 = 0.15;
const THIN_MM: f64 = 0.25;
const THICK_MM: f64 = 0.5;
/// Width that a light edge adds to a line, so that the line stays visible on dark water.
const EDGE_MM: f64 = 0.4;
/// Opacity of a depth area: pale enough for the lines and figures above it, as on charts.
const AREA_OPACITY: f64 = 0.6;
/// Length on the sheet below which a line has no label, millimetres.
const LEAST_LABELLED_MM: f64 = 12.0;
/// Distance between repeated labels of a line, millimetres of the sheet.
const REPEAT_MM: f64 = 80.0;

/// Returns the style of isobaths: lines with `is_index` are thick and labelled along the line,
/// upright.
pub(super) fn isobath_style() -> String {
    let rule = |name: &str, filter: &str, symbol: usize| {
        format!("<rule key=\"{name}\" label=\"{name}\" filter=\"{filter}\" symbol=\"{symbol}\"/>")
    };
    let renderer = format!(
        "<renderer-v2 type=\"RuleRenderer\" enableorderby=\"0\" symbollevels=\"0\" forceraster=\"0\"><rules key=\"all\">{}{}</rules><symbols>{}{}</symbols></renderer-v2>",
        rule("index isobath", "&quot;is_index&quot;", 0),
        rule("isobath", "ELSE", 1),
        edged_line_symbol("0", DEPTH_INK, THICK_MM),
        edged_line_symbol("1", DEPTH_INK, FINE_MM),
    );
    let label = FeatureLabel {
        expression: "CASE WHEN \"is_index\" THEN \"label\" END",
        size_pt: 8.0,
        colour: DEPTH_INK,
        halo_mm: 0.5,
        placement: Placement::OnLine,
    };
    document(&renderer, Some(&label), 1.0)
}

/// Returns the style of spot soundings: only the figures, upright, in the place of the depth. Of
/// two figures that would overlap, the shallower one is drawn.
pub(super) fn spot_sounding_style() -> String {
    let label = FeatureLabel {
        expression: "label",
        size_pt: 7.0,
        colour: FIGURE_INK,
        halo_mm: 0.3,
        placement: Placement::OverPoint,
    };
    let renderer = "<renderer-v2 type=\"nullSymbol\" enableorderby=\"0\" symbollevels=\"0\" forceraster=\"0\"/>";
    document(renderer, Some(&label), 1.0)
}

/// Returns the style of depth areas; `classes` are the least and greatest depth of each, metres,
/// and its colour.
pub(super) fn depth_area_style(classes: &[([f64; 2], Rgb)]) -> String {
    let (mut ranges, mut symbols) = (String::new(), String::new());
    for (number, ([from_m, to_m], colour)) in classes.iter().enumerate() {
        ranges += &format!(
            "<range symbol=\"{number}\" lower=\"{from_m}\" upper=\"{to_m}\" label=\"{from_m:.2} to {to_m:.2} m\" render=\"true\"/>"
        );
        symbols += &fill_symbol(&number.to_string(), Some(*colour), None);
    }
    let renderer = format!(
        "<renderer-v2 type=\"graduatedSymbol\" attr=\"(&quot;from_m&quot; + &quot;to_m&quot;) / 2\" graduatedMethod=\"GraduatedColor\" enableorderby=\"0\" symbollevels=\"0\" forceraster=\"0\"><ranges>{ranges}</ranges><symbols>{symbols}</symbols></renderer-v2>"
    );
    document(&renderer, None, AREA_OPACITY)
}

/// Returns the style of the track: a thin line.
pub(super) fn track_style() -> String {
    document(&single(&symbol("0", "line", &line_layer(RED, 255, THIN_MM))), None, 1.0)
}

/// Returns the style of the insonified ground: a dashed edge without a fill, so that maps below
/// stay visible.
pub(super) fn footprint_style() -> String {
    document(&single(&fill_symbol("0", None, Some((GREY, true)))), None, 1.0)
}

/// Returns the style of objects: a mark, labelled with the name, or with class and number.
pub(super) fn target_style() -> String {
    let label = FeatureLabel {
        expression: "coalesce(nullif(\"name\", ''), \"class\" || ' ' || \"number\")",
        size_pt: 8.0,
        colour: DARK_RED,
        halo_mm: 0.5,
        placement: Placement::BesidePoint,
    };
    document(&single(&mark_symbol("0", RED)), Some(&label), 1.0)
}

/// Returns the style of the outlines of objects on the ground.
pub(super) fn target_outline_style() -> String {
    document(&single(&fill_symbol("0", None, Some((RED, false)))), None, 1.0)
}

/// Position of a label.
enum Placement {
    OnLine,
    OverPoint,
    BesidePoint,
}

/// Label of a feature.
struct FeatureLabel {
    expression: &'static str,
    size_pt: f64,
    colour: Rgb,
    /// Width of the white edge around letters, millimetres.
    halo_mm: f64,
    placement: Placement,
}

/// Returns a style from its renderer, labels and opacity, 0 to 1.
fn document(renderer: &str, label: Option<&FeatureLabel>, opacity: f64) -> String {
    let (enabled, labels) = match label {
        Some(label) => (1, labelling(label)),
        None => (0, String::new()),
    };
    format!(
        "<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>\n<qgis version=\"3.22.0\" styleCategories=\"Symbology|Labeling\" labelsEnabled=\"{enabled}\">{renderer}{labels}<blendMode>0</blendMode><layerOpacity>{opacity}</layerOpacity></qgis>\n"
    )
}

fn labelling(label: &FeatureLabel) -> String {
    let FeatureLabel { expression, size_pt, colour, halo_mm, placement } = label;
    let least_mm = match placement {
        Placement::OnLine => LEAST_LABELLED_MM,
        _ => 0.0,
    };
    // QGIS's numbers: 2 is beside a line or, by its flags, on it; 0 is around a point. Labels on a
    // line stay upright, and each part of a broken line has its own label.
    let placed = match placement {
        Placement::OnLine => format!(
            "placement=\"2\" placementFlags=\"1\" repeatDistance=\"{REPEAT_MM}\" repeatDistanceUnits=\"MM\""
        ),
        Placement::OverPoint => "placement=\"1\" quadOffset=\"4\"".to_owned(),
        Placement::BesidePoint => "placement=\"6\" dist=\"1\" distUnits=\"MM\"".to_owned(),
    };
    format!(
        "<labeling type=\"simple\"><settings calloutType=\"simple\"><text-style fieldName=\"{}\" isExpression=\"1\" fontSize=\"{size_pt}\" fontSizeUnit=\"Point\" fontFamily=\"Sans Serif\" fontWeight=\"75\" textColor=\"{}\" textOpacity=\"1\"><text-buffer bufferDraw=\"1\" bufferSize=\"{halo_mm}\" bufferSizeUnits=\"MM\" bufferColor=\"{}\" bufferOpacity=\"1\" bufferJoinStyle=\"128\"/></text-style><placement {placed}/><rendering drawLabels=\"1\" upsidedownLabels=\"0\" obstacle=\"0\" displayAll=\"0\" mergeLines=\"0\" minFeatureSize=\"{least_mm}\"/></settings></labeling>",
        xml(expression),
        with_alpha(*colour, 255),
        with_alpha(WHITE, 255),
    )
}

/// Returns a renderer with one symbol for all features.
fn single(symbol: &str) -> String {
    format!(
        "<renderer-v2 type=\"singleSymbol\" enableorderby=\"0\" symbollevels=\"0\" forceraster=\"0\"><symbols>{symbol}</symbols></renderer-v2>"
    )
}

/// Returns a line symbol with a light edge under the line.
fn edged_line_symbol(name: &str, colour: Rgb, width_mm: f64) -> String {
    let edge = line_layer(WHITE, 110, width_mm + EDGE_MM);
    symbol(name, "line", &(edge + &line_layer(colour, 255, width_mm)))
}

fn line_layer(colour: Rgb, alpha: u8, width_mm: f64) -> String {
    let options = [
        ("line_color", with_alpha(colour, alpha)),
        ("line_style", "solid".to_owned()),
        ("line_width", width_mm.to_string()),
        ("line_width_unit", "MM".to_owned()),
        ("capstyle", "round".to_owned()),
        ("joinstyle", "round".to_owned()),
    ];
    symbol_layer("SimpleLine", &options)
}

/// Returns the symbol of an area: without a fill, only its edge, with a colour and dashed if the
/// flag is true; without an edge, only its fill.
fn fill_symbol(name: &str, fill: Option<Rgb>, edge: Option<(Rgb, bool)>) -> String {
    let edge_style = match edge {
        Some((_, true)) => "dash",
        Some((_, false)) => "solid",
        None => "no",
    };
    let (edge_colour, _) = edge.unwrap_or((GREY, false));
    let options = [
        ("color", with_alpha(fill.unwrap_or(WHITE), 255)),
        ("style", if fill.is_some() { "solid" } else { "no" }.to_owned()),
        ("outline_color", with_alpha(edge_colour, 255)),
        ("outline_style", edge_style.to_owned()),
        ("outline_width", THIN_MM.to_string()),
        ("outline_width_unit", "MM".to_owned()),
    ];
    symbol(name, "fill", &symbol_layer("SimpleFill", &options))
}

fn mark_symbol(name: &str, colour: Rgb) -> String {
    let options = [
        ("name", "circle".to_owned()),
        ("color", with_alpha(WHITE, 255)),
        ("outline_color", with_alpha(colour, 255)),
        ("outline_width", "0.5".to_owned()),
        ("outline_width_unit", "MM".to_owned()),
        ("size", "2.4".to_owned()),
        ("size_unit", "MM".to_owned()),
    ];
    symbol(name, "marker", &symbol_layer("SimpleMarker", &options))
}

fn symbol(name: &str, kind: &str, layers: &str) -> String {
    format!(
        "<symbol name=\"{name}\" type=\"{kind}\" alpha=\"1\" clip_to_extent=\"1\" force_rhr=\"0\">{layers}</symbol>"
    )
}

fn symbol_layer(class: &str, options: &[(&str, String)]) -> String {
    let options = options
        .iter()
        .map(|(key, value)| format!("<Option type=\"QString\" name=\"{key}\" value=\"{value}\"/>"));
    let options: String = options.collect();
    format!(
        "<layer class=\"{class}\" enabled=\"1\" locked=\"0\" pass=\"0\"><Option type=\"Map\">{options}</Option></layer>"
    )
}

fn with_alpha([red, green, blue]: Rgb, alpha: u8) -> String {
    format!("{red},{green},{blue},{alpha}")
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

    #[test]
    fn every_style_is_well_formed_and_names_the_columns_that_it_uses() {
        let styles = [
            (isobath_style(), "is_index"),
            (depth_area_style(&[([1.0, 1.5], [1, 2, 3]), ([1.5, 2.0], [4, 5, 6])]), "from_m"),
            (target_style(), "number"),
            (track_style(), ""),
            (footprint_style(), ""),
            (target_outline_style(), ""),
            (spot_sounding_style(), "label"),
        ];
        for (style, column) in styles {
            assert!(style.contains(column), "{style}");
            let mut reader = quick_xml::Reader::from_str(&style);
            let mut open = 0;
            loop {
                match reader.read_event().expect("well-formed") {
                    quick_xml::events::Event::Start(_) => open += 1,
                    quick_xml::events::Event::End(_) => open -= 1,
                    quick_xml::events::Event::Eof => break,
                    _ => {}
                }
            }
            assert_eq!(open, 0);
        }
    }

    #[test]
    fn an_area_has_the_colour_of_its_depths() {
        let style = depth_area_style(&[([1.0, 1.5], [1, 2, 3]), ([1.5, 2.0], [4, 5, 6])]);
        assert!(style.contains("upper=\"1.5\" label=\"1.00 to 1.50 m\""), "{style}");
        assert!(style.contains("value=\"4,5,6,255\""));
        assert_eq!(style.matches("<symbol ").count(), 2);
    }
}
