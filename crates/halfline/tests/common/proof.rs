//! How many rays the tests send, and what they say when none went wrong.

use std::io::Write;

use proptest::prelude::*;
use proptest::test_runner::{TestCaseError, TestRunner};

use super::contact::Case;
use super::engines::check_engines;
use halfline::Mesh;

/// How many rays the tests that count them cast in all; `make test-long` asks for more.
pub fn ray_budget() -> usize {
    std::env::var("HALFLINE_TEST_RAYS")
        .map_or(500_000, |rays| rays.parse().expect("HALFLINE_TEST_RAYS is a number of rays"))
}

/// Says what was proven, past the capturing of what tests print.
pub fn report(what: &str, rays: usize) {
    let digits = rays.to_string();
    let mut grouped = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            grouped.push(',');
        }
        grouped.push(digit);
    }
    writeln!(std::io::stderr(), "{what}: {grouped} rays, 0 wrong").expect("standard error");
}

/// A part of all rays.
#[derive(Clone, Copy, Debug)]
pub struct Share(pub f64);

impl Share {
    /// Four tenths: engine alone, at closed surfaces.
    pub const CLOSED_SURFACES: Share = Share(0.4);
    /// Two tenths: engine alone, from origins off the faces of hits.
    pub const SECONDARY_RAYS: Share = Share(0.2);
    /// Two tenths: engine and textbook against brute force.
    pub const ORACLE: Share = Share(0.2);
    /// Two tenths: all engines against the integer judge.
    pub const INTEGERS: Share = Share(0.2);

    /// How many rays that is.
    pub fn rays(self) -> usize {
        (ray_budget() as f64 * self.0).ceil() as usize
    }
}

/// Sends at least `rays` rays, by meshes with their cases, through all engines, and fails with the
/// smallest mesh for which one is wrong.
pub fn prove<S: Strategy>(
    what: &str,
    rays: usize,
    rays_per_mesh: usize,
    strategy: S,
    cases: impl Fn(&S::Value) -> (Mesh, Vec<Case>),
) {
    let sent = std::cell::Cell::new(0);
    let config = ProptestConfig {
        cases: rays.div_ceil(rays_per_mesh) as u32,
        failure_persistence: None,
        ..ProptestConfig::default()
    };
    let proof = TestRunner::new(config).run(&(strategy, 0..12usize), |(value, turn)| {
        let (mesh, cases) = cases(&value);
        sent.set(sent.get() + cases.len());
        check_engines(&mesh, &cases, turn).map_err(TestCaseError::fail)
    });
    if let Err(failure) = proof {
        panic!("{what}: {failure}");
    }
    assert!(sent.get() >= rays, "{what}: only {} rays of {rays}", sent.get());
    report(what, sent.get());
}
