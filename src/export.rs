//! Run folders for other programs: ParaView (`vtk`) and archives (`archive`).

pub mod archive;
pub mod vtk;
