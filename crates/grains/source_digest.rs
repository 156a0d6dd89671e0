//! The digest of a folder of source files: what the build script puts into `grains::SOURCE_DIGEST`, and what its test
//! takes of a changed copy.

use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

/// SHA-256, in hexadecimal, over the relative path, the length and the bytes of every file below `folder`, in the order
/// of their paths.
pub fn of_folder(folder: &Path) -> std::io::Result<String> {
    let mut files = Vec::new();
    gather(folder, &mut files)?;
    files.sort();
    let mut hash = Sha256::new();
    for path in files {
        let name = path.strip_prefix(folder).unwrap_or(&path);
        let bytes = std::fs::read(&path)?;
        hash.update(name.to_string_lossy().replace('\\', "/"));
        hash.update(format!("\0{}\0", bytes.len()));
        hash.update(&bytes);
    }
    Ok(hash
        .finalize()
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect())
}

fn gather(folder: &Path, files: &mut Vec<PathBuf>) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            gather(&path, files)?;
        } else {
            files.push(path);
        }
    }
    Ok(())
}
