"""How an order comes about, in pictures: dependencies, equilibrium, a swept lift, a hidden contact.

    python docs/figures/reasoning.py

What is drawn is what topple answered about the clouds; where it answers otherwise the script stops.
"""

from dataclasses import replace

import numpy as np
import trimesh
from PIL import Image, ImageDraw
from relations import box, sampled, vessel
from scipy.spatial import KDTree
from studio import BLUE, GREEN, GREY, INK, ORANGE, PAPER, RED, SOFT, Studio, beside, font, save

from topple.planner import order
from topple.planner.report.drawing import Drawing
from topple.planner.report.raster import Projection, render_clouds
from topple.robots import scenario
from topple.topology import Scene
from topple.topology.situation.situation import Situation
from topple.topology.statics.equilibrium import balance
from topple.topology.statics.tolerances import DENSITY

PURPLE = "#7d5ba6"
SCALE = 0.16
"""Length of an arrow per kilogram that it carries [m]."""
TABLE = box((0.5, 0.4, 0.02), (0, 0, -0.01))


def turned(mesh: trimesh.Trimesh, degrees: float, at: tuple[float, float, float]) -> trimesh.Trimesh:
    """The mesh turned about y, then moved [m]."""
    mesh.apply_transform(trimesh.transformations.rotation_matrix(np.radians(degrees), (0, 1, 0)))
    return mesh.apply_translation(at)


def scene_of(meshes: dict[str, trimesh.Trimesh]) -> Scene:
    """Clouds of everything, and of the table."""
    clouds = {name: sampled(mesh, 4000, seed=n) for n, (name, mesh) in enumerate(meshes.items())}
    return Scene({"table": sampled(TABLE, 8000), **clouds}, fixed=["table"], up=[0, 0, 1])


def dependencies() -> None:
    """A small scene with an arrow for each dependency, and its order with the reasons."""
    meshes = {
        "bowl": vessel(0.075, 0.06, 0.004, 0.5).apply_translation((-0.12, 0, 0)),
        "lemon": trimesh.creation.icosphere(4, 0.024).apply_translation((-0.12, 0, 0.0285)),
        "box": box((0.09, 0.1, 0.07), (0.06, 0, 0.035)),
        "tin": trimesh.creation.cylinder(0.03, 0.05, sections=64).apply_translation((0.055, 0, 0.095)),
        "board": turned(box((0.008, 0.09, 0.15), (0, 0, 0.075)), -32, (0.1545, 0, 0.0025)),
    }
    colours = {"bowl": BLUE, "lemon": "#e2b93b", "box": ORANGE, "tin": PURPLE, "board": GREEN}
    found = order(scene_of(meshes))
    view = Studio((800, 560))
    view.mesh(TABLE, GREY)
    for name, mesh in meshes.items():
        view.mesh(mesh, colours[name], 0.55 if name == "bowl" else 1)
        top = np.array([*mesh.bounds.mean(axis=0)[:2], mesh.bounds[1, 2]])
        aside = {
            "bowl": (-0.06, -0.06, 0.0),
            "box": (-0.03, -0.05, -0.03),
            "board": (0.05, -0.05, -0.07),
        }.get(name, (0, 0, 0.02))
        view.label(top + aside, f"{found.order.index(name) + 1}  {name}")
    picture = view.image((0.18, -0.72, 0.42), (0.02, 0, 0.03), 24)
    save(beside(picture, listed(found), titles=("what lies where", "what depends on what")), "dependencies")


def listed(found) -> Image.Image:  # an Order
    """The dependencies as arrows between names, and the order with its reasons."""
    image = Image.new("RGB", (560, 560), PAPER)
    pen = ImageDraw.Draw(image)
    for row, edge in enumerate(found.graph.dependencies):
        y = 40 + 62 * row
        pen.text((20, y), edge.first, font=font(26), fill=INK, anchor="lm")
        pen.line((150, y, 372, y), fill=RED, width=3)
        pen.polygon([(386, y), (368, y - 8), (368, y + 8)], fill=RED)
        pen.text((261, y - 16), str(edge.reason), font=font(18), fill=SOFT, anchor="mm")
        pen.text((400, y), edge.then, font=font(26), fill=INK, anchor="lm")
    y = 90 + 62 * len(found.graph.dependencies)
    pen.text((20, y), "a safe order", font=font(22), fill=SOFT)
    for row, sentence in enumerate(found.explanation):
        pen.text((20, y + 44 + 34 * row), sentence.split(" (")[0], font=font(19), fill=INK)
    return image


