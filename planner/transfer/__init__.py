"""One object taken from here to there: grasp, ways in and out, carrying, and why it cannot be done."""
