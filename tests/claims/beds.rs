//! What is said of beds, and of how many of them there are.

use crossgrain::study::claims::Verdict;

use super::{claims_where, none_of, verdict};

#[test]
fn heights_are_read_by_definition() {
    let claims = claims_where(|truth| (truth.members, truth.heights) = (320, [0.462, 0.49, 0.44]));
    for id in ["height", "height_and_porosity"] {
        assert_eq!(
            verdict(&claims, id),
            Some(Verdict::HoldsUnderStatedChoices),
            "{id}"
        );
    }
    let claims = claims_where(|truth| {
        (truth.members, truth.heights, truth.porosity) = (320, [0.44; 3], 0.13)
    });
    none_of(&claims, "height porosity height_and_porosity");
}

/// Members without the force are counted, and nothing is said of means under load as if they were not.
#[test]
fn sunk_members_are_not_hidden() {
    let claims = claims_where(|truth| truth.missed = 0.3);
    assert_eq!(verdict(&claims, "reached"), Some(Verdict::CannotBeDecided));
    assert!((150..210).contains(&claims.endings["target load not reached"]));
    let rows = |id: &str| {
        let claim = claims.claims.iter().find(|claim| claim.id == id);
        claim.expect("the claim").rows.iter()
    };
    let packings = rows("mean.O").next().map(|row| row.packings);
    assert_eq!(packings, Some(claims.endings["reached"]));
}

#[test]
fn few_members_decide_nothing() {
    let claims = claims_where(|truth| truth.members = 20);
    assert!(!claims.complete);
    assert_eq!(claims.verdicts["undecided"], claims.claims.len());
    // None at all is no panic either.
    let none = claims_where(|truth| truth.members = 0);
    assert!(!none.complete);
    assert!(serde_json::to_string(&none).is_ok());
}
