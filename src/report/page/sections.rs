//! Parts of the page that show the records of other jobs.

use serde::Serialize;

use crate::document::{Block, Document};
use crate::error::Error;
use crate::report::figure::{Figure, Page};
use crate::report::svg;
use crate::report::views::words;
use crate::reproduce::beside::{Beside, Stated};

/// A part of the page that shows the record of another job.
#[derive(Debug, Serialize)]
pub struct Section {
    id: &'static str,
    title: &'static str,
    html: String,
    /// Where the record comes from.
    stated: Stated,
}

/// All of them, with their figures.
pub struct Sections {
    /// Cost against error, stable steps, distributions.
    pub charts: Vec<Section>,
    /// The claims.
    pub claimed: Vec<Section>,
    /// Of all of them.
    pub figures: Vec<Figure>,
}

/// The parts that are there, in the order of the page.
pub fn sections(beside: &Beside) -> Result<Sections, Error> {
    let mut figures = Vec::new();
    let mut section = |id, title, part: Page, stated: &Stated| {
        figures.extend(part.figures);
        Section {
            id,
            title,
            html: part.html,
            stated: stated.clone(),
        }
    };
    let mut charts = Vec::new();
    if let Some(of) = &beside.tradeoff {
        let document = of.record.document();
        let title = "Cost against error";
        charts.push(section("cost", title, part(&document), &of.stated));
    }
    if let Some(of) = &beside.stability {
        let document = of.record.document();
        let title = "The largest stable time steps";
        charts.push(section("stability", title, part(&document), &of.stated));
    }
    let mut claimed = Vec::new();
    if let Some(of) = &beside.claims {
        let title = "The paper's claims about its simulations";
        let part = part(&of.record.summary());
        claimed.push(section("claims", title, part, &of.stated));
    }
    Ok(Sections {
        charts,
        claimed,
        figures,
    })
}

/// A document as a part of a page.
fn part(document: &Document) -> Page {
    let mut page = Page {
        html: format!("<p>{}</p>\n", words(&document.answer)),
        figures: Vec::new(),
    };
    for section in document.sections.iter().filter(|section| !section.details) {
        page.html += &format!(
            "<h3>{}</h3>\n<p>{}</p>\n",
            words(&section.title),
            words(&section.answer)
        );
        for block in &section.blocks {
            match block {
                Block::Table(table) => page.html += &table.html(),
                Block::Plot(plot) => {
                    let svg = svg(plot);
                    page.html += &format!(
                        "<figure id=\"fig-{name}\"><div class=\"scroll\"><div class=\"drawn\">{svg}</div></div><figcaption>{} \
                         <span class=\"files\"><a href=\"figures/{name}.svg\">SVG</a> \
                         <a href=\"figures/{name}.csv\">CSV</a></span></figcaption></figure>\n",
                        words(&plot.caption),
                        name = plot.name,
                    );
                    page.figures.push(Figure {
                        name: plot.name.clone(),
                        caption: plot.caption.clone(),
                        svg,
                        csv: plot.table().csv(),
                    });
                }
                Block::Text(_) | Block::Drawing(_) => {}
            }
        }
    }
    page
}
