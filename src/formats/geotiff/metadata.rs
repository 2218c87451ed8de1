//! What GDAL keeps of a band in a tag of its own: a little XML.

use super::statistics::Statistics;
use super::{Band, RasterSpec};
use crate::printable::xml;
use std::fmt::Write as _;

/// Name of the item that says which way values count, as the CF conventions name it, and what it says of depths.
pub const POSITIVE: &str = "positive";
/// See [`POSITIVE`].
pub const DOWN: &str = "down";

/// The text of the tag.
pub fn gdal_metadata(spec: &RasterSpec, band: &Band, statistics: &Statistics) -> String {
    let mut text = "<GDALMetadata>\n".to_owned();
    let mut item = |name: &str, role: &str, value: &str| {
        let role = match role {
            "" => String::new(),
            role => format!(" role=\"{role}\""),
        };
        // Writing into text cannot fail.
        writeln!(
            text,
            "  <Item name=\"{name}\" sample=\"0\"{role}>{}</Item>",
            xml(value)
        )
        .ok();
    };
    item("DESCRIPTION", "description", band.name);
    if !band.unit.is_empty() {
        item("UNITTYPE", "unittype", band.unit);
    }
    if band.positive_down {
        item(POSITIVE, "", DOWN);
    }
    if let (Some(mean), Some(deviation)) = (statistics.mean(), statistics.deviation()) {
        let cells = (spec.columns * spec.rows).max(1) as f64;
        for (name, value) in [
            ("STATISTICS_MINIMUM", statistics.least),
            ("STATISTICS_MAXIMUM", statistics.most),
            ("STATISTICS_MEAN", mean),
            ("STATISTICS_STDDEV", deviation),
            (
                "STATISTICS_VALID_PERCENT",
                100.0 * statistics.count as f64 / cells,
            ),
        ] {
            item(name, "", &value.to_string());
        }
    }
    text + "</GDALMetadata>"
}

/// Whether the text of such a tag, by whatever program, says that values count downwards.
pub fn counts_downwards(text: &str) -> bool {
    let items = text.split("<Item").skip(1);
    let attribute = format!("name=\"{POSITIVE}\"");
    items.into_iter().any(|item| {
        let parts = item.split_once('>');
        parts.is_some_and(|(head, rest)| {
            let value = rest.split('<').next().unwrap_or_default();
            head.contains(&attribute) && value.trim().eq_ignore_ascii_case(DOWN)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_way_of_counting_is_read_from_its_item_alone() {
        let down = "<GDALMetadata>\n <Item name=\"X\">down</Item>\n <Item name=\"positive\" sample=\"0\">down</Item></GDALMetadata>";
        assert!(counts_downwards(down));
        assert!(!counts_downwards(
            &down.replace(">down</Item></G", ">up</Item></G")
        ));
        assert!(!counts_downwards("<Item name=\"positive\""));
        assert!(!counts_downwards(""));
    }
}
