"""One scene of views whose camera poses are only roughly known: registered, on a ground, cut into objects."""
