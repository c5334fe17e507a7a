//! What a program that has the command inside can do for it.

use std::path::Path;

use halfline::error::Result;
use halfline::progress::Observer;

/// The program around the command: Python, for the command of the wheel.
pub trait Host {
    /// Reaches the cluster at `address`.
    ///
    /// # Errors
    /// [`Error::Invalid`](halfline::Error::Invalid) if nobody answers there.
    fn connect(&self, address: &str) -> Result<Box<dyn Cluster>>;
}

/// Other machines, which trace rows of pictures.
pub trait Cluster {
    /// All rows of a picture, as [`Rows`](halfline_render::Rows) in bytes and in any order, traced of
    /// the tree file at `tree`. `settings` are [`RenderSettings`](halfline_render::RenderSettings) as
    /// JSON.
    ///
    /// # Errors
    /// [`Error::Interrupted`](halfline::Error::Interrupted) soon after `observer` asks for the end;
    /// [`Error::Invalid`](halfline::Error::Invalid) if the cluster cannot.
    fn trace(&self, tree: &Path, settings: &str, observer: &dyn Observer) -> Result<Vec<Vec<u8>>>;
}
