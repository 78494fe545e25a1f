"""How much of a scene goes into a page or a picture, with the reason for every number."""

from dataclasses import dataclass

import numpy as np

from topple.planner.tolerances import DISTURBED, TURNED


@dataclass(frozen=True)
class Limits:
    """Budgets of the reports.

    Attributes:
        page_points: Points drawn on one page. At 6 bytes each, 8 in base64, this is about 0.6 MB, and
            a laptop redraws it in some 10 ms without a graphics card.
        run_points: Points drawn in a whole run report, shared by its steps.
        least_points: Points an object keeps however many objects share the budget: fewer no longer
            look like a surface.
        fixed_share: Share of the points that tables and shelves may take together.
        hull_vertices: Corners of a drawn hull. The hull of a noisy cloud has hundreds and its edges
            then hide the cloud; the farthest 36 keep its outline within a few percent.
        crease: Edges between hull facets closer in direction than this many degrees are not drawn.
        label: Characters of a name shown in a graph node; the whole name is in its tooltip.
        graph_edges: Above this many arrows a graph shows the transitive reduction, and says so.
        path_points: Points of a drawn tool path.
        risk: Risks below this chance are not mentioned: they are the same for every object, and distract.
        moved: Metres from which a disturbed object is shown in red: what counts as a violation.
        turned: Degrees from which it is.
    """

    page_points: int = 72_000
    run_points: int = 160_000
    least_points: int = 150
    fixed_share: float = 0.3
    hull_vertices: int = 36
    crease: float = 3.0
    label: int = 18
    graph_edges: int = 60
    path_points: int = 200
    risk: float = 0.05
    moved: float = DISTURBED
    turned: float = float(np.degrees(TURNED))


LIMITS = Limits()
