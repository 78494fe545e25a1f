"""The closed loop: look, decide, act, judge."""
