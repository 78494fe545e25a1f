"""Whether scenes stand: a verdict per object, what carries it, and how far it is from falling."""
