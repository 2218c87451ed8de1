//! Rows as pages: leaves with the rows in the order of their numbers, and over them pages that lead to the leaves.

use super::record::{Value, record, varint};
use super::{HEADER, PAGE};
use std::io::{self, Seek, SeekFrom, Write};

/// Kinds of pages.
const TABLE_LEAF: u8 = 0x0d;
const TABLE_INTERIOR: u8 = 0x05;
const INDEX_LEAF: u8 = 0x0a;
const INDEX_INTERIOR: u8 = 0x02;
/// Bytes of the header of a leaf, and of a page that leads to others.
const LEAF_HEADER: usize = 8;
const INTERIOR_HEADER: usize = 12;
/// Bytes of a row that lie in its leaf at most; of a longer one as many as the format says, and the rest in pages of its own.
const MOST_IN_LEAF: usize = PAGE - 35;
const LEAST_IN_LEAF: usize = (PAGE - 12) * 32 / 255 - 23;
/// The same of an index; nothing here comes near it.
const MOST_IN_INDEX: usize = (PAGE - 12) * 64 / 255 - 23;
/// What is left free in a page of an index, so that one more entry always fits: an entry, its length, and the page before it.
const LARGEST_SPARE: usize = MOST_IN_INDEX + 9 + 4;

/// A row on its way into a leaf.
pub struct Cell {
    id: i64,
    payload: Vec<u8>,
}

impl Cell {
    /// A row by its number.
    pub fn of_row(id: i64, values: &[Value]) -> Self {
        Self {
            id,
            payload: record(values.iter()),
        }
    }
}

/// Pages of a file, written one after the other; the first one is empty until the schema is known.
pub struct Pages<W> {
    out: W,
    count: u32,
}

/// A page that another one leads to, and the highest number in it.
struct Child {
    page: u32,
    last: i64,
}

/// An entry of an index on its way into a page: the page of those before it, where it has one, and its bytes.
type Entry = (Option<u32>, Vec<u8>);

impl<W: Write + Seek> Pages<W> {
    /// The first page alone.
    pub fn new(out: W) -> io::Result<Self> {
        let mut pages = Self { out, count: 0 };
        pages.push(&[0; PAGE])?;
        Ok(pages)
    }

    /// Adds a table; gives back the number of its first page. No more than one of its leaves is in memory.
    pub fn add_table(&mut self, rows: impl Iterator<Item = io::Result<Cell>>) -> io::Result<u32> {
        let (mut leaf, mut children) = (Level::default(), Vec::new());
        for row in rows {
            let row = row?;
            let (cell, id) = (self.leaf_cell(&row)?, row.id);
            if leaf.is_full(&cell, LEAF_HEADER) {
                children.push(self.close(TABLE_LEAF, LEAF_HEADER, &std::mem::take(&mut leaf))?);
            }
            leaf.add(cell, id);
        }
        children.push(self.close(TABLE_LEAF, LEAF_HEADER, &leaf)?);
        while children.len() > 1 {
            let level = interior(&children, 0);
            let closed = level
                .iter()
                .map(|one| self.close(TABLE_INTERIOR, INTERIOR_HEADER, one));
            children = closed.collect::<io::Result<_>>()?;
        }
        Ok(children.first().map_or(0, |top| top.page))
    }

    /// Puts the rows of the schema into the first page, or under it where they do not fit, and the header over it.
    pub fn finish(
        mut self,
        schema: impl Iterator<Item = Cell>,
        header: impl Fn(u32) -> [u8; HEADER],
    ) -> io::Result<W> {
        let mut leaves = vec![Level::default()];
        for row in schema {
            let cell = self.leaf_cell(&row)?;
            add_to(&mut leaves, cell, row.id, LEAF_HEADER + HEADER);
        }
        let mut first = match &leaves[..] {
            [only] => page(TABLE_LEAF, LEAF_HEADER, HEADER, only),
            _ => {
                let children = leaves
                    .iter()
                    .map(|one| self.close(TABLE_LEAF, LEAF_HEADER, one));
                let children: Vec<Child> = children.collect::<io::Result<_>>()?;
                // One page leads to hundreds of leaves, and a schema has a few rows.
                let top = interior(&children, HEADER);
                page(TABLE_INTERIOR, INTERIOR_HEADER, HEADER, &top[0])
            }
        };
        first[..HEADER].copy_from_slice(&header(self.count));
        self.out.seek(SeekFrom::Start(0))?;
        self.out.write_all(&first)?;
        self.out.flush()?;
        Ok(self.out)
    }

