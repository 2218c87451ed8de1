//! Rows as pages: leaves with the rows in the order of their numbers, and over them pages that lead to the leaves.

use super::record::{Value, record, varint};
use super::{HEADER, PAGE};

/// Kinds of pages.
const TABLE_LEAF: u8 = 0x0d;
const TABLE_INTERIOR: u8 = 0x05;
const INDEX_LEAF: u8 = 0x0a;
/// Bytes of the header of a leaf, and of a page that leads to others.
const LEAF_HEADER: usize = 8;
const INTERIOR_HEADER: usize = 12;
/// Bytes of a row that lie in its leaf at most; of a longer one as many as the format says, and the rest in pages of its own.
const MOST_IN_LEAF: usize = PAGE - 35;
const LEAST_IN_LEAF: usize = (PAGE - 12) * 32 / 255 - 23;
/// The same of an index; nothing here comes near it.
const MOST_IN_INDEX: usize = (PAGE - 12) * 64 / 255 - 23;

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

/// Pages of a file, the first one empty until the schema is known.
pub struct Pages {
    pages: Vec<Vec<u8>>,
}

/// A page that another one leads to, and the highest number in it.
struct Child {
    page: u32,
    last: i64,
}

impl Pages {
    /// The first page alone.
    pub fn new() -> Self {
        Self {
            pages: vec![vec![0; PAGE]],
        }
    }

    /// All pages one after the other.
    pub fn into_bytes(self) -> Vec<u8> {
        self.pages.concat()
    }

    /// Adds a table; gives back the number of its first page.
    pub fn add_table(&mut self, rows: impl Iterator<Item = Cell>) -> u32 {
        let leaves = self.leaves(rows, 0);
        let (mut level, mut header) = (leaves, LEAF_HEADER);
        let mut kind = TABLE_LEAF;
        loop {
            if let [only] = &level[..] {
                return self.push(page(kind, header, 0, only));
            }
            let children = level.iter().map(|one| Child {
                page: self.push(page(kind, header, 0, one)),
                last: one.last,
            });
            let children: Vec<Child> = children.collect();
            level = interior(&children, 0);
            (kind, header) = (TABLE_INTERIOR, INTERIOR_HEADER);
        }
    }

    /// Puts the rows of the schema into the first page, or under it where they do not fit.
    pub fn set_schema(&mut self, rows: impl Iterator<Item = Cell>) {
        let leaves = self.leaves(rows, HEADER);
        let first = match &leaves[..] {
            [only] => page(TABLE_LEAF, LEAF_HEADER, HEADER, only),
            _ => {
                let children = leaves.iter().map(|one| Child {
                    page: self.push(page(TABLE_LEAF, LEAF_HEADER, 0, one)),
                    last: one.last,
                });
                let children: Vec<Child> = children.collect();
                // One page leads to hundreds of leaves, and a schema has a few rows.
                let top = interior(&children, HEADER);
                page(TABLE_INTERIOR, INTERIOR_HEADER, HEADER, &top[0])
            }
        };
        self.pages[0] = first;
    }

    /// Adds an index over some columns; `None` where it does not fit into a page.
    pub fn add_index(&mut self, rows: &[(i64, Vec<Value>)], columns: &[usize]) -> Option<u32> {
        let mut entries: Vec<Vec<Value>> = rows
            .iter()
            .map(|(id, row)| {
                let keys = columns
                    .iter()
                    .filter_map(|column| row.get(*column).cloned());
                keys.chain([Value::Integer(*id)]).collect()
            })
            .collect();
        entries.sort_by(|a, b| {
            let mut orders = a.iter().zip(b).map(|(a, b)| a.order(b));
            let first = orders.find(|order| order.is_ne());
            first.unwrap_or(std::cmp::Ordering::Equal)
        });
        let mut leaf = Level::default();
        for entry in &entries {
            let payload = record(entry.iter());
            if payload.len() > MOST_IN_INDEX {
                return None;
            }
            let mut cell = varint(payload.len() as u64);
            cell.extend(payload);
            leaf.add(cell, 0);
        }
        (leaf.bytes + LEAF_HEADER <= PAGE)
            .then(|| self.push(page(INDEX_LEAF, LEAF_HEADER, 0, &leaf)))
    }

    fn push(&mut self, page: Vec<u8>) -> u32 {
        self.pages.push(page);
        self.pages.len() as u32
    }

    /// Rows in leaves with so many bytes taken; there is one leaf at least.
    fn leaves(&mut self, rows: impl Iterator<Item = Cell>, taken: usize) -> Vec<Level> {
        let mut leaves = vec![Level::default()];
        for Cell { id, payload } in rows {
            let mut cell = varint(payload.len() as u64);
            // The number of a row is signed; its bits are written.
            cell.extend(varint(id as u64));
            let inside = in_leaf(payload.len());
            cell.extend(&payload[..inside]);
            if inside < payload.len() {
                let next = self.overflow(&payload[inside..]);
                cell.extend(next.to_be_bytes());
            }
            add_to(&mut leaves, cell, id, LEAF_HEADER + taken);
        }
        leaves
    }

    /// What does not fit into a leaf, page after page; gives back the first of them.
    fn overflow(&mut self, bytes: &[u8]) -> u32 {
        let first = self.pages.len() as u32 + 1;
        let parts = bytes.chunks(PAGE - 4);
        let count = parts.len();
        for (index, part) in parts.enumerate() {
            let is_last = index + 1 == count;
            let next = if is_last { 0 } else { first + index as u32 + 1 };
            let mut page = next.to_be_bytes().to_vec();
            page.extend(part);
            page.resize(PAGE, 0);
            self.pages.push(page);
        }
        first
    }
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
}

/// Adds a cell to the last page, or to a new one where it is full.
fn add_to(levels: &mut Vec<Level>, cell: Vec<u8>, id: i64, taken: usize) {
    let is_full = |level: &Level| level.bytes + cell.len() + 2 + taken > PAGE;
    if levels.last().is_none_or(is_full) {
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
