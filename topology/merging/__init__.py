"""Views whose camera poses are only roughly known, merged into one scene of objects on a ground."""
