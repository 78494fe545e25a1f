"""Every threshold of the topology layer, with the reason for its value."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Tolerances:
    """Lengths in metres unless said otherwise.

    Attributes:
        plain_deviation: The paper's deviation factor δ where none is given, its 2 mm (section 4).
        flat: A cloud thinner than this along an axis has no extent there. One micrometre is a
            thousand times finer than any depth sensor and well above float32 rounding at 10 m.
        largest_extent: A scene larger than this is surely in millimetres, not metres.
        least_deviation: Smallest estimated deviation: file formats round clouds to 0.1 mm, and two
            rounded surfaces in contact may then stand up to twice that apart.
        greatest_deviation: Largest estimated deviation; a coarser cloud says too little about
            contact, and a larger δ would swallow spoons and plates (2 mm to 3 mm thick).
        noise_factor: Deviation in standard deviations of the surface noise: 3 leaves one point in
            400 outside, which the counts below forgive.
    """

    plain_deviation: float = 0.002
    flat: float = 1e-6
    largest_extent: float = 20.0
    least_deviation: float = 0.0005
    greatest_deviation: float = 0.004
    noise_factor: float = 3.0


TOLERANCES = Tolerances()
