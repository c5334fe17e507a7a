//! Triangle test, engines and exact references, against exact arithmetic that shares no code with them.

#[path = "../common/mod.rs"]
mod common;
mod engines;
mod references;
mod triangle;
