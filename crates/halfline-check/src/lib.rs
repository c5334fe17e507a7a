#![doc = include_str!("../README.md")]

pub mod topology;
pub mod watertight;
