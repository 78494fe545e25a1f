"""A scene with all that is known of it, each part worked out once."""
