"""The constants of merging views, each with its reason."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Tolerances:
    """Lengths in metres, angles in radians.

    Attributes:
        reach: How far, level, a camera may be from where it is said to be: calibrations are off by 5 cm.
        turn: How far it may be turned about the vertical: by 5 degrees, and what levelling adds.
        tilt: How far the ground may be tilted against that of the first view, twice what poses are off by.
        ground: Points this close to the ground's plane belong to it: depth noise and a mat.
        highest: Above the ground nothing is part of the scene: lamps and people.
        around: So far from the middle of what stands there the ground is kept.
        fine: Edge of the cells that what stands there is thinned to: finer than its edges are seen.
        coarse: The same of the ground.
        probes: Points of a view that are looked up in the others for each pose that is tried.
        steps: Steps, half widths in steps, and where surfaces count as the same and as seen through, in each
            round of the search: from what a calibration is off by down to a depth camera's noise.
        match: How far a point may be from its partner in the last registration.
        same: A point this close to what another camera saw there is the same surface.
        through: Another camera that saw this much further was looking through the point: it is misplaced.
        conflict: Largest share of misplaced points in a registration: right ones stay below 5 %, for
            edges and noise, and poses off by two centimetres are above.
        residual: Largest root mean square of the distances to the same surfaces: a Kinect's is 2 to 3 mm.
        fewest: Points that a view has to have in common with the others for it to be registered.
        spread: Points whose neighbours are further away than those of most, by so many deviations, are stray.
        outliers: Largest share of them: clouds of more are noise.
        cell: Edge of the cells in which what stands there is cut into objects: its noise is averaged.
        link: Cells this close are neighbours: those beside each other and across a corner.
        crease: Share of a cell's neighbours that bend inwards from which it is a crease, linking nothing.
        shared: Share of an object's surface that two views have to share for it to be one object.
        convex: Neighbouring patches that bend inwards by more than this angle belong to two objects.
        smallest: Patches of a segment; smaller ones are crumbs, mostly of edges.
        crumbs: Largest share of what stands there that may be in no segment.
        near: Neighbours that a patch's plane is fitted to.
        flat: A label with a larger share of its pixels in the ground's plane may be the ground's.
        wide: It is where it has this share of all pixels too: no plate fills a sixth of a picture of a scene.
        level: Smallest share of a view's points in the ground's plane: below, another plane is as likely.
    """

    reach: float = 0.075
    turn: float = float(np.radians(10))
    tilt: float = float(np.radians(12))
    ground: float = 0.012
    highest: float = 0.5
    around: float = 0.6
    fine: float = 0.004
    coarse: float = 0.015
    probes: int = 400
    steps: tuple[tuple[float, float, int, float, float], ...] = (
        (0.015, float(np.radians(2.0)), 5, 0.010, 0.015),
        (0.005, float(np.radians(0.7)), 2, 0.008, 0.012),
        (0.002, float(np.radians(0.3)), 2, 0.006, 0.010),
    )
    match: float = 0.008
    same: float = 0.006
    through: float = 0.012
    conflict: float = 0.08
    residual: float = 0.004
    fewest: int = 150
    spread: float = 2.5
    outliers: float = 0.2
    cell: float = 0.006
    link: float = 0.011
    crease: float = 0.3
    shared: float = 0.15
    convex: float = float(np.radians(15))
    smallest: int = 25
    crumbs: float = 0.3
    near: int = 16
    flat: float = 0.8
    wide: float = 0.15
    level: float = 0.1


TOLERANCES = Tolerances()

# -- register

MISPLACED = 2.0
"""A point that was looked through counts as much as two that fit."""
