//! Writes database files of SQLite 3, by SQLite itself (crate `rusqlite`).

use super::ExportError;
use super::atomic_write::write_atomically_at;
pub(super) use rusqlite::types::Value;
use rusqlite::{Connection, params_from_iter};
use std::io;
use std::path::Path;

/// Identity of a kind of database in the header.
#[derive(Clone, Copy, Debug)]
pub(super) struct DatabaseKind {
    /// Program that the file belongs to: four letters as a number.
    pub application: u32,
    /// Version of the program's format.
    pub version: u32,
}

/// Converts a number of things to a value.
pub(super) fn count(number: usize) -> Value {
    Value::Integer(i64::try_from(number).unwrap_or(i64::MAX))
}

/// Converts a text to a value.
pub(super) fn text(text: &str) -> Value {
    Value::Text(text.to_owned())
}

/// Writes a database, which `fill` fills under a temporary name, and renames it. The same rows give
/// the same bytes.
pub(super) fn database<T>(
    path: &Path,
    kind: DatabaseKind,
    fill: impl FnOnce(&Connection) -> io::Result<T>,
) -> Result<T, ExportError> {
    write_atomically_at(path, |passing| {
        let connection = Connection::open(passing).map_err(io::Error::other)?;
        // An unfinished file is never used, so nothing has to be rolled back.
        let start = format!(
            "PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF; PRAGMA application_id = {}; PRAGMA user_version = {}; BEGIN;",
            kind.application, kind.version
        );
        run(&connection, &start)?;
        let made = fill(&connection)?;
        run(&connection, "COMMIT;")?;
        connection.close().map_err(|(_, error)| io::Error::other(error))?;
        Ok(made)
    })
}

/// Runs SQL statements.
///
/// # Errors
/// When SQLite refuses a statement.
pub(super) fn run(connection: &Connection, statements: &str) -> io::Result<()> {
    connection.execute_batch(statements).map_err(io::Error::other)
}

/// Adds rows to a table, each with a value for every column. NaN is stored as NULL.
///
/// # Errors
/// When SQLite refuses a row, or a row is an error.
pub(super) fn insert(
    connection: &Connection,
    table: &str,
    rows: impl IntoIterator<Item = io::Result<Vec<Value>>>,
) -> io::Result<()> {
    let mut statement = None;
    for row in rows {
        let row = row?;
        if statement.is_none() {
            let places = vec!["?"; row.len()].join(",");
            let insert = format!("INSERT INTO \"{table}\" VALUES ({places})");
            statement = Some(connection.prepare(&insert).map_err(io::Error::other)?);
        }
        if let Some(statement) = &mut statement {
            statement.execute(params_from_iter(row)).map_err(io::Error::other)?;
        }
    }
    Ok(())
}
