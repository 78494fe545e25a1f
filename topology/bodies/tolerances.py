"""Thresholds of bodies, each with its unit and reason, by the module that asks them."""

# -- complete

BARE = 0.01
"""A place on the hull this far [m] from every point has no surface near it: twice a cloud's spacing."""

MOUTH = 0.1
"""Share of the hull's surface that is mouth from which a body counts as hollow: a mug's is a sixth."""

COMPLETE_CLOSED = 0.6
"""Share of the underside with points on it from which a cloud without viewpoints counts as whole."""

LARGEST = 4.0
"""Surface [m²] of the box around a body beyond which nothing is guessed of it: a crate of 80 cm has less, and
no arm takes more. A guess has a point every few millimetres, of a room it would have a hundred million."""

REFUTED = 0.35
"""Share of a guess that lies in space seen to be empty, from which the symmetry behind it is given up."""

ROUND_REFUTED = 0.25
"""The same for a round body, whose own outline leaves nothing to be refuted but noise."""

OUTSIDE = 0.8
"""Share of the seen points that are on the outside of a round body: noise turns some at its outline."""

PLACES = 400
"""Places on a hull that are looked at: a mouth of a tenth of its surface is 40 of them."""

PLATE = 0.3
"""Height, as a share of its width, below which a hollow body is called a plate, and a round one no can."""

BOXY = 0.035
"""Distance of points from their box, as a share of its length, below which a body is called a box: half of
those above, in real frames, were round."""

BOWL = 0.2
"""Share of its hull that is a bowl's mouth: 0.22 to 0.27 in real frames; a box behind others had 0.15."""

UPRIGHT = 0.75
"""Height, as a share of its width, of cups and balls: bowls upside down have half."""

KEPT_BODIES = 100
"""Bodies of which what was worked out is kept, some 0.3 MB each: ten scenes of ten things."""

KEPT_FRAMES = 8
"""Tables whose sides' directions are kept."""


# -- completed

RAGGED = 0.008
"""[m] the seen underside of a flat foot is uneven by: three times the noise of a depth camera."""

BENT = 0.06
"""Of a body's height is at most taken for noise: a ball's underside so high is a quarter as wide."""

COMPLETED_LEVEL = 0.5
"""Of its outline has to be that low: then it is a foot, not a rounding."""

SPACING = 0.006
"""[m] between the points of an underside that is looked at."""


# -- model_registration

ORIENTATIONS = 576
"""Orientations tried: each is within some 20 degrees of one of them, and a fit settles from as far."""

STAGES = ((40, 48, 6, 0.03, False), (16, 150, 8, 0.02, True), (6, 400, 12, 0.008, True))
"""Of each stage the poses kept, the points of either side looked at, the rounds, from where on points are not
matched [m], and whether points of the model that cannot be there count: from outlines down to depth noise."""

SLIDING = 0.1
"""Weight of a match's way along the surface, where its way to the surface weighs 1: points between the
model's own hold a fit back."""

AGAINST = 1.0
"""A point of the model that cannot be there counts as much as one that was seen and is far from it."""

OFF = 0.008
"""[m] from where on a seen point is simply off: four times the noise of a depth camera."""

CLOSE = 0.003
"""[m] within which a seen point is on the model: twice the noise of a depth camera at 1 m."""

TRIMMED = 0.9
"""Share of the seen points whose distances make the residual: a tenth may fly at outlines."""

ALIKE = 0.02
"""Costs that differ by less are of poses that fit alike."""

SETTLED = 0.15
"""Cost of a fit from which on it is looked for again, from more places: right ones cost a third."""

MOST_STARTS, FEW = 1000, 48
"""Poses that are followed then, and the points by which they are chosen."""

SLIDES = (-0.5, -0.25, -0.12, 0.12, 0.25, 0.5)
"""Shares of a model's extents by which fits are shifted: what hides an end hides how far it reaches."""

ALL_BUT_ENDS = 0.95
"""Share of a surface that tells how far it is from another: a shift along a rod moves its ends alone."""

FARTHEST_STEP = 0.3
"""Largest turn [rad] of one round, beyond which its equations, linear in turns, say little."""

TOLD_APART_BY = 4
"""Poses looked at for each that is kept: many are one and the same."""

SEEN_SPACING = 0.003
"""[m] of the seen points that a model is registered with: what a depth camera sees at 1.5 m."""

SEEN_THROUGH = 0.006
"""[m] by which a camera saw further than a point of a model that cannot be there: three times its noise."""

AGREED = 0.3
"""Length of the mean of the directions that cameras look in from which on they have a side in common."""

INTO = 0.008
"""[m] by which a model may be in what it stands on: noise of both."""

MODEL_FEWEST = 40
"""Points that were seen of an object, 3 mm apart, for its model to be registered: a square of 2 cm."""

MODEL_RESIDUAL = 0.0035
"""Largest residual of a fit [m]: noise of a depth camera leaves 1 to 2 mm, another shape more."""

MODEL_INLIERS = 0.8
"""Smallest share of the seen points within 3 mm of the model: nine tenths are, but for flying ones."""

MODEL_SEEN_THROUGH = 0.08
"""Largest share of the model that may be where cameras looked through: outlines are off by a pixel."""

