//! Reads the track points of GPX 1.0 and 1.1, and provides functions for readers of XML.

use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

/// A track point as written in the file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct GpxPoint {
    /// Longitude and latitude, degrees; `None` where they are no numbers.
    pub lon_lat: Option<[f64; 2]>,
    /// Time of the point as text; empty where it has none.
    pub time: String,
}

/// Reads the track points of a text one after the other, with any prefix of the elements. A file
/// that ends early, because the receiver was switched off, gives its whole points.
///
/// # Errors
/// When the text is no XML.
pub(super) fn gpx_points(text: &str) -> Result<Vec<GpxPoint>, String> {
    let mut reader = Reader::from_str(text);
    // Receivers write names such as `Tom & Jerry` without escaping `&`.
    reader.config_mut().allow_dangling_amp = true;
    let mut points = Vec::new();
    let mut open: Option<Open> = None;
    loop {
        let event = reader.read_event().map_err(|error| {
            format!("the GPX is damaged at byte {}: {error}", reader.error_position())
        })?;
        match (&event, &mut open) {
            (Event::Eof, _) => return Ok(points),
            (Event::Start(element), None) if is(element, "trkpt") => {
                open = Some(Open::new(element));
            }
            (Event::Empty(element), None) if is(element, "trkpt") => {
                points.push(Open::new(element).point);
            }
            (Event::Start(element), Some(point)) => {
                point.in_time = point.depth == 0 && is(element, "time");
                point.depth += 1;
            }
            (Event::End(_), Some(point)) if point.depth > 0 => {
                point.in_time = false;
                point.depth -= 1;
            }
            (Event::End(_), Some(_)) => points.extend(open.take().map(|open| open.point)),
            (event, Some(point)) if point.in_time => point.point.time.extend(text_of(event)),
            _ => {}
        }
    }
}

/// A track point whose end tag is not read yet.
struct Open {
    point: GpxPoint,
    /// Number of open elements within the point.
    depth: usize,
    /// True if the innermost open element is the time of the point.
    in_time: bool,
}

impl Open {
    fn new(element: &BytesStart<'_>) -> Self {
        let point = GpxPoint { lon_lat: lon_lat(element), time: String::new() };
        Self { point, depth: 0, in_time: false }
    }
}

/// Returns the longitude and latitude in the attributes of an element, degrees; `None` where they
/// are no numbers.
pub(super) fn lon_lat(element: &BytesStart<'_>) -> Option<[f64; 2]> {
    let number = |name| attribute(element, name)?.trim().parse().ok();
    Some([number("lon")?, number("lat")?])
}

/// Returns true if an element has this name, with any prefix.
pub(super) fn is(element: &BytesStart<'_>, name: &str) -> bool {
    element.local_name().as_ref() == name.as_bytes()
}

/// Returns the value of an attribute without a prefix; `None` where it is missing or damaged.
pub(super) fn attribute(element: &BytesStart<'_>, name: &str) -> Option<String> {
    let found = element.try_get_attribute(name).ok()??;
    let value = found.normalized_value(XmlVersion::Implicit1_0).ok()?;
    Some(value.into_owned())
}

/// Returns the text that an event adds to the element around it: plain text or a CDATA section;
/// `None` for other events, such as comments.
pub(super) fn text_of(event: &Event<'_>) -> Option<String> {
    let text = match event {
        Event::Text(text) => text.decode(),
        Event::CData(text) => text.decode(),
        _ => return None,
    };
    text.ok().map(|text| text.into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the longitude, the latitude and the time of each point.
    fn read(text: &str) -> Vec<(f64, f64, String)> {
        let points = gpx_points(text).unwrap().into_iter();
        let point = |point: GpxPoint| {
            let [lon, lat] = point.lon_lat.unwrap();
            (lon, lat, point.time)
        };
        points.map(point).collect()
    }

    #[test]
    fn a_prefix_makes_no_difference() {
        let text = "<?xml version='1.0'?><g:gpx xmlns:g='http://www.topografix.com/GPX/1/1'><g:trk><g:trkseg>\
                    <g:trkpt lon='-82.11' lat = \"29.41\"><g:ele>3</g:ele><g:time>2021</g:time></g:trkpt>\
                    </g:trkseg></g:trk></g:gpx>";
        assert_eq!(read(text), [(-82.11, 29.41, "2021".to_owned())]);
    }

    #[test]
    fn what_stands_in_a_comment_or_in_a_name_is_no_point() {
        let text = "<gpx><!-- <trkpt lat='1' lon='2'><time>1999</time></trkpt> --><name><![CDATA[<trkpt lat='9' lon='9'>]]></name>\
                    <trkpt lat='1' lon='2'><!-- <time>1999</time> --><time>20<!-- not so -->21</time></trkpt></gpx>";
        assert_eq!(read(text), [(2.0, 1.0, "2021".to_owned())]);
    }

    #[test]
    fn a_time_may_be_character_data_and_that_of_an_extension_is_none() {
        let text = "<gpx><name>Tom & Jerry</name><trkpt lat='1' lon='2'><extensions><x><time>1999</time></x></extensions>\
                    <time><![CDATA[2021]]></time></trkpt><trkpt lat='3' lon='4'/></gpx>";
        let expected = [(2.0, 1.0, "2021".to_owned()), (4.0, 3.0, String::new())];
        assert_eq!(read(text), expected);
    }

    #[test]
    fn an_early_end_leaves_what_is_whole_and_damage_is_said_with_its_place() {
        let whole = "<gpx><trkpt lat='1' lon='2'><time>2021</time></trkpt>";
        assert_eq!(read(&format!("{whole}<trkpt lat='1' lon='2'><time>20")).len(), 1);
        for damaged in ["<trkpt lat='1' lon='2", "<a></b>"] {
            let error = gpx_points(&format!("{whole}{damaged}")).unwrap_err();
            assert!(error.starts_with("the GPX is damaged at byte 5"), "{error}");
        }
        let points = gpx_points("<gpx><trkpt lat='1'></trkpt></gpx>").unwrap();
        assert_eq!(points[0].lon_lat, None);
    }
}
