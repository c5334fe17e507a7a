//! The reader of ray files, apart from the command that needs it, so that fuzzers reach it too.
//!
//! Not meant to be built upon: the library is `halfline`.

pub mod npy;
