//! A database file of SQLite 3, written at once: tables of rows, and the indexes that their keys ask for. What a GeoPackage needs, without
//! the engine. The format is that of <https://www.sqlite.org/fileformat2.html>.
//!
//! `record` turns values into bytes, `tree` rows into pages.

mod record;
mod tree;

pub use record::Value;

use std::io::{self, Cursor, Seek, Write};
use tree::{Cell, Pages};

/// Bytes of a page.
const PAGE: usize = 4096;
/// Bytes of the header of the file, at the start of the first page.
const HEADER: usize = 100;
/// The version of SQLite that the file says to have been written by: 3.45.0.
const WRITER: u32 = 3_045_000;

/// A table with its rows.
pub struct Table {
    /// Its name.
    pub name: String,
    /// The statement that makes it.
    pub sql: String,
    /// Row numbers, growing, and the values of their columns. The column that is the number of its row has [`Value::Null`].
    pub rows: Vec<(i64, Vec<Value>)>,
    /// The columns of each index that SQLite makes by itself for a key of the statement, in the order in which the statement names them.
    pub keys: &'static [&'static [usize]],
}

/// What the schema names that has no page of its own: a virtual table, a trigger.
pub struct SchemaEntry {
    /// `table` or `trigger`.
    pub kind: &'static str,
    /// Its name.
    pub name: String,
    /// The table that it is of.
    pub table: String,
    /// The statement that makes it.
    pub sql: String,
}

/// The bytes of a database with these tables, and with what else its schema names; `None` of a key that does not fit into a page, which a table of rows must not ask for.
/// `application` says what kind of file it is, `version` which version of that.
pub fn database(
    application: u32,
    version: u32,
    tables: &[Table],
    more: &[SchemaEntry],
) -> Option<Vec<u8>> {
    let made = || {
        let mut database = Database::new(Cursor::new(Vec::new()))?;
        for table in tables {
            let rows = table.rows.iter().cloned().map(Ok);
            database.add(&table.name, &table.sql, table.keys, rows)?;
        }
        for one in more {
            database.entry(one.kind, one.name.clone(), &one.table, 0, Some(&one.sql));
        }
        database.finish(application, version)
    };
    made().ok().map(Cursor::into_inner)
}

/// A database on its way into a file, table by table: no table has to be in memory.
pub struct Database<W> {
    pages: Pages<W>,
    schema: Vec<Vec<Value>>,
}

impl<W: Write + Seek> Database<W> {
    /// An empty one.
    ///
    /// # Errors
    /// When the file cannot be written, as of all that follows.
    pub fn new(out: W) -> io::Result<Self> {
        Ok(Self {
            pages: Pages::new(out)?,
            schema: Vec::new(),
        })
    }

    /// Adds a table ([`Table`] says what of) whose rows come one by one.
    pub fn add(
        &mut self,
        name: &str,
        sql: &str,
        keys: &[&[usize]],
        rows: impl Iterator<Item = io::Result<(i64, Vec<Value>)>>,
    ) -> io::Result<()> {
        let mut entries: Vec<Vec<Vec<Value>>> = vec![Vec::new(); keys.len()];
        let cells = rows.map(|row| {
            let (id, row) = row?;
            for (entries, columns) in entries.iter_mut().zip(keys) {
                let values = columns
                    .iter()
                    .filter_map(|column| row.get(*column).cloned());
                entries.push(values.chain([Value::Integer(id)]).collect());
            }
            Ok(Cell::of_row(id, &row))
        });
        let root = self.pages.add_table(cells)?;
        self.entry("table", name.to_owned(), name, root, Some(sql));
        for (number, entries) in (1..).zip(entries) {
            let root = self.pages.add_index(entries)?;
            let index = format!("sqlite_autoindex_{name}_{number}");
            self.entry("index", index, name, root, None);
        }
        Ok(())
    }

    fn entry(&mut self, kind: &str, name: String, table: &str, root: u32, sql: Option<&str>) {
        self.schema.push(vec![
            Value::Text(kind.to_owned()),
            Value::Text(name),
            Value::Text(table.to_owned()),
            Value::Integer(i64::from(root)),
            sql.map_or(Value::Null, |sql| Value::Text(sql.to_owned())),
        ]);
    }

    /// Ends the file; `application` and `version` as of [`database`].
    pub fn finish(self, application: u32, version: u32) -> io::Result<W> {
        let rows = (1..)
            .zip(&self.schema)
            .map(|(id, row)| Cell::of_row(id, row));
        self.pages
            .finish(rows, |count| header(application, version, count))
    }
}

/// The header of the file.
fn header(application: u32, version: u32, pages: u32) -> [u8; HEADER] {
    let mut header = [0; HEADER];
    header[..16].copy_from_slice(b"SQLite format 3\0");
    header[16..18].copy_from_slice(&(PAGE as u16).to_be_bytes());
    // No write-ahead log, no bytes reserved in a page, and the fractions of a page that the format fixes.
    header[18..24].copy_from_slice(&[1, 1, 0, 64, 32, 32]);
    let mut put = |at: usize, number: u32| {
        header[at..at + 4].copy_from_slice(&number.to_be_bytes());
    };
    // The number of changes, which is said again where the number of pages is to be believed.
    put(24, 1);
    put(28, pages);
    put(40, 1);
    // Format of the schema; texts in UTF-8.
    put(44, 4);
    put(56, 1);
    put(60, version);
    put(68, application);
    put(92, 1);
    put(96, WRITER);
    header
}

#[cfg(test)]
mod tests;
