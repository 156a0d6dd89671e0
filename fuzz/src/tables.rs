//! Tables, packed or not. The first byte says which table it is and whether it is packed.

use std::fmt::Debug;
use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crossgrain::files::FileError;
use crossgrain::run::folder::record::TraceRow;
use crossgrain::tables::{
    Rows, read_bodies, read_contacts, write_bodies, write_contacts, write_rows,
};
use grains::measure::HistoryRow;
use grains::tables::BodyIds;

use super::parts;

/// As many rows as there may be.
const MOST_ROWS: u32 = 64;

/// A table that is accepted reads back as itself.
pub fn read(input: &[u8]) -> bool {
    let Some((kind, bytes)) = input.split_first() else {
        return false;
    };
    let folder = parts::folder();
    // Upper case: packed as it is; `z`-like letters: packed by us, so that its text can be reached.
    let packed = kind.is_ascii_uppercase();
    let name = if packed { "table.csv.gz" } else { "table.csv" };
    parts::put(folder.path(), name, bytes);
    let path = folder.path().join(name);
    let again = folder.path().join("again.csv");
    match kind.to_ascii_lowercase() {
        b'b' => same(
            &path,
            &again,
            |path| read_bodies(path, MOST_ROWS),
            |path, rows| write_bodies(path, rows),
        ),
        b'c' => same(
            &path,
            &again,
            |path| read_contacts(path, BodyIds::of_box(MOST_ROWS)),
            |path, (contacts, across)| write_contacts(path, contacts, across),
        ),
        b'h' => rows::<HistoryRow>(&path, &again, HistoryRow::HEADER, HistoryRow::is_finite),
        b't' => rows::<TraceRow>(&path, &again, TraceRow::HEADER, |row| {
            (row.x + row.z).is_finite()
        }),
        _ => false,
    }
}

fn rows<T: Serialize + DeserializeOwned + Debug + PartialEq>(
    path: &Path,
    again: &Path,
    header: &[&str],
    finite: fn(&T) -> bool,
) -> bool {
    let read = |path| Rows::open(path, u64::from(MOST_ROWS))?.collect();
    let found: Result<Vec<T>, FileError> = read(path);
    let Ok(found) = found else {
        return false;
    };
    // Whoever reads such rows refuses the others.
    if !found.iter().all(finite) {
        return false;
    }
    write_rows(again, header, found.iter()).expect("a table that can be written");
    let second: Vec<T> = read(again).expect("what was accepted once");
    assert_eq!(second, found);
    true
}

fn same<T: Debug + PartialEq>(
    path: &Path,
    again: &Path,
    read: impl Fn(&Path) -> Result<T, FileError>,
    write: impl Fn(&Path, &T) -> Result<(), FileError>,
) -> bool {
    let Ok(found) = read(path) else { return false };
    write(again, &found).expect("a table that can be written");
    assert_eq!(read(again).expect("what was accepted once"), found);
    true
}
