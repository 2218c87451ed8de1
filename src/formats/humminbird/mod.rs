//! Humminbird DAT and SON: 700 to 1100 series, Helix, Solix.

pub mod dat;
mod meaning;
pub mod ping;
mod recording;
mod son;

pub(super) use recording::{Recording, find_in_folder, sniff};

use super::{OpenError, assemble, collected::Collected};
use crate::progress::Progress;
use crate::survey::{Source, Survey};
use dat::Dat;

/// Reads a recording.
pub(super) fn read(recording: Recording, progress: &Progress) -> Result<Survey, OpenError> {
    let dat = recording.dat.as_ref().and_then(|(_, dat, _)| *dat);
    let format = format_name(dat);
    if recording.sons.is_empty() {
        return Err(OpenError::Broken {
            path: recording.opened,
            format,
            what: "no B00n.SON file with pings lies in the folder of the same name; copy that folder from the card too".into(),
        });
    }
    let mut log = Collected::new(source(&recording, format.clone()), Vec::new());
    log.start_unix_s = dat.and_then(|dat| dat.start_unix_s).map(f64::from);
    remark(&recording, &mut log);
    progress.start(
        recording
            .sons
            .iter()
            .map(|(_, bytes)| bytes.len() as u64)
            .sum(),
    );
    let first_son = log.source.files.len() - recording.sons.len();
    log.bytes = vec![crate::survey::Bytes::Held(std::sync::Arc::from(Vec::new())); first_son];
    for (index, (path, bytes)) in recording.sons.iter().enumerate() {
        log.bytes.push(bytes.clone());
        let Some(order) = son::byte_order(bytes) else {
            continue;
        };
        let name = path
            .file_stem()
            .map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        let mut reader = meaning::Reader::new(first_son + index, name, dat);
        let mut report = std::mem::take(&mut log.report);
        let mut walk = son::Walk {
            bytes,
            file: first_son + index,
            order,
            report: &mut report,
            progress,
        };
        let walked = walk.run(|offset, ping| reader.take(&mut log, offset, ping));
        reader.finish(&mut log);
        log.report.absorb(report);
        walked?;
    }
    Ok(assemble::assemble(log))
}

fn source(recording: &Recording, format: String) -> Source {
    let dat = recording.dat.iter().map(|(path, _, _)| path.clone());
    let sons = recording.sons.iter().map(|(path, _)| path.clone());
    let son_bytes: u64 = recording
        .sons
        .iter()
        .map(|(_, bytes)| bytes.len() as u64)
        .sum();
    Source {
        files: dat.chain(sons).collect(),
        format,
        byte_count: son_bytes + recording.dat.as_ref().map_or(0, |(_, _, len)| *len),
    }
}

fn remark(recording: &Recording, log: &mut Collected) {
    match &recording.dat {
        None => log.report.companion(
            "the DAT file is missing: the start time is unknown, fresh water is assumed",
        ),
        Some((_, None, _)) => log.report.companion(
            "the DAT file is damaged: the start time is unknown, fresh water is assumed",
        ),
        Some((_, Some(_), _)) => {}
    }
    log.report.log(
        "the recorder does not store the side-scan range; it is estimated from the transducer's size and may be off by some percent until calibrated",
    );
}

fn format_name(dat: Option<Dat>) -> String {
    match dat.map(|dat| dat.order) {
        Some(super::ByteOrder::Little) => "Humminbird Solix",
        _ => "Humminbird",
    }
    .to_owned()
}
