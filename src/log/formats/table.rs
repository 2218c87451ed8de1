//! Defines the table of the formats of recorders' logs and functions that derive data from it, and
//! recognises some formats that are not read.
//!
//! The messages, the file dialogs, the desktop entry with its file types, `bathyscope info
//! --formats` and the table in README.md are all made from [`FORMATS`].

use super::cerulean::Cerulean;
use super::edgetech::EdgeTech;
use super::garmin::Garmin;
use super::humminbird::Humminbird;
use super::klein::Klein;
use super::log_format::LogFormat;
use super::log_writer::LogWriter;
use super::lowrance::Lowrance;
use super::nmea::Nmea;
use super::picture_table::PictureTable;
use super::sounding_table::SoundingTable;
use super::xtf::Xtf;
use std::ffi::OsStr;
use std::path::Path;
use std::sync::LazyLock;

/// Role of a file in its recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileRole {
    /// The whole recording. Few other programs use this ending.
    Log,
    /// The description of a recording of several files. It is small, and the recorder rewrites it
    /// as a whole. Other programs may use the same ending.
    Description,
    /// One of several files with the pings of a recording. The recorder appends to it.
    Part,
    /// The whole recording, in a file whose ending is used by many other programs: only its content
    /// identifies it.
    Shared,
    /// One of two files that form a recording and have the same name. Many other programs use the
    /// same ending.
    Paired,
}

impl FileRole {
    /// Returns the word for scripts.
    pub fn name(self) -> &'static str {
        match self {
            FileRole::Log => "log",
            FileRole::Description => "description",
            FileRole::Part => "part",
            FileRole::Shared => "shared",
            FileRole::Paired => "paired",
        }
    }
}

/// Kind of data that is read from a log if the recorder wrote it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Carried {
    /// Echoes of port and starboard.
    SideScan,
    /// Echoes of a sonar that looks down.
    DownScan,
    /// Depths that the recorder determined.
    Soundings,
    /// Depths across the track.
    Swath,
    /// Positions of the boat or the sonar.
    Positions,
    /// Heading from a compass.
    Heading,
}

impl Carried {
    /// Returns the word for lists.
    pub fn name(self) -> &'static str {
        match self {
            Carried::SideScan => "side-scan",
            Carried::DownScan => "down-scan",
            Carried::Soundings => "soundings",
            Carried::Swath => "swath",
            Carried::Positions => "positions",
            Carried::Heading => "heading",
        }
    }
}

/// A file type of the desktop, for files with the role [`FileRole::Log`].
#[derive(Clone, Copy, Debug)]
pub struct FileType {
    /// MIME type, as `application/x-xtf`.
    pub mime: &'static str,
    /// Name of the file type for users.
    pub comment: &'static str,
}

/// A format of recorders' logs.
pub struct FormatEntry {
    /// Name in lists, with `and` between the last two of several kinds: `Lowrance SLG, SL2 and
    /// SL3`.
    pub name: &'static str,
    /// Recorders that write the format, for users.
    pub recorders: &'static str,
    /// Endings of its files as recorders write them, without the dot, and the role of each file.
    /// Upper and lower case are equivalent.
    pub endings: &'static [(&'static str, FileRole)],
    /// Bytes by which the format is recognised, for users.
    pub magic: &'static str,
    /// Kinds of data that are read from the format.
    pub carries: &'static [Carried],
    /// Real recordings on which the reader was tried, for users; `None` where it was written from
    /// the specification and not tried on any.
    pub tried_on: Option<&'static str>,
    /// Notes for users.
    pub notes: &'static str,
    /// File type of the desktop; `None` where other programs use the same endings.
    pub file_type: Option<FileType>,
    /// Words for the desktop's search, in addition to the endings with the role [`FileRole::Log`].
    pub keywords: &'static [&'static str],
    /// Reader of the format.
    pub(super) reader: &'static dyn LogFormat,
    /// Ending of written files, without the dot, and the writer of the format; `None` where the
    /// format is only read.
    pub(super) writer: Option<(&'static str, &'static dyn LogWriter)>,
}

