//! The digest of the source changes with any change of the source.

#[path = "../source_digest.rs"]
mod source_digest;

use std::fs;
use std::path::Path;

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("a writable folder");
    for entry in fs::read_dir(from).expect("the source") {
        let path = entry.expect("an entry").path();
        let to = to.join(path.file_name().expect("a name"));
        if path.is_dir() {
            copy(&path, &to);
        } else {
            fs::copy(&path, &to).expect("room");
        }
    }
}

#[test]
fn a_changed_source_has_another_digest() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let source = place.path().join("src");
    copy(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &source);
    let digest = || source_digest::of_folder(&source).expect("readable");
    assert_eq!(digest(), grains::SOURCE_DIGEST, "a copy is the same source");
    // One operation of the kernel.
    let kernel = source.join("native/contact.rs");
    let text = fs::read_to_string(&kernel).expect("the contacts");
    let changed = text.replacen(" * ", " + ", 1);
    assert_ne!(changed, text);
    fs::write(&kernel, changed).expect("writable");
    assert_ne!(digest(), grains::SOURCE_DIGEST);
    fs::write(&kernel, &text).expect("writable");
    assert_eq!(digest(), grains::SOURCE_DIGEST);
    // A file of the same bytes under another name, and one more file.
    fs::rename(&kernel, source.join("native/contacts.rs")).expect("writable");
    assert_ne!(digest(), grains::SOURCE_DIGEST);
    fs::rename(source.join("native/contacts.rs"), &kernel).expect("writable");
    fs::write(source.join("more.rs"), "").expect("writable");
    assert_ne!(digest(), grains::SOURCE_DIGEST);
}
