"""What make bench-STUDY runs, a module for each."""
