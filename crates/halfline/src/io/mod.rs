//! Bytes to meshes and back: one file per format.
