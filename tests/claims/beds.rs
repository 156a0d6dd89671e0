//! What is said of beds, and of how many of them there are.

use crossgrain::study::claims::Verdict;

use super::truth::Truth;
use super::{NO, claims_of, verdict};

#[test]
fn heights_are_read_by_definition() {
    let truth = Truth {
        members: 320,
        heights: [0.462, 0.49, 0.44],
        ..Truth::paper()
    };
    let claims = claims_of(&truth);
    assert_eq!(
        verdict(&claims, "height"),
        Some(Verdict::HoldsUnderStatedChoices)
    );
    assert_eq!(
        verdict(&claims, "height_and_porosity"),
        Some(Verdict::HoldsUnderStatedChoices)
    );
    let truth = Truth {
        members: 320,
        heights: [0.44; 3],
        porosity: 0.13,
        ..Truth::paper()
    };
    let claims = claims_of(&truth);
    for id in ["height", "porosity", "height_and_porosity"] {
        assert_eq!(verdict(&claims, id), Some(NO), "{id}");
    }
}

/// Members without the force are counted, and nothing is said of means under load as if they were not.
#[test]
fn sunk_members_are_not_hidden() {
    let truth = Truth {
        missed: 0.3,
        ..Truth::paper()
    };
    let claims = claims_of(&truth);
    assert_eq!(verdict(&claims, "reached"), Some(Verdict::CannotBeDecided));
    assert!((150..210).contains(&claims.endings["target load not reached"]));
    let reached = claims.claims.iter().find(|claim| claim.id == "reached");
    let rows = &reached.expect("the claim").rows;
    let mut rows = rows.iter();
    assert!(rows.any(|row| row.what == "bias of height" && row.ours.is_some()));
    let mean = claims
        .claims
        .iter()
        .find(|claim| claim.id == "mean.O")
        .expect("the claim");
    assert_eq!(mean.rows[0].packings, claims.endings["reached"]);
}

/// Twenty members say nothing, and the record says so.
#[test]
fn few_members_decide_nothing() {
    let truth = Truth {
        members: 20,
        ..Truth::paper()
    };
    let claims = claims_of(&truth);
    assert!(!claims.complete);
    assert_eq!(claims.verdicts["undecided"], claims.claims.len());
    // None at all is no panic either.
    let none = claims_of(&Truth {
        members: 0,
        ..Truth::paper()
    });
    assert!(!none.complete);
    assert!(serde_json::to_string(&none).is_ok());
}
