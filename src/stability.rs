//! The stability map.

pub mod beds;
pub mod growth;
pub mod network;
pub mod scenes;
pub mod spectrum;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::case::Case;

    #[test]
    fn look() {
        let mut all = scenes::small();
        let n: u32 = std::env::var("N").map_or(500, |n| n.parse().unwrap());
        let t = std::time::Instant::now();
        all.push(beds::crystal(12).unwrap());
        println!("crystal {:.2}", t.elapsed().as_secs_f64());
        all.extend(beds::beds(n).unwrap());
        println!("beds {:.2}", t.elapsed().as_secs_f64());
        for scene in all {
            let snap = crate::engine::native::run_case(&Case { moments: vec![0], ..scene.case.clone() }, None).unwrap();
            let loads = crate::engine::native::loads(&Case { moments: vec![0], ..scene.case.clone() }, None).unwrap();
            let mf = snap[0].contacts.iter().map(|c| c.normal_force).sum::<f64>() / snap[0].contacts.len() as f64;
            let un: f64 = loads[0].iter().zip(&scene.case.bodies.mass).map(|(f, m)| (f[0] + m * scene.case.model.gravity[0]).hypot(f[1] + m * scene.case.model.gravity[1])).fold(0.0, f64::max);
            println!("max unbalanced / mean force {:.2e}", un / mf);
            let network = network::Network::of(&scene.case).unwrap();
            let limit = spectrum::limit(&network, 0.0);
            let d = growth::Disturbed::at_random(&scene.case, scene.axes).unwrap();
            let t = std::time::Instant::now();
            let f = d.undamped().unwrap();
            let fr = f.and_then(|f| d.damped(0.2, &f).unwrap());
            let la = spectrum::limit(&network, 0.2).dt;
            let mode = spectrum::top(&network, la * la, 2.0 * la);
            let m = growth::Disturbed::in_mode(&scene.case, &mode.vector).unwrap();
            let fd = f.and_then(|f| m.damped(0.2, &f).unwrap());
            println!("random {:?}", fr.map(|f| f.limit / la));
            println!("{} contacts {} pred {:.5e} closed {:.4} found {:?} {:?} damped {:?} | {:.2}s", scene.name, network.contacts(), limit.dt,
                scene.closed.as_ref().map_or(f64::NAN, |c| c.dt / limit.dt), f.map(|f| f.limit / limit.dt), f.map(|f| f.trials),
                fd.map(|f| f.limit / spectrum::limit(&network, 0.2).dt), t.elapsed().as_secs_f64());
        }
    }
}
