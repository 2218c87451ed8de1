use super::*;

/// A reader of its own: as little of the format as these files use.
struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn page(&self, number: u32) -> &[u8] {
        let start = (number as usize - 1) * PAGE;
        &self.0[start..start + PAGE]
    }

    fn u16(&self, page: u32, at: usize) -> usize {
        let page = self.page(page);
        usize::from(u16::from_be_bytes([page[at], page[at + 1]]))
    }

    fn u32(&self, page: u32, at: usize) -> u32 {
        let page = self.page(page);
        u32::from_be_bytes([page[at], page[at + 1], page[at + 2], page[at + 3]])
    }

    fn varint(bytes: &[u8]) -> (u64, usize) {
        let mut number = 0;
        for (index, byte) in bytes.iter().enumerate().take(9) {
            if index == 8 {
                return (number << 8 | u64::from(*byte), 9);
            }
            number = number << 7 | u64::from(byte & 0x7f);
            if byte & 0x80 == 0 {
                return (number, index + 1);
            }
        }
        panic!("no end")
    }

    /// The rows under a page, in order.
    fn rows(&self, page: u32) -> Vec<(i64, Vec<Value>)> {
        let offset = if page == 1 { HEADER } else { 0 };
        let cells = self.u16(page, offset + 3);
        let mut rows = Vec::new();
        match self.page(page)[offset] {
            0x05 => {
                assert!(cells > 0, "a page that leads to one other only");
                for cell in 0..cells {
                    let at = self.u16(page, offset + 12 + 2 * cell);
                    rows.extend(self.rows(self.u32(page, at)));
                    let (last, _) = Self::varint(&self.page(page)[at + 4..]);
                    assert_eq!(rows.last().map(|row| row.0), Some(last as i64));
                }
                rows.extend(self.rows(self.u32(page, offset + 8)));
            }
            0x0d => {
                for cell in 0..cells {
                    let at = self.u16(page, offset + 8 + 2 * cell);
                    rows.push(self.row(page, at));
                }
            }
            kind => panic!("page {page} is of kind {kind}"),
        }
        rows
    }

    fn row(&self, page: u32, at: usize) -> (i64, Vec<Value>) {
        let bytes = self.page(page);
        let (length, first) = Self::varint(&bytes[at..]);
        let (id, second) = Self::varint(&bytes[at + first..]);
        let (length, start) = (length as usize, at + first + second);
        let usable = PAGE;
        let inside = match length > usable - 35 {
            false => length,
            true => {
                let least = (usable - 12) * 32 / 255 - 23;
                let inside = least + (length - least) % (usable - 4);
                if inside <= usable - 35 { inside } else { least }
            }
        };
        let mut payload = bytes[start..start + inside].to_vec();
        let mut next = match inside < length {
            true => self.u32(page, start + inside),
            false => 0,
        };
        while next != 0 {
            let page = self.page(next);
            let part = (length - payload.len()).min(PAGE - 4);
            payload.extend(&page[4..4 + part]);
            next = self.u32(next, 0);
        }
        assert_eq!(payload.len(), length);
        (id as i64, Self::values(&payload))
    }

    fn values(payload: &[u8]) -> Vec<Value> {
        let (head, mut at) = Self::varint(payload);
        let (mut body, mut values) = (head as usize, Vec::new());
        while at < head as usize {
            let (code, length) = Self::varint(&payload[at..]);
            at += length;
            let mut take = |length: usize| {
                body += length;
                &payload[body - length..body]
            };
            values.push(match code {
                0 => Value::Null,
                6 => Value::Integer(i64::from_be_bytes(take(8).try_into().unwrap())),
                7 => Value::Real(f64::from_be_bytes(take(8).try_into().unwrap())),
                code if code % 2 == 1 => {
                    let text = take((code as usize - 13) / 2).to_vec();
                    Value::Text(String::from_utf8(text).unwrap())
                }
                code => Value::Blob(take((code as usize - 12) / 2).to_vec()),
            });
        }
        values
    }

    /// First page of a table or an index.
    fn root(&self, name: &str) -> u32 {
        let schema = self.rows(1);
        let entry = schema
            .iter()
            .find(|(_, row)| row[1] == Value::Text(name.to_owned()));
        match entry.unwrap().1[3] {
            Value::Integer(root) => root as u32,
            _ => panic!("no page"),
        }
    }
}

fn table(rows: Vec<(i64, Vec<Value>)>) -> Table {
    Table {
        name: "t".to_owned(),
        sql: "CREATE TABLE t (id INTEGER PRIMARY KEY NOT NULL, name TEXT)".to_owned(),
        rows,
        keys: &[],
    }
}