/// All formats that are read, in the order of recognition: first those that their first bytes
/// identify with certainty, last those that must list folders.
pub const FORMATS: &[FormatEntry] = &[
    FormatEntry {
        name: "Lowrance SLG, SL2 and SL3",
        recorders: "Lowrance, Simrad",
        endings: &[("sl2", FileRole::Log), ("sl3", FileRole::Log), ("slg", FileRole::Log)],
        magic: "number 2 or 3 at byte 0 and a first frame that holds its own offset, 8; else two such frames in a row; number 1 at byte 0 and blocks of the size at byte 4",
        carries: &[
            Carried::SideScan,
            Carried::DownScan,
            Carried::Soundings,
            Carried::Swath,
            Carried::Positions,
            Carried::Heading,
        ],
        tried_on: Some(
            "recordings of SL2 and SL3; those with side-scan hold only noise in it, or were converted; SLG and StructureScan 3D from the specification",
        ),
        notes: "side-scan combined or separate port and starboard; the depths across the track of StructureScan 3D (`.sl3`); `.slg` has depths and a track only",
        file_type: Some(FileType {
            mime: "application/x-lowrance-sonar",
            comment: "Lowrance sonar log",
        }),
        keywords: &["lowrance", "simrad"],
        reader: &Lowrance,
        writer: Some(("sl2", &Lowrance)),
    },
    FormatEntry {
        name: "Garmin RSD",
        recorders: "Garmin",
        endings: &[("RSD", FileRole::Log)],
        magic: "7C 4B 26 D9 at byte 2; else records with 86 DA E9 B7 at their byte 2",
        carries: &[Carried::SideScan, Carried::DownScan, Carried::Soundings, Carried::Positions],
        tried_on: None,
        notes: "ECHOMAP, STRIKER and GPSMAP series; side-scan, down-scan and traditional channels, 8 and 16 bit; of channels of one kind that were recorded at once one is shown",
        file_type: Some(FileType { mime: "application/x-garmin-rsd", comment: "Garmin sonar log" }),
        keywords: &["garmin"],
        reader: &Garmin,
        writer: None,
    },
    FormatEntry {
        name: "XTF",
        recorders: "any that exports XTF",
        endings: &[("xtf", FileRole::Log)],
        magic: "7B at byte 0 and a header of channels; else packets that begin with CE FA",
        carries: &[Carried::SideScan, Carried::Soundings, Carried::Positions, Carried::Heading],
        tried_on: Some("recordings of side-scan surveys"),
        notes: "8, 16 and 32 bit and floating point, several frequencies, towed sonars; Raymarine recordings have to be exported first",
        file_type: Some(FileType { mime: "application/x-xtf", comment: "XTF sonar log" }),
        keywords: &[],
        reader: &Xtf,
        writer: Some(("xtf", &Xtf)),
    },
    FormatEntry {
        name: "EdgeTech JSF",
        recorders: "EdgeTech side-scan sonars",
        endings: &[("jsf", FileRole::Log)],
        magic: "messages that begin with 01 16",
        carries: &[Carried::SideScan, Carried::Soundings, Carried::Positions, Carried::Heading],
        tried_on: None,
        notes: "envelope and analytic samples; of several subsystems one is shown",
        file_type: Some(FileType {
            mime: "application/x-edgetech-jsf",
            comment: "EdgeTech sonar log",
        }),
        keywords: &["edgetech"],
        reader: &EdgeTech,
        writer: None,
    },
    FormatEntry {
        name: "Cerulean svlog",
        recorders: "Cerulean and Blue Robotics Omniscan 450",
        endings: &[("svlog", FileRole::Log)],
        magic: "packets that begin with BR and end with the right sum",
        carries: &[Carried::SideScan, Carried::Positions, Carried::Heading],
        tried_on: None,
        notes: "profiles of the side-scan; the log has no depths",
        file_type: Some(FileType {
            mime: "application/x-cerulean-svlog",
            comment: "Cerulean sonar log",
        }),
        keywords: &["cerulean"],
        reader: &Cerulean,
        writer: None,
    },
    FormatEntry {
        name: "Klein SDF",
        recorders: "Klein side-scan sonars",
        endings: &[("sdf", FileRole::Log)],
        magic: "pages that begin with FF FF FF FF, their length and a version from 3000 on",
        carries: &[Carried::SideScan, Carried::Soundings, Carried::Positions, Carried::Heading],
        tried_on: None,
        notes: "System 3000 and 3500 series; System 5000 and 7000 have to be exported as XTF first; of two frequencies the high one is shown",
        file_type: Some(FileType { mime: "application/x-klein-sdf", comment: "Klein sonar log" }),
        keywords: &["klein"],
        reader: &Klein,
        writer: None,
    },
    FormatEntry {
        name: "NMEA 0183",
        recorders: "loggers of NMEA 0183",
        endings: &[("nmea", FileRole::Log), ("log", FileRole::Shared), ("txt", FileRole::Shared)],
        magic: "text with three sentences that are read and whose sums are right",
        carries: &[Carried::Soundings, Carried::Positions, Carried::Heading],
        tried_on: None,
        notes: "depths of DPT, DBT or DBS with a track; the logger's times before the sentences are used",
        file_type: Some(FileType { mime: "application/x-nmea-log", comment: "NMEA 0183 log" }),
        keywords: &["nmea"],
        reader: &Nmea,
        writer: None,
    },
    FormatEntry {
        name: "picture with CSV",
        recorders: "any whose waterfall was exported as PNG or JPEG",
        endings: &[
            ("png", FileRole::Paired),
            ("jpg", FileRole::Paired),
            ("jpeg", FileRole::Paired),
        ],
        magic: "a PNG or JPEG, and a CSV of the same name beside it whose first line names a column of ranges",
        carries: &[Carried::SideScan, Carried::Soundings, Carried::Positions, Carried::Heading],
        tried_on: None,
        notes: "`NAME.png` beside `NAME.csv` with a row a ping: lon and lat, `range_m`, perhaps depth, time and heading; port on the left, the water column in the middle: not corrected to ground range; grey of 8 or 16 bits, or colours by their luminance; `bathyscope manual files`",
        file_type: None,
        keywords: &["waterfall"],
        reader: &PictureTable,
        writer: None,
    },
    FormatEntry {
        name: "CSV of soundings",
        recorders: "Deeper, ReefMaster and other programs",
        endings: &[("csv", FileRole::Shared)],
        magic: "a first line that names columns of place and depth; else rows of latitude, longitude, depth and perhaps Unix milliseconds",
        carries: &[Carried::Soundings, Carried::Positions, Carried::Heading],
        tried_on: None,
        notes: "columns lon and lat, or easting and northing with `source.crs`; depth in metres, or feet as `depth_ft`; perhaps time and heading; read where the file is named, not in a folder",
        file_type: None,
        keywords: &["deeper", "reefmaster"],
        reader: &SoundingTable,
        writer: None,
    },
    FormatEntry {
        name: "Humminbird DAT and SON",
        recorders: "Humminbird",
        endings: &[("DAT", FileRole::Description), ("SON", FileRole::Part)],
        magic: "pings that begin with C0 DE AB 21 in a SON; in a DAT the name of a SON at byte 32, or the text of an Onix",
        carries: &[Carried::SideScan, Carried::DownScan, Carried::Soundings, Carried::Positions],
        tried_on: Some("recordings of a 998; others from the specification"),
        notes: "900, 1100 and Helix series, Solix, and newer units whose pings have the same tags; keep the folder of `.SON` files beside the `.DAT`",
        file_type: None,
        keywords: &["humminbird"],
        reader: &Humminbird,
        writer: None,
    },
];
/// Formats that are recognised but not read: the first bytes, and a text with the name and advice.
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

