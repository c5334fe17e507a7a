//! One ray's walk through the tree, as text, JSON, a page to step through, and a slice of the cells.
