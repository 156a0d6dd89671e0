use super::*;
use crate::engine::native::perturb::{Quantity, Switch};
use crate::engine::native::{Perturbation, run_case};
use crate::verify::{Line, Track};

fn tracks(rung: &Rung, fault: Option<Perturbation>) -> Option<Vec<Track>> {
    rung.cases
        .iter()
        .map(|case| run_case(case, fault).ok())
        .collect()
}

fn climb(rung: &Rung, fault: Option<Perturbation>) -> Option<Vec<Line>> {
    tracks(rung, fault).map(|tracks| (rung.judge)(&tracks))
}

fn notices(rung: &Rung, fault: Perturbation) -> bool {
    climb(rung, Some(fault)).is_none_or(|lines| lines.iter().any(|line| !line.holds()))
}

fn table() {
    for rung in rungs() {
        let start = std::time::Instant::now();
        let all = tracks(&rung, None).unwrap();
        let took = start.elapsed();
        let lines = (rung.judge)(&all);
        let steps: u64 = rung
            .cases
            .iter()
            .filter_map(|case| case.moments.last())
            .sum();
        println!(
            "{}: {} cases, {steps} steps, {took:?} + judge {:?}",
            rung.name,
            rung.cases.len(),
            start.elapsed() - took
        );
        for line in lines {
            let off = line.value - line.expected;
            println!(
                "  {:60} {:>22.15e} {:>22.15e} {:>10.2e} {:>9.4}",
                line.quantity,
                line.value,
                line.expected,
                line.tolerance,
                off / line.tolerance
            );
        }
    }
}

#[test]
fn matrix() {
    table();
    for rung in rungs() {
        print!("MATRIX {:32}", rung.name);
        for q in Perturbation::quantities() {
            let mut best = None;
            for e in 1..=13 {
                let s = 10f64.powi(-e);
                if notices(&rung, Perturbation::Sized(q, s)) {
                    best = Some(e);
                } else {
                    break;
                }
            }
            if let Some(e) = best {
                print!(" {q}=1e-{e}");
            }
        }
        for s in Perturbation::switches() {
            if notices(&rung, Perturbation::Switched(s)) {
                print!(" {s}");
            }
        }
        println!();
    }
}
