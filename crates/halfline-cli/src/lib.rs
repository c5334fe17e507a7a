//! The `halfline` command, so that a program in another language can be the same one: [`run`] is all of
//! it, and [`run_with`] what such a program adds. Besides that, its reader of ray files, where fuzzers
//! reach it.
//!
//! Not meant to be built upon: the library is `halfline`.

// What only some subcommands need is not taken out piece by piece.
#![cfg_attr(not(feature = "default"), allow(dead_code))]

mod arguments;
mod camera_options;
mod commands;
#[cfg(feature = "query")]
mod engine;
mod failure;
mod global_options;
mod host;
mod input;
mod interrupt;
mod left_out;
#[cfg(feature = "query")]
pub mod npy;
#[cfg(feature = "query")]
mod npz;
mod one_line;
mod output;
mod program;
mod progress;
mod report;
mod session;
mod source;
mod table;
mod temporary;
mod tree_options;
mod values;

use halfline_explain::units;

pub use host::{Cluster, Host};
pub use program::{run, run_with};