impl FormatEntry {
    /// Returns the files that can be opened, each ending formatted by `mark`: `.sl2, .sl3`; `the
    /// .DAT, the folder or one .SON`.
    pub fn opened_as(&self, mark: impl Fn(&str) -> String) -> String {
        let of = |role: FileRole, before: &str| {
            let endings = self.endings.iter().filter(|(_, its)| *its == role);
            let names =
                endings.map(|(ending, _)| format!("{before}{}", mark(&format!(".{ending}"))));
            names.collect::<Vec<_>>()
        };
        let mut names = of(FileRole::Log, "");
        names.extend(of(FileRole::Shared, ""));
        names.extend(of(FileRole::Paired, ""));
        names.extend(of(FileRole::Description, "the "));
        let parts = of(FileRole::Part, "one ").join(" or ");
        if parts.is_empty() {
            names.join(", ")
        } else {
            format!("{}, the folder or {parts}", names.join(", "))
        }
    }

    /// Returns the kinds of data that are read: `side-scan, positions`.
    pub fn carried(&self) -> String {
        let names: Vec<&str> = self.carries.iter().map(|kind| kind.name()).collect();
        names.join(", ")
    }

    /// Returns the recordings on which the reader was tried, or a sentence that there are none.
    pub fn tried(&self) -> &'static str {
        let untried = "from the specification, not tried on a real recording";
        self.tried_on.unwrap_or(untried)
    }

    /// Returns the ending of written files, without the dot; `None` where the format is only read.
    pub fn written_as(&self) -> Option<&'static str> {
        self.writer.map(|(ending, _)| ending)
    }

    /// Returns the endings of files that are a log by themselves, in lower case.
    pub fn log_endings(&self) -> impl Iterator<Item = String> {
        let logs = self.endings.iter();
        let logs = logs.filter(|(_, role)| *role == FileRole::Log);
        logs.map(|(ending, _)| ending.to_ascii_lowercase())
    }
}

/// Returns the writer for an ending, in upper or lower case; `None` where there is none.
pub fn writer_for(ending: &OsStr) -> Option<&'static dyn LogWriter> {
    let mut writers = FORMATS.iter().filter_map(|format| format.writer);
    let (_, writer) = writers.find(|(own, _)| ending.eq_ignore_ascii_case(own))?;
    Some(writer)
}

