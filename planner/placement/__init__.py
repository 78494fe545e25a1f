"""Where a thing can be put down: on the table, on or in another one, and how it stands there."""
