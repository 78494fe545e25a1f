"""Pages and pictures for people: what was seen, what depends on what, what the arm did."""
