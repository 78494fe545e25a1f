"""How much of a scene goes into a page or a picture, with the reason for every number."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Limits:
    """Budgets of the reports."""

    page_points: int = 72_000  # of one page: 0.6 MB in base64, redrawn in some 10 ms without a graphics card
    cell_points: int = 20_000  # of a notebook's cell: 0.2 MB, so that a notebook of fifty stays small
    picture_points: int = 20_000  # of a moving picture: a third of a page's, there are thirty
    live_points: int = 150_000  # of a live page: what a laptop's graphics draw at once
    run_points: int = 34_000  # of a whole run, shared by its steps: a page of ten steps stays below 1.5 MB
    least_points: int = 150  # of an object, however many share the budget: fewer look like no surface
    fixed_share: float = 0.3  # of the points, that tables and shelves may take together
    finest: float = 0.0025  # [m] cells in which noise is averaged away; a spoon still has a rim
    normal: int = 26  # neighbours that a surface normal is fitted to: a patch of a centimetre
    guessed: float = 0.008  # [m] from all that was seen: twice the spacing of the completed surface
    largest: int = 130  # part of a picture's height that a disc may have: larger ones take seconds
    parts: float = 0.006  # [m] between points of what is drawn from its convex parts
    outline: float = 0.003  # [m] by which a drawn hull may differ: a pixel or two, and few enough edges
    crease: float = 3.0  # [degrees] between facets whose edge is drawn
    graph_edges: int = 60  # arrows above which a graph shows its transitive reduction, and says so
    matrix: int = 20  # objects up to which a page has the square of relations: a column wide
    arm_triangles: int = 3500  # of an arm, most of which are used: some 50 kB, once a page
    exposed: float = 150.0  # mean over objects of their brightest channel: darker photos are lightened
    widest: float = 0.05  # [m] between points of a surface: those of a table that shares few with many
    rows: int = 40  # of a live table of relations: more push the sliders out of sight
    path_points: int = 80  # of a drawn tool path


LIMITS = Limits()
