//! The engine's answers against brute force and the textbook's tree, in all ways in which it can be asked.

mod batches;
mod border;
mod closed_surfaces;
mod columns;
#[path = "../common/mod.rs"]
mod common;
mod explain;
mod filters;
mod golden;
mod near_starts;
mod packets;
mod secondary_rays;
mod textbook_and_engine;
