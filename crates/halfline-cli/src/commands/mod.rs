//! One file per subcommand: its options, and what it does.

pub mod build;
pub mod doctor;
pub mod explain;
pub mod generate;
pub mod info;
pub mod query;
pub mod render;
pub mod study;
