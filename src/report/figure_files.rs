//! A figure as three files: SVG to edit, PNG to show, CSV with the numbers that are drawn.

use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock};

use resvg::tiny_skia::{Color, Pixmap, Transform};
use resvg::usvg::{self, Tree, fontdb::Database};

use super::chart::FONT;
use crate::error::Error;
use crate::files::write_whole;

/// Pixels of PNG for a unit of SVG.
pub const SCALE: f32 = 2.0;

/// The embedded font, whatever the SVG asks for: no font of the system is looked at, so that a figure has the
/// same bytes everywhere.
static FONTS: LazyLock<Arc<Database>> = LazyLock::new(|| {
    let mut fonts = Database::new();
    fonts.load_font_data(FONT.to_vec());
    for set in [
        Database::set_sans_serif_family,
        Database::set_serif_family,
        Database::set_monospace_family,
    ] {
        set(&mut fonts, "DejaVu Sans");
    }
    Arc::new(fonts)
});

/// Writes `name.svg`, `name.png` and `name.csv` into a folder that exists, each whole.
pub fn figure_files(
    folder: &Path,
    name: &str,
    svg: &str,
    csv: &str,
    scale: f32,
) -> Result<[PathBuf; 3], Error> {
    if csv.lines().nth(1).is_none() {
        return Err(Error::Report(format!("{name} has no numbers to draw")));
    }
    let pixels = png(svg, scale).map_err(|reason| Error::Report(format!("{name}: {reason}")))?;
    let paths = ["svg", "png", "csv"].map(|end| folder.join(format!("{name}.{end}")));
    for (path, bytes) in paths.iter().zip([svg.as_bytes(), &pixels, csv.as_bytes()]) {
        write_whole(path, bytes)?;
    }
    Ok(paths)
}

/// The drawing as PNG on white, `scale` pixels a unit.
pub fn png(svg: &str, scale: f32) -> Result<Vec<u8>, String> {
    let options = usvg::Options {
        fontdb: Arc::clone(&FONTS),
        font_family: "DejaVu Sans".to_owned(),
        ..usvg::Options::default()
    };
    let tree = Tree::from_str(svg, &options).map_err(|error| error.to_string())?;
    let [width, height] =
        [tree.size().width(), tree.size().height()].map(|length| (scale * length).ceil());
    if !(1.0..=20_000.0).contains(&width) || !(1.0..=20_000.0).contains(&height) {
        return Err(format!(
            "a picture of {width} by {height} pixels; take another scale"
        ));
    }
    let mut pixels = Pixmap::new(width as u32, height as u32)
        .ok_or_else(|| "no memory for its pixels".to_owned())?;
    pixels.fill(Color::WHITE);
    resvg::render(
        &tree,
        Transform::from_scale(scale, scale),
        &mut pixels.as_mut(),
    );
    pixels.encode_png().map_err(|error| error.to_string())
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
    use crate::report::frame;

    /// Pixels that are not white, of all.
    fn ink(png: &[u8]) -> usize {
        let pixels = Pixmap::decode_png(png).expect("a PNG");
        let white = |pixel: &&resvg::tiny_skia::PremultipliedColorU8| {
            pixel.red() > 250 && pixel.green() > 250 && pixel.blue() > 250
        };
        pixels.pixels().len() - pixels.pixels().iter().filter(white).count()
    }

    /// Every sign that figures use has a glyph of its own: a missing one leaves no ink, or the same box as any other.
    #[test]
    fn the_font_has_the_signs_that_figures_use() {
        let drawn = |sign: char| {
            let words = frame::text([10.0, 30.0], "start", &sign.to_string());
            png(&frame::whole([40.0, 40.0], "", &words), 2.0).expect("draws")
        };
        let missing = drawn('\u{4e2d}');
        for sign in "σΣθαφνπρ√∞≈½²³·–—×−≤≥°→«»′…⟨⟩AZaz09".chars()
        {
            let picture = drawn(sign);
            assert!(ink(&picture) > 4 && picture != missing, "{sign}");
        }
    }

    #[test]
    fn three_files_or_none() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let svg = frame::whole([30.0, 20.0], "x", &frame::text([2.0, 15.0], "start", "x"));
        let empty = figure_files(folder.path(), "empty", &svg, "x (m)\n", SCALE);
        assert!(
            empty
                .expect_err("no rows")
                .to_string()
                .contains("no numbers")
        );
        let broken = figure_files(folder.path(), "broken", "<svg", "x (m)\n1\n", SCALE);
        assert!(broken.is_err());
        assert_eq!(
            std::fs::read_dir(folder.path()).expect("is there").count(),
            0
        );
        let paths = figure_files(folder.path(), "good", &svg, "x (m)\n1\n", SCALE).expect("draws");
        let pixels = Pixmap::load_png(&paths[1]).expect("a PNG");
        assert_eq!((pixels.width(), pixels.height()), (60, 40));
    }
}
