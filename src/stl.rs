//! Triangles of STL files, text or binary.

use std::io::{Cursor, Read};
use std::path::Path;

use grains::obstacle::Triangles;
use grains::scene::Mesh;

use crate::files::regular;

/// The most triangles of a file.
const MOST: usize = 5_000;
/// Room for them as text.
const LARGEST: u64 = 1 << 22;
/// Of a binary file: what comes before the number of triangles, and what a triangle takes, bytes.
const HEADER: usize = 80;
const RECORD: usize = 50;

/// The triangles of this file, in m, or what is wrong with it.
pub fn triangles(folder: &Path, mesh: &Mesh) -> Result<Triangles, String> {
    let file = regular(&*folder.join(&mesh.path));
    let file = file.map_err(|error| format!("a file that can be read: {error}"))?;
    let mut bytes = Vec::new();
    let read = file.take(LARGEST + 1).read_to_end(&mut bytes);
    read.map_err(|error| format!("a file that can be read: {error}"))?;
    if bytes.len() as u64 > LARGEST {
        return Err(format!("an STL file of at most {LARGEST} bytes"));
    }
    let found = parsed(bytes)?;
    let moved = |vertex: [f32; 3]| {
        [0, 1, 2].map(|axis| f64::from(vertex[axis]) * mesh.scale + mesh.shift[axis])
    };
    Ok(found
        .into_iter()
        .map(|vertices| vertices.map(moved))
        .collect())
}

fn parsed(mut bytes: Vec<u8>) -> Result<Vec<[[f32; 3]; 3]>, String> {
    let count = bytes.get(HEADER..HEADER + 4);
    let count = count.map(|count| u32::from_le_bytes(count.try_into().expect("four bytes")));
    let length = |count: u32| (HEADER + 4) as u64 + RECORD as u64 * u64::from(count);
    match count.map(length) == Some(bytes.len() as u64) {
        // Some that are binary begin as text does, by which the reader tells them apart.
        true => bytes[0] = 0,
        // Of a longer one it would read the beginning.
        false if !bytes.starts_with(b"solid ") => {
            let wanted = "an STL file: text, or as long as its number of triangles says";
            return Err(wanted.to_owned());
        }
        false => {}
    }
    let wrong = |error: std::io::Error| format!("a whole STL file: {error}");
    let mut bytes = Cursor::new(bytes);
    let mut all = Vec::new();
    for triangle in stl_io::create_stl_reader(&mut bytes).map_err(wrong)? {
        if all.len() == MOST {
            return Err(format!("at most {MOST} triangles"));
        }
        let vertices = triangle.map_err(wrong)?.vertices.map(|vertex| vertex.0);
        if !vertices.iter().flatten().all(|number| number.is_finite()) {
            return Err(format!("finite numbers in triangle {}", all.len()));
        }
        all.push(vertices);
    }
    match all.is_empty() {
        true => Err("a file with triangles".to_owned()),
        false => Ok(all),
    }
}
