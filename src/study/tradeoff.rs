//! Cost against error: what each way of running the paper's scene costs, and what it does to the results.

pub mod convergence;
pub mod document;
pub mod judge;
pub mod plan;
pub mod quantities;
pub mod record;

use std::path::Path;

use super::machine::Folder;
use super::member::{Member, Members};
use super::realization::{Engines, Runner};
use super::report::Judged;
use super::specification::sound;
use super::{Outline, Study, StudyError};
use crate::engine::EngineError;
use plan::Plan;
use quantities::QUANTITIES;
use record::Tradeoff;

impl Study for Plan {
    const KIND: &'static str = "tradeoff";
    type Row = Member;

    fn count(&self) -> u64 {
        self.tasks().len() as u64
    }

    fn check(&self) -> Result<(), String> {
        sound(self.settings())
    }

    fn runner(&self, task: u64) -> Runner {
        self.task(task).0.specification.runner
    }

    fn identity(&self, task: u64) -> String {
        let (setting, cloud) = self.task(task);
        format!("{} {cloud}", setting.specification.digest())
    }

    fn run(&self, task: u64, engines: &Engines, work: &Path) -> Result<Member, EngineError> {
        let (setting, cloud) = self.task(task);
        let keep = |key: &str| QUANTITIES.iter().any(|of| of.key == key);
        Member::run(&setting.specification, cloud, engines, work, keep)
    }

    fn belongs(&self, task: u64, row: &Member) -> bool {
        let (setting, cloud) = self.task(task);
        row.realization == cloud && row.specification == setting.specification.digest()
    }

    fn same(first: &Member, second: &Member) -> bool {
        let timeless = |of: &Member| Member {
            cost: None,
            ..of.clone()
        };
        timeless(first) == timeless(second)
    }

    fn outline(&self, row: &Member) -> Outline {
        let settings = self.settings();
        let of = settings
            .into_iter()
            .find(|of| of.specification.digest() == row.specification);
        row.outline(of.map_or("", |of| &of.id))
    }

    fn judge(folder: &Folder<Self>) -> Result<Judged, StudyError> {
        let mut rows = Vec::new();
        folder.each(|_, row| rows.push(row))?;
        let members: Members = rows.into_iter().collect();
        let external = folder.plan.program.as_ref().map(|of| &of.described);
        let convergence = convergence::all().map_err(EngineError::Native)?;
        let record = Tradeoff::of(&folder.plan.study, &members, convergence, external);
        let document = record.document();
        Judged::of(Self::KIND, &record, document)
    }
}
