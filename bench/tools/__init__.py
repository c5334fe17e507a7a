"""What a library or program that is compared does in a process and an environment of its own."""
