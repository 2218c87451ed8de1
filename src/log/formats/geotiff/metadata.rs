//! Computes the statistics of a band, as GDAL defines them, and writes and reads the XML about the
//! band in GDAL's own tag.

use super::{Band, CellFormat, NODATA, RasterSpec};
use crate::formats::gpx::{attribute, is, text_of};
use crate::support::printable::xml;
use quick_xml::Reader;
use quick_xml::events::Event;

/// Name of the item for the direction in which values count, from the CF conventions.
const POSITIVE: &str = "positive";
/// Value of the item [`POSITIVE`] for depths.
const DOWN: &str = "down";

/// Number, extremes, mean and spread of the known values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Statistics {
    /// Number of known values.
    count: u64,
    /// Least value; positive infinity where none is known.
    least: f64,
    /// Greatest value; negative infinity where none is known.
    most: f64,
    mean: f64,
    /// Sum of the squared differences of the values from their mean.
    squares: f64,
}

impl Default for Statistics {
    fn default() -> Self {
        Self { count: 0, least: f64::INFINITY, most: f64::NEG_INFINITY, mean: 0.0, squares: 0.0 }
    }
}

impl Statistics {
    /// Computes the statistics of the cells of a tile; those of colours are empty.
    pub(super) fn of(cells: CellFormat, bytes: &[u8]) -> Self {
        match cells {
            CellFormat::Rgba => Self::default(),
            CellFormat::Level | CellFormat::Class => Self::of_levels(bytes),
            CellFormat::Metres => {
                let values = bytes.as_chunks().0.iter();
                let values = values.map(|&four| f32::from_le_bytes(four));
                Self::of_values(values.filter(|&metres| metres != NODATA).map(f64::from))
            }
        }
    }

    fn of_levels(levels: &[u8]) -> Self {
        let mut counts = [0_u64; 256];
        for &level in levels {
            counts[usize::from(level)] += 1;
        }
        let mut all = Self::default();
        for (level, &count) in counts.iter().enumerate().skip(1).filter(|(_, count)| **count > 0) {
            let level = level as f64;
            all.join(&Self { count, least: level, most: level, mean: level, squares: 0.0 });
        }
        all
    }

    fn of_values(values: impl Iterator<Item = f64> + Clone) -> Self {
        let mut all = Self::default();
        let mut sum = 0.0;
        for value in values.clone() {
            all.count += 1;
            all.least = all.least.min(value);
            all.most = all.most.max(value);
            sum += value;
        }
        all.mean = sum / all.count.max(1) as f64;
        all.squares = values.map(|value| (value - all.mean).powi(2)).sum();
        all
    }

    /// Adds the statistics of another part.
    pub(super) fn join(&mut self, other: &Self) {
        if other.count == 0 {
            return;
        }
        let [own, others] = [self.count, other.count].map(|count| count as f64);
        let apart = other.mean - self.mean;
        self.squares += other.squares + apart * apart * own * others / (own + others);
        self.mean += apart * others / (own + others);
        self.count += other.count;
        self.least = self.least.min(other.least);
        self.most = self.most.max(other.most);
    }

    /// Returns the mean; `None` where no value is known.
    fn mean(&self) -> Option<f64> {
        (self.count > 0).then_some(self.mean)
    }

    /// Returns the standard deviation of all values, not of a sample; `None` where no value is
    /// known.
    fn deviation(&self) -> Option<f64> {
        (self.count > 0).then(|| (self.squares / self.count as f64).sqrt())
    }
}

/// Returns the XML text of GDAL's tag.
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

/// Returns true if the text of such a tag, written by any program, states that values count
/// downwards.
pub(super) fn counts_downwards(text: &str) -> bool {
    let mut reader = Reader::from_str(text);
    // Text of the item [`POSITIVE`] while it is open.
    let mut value: Option<String> = None;
    loop {
        match (reader.read_event(), &mut value) {
            (Err(_) | Ok(Event::Eof), _) => return false,
            (Ok(Event::Start(item)), _) => {
                let says_so = attribute(&item, "name").is_some_and(|name| name == POSITIVE);
                value = (is(&item, "Item") && says_so).then(String::new);
            }
            (Ok(Event::End(_)), Some(item_text)) => {
                if item_text.trim().eq_ignore_ascii_case(DOWN) {
                    return true;
                }
                value = None;
            }
            (Ok(event), Some(item_text)) => item_text.extend(text_of(&event)),
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

    #[test]
    fn parts_join_to_the_figures_of_the_whole() {
        let bytes = |values: &[f32]| -> Vec<u8> {
            values.iter().flat_map(|value| value.to_le_bytes()).collect()
        };
        let mut joined = Statistics::default();
        for part in [&[2.0, NODATA, 4.0][..], &[NODATA], &[4.0, 4.0, 5.0, 5.0, 7.0, 9.0]] {
            joined.join(&Statistics::of(CellFormat::Metres, &bytes(part)));
        }
        // A well-known example: mean 5, standard deviation 2.
        assert_eq!((joined.count, joined.least, joined.most), (8, 2.0, 9.0));
        assert!((joined.mean().unwrap() - 5.0).abs() < 1e-12);
        assert!((joined.deviation().unwrap() - 2.0).abs() < 1e-12);
        let levels = Statistics::of(CellFormat::Level, &[2, 4, 4, 0, 4, 5, 5, 0, 7, 9]);
        assert_eq!((levels.count, levels.least, levels.most), (8, 2.0, 9.0));
        assert!((levels.deviation().unwrap() - 2.0).abs() < 1e-12);
        assert_eq!(Statistics::default().mean(), None);
    }
}
