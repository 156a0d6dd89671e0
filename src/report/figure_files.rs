//! A figure as two files: SVG to edit and to convert, CSV with the numbers that are drawn.

use std::path::{Path, PathBuf};

use crate::error::Error;
use crate::files::write_whole;

/// Writes `name.svg` and `name.csv` into a folder that exists, each whole.
pub fn figure_files(
    folder: &Path,
    name: &str,
    svg: &str,
    csv: &str,
) -> Result<[PathBuf; 2], Error> {
    if csv.lines().nth(1).is_none() {
        return Err(Error::Report(format!("{name} has no numbers to draw")));
    }
    let paths = ["svg", "csv"].map(|end| folder.join(format!("{name}.{end}")));
    for (path, text) in paths.iter().zip([svg, csv]) {
        write_whole(path, text.as_bytes())?;
    }
    Ok(paths)
}

/// A table with its head as CSV.
pub fn table<Row, Cell>(head: &[&str], rows: impl IntoIterator<Item = Row>) -> Result<String, Error>
where
    Row: IntoIterator<Item = Cell>,
    Cell: AsRef<[u8]>,
{
    let failed = |error: csv::Error| Error::Report(error.to_string());
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(head).map_err(failed)?;
    for row in rows {
        writer.write_record(row).map_err(failed)?;
    }
    let bytes = writer
        .into_inner()
        .map_err(|error| Error::Report(error.to_string()))?;
    String::from_utf8(bytes).map_err(|error| Error::Report(error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_files_or_none() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let empty = figure_files(folder.path(), "empty", "<svg/>", "x (m)\n");
        let error = empty.expect_err("no rows").to_string();
        assert!(error.contains("no numbers"), "{error}");
        let count = || std::fs::read_dir(folder.path()).expect("is there").count();
        assert_eq!(count(), 0);
        figure_files(folder.path(), "good", "<svg/>", "x (m)\n1\n").expect("writes");
        assert_eq!(count(), 2);
    }
}
