//! The lecture made visible.
//!
//! The lecture claims three things: intersection takes nearly all the time; a kd-tree turns n into
//! log n; traversal is a matter of a few cases. [`study`] measures the first two on the user's own
//! machine and mesh, and [`explanation`] shows the third, ray by ray.

pub mod explanation;
mod markup;
pub mod number;
pub mod study;
