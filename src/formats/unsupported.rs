//! Formats that Bathyscope recognises but does not read, each with advice.

/// The first bytes of a format, its name, and what to do with it.
const KNOWN: &[(&[u8], &str)] = &[
    (
        b"\x01\x16",
        "an EdgeTech JSF log is not read; export it as XTF",
    ),
    (
        b"PK\x03\x04",
        "a zip archive; unpack it and open the log in it",
    ),
    (
        b"\x1f\x8b",
        "a gzip archive; unpack it and open the log in it",
    ),
    (
        b"7z\xbc\xaf",
        "a 7z archive; unpack it and open the log in it",
    ),
    (
        b"SQLite format 3",
        "an SQLite database, not a sonar log; open the sl2 or sl3 file that the unit recorded",
    ),
    (
        b"BND4",
        "a game's save file that is also called sl2, not a sonar log; open the file that the unit recorded",
    ),
];

/// What to do with a file of a format that is known by sight.
pub(super) fn advice(bytes: &[u8]) -> Option<&'static str> {
    let known = KNOWN.iter().find(|(magic, _)| bytes.starts_with(magic));
    let svlog = || {
        // Blue Robotics ping packets: "BR", u16 length, u16 message number; one follows the other.
        let len = super::scalar::u16_le(bytes, 2).filter(|_| bytes.starts_with(b"BR"))?;
        let next = 8 + usize::from(len) + 2;
        bytes
            .get(next..)?
            .starts_with(b"BR")
            .then_some("a Blue Robotics svlog is not read; export it as XTF")
    };
    known.map(|(_, advice)| *advice).or_else(svlog)
}
