//! Pictures of triangle meshes, traced with halfline.
