//! `bathyscope info --formats`: the formats of logs that can be read.

use super::{Failure, output};
use bathyscope_log::formats::{FORMATS, FormatEntry};
use serde_json::{Value, json};

/// Prints them, as text or as JSON for scripts.
pub(super) fn print(as_json: bool) -> Result<(), Failure> {
    let formats = FORMATS.iter();
    if as_json {
        output::json(&formats.map(to_json).collect::<Value>())
    } else {
        let texts: Vec<String> = formats.map(to_text).collect();
        output::results(texts.join("\n").trim_end())
    }
}

/// The name, and below it a line for each thing that is known, all in one column.
fn to_text(format: &FormatEntry) -> String {
    let lines = [
        ("recorders", format.recorders.to_owned()),
        ("open", format.opened_as(str::to_owned)),
        ("recognised by", format.magic.to_owned()),
        ("carries", format.carried()),
        ("tried on", format.tried().to_owned()),
        ("notes", format.notes.replace('`', "")),
    ];
    let written = format.written_as();
    let written = written.map(|ending| ("written as", format!(".{ending}")));
    let lines = lines.into_iter().chain(written);
    let lines = lines.map(|(name, value)| format!("  {name:<14} {value}\n"));
    format!("{}\n{}", format.name, lines.collect::<String>())
}

fn to_json(format: &FormatEntry) -> Value {
    let ending = |(ending, role): &(&str, bathyscope_log::formats::FileRole)| json!({ "ending": ending, "role": role.name() });
    let endings: Vec<Value> = format.endings.iter().map(ending).collect();
    let carries: Vec<&str> = format.carries.iter().map(|one| one.name()).collect();
    json!({
        "name": format.name,
        "recorders": format.recorders,
        "endings": endings,
        "recognised_by": format.magic,
        "carries": carries,
        "tried_on": format.tried_on,
        "written_as": format.written_as(),
        "notes": format.notes,
    })
}
