"""A scene at rest: contacts, equilibrium, what falls, what carries what."""
