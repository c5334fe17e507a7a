//! The halfline command.

fn main() {}
