"""What studies and tools share."""
