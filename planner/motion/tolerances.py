"""Thresholds of motion, each with its unit and reason, by the module that asks them."""

# -- cartesian

TURN = 0.05
"""[rad] between waypoints where the tool also turns."""


# -- collision

EDGE_STEP = 0.05
"""[rad] largest joint change between two checked states of an edge, the usual resolution."""

ROUNDED = 5e-5
"""How much less [m] than a state has is wanted near it: what is equal is not proven."""


# -- planner

CLEARANCE = 0.005
"""[m] kept to obstacles on the way: depth noise and tracking error, each some 2 mm."""

RELAXED = (1.0, 0.2, 0.0)
"""Shares of the clearance that are tried in turn: none is better than no motion."""

PATIENCE = (0.35, 0.2, 0.45)
"""Share of the rounds of a search that is spent on each."""


# -- trajectory

CORNER_SHARE = 0.25
"""Of the acceleration limits, for the jump of direction at a waypoint."""


# -- upright

STEP = 0.01
"""[rad] between states of an edge whose tilt is looked at."""

WITHIN = 0.6
"""Share of the tilt that states are turned back to: the rest is for the edges between them."""

# -- cartesian

SPACING = 0.01
"""[m] between waypoints: the tool strays less than 0.1 mm from the line in between."""

JUMP = 0.25
"""[rad] largest joint change between waypoints; more means another branch of solutions."""


# -- certificate

FIRST = 0.05
"""[rad] length of the first intervals, in the largest joint change."""

FINEST = 2e-4
"""[m] motion within an interval below which a pair that is still open is given to python-fcl."""

PIECES = 4
"""Parts an interval is divided into where a pair is open: fewer, larger batches than by halves."""

DEPTH = 12
"""Levels; a motion of a metre is below FINEST after 7."""

DIRECTIONS = 4
"""Separating directions tried for a pair before its interval is divided."""


# -- ompl_search

RANGE = 1.0
"""[rad] longest branch; beats OMPL's default of 20 % of the space in clutter."""


# -- planner

DIRECT = 16
"""Goals tried by a straight edge: the nearest with the first check, then the others at once."""

ATTEMPTS = 4
"""Searches with different seeds before a path that could not be certified is returned."""

ROUNDS = 5000
"""Batches of a dozen branches until a search gives up: 4 s. Of 30 ways round a wall each is found within 5,
of 69 with a Fetch in narrow places 64. OMPL then has as many iterations."""

ROUNDED_LIMIT = 5e-6
"""How far [rad] beyond a limit a state counts as within: URDFs write pi as 3.14159, goals do not."""


# -- shortcut

SHORTCUT_ROUNDS = 40
"""Batches before what is known must do."""

POINTS = 16
"""Points a path is divided into; 24 give paths 2 % shorter in twice the time."""

TRIES = 32
"""Alternatives checked with the best path in one batch: mostly one batch is then enough."""


# -- trajectory

PERIOD = 1 / 240
"""[s] sampling of a trajectory: one PyBullet step."""


# -- upright

UPRIGHT_ROUNDS = 12
"""Steps of turning back; tilts of 0.5 rad take five."""

DAMPING = 1e-3
"""Of the least squares that turn a state upright, in [rad²]: steps stay short where a joint hardly helps."""


# -- other_arm

GIVES_WAY = 0.005
"""[m] by which links of an arm that stands still are taken to be larger: a hand gives way as it closes."""

SPREAD = 0.04
"""[m] between points that stand for the surface of a link: less than a thin one is thick."""
