"""A scene: what was seen of objects, checked."""
