//! Rays against triangles: a ladder of four rungs, each of which takes what the one before leaves open.
//!
//! 1. [`filter_f32`]: single precision, eight pairs at a time, with bounds on its errors. It tells which
//!    triangles are missed for certain, which are hit for certain, and between which two numbers t is. It is
//!    certain of nearly all.
//! 2. [`filter_f64`]: the same in double precision, from the user's own coordinates, for what is left.
//! 3. [`hit_f64`] and [`t_f32`]: t of a triangle that is known to be hit, correctly rounded, and the weights;
//!    of two that are nearly as near, this tells the nearer.
//! 4. [`numeric`](crate::numeric): exact signs, one triangle at a time, whatever it takes.
//!
//! **Invariant:** a rung may leave a pair open, but never says anything that exact arithmetic denies. So the
//! answers do not depend on where on the ladder a pair was decided, nor on the instruction set.

pub mod filter_f32;
pub mod filter_f64;
pub mod hit_f64;
pub mod t_f32;
