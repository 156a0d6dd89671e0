//! One binary; the modules say what they prove.

mod support;

/// What the fuzzers do with an input.
#[path = "../fuzz/src/lib.rs"]
mod readers;

mod architecture;
mod scene;

mod card;
mod corpus;
mod corpus_rules;
mod generate;
mod in_space;
mod itself;

mod emulated;
mod native;
mod soak;
mod standing_punch;

mod properties;

mod tables;

mod measure;
mod parts;
mod resume;
mod round_trips;

mod paper;

mod tradeoff;

mod campaign_compare;
mod candidates;
mod conventions;

mod broken_yade;
mod export;
mod figures;
mod flipped_bits;
mod folder;
mod full_disk;
mod fuzz_corpus;
mod hostile_bytes;
mod hostile_names;
mod hostile_pages;
mod hostile_paths;
mod hostile_scripts;
mod too_large;

mod compare;

mod verify;

mod search;

mod stability;
mod study;

mod bench;

mod browser;
mod regression;

mod answer;
mod campaign;
mod checks;
mod claims;
mod recorded_campaigns;

mod slurm;

mod cli;
mod docs;

mod orphans;
mod page;

mod conformance_table;
mod exec_adapters;
mod exec_engine;
mod field_tests;
mod fourth_engine;
mod live_faults;
mod strangers;

mod yade_driver;

mod yade_in_space;
mod yade_live;
mod yade_open;

mod python;
