//! Exact signs, error bounds, and the rule that says what "hits" means.