    /// Adds an index: entries of the values of its columns and the number of the row.
    pub fn add_index(&mut self, mut entries: Vec<Vec<Value>>) -> io::Result<u32> {
        entries.sort_by(|a, b| {
            let mut orders = a.iter().zip(b).map(|(a, b)| a.order(b));
            let first = orders.find(|order| order.is_ne());
            first.unwrap_or(std::cmp::Ordering::Equal)
        });
        let mut items: Vec<Entry> = Vec::with_capacity(entries.len());
        for entry in &entries {
            let payload = record(entry.iter());
            if payload.len() > MOST_IN_INDEX {
                return Err(io::Error::other("a key does not fit into a page"));
            }
            items.push((None, [varint(payload.len() as u64), payload].concat()));
        }
        let (mut kind, mut header, mut right) = (INDEX_LEAF, LEAF_HEADER, None);
        loop {
            let (pages, between) = spread(items, right, header);
            let mut numbers = Vec::with_capacity(pages.len());
            for one in &pages {
                numbers.push(self.push(&page(kind, header, 0, one))?);
            }
            right = numbers.pop();
            if between.is_empty() {
                return Ok(right.unwrap_or_default());
            }
            let led = numbers.into_iter().zip(between);
            items = led.map(|(page, cell)| (Some(page), cell)).collect();
            (kind, header) = (INDEX_INTERIOR, INTERIOR_HEADER);
        }
    }

    fn close(&mut self, kind: u8, header: usize, level: &Level) -> io::Result<Child> {
        Ok(Child {
            page: self.push(&page(kind, header, 0, level))?,
            last: level.last,
        })
    }

    fn push(&mut self, page: &[u8]) -> io::Result<u32> {
        self.out.write_all(page)?;
        self.count += 1;
        Ok(self.count)
    }

    /// A row as it lies in a leaf; what does not fit into one is written.
    fn leaf_cell(&mut self, Cell { id, payload }: &Cell) -> io::Result<Vec<u8>> {
        let mut cell = varint(payload.len() as u64);
        // The number of a row is signed; its bits are written.
        cell.extend(varint(*id as u64));
        let inside = in_leaf(payload.len());
        cell.extend(&payload[..inside]);
        if inside < payload.len() {
            let next = self.overflow(&payload[inside..])?;
            cell.extend(next.to_be_bytes());
        }
        Ok(cell)
    }

    /// What does not fit into a leaf, page after page; gives back the first of them.
    fn overflow(&mut self, bytes: &[u8]) -> io::Result<u32> {
        let first = self.count + 1;
        let parts = bytes.chunks(PAGE - 4);
        let count = parts.len();
        for (index, part) in parts.enumerate() {
            let is_last = index + 1 == count;
            let next = if is_last { 0 } else { first + index as u32 + 1 };
            let mut page = next.to_be_bytes().to_vec();
            page.extend(part);
            page.resize(PAGE, 0);
            self.push(&page)?;
        }
        Ok(first)
    }
}

/// Entries of one level of an index as pages, and those between the pages, which the level above holds. Each page leads to what comes
/// before its entries; `right` is what comes behind the last.
fn spread(items: Vec<Entry>, right: Option<u32>, header: usize) -> (Vec<Level>, Vec<Vec<u8>>) {
    let (mut pages, mut between) = (vec![Level::default()], Vec::new());
    let count = items.len();
    for (index, (left, cell)) in items.into_iter().enumerate() {
        let whole = || {
            let page = left.map(u32::to_be_bytes);
            [page.as_ref().map_or(&[][..], |page| page), &cell].concat()
        };
        let Some(last) = pages.last_mut() else {
            break;
        };
        // The last entry stays in a page: none may be empty.
        if last.is_full(&whole(), header + LARGEST_SPARE) && index + 1 < count {
            last.right = left;
            between.push(cell);
            pages.push(Level::default());
        } else {
            last.add(whole(), 0);
        }
    }
    if let Some(last) = pages.last_mut() {
        last.right = right;
    }
    (pages, between)
}