def equilibrium() -> None:
    """A plank over an edge: the forces that hold it with a can on its end, and none without."""
    block = box((0.12, 0.12, 0.08), (-0.06, 0, 0.04))
    plank = box((0.30, 0.08, 0.014), (0.03, 0, 0.087))
    can = trimesh.creation.cylinder(0.033, 0.09, sections=64).apply_translation((-0.075, 0, 0.139))
    pictures = []
    for meshes in ({"block": block, "plank": plank, "can": can}, {"block": block, "plank": plank}):
        scene = scene_of(meshes).weighed(
            masses={"plank": 0.2, "block": 1.0} | {"can": 0.4} if "can" in meshes else {}
        )
        statics = Situation.of(scene).statics
        held = balance(statics.weights, statics.contacts)
        if (held.deficit["plank"] > 0.05) is ("can" in meshes):
            raise SystemExit(f"plank: deficit {held.deficit['plank']:.2f} with {list(meshes)}")
        view = Studio((720, 480))
        view.mesh(
            TABLE.copy().apply_translation((0, 0, -1e-3)), GREY
        )  # below the block: two faces in one plane flicker
        for name, mesh in meshes.items():
            view.mesh(mesh, {"block": "#a8a297", "plank": ORANGE, "can": BLUE}[name], 0.5)
        to_world = statics.upright.rotation  # of rows
        for name in meshes:
            if name != "block":
                centre, pull = np.asarray(statics.weights[name].centre) @ to_world, statics.weights[name].mass
                view.arrow(centre, centre - (0, 0, SCALE * pull), INK)
        for contact, loads in zip(statics.contacts, held.loads, strict=True):
            for point, load in zip(contact.points @ to_world, loads, strict=True):
                if "can" in meshes and load > 0.02 and {contact.a, contact.b} == {"block", "plank"}:
                    view.arrow(point - (0, 0, SCALE * load * DENSITY / 1e3), point, RED)
        if "can" not in meshes:
            tip = trimesh.transformations.rotation_matrix(np.radians(16), (0, 1, 0), (0, 0, 0.08))
            view.mesh(plank.copy().apply_transform(tip), RED, 0.35)
        pictures.append(view.image((0.12, -0.86, 0.22), (0.0, 0, 0.075), 20))
    titles = ("with the can: forces hold everything", "without: no forces hold the plank")
    save(beside(*pictures, titles=titles), "equilibrium")


def swept_lift() -> None:
    """A plate under a bridge of two blocks and a bar, and the volume that it would pass."""
    plate = vessel(0.075, 0.018, 0.005, 0.6)
    blocks = [box((0.04, 0.06, 0.06), (x, 0, 0.03)) for x in (-0.12, 0.12)]
    bar = box((0.28, 0.03, 0.018), (0, 0, 0.069))
    found = order(scene_of({"plate": plate, "left": blocks[0], "right": blocks[1], "bar": bar}), "plate")
    if [
        str(edge.reason) for edge in found.graph.dependencies if (edge.first, edge.then) == ("bar", "plate")
    ] != ["blocking"]:
        raise SystemExit(f"the bar does not block the plate: {found.graph.dependencies}")
    pictures = []
    for lift in (0.0, 0.042):
        view = Studio((720, 520))
        view.mesh(TABLE, GREY)
        for block in blocks:
            view.mesh(block, "#a8a297")
        swept = trimesh.creation.cylinder(0.075, 0.16, sections=96).apply_translation((0, 0, 0.081))
        view.mesh(plate.copy().apply_translation((0, 0, lift)), BLUE)
        view.mesh(bar, RED if lift else ORANGE)
        if not lift:
            view.mesh(swept, GREEN, 0.2)
        else:
            view.arrow(np.array((0.0, -0.09, 0.0)), np.array((0.0, -0.09, lift)), GREEN)
        pictures.append(view.image((0.30, -0.86, 0.36), (0.0, 0, 0.065), 19))
    save(
        beside(
            *pictures, titles=("what the plate sweeps contains the bar", "so the lift would take it along")
        ),
        "swept_lift",
    )


def hidden_contacts() -> None:
    """What one camera sees of a pile, its bodies completed, and the contacts that were inferred."""
    with scenario("dishes", 0) as stage:
        image = stage.cameras[0].look(stage.world, np.random.default_rng(0))
    scene = Scene.from_images([image], fixed=stage.fixed, up=stage.up)
    statics = Situation.of(scene).statics
    to_world = statics.upright.rotation  # of rows
    if not any(contact.inferred for contact in statics.contacts):
        raise SystemExit("no contact was inferred")
    whole = Drawing.of(scene)
    side = whole.centre - whole.eye
    behind = whole.centre + np.array((0.75 * side[0] + 0.6 * side[1], 0.75 * side[1] - 0.6 * side[0], 0.3))
    pictures = []
    for guessed in (False, True):
        objects = [each for each in whole.objects if not each.fixed]
        if not guessed:
            objects = [replace(o, points=o.points[: o.seen], normals=o.normals[: o.seen]) for o in objects]
        drawing = replace(whole, objects=tuple(objects), eye=behind)
        view = Projection(drawing, 1440, 1040)
        image = Image.fromarray(render_clouds(drawing, view, (255, 255, 255)))
        pen = ImageDraw.Draw(image)
        for contact in statics.contacts:
            for x, y in view.pixels(contact.points @ to_world)[0] if guessed and contact.inferred else ():
                pen.ellipse((x - 13, y - 13, x + 13, y + 13), fill=RED, outline=PAPER, width=4)
        flat = {} if guessed else {each.name: view.pixels(each.points)[0] for each in drawing.objects}
        for name, spots in flat.items():  # where least of the others is near
            others = np.concatenate([them for other, them in flat.items() if other != name])
            x, y = spots[KDTree(others).query(spots)[0].argmax()]
            pen.text((x, y), name, font=font(36), fill=INK, anchor="mm", stroke_width=6, stroke_fill=PAPER)
        pictures.append(image.resize((720, 520)).crop((0, 190, 720, 520)))
    titles = ("seen by one camera, from behind", "hatched: completed; red: contacts inferred")
    save(beside(*pictures, titles=titles), "hidden_contacts")


if __name__ == "__main__":
    dependencies()
    equilibrium()
    swept_lift()
    hidden_contacts()
