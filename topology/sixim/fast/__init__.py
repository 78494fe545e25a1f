"""Shortcuts that count the same matrix sooner."""
