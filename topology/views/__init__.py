"""Free space: what the cameras saw to be empty, and what they could not see."""
