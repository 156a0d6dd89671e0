use crossgrain::{scene::*,generate::*,engine::{*,native,yade},tables::*};
#[derive(Default)]
struct O(Vec<Snapshot>);
impl Observer for O{ fn snapshot(&mut self,s:&Snapshot){ self.0.push(s.clone()); } }
fn main(){
 let a:Vec<String>=std::env::args().collect();
 let mut s=paper_scene(a[1].parse().unwrap(),a[2].parse().unwrap());
 if let Some(w)=a.get(4) {s.container.width=w.parse().unwrap(); s.cloud=Cloud::JitteredLattice{columns:(s.container.width*80.0) as u32,jitter:0.9,speed:0.3};}
 let steps:u64=a[3].parse().unwrap();
 let init=initial_bodies(&s);
 let task=if steps>0{Task::pour(init,steps)}else{Task::whole(init)};
 let mut on=O::default(); let mut oy=O::default();
 let n=native::run(&s,&task,&native::Options{skin:None,perturbation:None},&mut on).unwrap();
 println!("{:?}",n.stages);
 let w=tempfile::tempdir().unwrap();
 let y=yade::run(&s,&task,&yade::Options::default(),w.path(),&mut oy);
 let y=match y{Ok(y)=>y,Err(e)=>{println!("{e}");return}};
 println!("{:?}",y.outcome.stages);
 println!("frames {} {}",on.0.len(),oy.0.len());
 for (a,b) in on.0.iter().zip(&oy.0){
  let d=a.bodies==b.bodies; let p=a.punch==b.punch; let nc=(a.contacts.len(),b.contacts.len());
  let dc=a.contacts.iter().zip(&b.contacts).filter(|(a,b)|a!=b).count();
  println!("{} {} bodies {} punch {} contacts {:?} differ {}",a.stage.name(),a.step,d,p,nc,dc);
  if !p {println!("{:?} {:?}",a.punch,b.punch);}
  for (x,y) in a.contacts.iter().zip(&b.contacts).filter(|(a,b)|a!=b).take(3){println!("  {x:?}\n  {y:?}");}
 }
}
