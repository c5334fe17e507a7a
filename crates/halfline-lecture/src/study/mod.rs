//! What a ray costs, as meshes grow: measured, fitted and reported.
