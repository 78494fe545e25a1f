"""Orders, steps and whole plans."""
