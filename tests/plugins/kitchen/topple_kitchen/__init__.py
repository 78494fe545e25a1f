"""What another package adds to topple, one file for each group of entry points."""
