use crossgrain::{scene::*,generate::*,engine::{self,*,native},tables::*};
struct O(u64);
impl Observer for O{ fn snapshot(&mut self,s:&Snapshot){
 let ke:f64=s.bodies.mass.iter().zip(s.bodies.vx.iter().zip(&s.bodies.vz)).map(|(m,(a,b))|0.5*m*(a*a+b*b)).sum();
 if s.step%self.0==0 {println!("{} {} t={:.3} KE={:.4} c={} {} F={:.1} d={:.4}",s.stage.name(),s.step,s.time,ke,s.contacts.len(),s.bodies.digest(),s.punch.map_or(0.0,|p|p.force),s.punch.map_or(0.0,|p|p.depth()));}
}}
fn main(){
 let a:Vec<String>=std::env::args().collect();
 let mut s=paper_scene(a[1].parse().unwrap(),5000);
 if let Some(v)=a.get(2){ s.loading.speed=v.parse().unwrap(); }
 if let Some(v)=a.get(3){ s.damping=Damping::Cundall{alpha:v.parse().unwrap()}; }
 if let Some(v)=a.get(4){ s.settle.kinetic_energy_fraction=v.parse().unwrap(); }
 let o=native::run(&s,&Task::whole(initial_bodies(&s)),&native::Options{skin:a.get(5).map(|v|v.parse().unwrap()),perturbation:None},&mut O(5000)).unwrap();
 println!("{:?} us/step {:?}",o.stages,o.stages.iter().map(|r|r.cpu_seconds/r.steps as f64*1e6).collect::<Vec<_>>());
 let h:f64=o.settled.as_ref().map_or(0.0,|s|2.0*s.bodies.z.iter().zip(&s.bodies.mass).map(|(z,m)|z*m).sum::<f64>()/s.bodies.mass.iter().sum::<f64>());
 println!("H2cm {h}");
 engine::native::first_contact_punch(&s,&o.last.bodies);
}
