"""Every threshold of the simulated world, with the reason for its value."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Tolerances:
    """Lengths in [m], times in [s] unless said otherwise.

    Attributes:
        time_step: 240 Hz, Bullet's own: what has fallen 5 cm goes 4 mm a step, as thick as a plate.
        solver_iterations: With 100 a stack of eight blocks stands, but a fork of 45 g held by its neck turns
            by 6 degrees in the hand in two seconds; with 250 it stays, but a box in the fingers of a linkage
            of six hinges shifts by 3 mm on its way; with 400 by 1 mm.
        solver_residual: Change of speeds in an iteration, squared, at which the solver stops before: at rest
            it does. Ten times less holds no better and makes piles settle more slowly.
        margin: Radius of the edges of simulated bodies: contacts are fast and steady while only margins
            overlap. More would round cutlery away.
        margin_share: Share of the thinnest part that the margin may be: a core must remain.
        seam: Parts of one body closer than this meet in a seam, which is no surface.
        contact: Shapes closer than this count as touching: a tenth of a depth camera's noise.
        still_speed: Speed in [m/s] below which a body rests: 0.3 mm in the time it must last.
        still_turn: Turning speed in [rad/s] below which a body rests: 1 degree in the time it must last.
        still_for: How long all must be slow; a body at the top of a swing is slow for less.
        floor_drop: Depth of the floor below a table: a usual table's height.
        cell: Spacing of the rays that sample a foreign world's surfaces.
        empty_jaw: Jaws that stop this much short of where they were told to close have something between:
            sheet steel, and five times what the encoders of their motors are off.
        stalled: Share of its force limit beyond which a jaw's motor is held up: one that moves or rests
            at its end takes a fiftieth; where linkages share the load, a third is left.
        grazing: Incidence in [rad] beyond which a depth camera mostly sees nothing (about 80 degrees).
        edge_jump: Depth step between neighbouring pixels that counts as an object's edge.
        inertia_decimals: To which moments of inertia [kg m^2] are rounded: a teaspoon has some 1e-6.
    """

    time_step: float = 1 / 240
    solver_iterations: int = 400
    solver_residual: float = 1e-8
    margin: float = 1e-3
    margin_share: float = 0.3
    seam: float = 2e-4
    contact: float = 5e-4
    still_speed: float = 2e-3
    still_turn: float = 0.07
    still_for: float = 0.15
    floor_drop: float = 0.75
    cell: float = 0.004
    empty_jaw: float = 5e-4
    stalled: float = 0.2
    grazing: float = 1.4
    edge_jump: float = 0.01
    inertia_decimals: int = 15


TOLERANCES = Tolerances()
