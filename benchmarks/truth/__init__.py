"""The gate of truth: how much of what simulation and people say of scenes topple says as well.

`pool` holds the scenes with their labels, made by the generators `piles`, `built` and `designed`; `views`
turns one into what topple is given; `answers` asks one version of topple in its own process; `counts` scores;
`gate` says what is refused. `topple bench truth` runs all of it.
"""
