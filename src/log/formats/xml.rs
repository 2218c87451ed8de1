//! Provides functions that the readers of XML share.

use quick_xml::XmlVersion;
use quick_xml::events::{BytesStart, Event};

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
