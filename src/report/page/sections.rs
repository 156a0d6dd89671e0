//! Parts of the page that show the records of other jobs.

use serde::Serialize;

use crate::error::Error;
use crate::report::figure::{Figure, Page};
use crate::report::{claims, pareto, stability};
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
    if let Some(of) = &beside.pareto {
        let part = pareto::part(&of.record)?;
        charts.push(section("cost", "Cost against error", part, &of.stated));
    }
    if let Some(of) = &beside.stability {
        let part = stability::part(&of.record)?;
        let title = "The largest stable time steps";
        charts.push(section("stability", title, part, &of.stated));
    }
    let mut claimed = Vec::new();
    if let Some(of) = &beside.claims {
        let part = claims::distributions(&of.record)?;
        let title = "Distributions of a grain's stress, with fits";
        charts.push(section("distributions", title, part, &of.stated));
        let part = claims::part(&of.record)?;
        let title = "The paper's claims about its simulations";
        claimed.push(section("claims", title, part, &of.stated));
    }
    Ok(Sections {
        charts,
        claimed,
        figures,
    })
}
