//! Every verdict can go either way: members drawn from known laws, with one thing wrong at a time.

mod beds;
mod stresses;
mod truth;
mod verb;

use crossgrain::study::claims::{self, Claim, Claims, Origin, Verdict};

use truth::{Truth, members};

use crate::support::*;

/// With what the paper claims changed so.
fn claims_where(change: impl FnOnce(&mut Truth)) -> Claims {
    let mut truth = Truth::paper();
    change(&mut truth);
    let scene = paper_scene(1, 5000);
    let origin = Origin {
        command: "a test".to_owned(),
        engine: "drawn".to_owned(),
        plan: String::new(),
        members_digest: String::new(),
    };
    claims::of(&scene, &members(&scene, &truth), origin)
}

fn verdict(claims: &Claims, id: &str) -> Option<Verdict> {
    let found = every(claims).find(|claim| claim.id == id);
    found.unwrap_or_else(|| panic!("no claim {id}")).verdict
}

fn every(claims: &Claims) -> impl Iterator<Item = &Claim> {
    claims.claims.iter().chain(&claims.earlier)
}

/// Everything holds, or is undecided, except what is listed, which does not hold.
fn only(claims: &Claims, others: &str) {
    for claim in every(claims) {
        let as_wanted = match others.split_whitespace().any(|id| id == claim.id) {
            true => claim.verdict == Some(NO),
            false => matches!(claim.verdict, None | Some(Verdict::Holds)),
        };
        assert!(as_wanted, "{claim:#?}");
    }
}

/// All of these do not hold.
fn none_of(claims: &Claims, ids: &str) {
    for id in ids.split(' ') {
        assert_eq!(verdict(claims, id), Some(NO), "{id}");
    }
}

const NO: Verdict = Verdict::DoesNotHold;

#[test]
fn what_the_paper_claims_holds_if_it_is_true() {
    let claims = claims_where(|_| ());
    only(&claims, "");
    assert!(2 * claims.verdicts["holds"] > claims.claims.len());
    assert_eq!(claims.endings["reached"], 600);
    assert!(claims.other_choices.is_empty());
    assert_eq!(claims.figures.distributions.len(), 12);
    assert_eq!(claims.figures.volumes.len(), 6);

    // The p-values stand beside the effects. All statements are true: none is rejected after adjusting.
    let rows = claims.claims.iter().flat_map(|claim| &claim.rows);
    let all: Vec<_> = rows.flat_map(|row| &row.probabilities).collect();
    assert!(all.len() > 50, "{}", all.len());
    assert!(all.iter().all(|one| one.adjusted >= one.p));
    assert!(all.iter().all(|one| one.adjusted > 0.05), "{all:#?}");

    // Where none is true each could be, with room.
    let smallest = 1.0 / (claims::SAMPLES + 1) as f64;
    assert!(smallest * (all.len() as f64) < 0.02);
}
