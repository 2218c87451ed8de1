//! XTF, the exchange format of the survey world.

mod channels;
mod date;
mod decode;
mod packets;
mod place;
pub mod raw;
mod sides;
mod walk;

use super::{OpenError, Opened, assemble, collected::Collected};
use crate::progress::Progress;
use crate::survey::Survey;
use raw::{FileHeader, record};

/// The file header is a multiple of this long: 1024 bytes for up to six channels.
const HEADER_BLOCK: usize = 1024;
/// Bytes searched for packets when the file header is damaged.
const SEARCHED_FOR_PACKETS: usize = 1 << 20;
const FORMAT: &str = "XTF";

/// What was recognised.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    header: Option<FileHeader>,
    first_packet: usize,
}

/// Recognises a file by its header, or by its packets when the header is damaged.
pub(super) fn sniff(bytes: &[u8]) -> Option<Found> {
    let header: Option<FileHeader> = record(bytes, 0).filter(is_header);
    let header_len = header.map_or(0, |header| {
        let channels = usize::from(header.sonar_channels) + usize::from(header.bathymetry_channels);
        (256 + 128 * channels).next_multiple_of(HEADER_BLOCK)
    });
    let searched = header_len..header_len + SEARCHED_FOR_PACKETS;
    let first_packet = if header.is_some() && walk::header(bytes, header_len).is_some() {
        Some(header_len)
    } else {
        walk::next_packet(bytes, searched.start, searched.end)
    };
    (header.is_some() || first_packet.is_some()).then(|| Found {
        header,
        first_packet: first_packet.unwrap_or(header_len.min(bytes.len())),
    })
}

/// 0x7B is also an opening brace: text has other bytes where the small numbers of the header are.
fn is_header(header: &FileHeader) -> bool {
    header.file_format == 0x7B
        && header.nav_units <= 3
        && header.sonar_channels <= 64
        && header.bathymetry_channels <= 64
        && header.sonar_channels + header.bathymetry_channels > 0
}

/// The sonar and the program that recorded it, as the header names them.
fn device_name(header: FileHeader) -> String {
    let mut names = Vec::new();
    for name in [&header.sonar_name[..], &header.program[..]] {
        names.extend(channels::text(name).filter(|name| !names.contains(name)));
    }
    names.join(", ")
}

/// Reads a file that [`sniff`] recognised.
pub(super) fn read(opened: Opened, found: Found, progress: &Progress) -> Result<Survey, OpenError> {
    let path = opened.path.clone();
    let bytes = opened.bytes.clone();
    let mut log = Collected::new(opened.source(FORMAT.to_owned()), vec![opened.bytes]);
    log.source.device = found.header.map_or_else(String::new, device_name);
    let report = log.report.clone();
    if found.header.is_none() {
        report.log("the file header is damaged; channels and units were inferred from the pings");
    }
    let mut reader = decode::Reader::new(&bytes, found.header);
    progress.start(bytes.len().saturating_sub(found.first_packet) as u64);
    walk::Walk {
        bytes: &bytes,
        report: &report,
        progress,
    }
    .run(found.first_packet, |offset, packet| {
        reader.take(&mut log, offset, &packet)
    })?;
    reader.finish(&mut log);
    if log.channels.is_empty() && reader.others().total() > 0 {
        return Err(OpenError::Unsupported {
            path,
            what: format!(
                "this XTF file is whole, but there is no side-scan in it, only {}; open the file that the side-scan was recorded into, or export it with the sonar channels",
                reader.others().summary()
            ),
        });
    }
    if log.channels.is_empty() {
        return Err(OpenError::Broken {
            path,
            format: FORMAT.to_owned(),
            what: format!(
                "no side-scan ping in its {} bytes; export the file again",
                bytes.len()
            ),
        });
    }
    Ok(assemble::assemble(log))
}
