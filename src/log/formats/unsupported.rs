//! Formats that Bathyscope recognises but does not read, each with advice.

/// The first bytes of a format, its name, and what to do with it.
const KNOWN: &[(&[u8], &str)] = &[
    (b"PK\x03\x04", "a zip archive; unpack it and open the log in it"),
    (b"\x1f\x8b", "a gzip archive; unpack it and open the log in it"),
    (b"7z\xbc\xaf", "a 7z archive; unpack it and open the log in it"),
    (
        b"SQLite format 3",
        "an SQLite database, not a sonar log; open the sl2 or sl3 file that the unit recorded",
    ),
    (b"\x89PNG\r\n\x1a\n", PICTURE),
    (b"\xFF\xD8\xFF", PICTURE),
    (
        b"BND4",
        "a game's save file that is also called sl2, not a sonar log; open the file that the unit recorded",
    ),
];

/// Advice for a picture without a table of its pings, or with a table that does not state their
/// range.
const PICTURE: &str = "a picture alone is no sonar log; where it is a side-scan waterfall, put a CSV of the same name beside it, with a row a ping and the columns lon, lat and range_m";

/// Returns advice about a file of a format that is recognised but not read.
pub(super) fn advice(bytes: &[u8]) -> Option<&'static str> {
    let known = KNOWN.iter().find(|(magic, _)| bytes.starts_with(magic));
    known.map(|(_, advice)| *advice)
}
