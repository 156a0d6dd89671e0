use grains::native::*;
use grains::task::Case;
use grains::variant::{self, *};
use verdict::{judge::*, starts::*};
fn main() {
    let n: u32 = std::env::args().nth(1).unwrap().parse().unwrap();
    let t = std::time::Instant::now();
    let reference = Reference::new(n, &mut |_| ()).unwrap();
    println!("reference {:?}", t.elapsed());
    let faults: Vec<String> = std::env::args().skip(2).collect();
    for f in faults {
        let t = std::time::Instant::now();
        let mut v = Variant::default();
        let mut opt = CaseOptions::default();
        let mut use_variant = true;
        for part in f.split(',') {
            let all = [
                ("g", Constant::GrainStiffness),
                ("w", Constant::WallStiffness),
                ("p", Constant::PunchStiffness),
                ("ks", Constant::ShearStiffness),
                ("mu", Constant::Friction),
                ("c", Constant::Dashpot),
                ("a", Constant::Damping),
                ("gx", Constant::GravityAcross),
                ("gz", Constant::GravityUp),
                ("dt", Constant::TimeStep),
                ("m", Constant::Mass),
                ("i", Constant::Inertia),
                ("r", Constant::Radius),
            ];
            let forms = [
                ("half", Form::FirstKick(0.5)),
                ("onehalf", Form::FirstKick(1.5)),
                ("before", Form::MovedBeforeKick),
                ("dv0", Form::DampingVelocity(0.0)),
                ("dv1", Form::DampingVelocity(1.0)),
                ("gu", Form::GravityUndamped),
                ("along", Form::DampingAlongVelocity),
                ("am", Form::ArithmeticMean),
                ("gm", Form::GeometricMean),
                ("w1", Form::WallMissing(1)),
                ("corner", Form::CornersMissing),
                ("late", Form::PunchLate),
                ("near", Form::LostNear(0.0097)),
                ("far", Form::LostFar(0.0103)),
                ("found", Form::FoundLate),
                ("old", Form::OldNormals),
                ("one", Form::OneSided),
                ("reset", Form::HistoryReset),
                ("turn", Form::HistoryNotTurned),
                ("limit", Form::NoCoulombLimit),
                ("arms", Form::WholeArms),
                ("sign", Form::TorqueSign),
                ("slip", Form::OtherSlip),
                ("new", Form::OtherNewContact),
                ("clip", Form::OtherClipping),
            ];
            if let Some((k, x)) = part.split_once('=') {
                let c = all.iter().find(|a| a.0 == k).unwrap().1;
                v = v.and(c, x.parse().unwrap());
            } else if let Some(of) = forms.iter().find(|a| a.0 == part) {
                v.forms.push(of.1);
            } else {
                use_variant = false;
                opt.mode = part.parse().unwrap();
            }
        }
        let mut engine = |cases: &[&Case]| -> Result<Vec<verdict::Answer>, ()> {
            Ok(cases
                .iter()
                .map(|c| {
                    if use_variant {
                        Ok(variant::run(c, &v))
                    } else {
                        run_case(c, opt).map_err(|e| e.to_string())
                    }
                })
                .collect())
        };
        let laws: &[LawKind] = if use_variant {
            &LawKind::ALL
        } else {
            &[LawKind::Springs]
        };
        let found = reference
            .judge(laws, &mut engine, &mut |p| {
                eprintln!("  {:?} {p}", t.elapsed())
            })
            .map_err(|_| ())
            .unwrap();
        println!(
            "### {f}: {:?} {:?} {:?}",
            found.verdict(),
            found.resolution,
            t.elapsed()
        );
        for s in &found.starts {
            println!(
                "   {:?} {:?} {:?} {:?}",
                s.law,
                s.start,
                s.verdict,
                s.farthest
                    .as_ref()
                    .map(|f| (f.ratio, f.step, f.quantity, f.grain, f.left_after))
            );
        }
        if f == "free" || f == "single" || f == "g=0" {
            for l in &found.limits {
                println!(
                    "   limit {} {:.1e} {:?} {:?}",
                    l.constant, l.smallest, l.law, l.start
                );
            }
        }
        for c in &found.causes {
            println!(
                "   cause {:?} explained {}: {}",
                c.law,
                c.explained,
                c.sentence()
            );
        }
    }
}
