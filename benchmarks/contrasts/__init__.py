"""Other models of where things lie and what must go first, to compare with."""