/// How many bytes of a row lie in its leaf.
fn in_leaf(length: usize) -> usize {
    if length <= MOST_IN_LEAF {
        return length;
    }
    let inside = LEAST_IN_LEAF + (length - LEAST_IN_LEAF) % (PAGE - 4);
    match inside <= MOST_IN_LEAF {
        true => inside,
        false => LEAST_IN_LEAF,
    }
}

/// The cells of one page.
#[derive(Default)]
struct Level {
    cells: Vec<Vec<u8>>,
    /// Of the cells and of what points to them.
    bytes: usize,
    last: i64,
    /// The page that holds what comes after the last cell, of a page that leads to others.
    right: Option<u32>,
}

impl Level {
    fn add(&mut self, cell: Vec<u8>, id: i64) {
        self.bytes += cell.len() + 2;
        self.last = id;
        self.cells.push(cell);
    }

    /// Whether one more cell does not fit beside `taken` bytes.
    fn is_full(&self, cell: &[u8], taken: usize) -> bool {
        self.bytes + cell.len() + 2 + taken > PAGE
    }
}

/// Adds a cell to the last page, or to a new one where it is full.
fn add_to(levels: &mut Vec<Level>, cell: Vec<u8>, id: i64, taken: usize) {
    if levels
        .last()
        .is_none_or(|level| level.is_full(&cell, taken))
    {
        levels.push(Level::default());
    }
    if let Some(level) = levels.last_mut() {
        level.add(cell, id);
    }
}

/// Pages that lead to some pages.
fn interior(children: &[Child], taken: usize) -> Vec<Level> {
    // A page and the longest number of a row.
    const WIDEST: usize = 4 + 9 + 2;
    let most = (PAGE - INTERIOR_HEADER - taken) / WIDEST;
    // The last of each group is its page's right one. Groups are as even as can be: a page leads to two others at least.
    let groups = children.len().div_ceil(most + 1).max(1);
    let (each, more) = (children.len() / groups, children.len() % groups);
    let mut levels = Vec::with_capacity(groups);
    let mut rest = children;
    for index in 0..groups {
        let (group, after) = rest.split_at(each + usize::from(index < more));
        rest = after;
        let mut level = Level::default();
        if let Some((right, others)) = group.split_last() {
            for child in others {
                let mut cell = child.page.to_be_bytes().to_vec();
                cell.extend(varint(child.last as u64));
                level.add(cell, child.last);
            }
            level.right = Some(right.page);
            level.last = right.last;
        }
        levels.push(level);
    }
    levels
}

/// A page with its cells at its end and what points to them at its start. `offset` is where it begins in the first page.
fn page(kind: u8, header: usize, offset: usize, level: &Level) -> Vec<u8> {
    let mut page = vec![0; PAGE];
    let mut end = PAGE;
    let mut pointers = Vec::with_capacity(2 * level.cells.len());
    for cell in &level.cells {
        end -= cell.len();
        page[end..end + cell.len()].copy_from_slice(cell);
        pointers.extend((end as u16).to_be_bytes());
    }
    page[offset] = kind;
    page[offset + 3..offset + 5].copy_from_slice(&(level.cells.len() as u16).to_be_bytes());
    page[offset + 5..offset + 7].copy_from_slice(&(end as u16).to_be_bytes());
    if let Some(right) = level.right {
        page[offset + 8..offset + 12].copy_from_slice(&right.to_be_bytes());
    }
    let start = offset + header;
    page[start..start + pointers.len()].copy_from_slice(&pointers);
    page
}
