"""How objects lie in each other: the default rule, and relations of a scene."""
