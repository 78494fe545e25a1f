"""Faults injected into runs: cameras, segmentation and arms that go wrong, and what becomes of the run."""
