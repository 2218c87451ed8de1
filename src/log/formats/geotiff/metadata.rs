//! Writes and reads the XML about a band that GDAL keeps in a tag of its own.

use super::statistics::Statistics;
use super::{Band, RasterSpec};
use crate::formats::xml::{attribute, is, text_of};
use crate::support::printable::xml;
use quick_xml::Reader;
use quick_xml::events::Event;

/// Name of the item that says which way values count, as the CF conventions name it, and what it
/// says of depths.
const POSITIVE: &str = "positive";
/// See [`POSITIVE`].
const DOWN: &str = "down";

/// The text of the tag.
pub(super) fn gdal_metadata(spec: &RasterSpec, band: &Band, statistics: &Statistics) -> String {
    let mut text = "<GDALMetadata>\n".to_owned();
    let mut item = |name: &str, role: &str, value: &str| {
        let role = match role {
            "" => String::new(),
            role => format!(" role=\"{role}\""),
        };
        text += &format!("  <Item name=\"{name}\" sample=\"0\"{role}>{}</Item>\n", xml(value));
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
            ("STATISTICS_VALID_PERCENT", 100.0 * statistics.count as f64 / cells),
        ] {
            item(name, "", &value.to_string());
        }
    }
    text + "</GDALMetadata>"
}

/// Returns true if the text of such a tag, by whatever program, says that values count downwards.
pub(super) fn counts_downwards(text: &str) -> bool {
    let mut reader = Reader::from_str(text);
    // Of the item that says so, where it is open.
    let mut value: Option<String> = None;
    loop {
        match (reader.read_event(), &mut value) {
            (Err(_) | Ok(Event::Eof), _) => return false,
            (Ok(Event::Start(item)), _) => {
                let says_so = attribute(&item, "name").is_some_and(|name| name == POSITIVE);
                value = (is(&item, "Item") && says_so).then(String::new);
            }
            (Ok(Event::End(_)), Some(said)) => {
                if said.trim().eq_ignore_ascii_case(DOWN) {
                    return true;
                }
                value = None;
            }
            (Ok(event), Some(said)) => said.extend(text_of(&event)),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_way_of_counting_is_read_from_its_item_alone() {
        let down = "<GDALMetadata>\n <Item name=\"X\">down</Item>\n <Item name=\"positive\" sample=\"0\">down</Item></GDALMetadata>";
        assert!(counts_downwards(down));
        assert!(counts_downwards(&down.replace("\"positive\"", "'positive'")));
        assert!(!counts_downwards(&format!("<!-- {down} -->")));
        assert!(!counts_downwards(&down.replace(">down</Item></G", ">up</Item></G")));
        assert!(!counts_downwards("<Item name=\"positive\""));
        assert!(!counts_downwards(""));
    }
}
