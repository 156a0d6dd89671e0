//! One binary; the modules say what they prove.

mod support;

mod scene;

mod generate;

mod native;
mod standing_punch;

mod properties;

mod tables;

mod measure;
mod modes;

mod paper;

mod pareto;

mod campaign_compare;

mod export;
mod figures;
mod folder;

mod compare;

mod verify;

mod sensitivity;

mod stability;

mod bench;

mod browser;
mod regression;

mod campaign;
mod checks;
mod claims;
mod recorded_campaigns;

mod slurm;

mod cli;

mod page;

mod exec_adapters;
mod exec_engine;

mod yade_driver;

mod yade_live;
