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
            its rim stands 0.2 up, a table bent by a depth camera 0.02.
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
    wall_slope: float = 0.05


TOLERANCES = Tolerances()
