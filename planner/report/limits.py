"""How much of a scene goes into a page or a picture, with the reason for every number."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Limits:
    """Budgets of the reports.

    Attributes:
        page_points: Points drawn on one page. At 6 bytes each, 8 in base64, this is about 0.6 MB, and
            a laptop redraws it in some 10 ms without a graphics card.
        cell_points: Points drawn in a notebook's cell: 0.2 MB, so that a notebook of fifty stays small.
        picture_points: Points drawn of a scene in a moving picture: a third of a page's, there are thirty.
        live_points: Points of the whole scene in a browser of its own: what a laptop's graphics draw at once.
        look_points: Points of a look in a Rerun file: one may zoom into twenty of them.
        rows: Rows of a live table of relations: more push the sliders out of sight.
        run_points: Points drawn in a whole run report, shared by its steps.
        least_points: Points an object keeps however many objects share the budget: fewer no longer
            look like a surface.
        fixed_share: Share of the points that tables and shelves may take together.
        finest: Edge in [m] of the cells in which a cloud is averaged before it is drawn: a depth camera's
            noise is smoothed away, and a spoon still has a rim.
        normal: Neighbours that a point's surface normal is fitted to: a patch of a centimetre.
        guessed: Surface farther in [m] than this from every point that was seen counts as guessed: more
            than twice the spacing of the completed surface.
        largest: A disc of a picture is at most this share of its height: larger ones take seconds.
        parts: Spacing in [m] of points of what is drawn from its convex parts.
        hull_vertices: Corners of a drawn hull. The hull of a noisy cloud has hundreds and its edges
            then hide the cloud; the farthest 36 keep its outline within a few percent.
        crease: Edges between hull facets closer in direction than this many degrees are not drawn.
        label: Characters of a name shown in a graph node; the whole name is in its tooltip.
        graph_edges: Above this many arrows a graph shows the transitive reduction, and says so.
        matrix: Objects up to which a page has the square of relations: a column wide.
        path_points: Points of a drawn tool path.
        arm: How far in [m] the drawn shape of a link may be from its convex parts: a pixel, at the size pages
            draw an arm.
        sure: Of steps with a smaller risk 2 of 100 move something else (one camera, 619 steps).
        guess: Of those with a greater one 18 of 100 do (135 steps), between the two 11 (689 steps).
    """

    page_points: int = 72_000
    cell_points: int = 20_000
    picture_points: int = 20_000
    live_points: int = 150_000
    look_points: int = 30_000
    rows: int = 40
    run_points: int = 160_000
    least_points: int = 150
    fixed_share: float = 0.3
    finest: float = 0.0025
    normal: int = 26
    guessed: float = 0.008
    parts: float = 0.006
    largest: int = 130
    hull_vertices: int = 36
    crease: float = 3.0
    label: int = 18
    graph_edges: int = 60
    matrix: int = 20
    path_points: int = 200
    arm: float = 0.003
    sure: float = 0.05
    guess: float = 0.3


LIMITS = Limits()
