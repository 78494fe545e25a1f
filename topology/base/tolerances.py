"""Every threshold of the topology layer, with the reason for its value."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Tolerances:
    """Lengths in metres unless said otherwise.

    Attributes:
        plain_deviation: Deviation factor δ of the paper's rule where none is given. The paper gives no
            number, "usually equal to the deviation of point clouds" (section 3.2): that of a depth camera
            at a metre is about 2 mm.
        flat: A cloud thinner than this along an axis has no extent there. One micrometre is a
            thousand times finer than any depth sensor and well above float32 rounding at 10 m.
        least_deviation: Smallest estimated deviation: file formats round clouds to 0.1 mm, and two
            rounded surfaces in contact may then stand up to twice that apart.
        greatest_deviation: Largest estimated deviation; a coarser cloud says too little about
            contact, and a larger δ would swallow spoons and plates (2 mm to 3 mm thick).
        noise_factor: Deviation in standard deviations of the surface noise: 3 leaves one point in
            400 outside, which the counts below forgive.
        reach: Boxes further apart than this are not looked at closely. An object that hides its own
            underside, 5 cm to 7 cm high, may stand on what the camera sees this far below.
        stray_share: Share of a cloud below which a piece of its own is stray: the pixels of a mask's edge
            that show the neighbour are 2 % of a mask 200 pixels wide.
        interior_share: Share of a cloud that must lie inside the other before it counts: noise puts one
            point in 400 on the wrong side, the foot of a cup in a shallow plate is 5 % of it.
        exterior_share: Share of a cloud that must lie outside the other before it counts, for the same noise.
        wall_azimuths: Share of the directions around a point in which a container's wall must stand
            higher: a full turn less what the content or the near wall hides from one camera. A banana
            reaches about half a turn.
        wall_slope: Rise over run of the line of sight to the wall's top: from the middle of a dinner plate
            its rim stands 0.2 up, from one nested 14 mm above it 0.06, a table bent by a depth camera 0.02.
    """

    plain_deviation: float = 0.002
    flat: float = 1e-6
    least_deviation: float = 0.0005
    greatest_deviation: float = 0.004
    noise_factor: float = 3.0
    reach: float = 0.08
    stray_share: float = 0.03
    interior_share: float = 0.01
    exterior_share: float = 0.02
    wall_azimuths: float = 0.75
    wall_slope: float = 0.04


TOLERANCES = Tolerances()

DEPTH_NOISE = 0.006
"""How far [m] noise of a depth camera puts points off their surface: three sigmas of a Kinect at 1 m."""


# -- checks

LARGEST_EXTENT = 20.0
"""Longest object and table [m]: no object on a table, nor the table, is longer; millimetres always are."""

FARTHEST = 1e8
"""Largest coordinate [m]: beyond it float64 cannot tell a hundredth of a millimetre; no map's frame goes so
far."""

HEAVIEST = 1e6
"""Largest mass [kg]: of no object that an arm clears; products of it stay far from what float64 holds."""

CENTRE_OUTSIDE = 0.5
"""Share of an object's diagonal by which its centre of mass may be outside of the box around its points: most
of it may not have been seen, but a place given in another frame is further off."""

RIGID = 1e-3
"""How far a rotation may be from a rigid one: those stored as float32 or printed to four
digits are off by less."""


DUPLICATE_NEAR = 0.003
"""[m] within which points of a copy lie at those of what it is one of, noise of a depth camera included."""

DUPLICATE_SHARE = 0.7
"""Share of them at least that do: noise of 1 mm leaves 97 %, of 2 mm on dense clouds 70 %. Of two masks, that
of their pixels that both have: SAM too keeps one of two whose boxes share more."""

DUPLICATE_OFFSET = 0.0004
"""[m] by which a copy lies to one side at most: a card on a book lies by half its thickness above it."""

DUPLICATE_POINTS = 200
"""Points of a cloud that are asked: their mean tells a fifth of a millimetre."""


# -- cloud

NEIGHBOURS = 12
"""Points of a local plane: enough to fit one, few enough to stay on one face."""

REGION = 2000
"""Points of a dense cloud that are looked at, all from one place: noise hardly varies over an object."""

PROBES = 150
"""Points per cloud at which spacing and noise are measured."""

STRAY = 2.5
"""Usual distances that make a neighbour too far: sides seen at 80 degrees are 2.4 times as sparse."""

MOST_STRAYS = 0.1
"""Share of a cloud that strays are at most: cameras leave up to 3 % of them."""


# -- image

FARTHEST_DEPTH = 20.0
"""Greatest depth [m]: beyond the reach of any depth camera; a depth in millimetres is far above."""

LIKELY_AWAY = (0.2, 4.0)
"""[m] that the middle of a picture is away: nearer than a depth camera sees, and further than arms reach."""

OFF_CENTRE = 0.12
"""Share of a picture's side that K's centre lies off its middle at most: cameras come to 3 %."""

BENT = 1e-5
"""[m] by which planes are bent from which a raw z-buffer is told: above rounding; z-buffers have no noise."""

STRAIGHTER = 0.25
"""Share of that which remains if depth itself, not its inverse, is straight over the picture: metric depth of
slanted planes comes to several, of level ones to 1."""


# -- scene

LARGEST_HELD = 2.0
"""Longest thing that may move [m]: no arm takes a longer one; what is fixed may be as large as a hall."""

SMALLEST_SEEN = 0.001
"""Largest of a scene's things at least [m]: no scene is of things all smaller than a grain of rice."""

FEWEST_SEEN = 4
"""Points of an object at least: fewer pixels span no solid, and are as likely a mask's edge as an object."""


# -- situation

USUAL = 0.15
"""Size [m] of what lengths of statics are meant for: half of what is in a kitchen is 12 to 17 cm large."""

USUAL_SIZES = (0.075, 0.43)
"""Sizes [m] between which half of a scene's things lie that is asked about as it is."""


# -- upright

VOXEL = 0.003
"""Voxel edge [m]: half the thickness of a spoon's bowl, and fine enough that what is found hangs little on
where the cells begin."""

KEPT_AROUND = 0.06
"""Fixed surfaces are kept this far [m] around the objects: further ones carry nothing."""


# -- arrays

DECIMALS = 9
"""Of lengths and angles that decisions and simulations begin with: a nanometre is far below what is measured,
and far above what sums in another order leave."""