#[test]
fn rows_come_back_however_many_and_however_long() {
    for count in [0, 1, 40, 3_000, 60_000] {
        let rows: Vec<(i64, Vec<Value>)> = (0..count)
            .map(|index: i64| {
                // Some of them longer than a page, and than many.
                let length = match index % 1_000 {
                    7 => 30_000,
                    8 => 4_100,
                    9 => 4_050,
                    rest => rest as usize % 60,
                };
                let row = vec![Value::Null, Value::Text("x".repeat(length))];
                (2 * index - 1, row)
            })
            .collect();
        let file = database(7, 3, &[table(rows.clone())], &[]).unwrap();
        assert_eq!(file.len() % PAGE, 0);
        let reader = Reader(&file);
        assert_eq!(reader.u32(1, 28) as usize, file.len() / PAGE);
        let back = reader.rows(reader.root("t"));
        assert!(back == rows, "{count} rows");
    }
}

#[test]
fn a_schema_that_is_longer_than_a_page_has_pages_under_the_first() {
    const LONG: &str = "CREATE TABLE t (id INTEGER PRIMARY KEY NOT NULL /* 0123456789012345678901234567890123456789012345678901234567890123456789012345678901234567890123456789012345678901234567890123456789 */)";
    let tables: Vec<Table> = (0..60)
        .map(|index| Table {
            sql: LONG.to_owned(),
            ..table(vec![(index, vec![Value::Null])])
        })
        .collect();
    let file = database(7, 3, &tables, &[]).unwrap();
    let schema = Reader(&file).rows(1);
    assert_eq!(schema.len(), 60);
    assert_eq!(schema[59].1[4], Value::Text(LONG.to_owned()));
}

#[test]
fn the_index_of_a_key_is_sorted_and_said_in_the_schema() {
    let text = |text: &str| Value::Text(text.to_owned());
    let keyed = Table {
        keys: &[&[0]],
        sql: "CREATE TABLE t (name TEXT NOT NULL PRIMARY KEY)".to_owned(),
        ..table(vec![(1, vec![text("b")]), (2, vec![text("a")])])
    };
    let file = database(7, 3, &[keyed], &[]).unwrap();
    let reader = Reader(&file);
    let root = reader.root("sqlite_autoindex_t_1");
    assert_eq!(reader.page(root)[0], 0x0a);
    let entry = |cell: usize| {
        let at = reader.u16(root, 8 + 2 * cell);
        let page = reader.page(root);
        let (length, start) = Reader::varint(&page[at..]);
        Reader::values(&page[at + start..at + start + length as usize])
    };
    assert_eq!(entry(0), [text("a"), Value::Integer(2)]);
    assert_eq!(entry(1), [text("b"), Value::Integer(1)]);
}

/// All entries of an index in their order, and how many levels it has.
fn entries(reader: &Reader<'_>, page: u32) -> (Vec<Vec<Value>>, usize) {
    let cells = reader.u16(page, 3);
    let start = |header: usize, cell: usize| reader.u16(page, header + 2 * cell);
    let values = |at: usize| {
        let bytes = &reader.page(page)[at..];
        let (length, first) = Reader::varint(bytes);
        Reader::values(&bytes[first..first + length as usize])
    };
    assert!(cells > 0, "page {page} is empty");
    match reader.page(page)[0] {
        0x0a => ((0..cells).map(|cell| values(start(8, cell))).collect(), 1),
        0x02 => {
            let (mut all, mut levels) = (Vec::new(), 0);
            for cell in 0..cells {
                let at = start(12, cell);
                let (before, below) = entries(reader, reader.u32(page, at));
                all.extend(before);
                all.push(values(at + 4));
                levels = below;
            }
            let (behind, below) = entries(reader, reader.u32(page, 8));
            assert!(levels == below, "leaves of different depths");
            all.extend(behind);
            (all, levels + 1)
        }
        kind => panic!("page {page} is of kind {kind}"),
    }
}

#[test]
fn an_index_of_many_rows_has_pages_above_its_leaves() {
    for (count, levels) in [(1, 1), (80, 1), (120, 2), (4_000, 2), (60_000, 3)] {
        let row = |index: i64| {
            let key = (index * 7_919) % count;
            (
                index + 1,
                vec![Value::Integer(key % 20), Value::Integer(key)],
            )
        };
        let rows: Vec<(i64, Vec<Value>)> = (0..count).map(row).collect();
        let keyed = Table {
            name: "t".to_owned(),
            sql: "CREATE TABLE t (a INTEGER, b INTEGER, PRIMARY KEY (a, b))".to_owned(),
            rows,
            keys: &[&[0, 1]],
        };
        let file = database(7, 3, &[keyed], &[]).unwrap();
        let reader = Reader(&file);
        let (found, high) = entries(&reader, reader.root("sqlite_autoindex_t_1"));
        assert_eq!(
            (found.len(), high),
            (count as usize, levels),
            "{count} rows"
        );
        let number = |value: &Value| match value {
            Value::Integer(number) => *number,
            _ => panic!("no number"),
        };
        let keys: Vec<[i64; 2]> = found
            .iter()
            .map(|one| [number(&one[0]), number(&one[1])])
            .collect();
        assert!(keys.is_sorted(), "{count} rows");
        let mut ids: Vec<i64> = found.iter().map(|one| number(&one[2])).collect();
        ids.sort_unstable();
        assert!(ids.into_iter().eq(1..=count), "{count} rows");
    }
}
