//! Gives the crate the digest of its own source, so that results of two kernels are never taken for those of one.

mod source_digest;

fn main() -> std::io::Result<()> {
    println!("cargo::rerun-if-changed=src");
    println!("cargo::rerun-if-changed=source_digest.rs");
    let digest = source_digest::of_folder(std::path::Path::new("src"))?;
    println!("cargo::rustc-env=GRAINS_SOURCE_DIGEST={digest}");
    Ok(())
}
