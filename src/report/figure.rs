//! A figure of a page, and a page with its figures.

use std::path::Path;

use serde::Serialize;

use super::chart::{Chart, Mark, Series};
use super::figure_files::figure_files;
use super::svg::svg;
use crate::document::Colour;
use crate::error::Error;
use crate::files::{failed, write_whole};

/// The folder of a page's figures, beside the page.
pub const FOLDER: &str = "figures";
/// The page.
pub const PAGE: &str = "report.html";

/// A drawing, its words, and the numbers that are drawn.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figure {
    /// Of its files: `figure-1`; no two of a page have the same.
    pub name: String,
    /// What it shows.
    pub caption: String,
    /// The drawing, which needs nothing else.
    pub svg: String,
    /// The numbers that are drawn, as CSV with a head.
    #[serde(skip)]
    pub csv: String,
}

impl Figure {
    /// A chart of lines and circles; none where there is too little to draw.
    pub fn of_chart(name: &str, caption: &str, chart: &Chart) -> Result<Option<Self>, Error> {
        if !chart.can_be_drawn() {
            return Ok(None);
        }
        Ok(Some(Figure {
            name: name.to_owned(),
            caption: caption.to_owned(),
            svg: svg(&chart.plot(name, caption)),
            csv: chart.csv()?,
        }))
    }
}

/// A series through points.
pub fn line(name: &str, colour: Colour, points: Vec<(f64, f64)>) -> Series {
    Series {
        name: name.to_owned(),
        colour,
        mark: Mark::Line,
        points,
    }
}

/// A series of circles.
pub fn circles(name: &str, colour: Colour, points: Vec<(f64, f64)>) -> Series {
    Series {
        mark: Mark::Circles,
        ..line(name, colour, points)
    }
}

/// A page, or a part of one, with the figures on it.
#[derive(Debug, Clone, PartialEq)]
pub struct Page {
    /// As HTML.
    pub html: String,
    /// In the order of the page.
    pub figures: Vec<Figure>,
}

impl Page {
    /// Writes every figure as SVG and CSV into `folder`/figures, and then the page, which links to them.
    pub fn write(&self, folder: &Path) -> Result<(), Error> {
        let figures = folder.join(FOLDER);
        if !self.figures.is_empty() {
            std::fs::create_dir_all(&figures).map_err(failed("create", &figures))?;
        }
        for figure in &self.figures {
            figure_files(&figures, &figure.name, &figure.svg, &figure.csv)?;
        }
        write_whole(&folder.join(PAGE), self.html.as_bytes())?;
        Ok(())
    }
}

/// The numbers of an interval or range as cells.
pub fn cells(values: impl IntoIterator<Item = f64>) -> Vec<String> {
    values.into_iter().map(|value| value.to_string()).collect()
}
