//! One input that holds several files: after a line `--- NAME` comes the file of that name.

use std::path::Path;

const MARK: &[u8] = b"--- ";

/// The files of an input, in order.
pub struct Parts<'a>(Vec<(&'a [u8], &'a [u8])>);

impl<'a> Parts<'a> {
    /// Takes an input apart; what stands before the first name is in no file.
    pub fn of(input: &'a [u8]) -> Self {
        let mut parts: Vec<(&[u8], usize, usize)> = Vec::new();
        let mut at = 0;
        for line in input.split_inclusive(|byte| *byte == b'\n') {
            let end = at + line.len();
            match line.strip_prefix(MARK) {
                Some(name) => parts.push((name.trim_ascii(), end, end)),
                None => {
                    if let Some(last) = parts.last_mut() {
                        last.2 = end;
                    }
                }
            }
            at = end;
        }
        let part = |(name, from, to): (&'a [u8], usize, usize)| (name, &input[from..to]);
        Parts(parts.into_iter().map(part).collect())
    }

    /// The first file of this name.
    pub fn get(&self, name: &str) -> Option<&'a [u8]> {
        let bytes_of = |(_, bytes): &(&[u8], &'a [u8])| *bytes;
        self.0
            .iter()
            .find(|(found, _)| *found == name.as_bytes())
            .map(bytes_of)
    }

    /// The first file of this name as text.
    pub fn text(&self, name: &str) -> Option<&'a str> {
        std::str::from_utf8(self.get(name)?).ok()
    }

    /// Writes the files that have one of these names; what ends in `.gz` is packed on the way.
    pub fn write(&self, names: &[&str], folder: &Path) {
        for name in names {
            if let Some(bytes) = self.get(name) {
                // The line's end was put there by `join`.
                let numbers = name.ends_with(".bin").then(|| bytes.strip_suffix(b"\n"));
                let bytes = numbers.flatten().unwrap_or(bytes);
                let packed = name.ends_with(".gz").then(|| packed(bytes));
                put(folder, name, packed.as_deref().unwrap_or(bytes));
            }
        }
    }
}

/// The other way round: an input of these files.
pub fn join(parts: &[(&str, &[u8])]) -> Vec<u8> {
    let mut input = Vec::new();
    for (name, bytes) in parts {
        input.extend_from_slice(MARK);
        input.extend_from_slice(name.as_bytes());
        input.push(b'\n');
        input.extend_from_slice(bytes);
        if !bytes.ends_with(b"\n") && !bytes.is_empty() {
            input.push(b'\n');
        }
    }
    input
}

/// Packs bytes as `gzip` does.
pub fn packed(bytes: &[u8]) -> Vec<u8> {
    use std::io::Write;
    let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    packer.write_all(bytes).expect("memory takes it");
    packer.finish().expect("memory takes it")
}

/// A folder that goes away.
pub fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

/// Writes a file into a folder of ours.
pub fn put(folder: &Path, name: &str, bytes: &[u8]) {
    std::fs::write(folder.join(name), bytes).expect("a writable folder");
}
