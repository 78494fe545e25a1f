"""The seven relations in 3-D, each with the matrix that `topple.relate` counted, and hull against surface.

python docs/figures/relations.py
"""

import numpy as np
import trimesh
from PIL import Image, ImageDraw
from studio import BLUE, INK, ORANGE, PAPER, SOFT, Points, Studio, beside, font, save

from topple.topology import Relation, Scene, relate

DELTA = 0.002
"""The deviation factor δ [m]."""
COUNT = 1500
"""Points of a cloud."""
CELLS = (("A∩B°", "A∩∂B", "A∩B⁻"), ("A°∩B", "∂A∩B", "A⁻∩B"))


def box(size: tuple[float, float, float], centre: tuple[float, float, float]) -> trimesh.Trimesh:
    """An axis-aligned box [m]."""
    return trimesh.creation.box(size, trimesh.transformations.translation_matrix(centre))


def vessel(radius: float, height: float, wall: float, foot: float = 1.0) -> trimesh.Trimesh:
    """An open jar, or a bowl where `foot`, its share of the radius, is below 1 [m]."""
    h = np.linspace(0, 1, 24)
    outer = np.stack([radius * (foot + (1 - foot) * np.sqrt(1 - (1 - h) ** 2)), h * height], axis=1)
    inner = np.maximum(outer[::-1] - [wall, 0], [0, wall])
    return trimesh.creation.revolve(np.vstack([[[0, 0]], outer, inner, [[0, wall]]]), sections=96)


def sampled(mesh: trimesh.Trimesh, count: int = COUNT, seed: int = 0) -> Points:
    """Points spread evenly over a mesh [m]."""
    return np.asarray(trimesh.sample.sample_surface(mesh, count, seed=seed)[0])


def pairs() -> dict[Relation, tuple[trimesh.Trimesh, trimesh.Trimesh]]:
    """A and B of each relation."""
    bowl, jar = vessel(0.09, 0.075, 0.004, 0.45), vessel(0.042, 0.1, 0.003)
    ball = trimesh.creation.icosphere(4, 0.026).apply_translation((0, 0, 0.035))
    rod = trimesh.creation.cylinder(0.011, segment=[(-0.008, 0, 0.012), (0.02, 0, 0.18)], sections=64)
    across = box((0.2, 0.045, 0.04), (0, 0, 0.02))
    return {
        Relation.DISJOINT: (
            box((0.07, 0.07, 0.07), (-0.07, 0, 0.035)),
            box((0.07, 0.07, 0.1), (0.06, 0, 0.05)),
        ),
        Relation.TOUCH: (box((0.09, 0.09, 0.05), (0.012, 0, 0.095)), box((0.13, 0.11, 0.07), (0, 0, 0.035))),
        Relation.CROSS: (across, box((0.045, 0.2, 0.04), (0, 0, 0.028))),
        Relation.WITHIN: (ball, bowl),
        Relation.PARTIAL_WITHIN: (rod, jar),
        Relation.CONTAIN: (bowl, ball),
        Relation.PARTIAL_CONTAIN: (jar, rod),
    }


def gallery() -> None:
    """One picture per relation."""
    for relation, (a, b) in pairs().items():
        cloud_a, cloud_b = sampled(a, seed=1), sampled(b, seed=2)
        found = relate(Scene({"A": cloud_a, "B": cloud_b}), deviation=DELTA, plain=True).between("A", "B")
        if found.relation is not relation:
            raise SystemExit(f"{relation}: the clouds are {found.relation}, {found.matrix.tolist()}")
        view = Studio((680, 460))
        apart = relation in (Relation.TOUCH, Relation.DISJOINT)  # nothing is hidden inside the other
        for mesh, cloud, colour in ((a, cloud_a, ORANGE), (b, cloud_b, BLUE)):
            view.mesh(mesh, colour, 1 if apart else 0.4)
            view.points(cloud, INK if apart else colour, 3 if apart else 5)
            if not apart:
                view.hull(cloud, colour, 0.06)
        tall = 0.085 if "partial" in relation else 0.04
        picture = view.image((0.36, -0.52, 0.34), (0, 0, tall), 16 if tall < 0.06 else 19)
        save(
            beside(picture, table(relation, np.asarray(found.matrix))),
            f"relation_{relation.replace(' ', '_')}",
        )


def table(relation: Relation, matrix: np.ndarray) -> Image.Image:
    """The matrix as six cells, filled where there are points, and the relation under it."""
    image = Image.new("RGB", (440, 460), PAPER)
    pen = ImageDraw.Draw(image)
    wide, high, left, top = 124, 92, 34, 96
    pen.text((left, 44), "R(A, B), points", font=font(22), fill=SOFT)
    for row in range(2):
        for column in range(3):
            count = int(matrix[row][column])
            x, y = left + column * wide, top + row * high
            fill = ("#fbe3d3", "#d9e7f4")[row] if count else PAPER
            pen.rectangle((x, y, x + wide, y + high), fill=fill, outline="#8a8f96", width=2)
            pen.text((x + 10, y + 8), CELLS[row][column], font=glyphs(17), fill=SOFT)
            colour = INK if count else "#8a8f96"
            pen.text((x + wide / 2, y + 58), str(count), font=font(30), fill=colour, anchor="mm")
    for row, (words, colour) in enumerate((("A", ORANGE), (str(relation), INK), ("B", BLUE))):
        x = (left + 20, left + 186, left + 352)[row]
        pen.text((x, 345), words, font=font(30), fill=colour, anchor="mm")
    return image


def glyphs(size: int):  # the default font lacks ∩, ° and ⁻
    """A font with the paper's signs: the one that matplotlib, which PyVista brings, carries."""
    from matplotlib.font_manager import FontProperties, findfont
    from PIL import ImageFont

    return ImageFont.truetype(findfont(FontProperties(family="DejaVu Sans")), size)


def hull_and_surface() -> None:
    """What either rule takes for a banana, with a box in its bend."""
    turn = np.linspace(0, 2 * np.pi, 40)
    slice_ = np.stack([0.09 + 0.018 * np.cos(turn), 0.018 * np.sin(turn)], axis=1)
    bent = trimesh.creation.revolve(slice_, angle=0.75 * np.pi, sections=64)
    ends = [(0.09 * np.cos(a), 0.09 * np.sin(a), 0) for a in (0, 0.75 * np.pi)]
    bent += sum(trimesh.creation.icosphere(4, 0.018).apply_translation(end) for end in ends)
    bent.apply_transform(trimesh.transformations.rotation_matrix(0.125 * np.pi, (0, 0, 1)))
    bent.apply_translation((0, -0.05, 0.018))
    side = box((0.045, 0.026, 0.03), (0, 0.0, 0.015))
    clouds = {"box": sampled(side, seed=3), "banana": sampled(bent, 4000, seed=4)}
    pictures, titles = [], []
    for plain in (True, False):
        found = relate(Scene(clouds, up=[0, 0, 1]), DELTA, plain).between("box", "banana").relation
        view = Studio((640, 420))
        view.mesh(side, BLUE)
        view.mesh(bent, ORANGE)
        if plain:
            view.hull(clouds["banana"], ORANGE, 0.25)
        pictures.append(view.image((0.10, -0.42, 0.34), (0, 0, 0.012), 21))
        titles.append(f"{'paper: convex hull' if plain else 'default: surface'}. Box {found} banana")
    save(beside(*pictures, titles=tuple(titles)), "rules")


if __name__ == "__main__":
    gallery()
    hull_and_surface()