AMBIGUOUS = 0.01
"""[m] between the surfaces of two poses that fit alike from which on neither is taken."""


# -- parts

FRACTIONS = (0.25, 0.5, 0.75)
"""Where cuts are tried along each axis, as quantiles of the points: enough to find a handle or a wall."""

PARTS_FEWEST = 12
"""Points below which a piece is not cut again: its hull follows single points."""

SECTION = 0.9
"""Cosine above which a face by a cut is the cut's own section, where a solid has no surface."""

SEARCHED = 300
"""Points that judge a cut: its hulls then take half a millisecond."""

FACE_SAMPLES = 192
"""Places on a hull that are compared with the cloud: with half as many 10 of 80 trays
have a lid over their rims, with these 5."""

OUTLINE = 400
"""Points of the whole object that tell whether it goes on beyond a cut."""


# -- plates

THICK = 0.006
"""Both faces of a thin wall and the depth noise of each belong to one plate [m]."""

AROUND = 0.02
"""A plate's direction is taken from the points this close together [m]."""

PLATES_LEAST = 0.04
"""Share of the points a plate has at least; what is left over is cut into convex parts."""

PATCH_FEWEST = 4
"""Points of a part that closes a gap between two: fewer have no volume."""

RIM_FEWEST = 6
"""Points of a part of it: 3 cm of a rim that is one averaged point wide."""

SKY = 10.0
"""[m] above a thing that never moves, from where whatever of it looks up shows."""

TRIES = 150
"""Points that a plate is looked for at: a wall with a twentieth of all points is not missed."""


# -- solids

GRAIN = 0.003
"""Cubes whose points are averaged before hulls are drawn: halves 1-2 mm of depth noise [m]."""

HOLLOW = 0.008
"""Hulls may stand out from the points by this: less cuts noise into pieces [m]."""

SLAB = 0.05
"""A table seen from above is taken to be this thick: fingers must not come out below it [m]."""

BOARD = 0.02
"""A board above another is at least taken to be this thick: depth noise would leave less [m]."""

SKIN = 0.01
"""Points of a slab's faces and edges lie this close to it: depth noise [m]."""

SOLIDS_CELL = 0.01
"""Grid on which what lies below an object is looked up [m]."""


# -- tops

FLAT = 0.02
"""A cloud no thicker than this is one surface: depth noise is 2-4 mm [m]."""

TOPS_CELL = 0.01
"""Edge of the cells of a plan view: a third of the disc that has to fit [m]."""

TOPS_LEVEL = 0.9
"""Cosine of the largest angle of a top with the level plane: up is known to some degrees."""

VOTE = 0.003
"""Points this close to a plane speak for it: more would count both faces of a thin board [m]."""

WIDEST_BAND = 0.01
"""Points of one level lie within this of its plane at most, where noise is larger than `DEPTH_NOISE` [m]."""

FACES = 0.003
"""The faces of a board are at least this far apart: a thinner one is a sheet [m]."""

TWO_FACED = 4.0
"""Distance of two faces over the spread of each: 2.7 for one normal spread, 3.5 for an even one."""

TOPS_LEAST = 0.01
"""Share of a cloud that a level has at least."""

MOST_LEVELS = 24
"""Both faces of a dozen boards."""

TOPS_FEWEST = 8
"""Points that a level has at least."""

MISSES = 3
"""Planes in a row with no level in them after which there is none left: they cut walls."""

HALF_WIDTH = 0.03
"""A disc of this radius fits on a top: the rim of a bin and the edge of a wall have none [m]."""

ROOM = 0.05
"""Two levels closer than this are the faces of one board: nothing goes in between [m]."""

FILLED = 0.5
"""Share of its outline that a level fills: the rim of a bin has a hole in it."""

OVERLAP = 0.5
"""Share of a level that lies under another one for the two to be parts of one board."""

SECTORS = 24
"""Directions from a level's middle in which walls are looked for."""

TOPS_CLOSED = 23
"""Of them with walls all the way up: no way in."""

WALLED = 15
"""Of them with walls on a level that is open above: a bin."""

RAISED = 0.03
"""A rim lower than this makes no bin [m]."""

SUNK = 0.02
"""An object's lowest point may lie this far below the top that carries it: noise of both [m]."""

MOST_CELLS = 400
"""Cells along each axis of a board's plan: 4 m of a shelf at 1 cm; a larger one has larger cells."""

ROUNDS = 10
"""Rounds of fitting a plane to the points about it: it settles in half as many."""


# -- matter

BRIDGED = 0.02
"""Width [m] of a gap that no plate reaches over: two cubes, as one may be without points."""

PLATE_FLAT = 0.02
"""Largest thickness [m] of a plate that is larger than that: a board of 1 cm seen from both sides, and noise;
at 1.5 cm such a screen fell into 315 pieces, at this it is one."""

PLATE_STRAYS = (0.02, 0.98)
"""Shares of a plate's points before and behind it that are noise."""

PLATE_SUNK = 0.003
"""Depth [m] of plates below what was seen, half the noise: what stands against a wall does not meet it."""

PLATE_BACK = 0.004
"""Least thickness [m] of a plate: how thick a wall is cannot be seen, and thin screens end there."""