fn names() -> String {
    let names: Vec<&str> = FORMATS.iter().map(|format| format.name).collect();
    names.join(", ")
}

/// Returns the part of an error message that lists the formats that were tried.
pub(super) fn looked_for() -> &'static str {
    static TEXT: LazyLock<String> = LazyLock::new(|| format!("looked for {}", names()));
    &TEXT
}

/// Returns the part of an error message about a folder without a log.
pub(super) fn looked_for_in_folder() -> &'static str {
    static TEXT: LazyLock<String> =
        LazyLock::new(|| format!("a folder without a log; {}", looked_for()));
    &TEXT
}

/// Returns advice about a file of a format that is recognised but not read; `None` for other files.
pub(super) fn advice(bytes: &[u8]) -> Option<&'static str> {
    let known = KNOWN.iter().find(|(magic, _)| bytes.starts_with(magic));
    known.map(|(_, advice)| *advice)
}

/// Returns the formats to choose from, as text: `Lowrance SLG, SL2 or SL3, XTF, Humminbird DAT or
/// SON`.
pub fn formats_to_open() -> &'static str {
    static TEXT: LazyLock<String> = LazyLock::new(|| names().replace(" and ", " or "));
    &TEXT
}

/// Returns the endings of all files that a dialog shows, in lower and in upper case, because a
/// dialog may distinguish them.
pub fn endings_to_show() -> Vec<String> {
    let endings = FORMATS.iter().flat_map(|format| format.endings);
    let both =
        endings.flat_map(|(ending, _)| [ending.to_ascii_lowercase(), ending.to_ascii_uppercase()]);
    both.collect()
}

/// Returns the role of a file by its name; `None` where no format has its ending.
pub fn role_by_name(path: &Path) -> Option<FileRole> {
    let found = path.extension()?;
    let mut endings = FORMATS.iter().flat_map(|format| format.endings);
    let (_, role) = endings.find(|(ending, _)| found.eq_ignore_ascii_case(ending))?;
    Some(*role)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_row_says_what_it_is_and_no_two_share_an_ending() {
        let mut endings = BTreeSet::new();
        let mut types = BTreeSet::new();
        for format in FORMATS {
            let said = [format.name, format.recorders, format.magic, format.notes];
            assert!(said.iter().all(|text| !text.is_empty()), "{}", format.name);
            // A table in Markdown uses bars as separators.
            let bars = said.iter().chain(&format.tried_on).any(|text| text.contains('|'));
            assert!(!bars, "{}", format.name);
            assert!(!format.carries.is_empty(), "{}", format.name);
            for (ending, _) in format.endings {
                assert!(endings.insert(ending.to_ascii_lowercase()), "{ending}");
            }
            let mime = format.file_type.map(|kind| kind.mime);
            assert!(mime.is_none_or(|mime| types.insert(mime)), "{mime:?}");
            let is_log = format.log_endings().next().is_some();
            assert_eq!(is_log, mime.is_some(), "{}", format.name);
        }
    }

    #[test]
    fn a_role_is_told_by_the_ending_in_letters_of_either_case() {
        let role = |name: &str| role_by_name(Path::new(name));
        assert_eq!(role("a/pond.SL2"), Some(FileRole::Log));
        assert_eq!(role("Rec00001.dat"), Some(FileRole::Description));
        assert_eq!(role("B002.SON"), Some(FileRole::Part));
        assert_eq!(role("pond.csv"), Some(FileRole::Shared));
        assert_eq!(role("pond.JPG"), Some(FileRole::Paired));
        assert_eq!(role("pond.tif"), None);
        assert_eq!(role("sl2"), None);
    }

    #[test]
    fn lists_are_in_words() {
        let marked = |name: &str| format!("`{name}`");
        let opened = |at: usize| FORMATS[at].opened_as(marked);
        assert_eq!(opened(0), "`.sl2`, `.sl3`, `.slg`");
        let folder = FORMATS.iter().find(|format| format.name.starts_with("Humminbird"));
        let folder = folder.map(|format| format.opened_as(str::to_owned));
        assert_eq!(folder.as_deref(), Some("the .DAT, the folder or one .SON"));
        assert!(looked_for().starts_with("looked for Lowrance SLG, SL2 and SL3, "));
        assert!(formats_to_open().starts_with("Lowrance SLG, SL2 or SL3, "));
        let shown = endings_to_show();
        assert!(
            ["sl2", "SL2", "dat", "DAT", "son", "XTF"]
                .iter()
                .all(|ending| shown.iter().any(|shown| shown == ending))
        );
    }
}
