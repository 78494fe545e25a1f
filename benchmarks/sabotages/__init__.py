"""Ways to spoil a plan, by what they spoil; `catalogue` lists them all."""
