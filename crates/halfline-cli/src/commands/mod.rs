//! One file per subcommand: its options, and what it does.

pub mod build;
pub mod distance;
#[cfg(feature = "doctor")]
pub mod doctor;
pub mod explain;
pub mod generate;
pub mod info;
#[cfg(feature = "query")]
pub mod query;
pub mod render;
#[cfg(feature = "study")]
pub mod study;

#[cfg(not(feature = "doctor"))]
pub(crate) use crate::left_out as doctor;
#[cfg(not(feature = "query"))]
pub(crate) use crate::left_out as query;
#[cfg(not(feature = "study"))]
pub(crate) use crate::left_out as study;
