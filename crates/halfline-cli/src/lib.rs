//! The `halfline` command, so that a program in another language can be the same one: [`run`] is all of
//! it, and [`run_with`] what such a program adds. Besides that, its reader of ray files, where fuzzers reach it, and its understanding of the
//! options of a picture.
//!
//! Not meant to be built upon: the library is `halfline`.

mod arguments;
mod camera_options;
mod commands;
mod engine;
mod failure;
mod global_options;
mod host;
mod input;
mod interrupt;
pub mod npy;
mod npz;
mod one_line;
mod output;
mod picture;
mod program;
mod progress;
mod session;
mod source;
mod table;
mod temporary;
mod tree_options;
mod units;
mod values;

pub use host::{Cluster, Host};
pub use picture::render_settings;
pub use program::{run, run_with};
