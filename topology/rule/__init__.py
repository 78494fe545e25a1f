"""The default rule: relations that withstand noise, hidden surfaces and hollow objects."""
