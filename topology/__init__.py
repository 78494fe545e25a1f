"""Where things are and how they lie in each other: clouds, hulls, relations, contacts and support."""
