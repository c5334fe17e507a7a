//! Winding numbers and containment, against solid angles in double-double arithmetic.

mod answers;
mod bits;
mod cases;
mod judge;
#[allow(dead_code)]
#[path = "../common/random.rs"]
mod random;
#[allow(dead_code)]
#[path = "../common/shapes.rs"]
mod shapes;
mod surface;
