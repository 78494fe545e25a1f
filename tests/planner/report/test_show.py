import base64
import io
import json
import re
from html.parser import HTMLParser
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image
from scipy.spatial import KDTree

from topple.planner.decide.names import spoken_names
from topple.planner.decide.words import order_in_words
from topple.planner.report.drawing import Drawing
from topple.planner.report.figure import PAPER, RISE, SIZE, order_gif, show_picture
from topple.planner.report.graph import graph_file
from topple.planner.report.limits import LIMITS
from topple.planner.report.palette import RELATION_COLOURS, css, object_colours
from topple.planner.report.raster import Projection, render_clouds
from topple.planner.report.show import show_page
from topple.planner.report.tables import relation_matrix
from topple.topology.base.errors import InvalidInput
from topple.topology.geometry.thin import voxel_means
from topple.topology.relations.relate import relate
from topple.topology.scene.scene import Scene
from topple.topology.sixim.table import Relation


class Page(HTMLParser):
    """Counts the elements of a page, and those that were never closed."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.links, self.open, self.text = [], [], [], ""
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.links += [value for key, value in attrs if key in ("src", "href") and value]
        if tag not in ("meta", "input", "img", "br"):
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.tags.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data


def data_of(page):
    return json.loads(re.search(r'id="data">(.*?)</script>', page, re.DOTALL).group(1))


def test_the_page_is_well_formed_and_fetches_nothing(stack):
    page = show_page(*stack, title="a <title>")
    parsed = Page(page)
    assert parsed.open == []
    assert parsed.links == []
    assert "http" not in page.replace("http-equiv", "")
    assert "a &lt;title&gt;" in page


def test_names_are_escaped_and_still_shown_whole(stack):
    scene, relations, found = stack
    page = show_page(scene, relations, found)
    parsed = Page(page)
    nasty = scene.names[3]
    assert nasty in parsed.text
    assert parsed.tags.count("script") == 2
    assert nasty in [drawn["name"] for drawn in data_of(page)["views"][0]["objects"]]


def test_points_come_back_within_the_step_of_their_packing(stack):
    scene = stack[0]
    view = data_of(show_page(*stack))["views"][0]
    drawn = view["objects"][scene.names.index("tin")]
    steps = np.frombuffer(base64.b64decode(drawn["points"]), dtype="<u2").reshape(-1, 3)
    points = steps * drawn["step"] + drawn["lower"]
    averaged = voxel_means(scene.clouds["tin"], LIMITS.finest)
    assert np.allclose(points, averaged, atol=drawn["step"])
    assert drawn["seen"] == len(points)


def test_every_relation_that_is_not_disjoint_has_a_line(stack):
    scene, relations, found = stack
    view = data_of(show_page(scene, relations, found))["views"][0]
    lines = {
        (scene.names[line["a"]], scene.names[line["b"]]) for line in view["relations"] if not line["faint"]
    }
    assert lines == {(pair.a, pair.b) for pair in relations.pairs if pair.relation != "disjoint"}


def test_the_square_of_relations_says_each_pair_from_both_sides_in_its_colour():
    pairs = [
        {"a": "lemon", "b": "bowl", "relation": "partial within"},
        {"a": "bowl", "b": "<table>", "relation": "touch", "inferred": True},
    ]
    html = relation_matrix({"relations": pairs}, {"lemon": 0, "bowl": 1, "<table>": 2})
    cells = dict(re.findall(r'data-ends="[^"]+" title="([^"]+)"><b[^>]*style="background:(#\w+)', html))
    said = {
        "lemon partial within bowl": Relation.PARTIAL_WITHIN,
        "bowl partial contain lemon": Relation.PARTIAL_CONTAIN,
        "bowl touch &lt;table&gt;, inferred": Relation.TOUCH,
        "&lt;table&gt; touch bowl, inferred": Relation.TOUCH,
    }
    assert cells == {told: css(RELATION_COLOURS[relation]) for told, relation in said.items()}
    legend = re.findall(r'class="key"><b[^>]*>(\w+)</b>([\w ]+)<', html)
    assert {relation for _, relation in legend} == {str(relation) for relation in Relation}
    assert len({letter for letter, _ in legend}) == len(legend) == 7


def test_many_objects_have_a_table_and_no_square():
    pairs = [{"a": "one", "b": f"{n}", "relation": "touch"} for n in range(LIMITS.matrix)]
    assert relation_matrix({"relations": pairs[:-1]}, {}) != ""
    assert relation_matrix({"relations": pairs}, {}) == relation_matrix({"relations": []}, {}) == ""


def test_the_order_is_told_with_its_reasons(stack):
    scene, relations, found = stack
    text = " ".join(Page(show_page(scene, relations, found)).text.split())
    assert text.index("tin:") < text.index("crate: after")
    assert "this is a target" in text


@pytest.mark.slow
def test_relations_alone_without_order_and_without_up():
    rng = np.random.default_rng(0)
    scene = Scene({"one": rng.normal(size=(50, 3)) * 0.05, "two": rng.normal(size=(50, 3)) * 0.05 + 0.3})
    page = show_page(scene, relate(scene), None)
    assert Page(page).open == []
    assert "Safe order" not in page
    assert "which way is up is not known" in page
    assert show_picture(scene, relate(scene), None)[:4] == b"\x89PNG"


@pytest.mark.slow
def test_fifty_objects_stay_within_the_budget():
    rng = np.random.default_rng(1)
    clouds = {f"thing {i}": rng.normal(size=(20_000, 3)) * 0.02 + rng.uniform(-1, 1, 3) for i in range(50)}
    scene = Scene(clouds, up=(0, 0, 1))
    chain = [
        {"first": f"thing {i}", "then": f"thing {j}", "reason": "supported", "confidence": 0.9}
        for i in range(50)
        for j in range(i + 1, min(i + 4, 50))
    ]
    found = {
        "targets": [],
        "order": list(clouds),
        "dependencies": chain,
        "groups": [],
        "unresolved": [],
        "risk": {},
    }
    page = show_page(scene, relate(scene), found)
    assert len(page) < 4_000_000
    assert "that follow from others are left out" in page


@pytest.mark.slow
@pytest.mark.parametrize(
    "cloud",
    [
        np.zeros((1, 3)),
        np.linspace([0, 0, 0], [0.1, 0, 0], 5),
        np.random.default_rng(0).uniform(size=(30, 3)) * [0.1, 0.1, 0],
    ],
)
def test_degenerate_clouds_can_be_drawn(cloud):
    scene = Scene({"odd": cloud, "other": np.random.default_rng(1).uniform(size=(30, 3)) * 0.1 + 0.2})
    pair = {"a": "odd", "b": "other", "relation": "disjoint", "gap": 0.1, "observed": True}
    assert Page(show_page(scene, {"relations": [pair]}, None)).open == []
    assert show_picture(scene, {"relations": [pair]}, None)


def test_the_photo_names_every_mask_and_its_place_in_the_order(photographed):
    scene, _, found = photographed
    page = show_page(*photographed)
    assert page.count('class="chip"') == len(scene.movable) == 2
    for place, name in zip(("1st", "2nd"), found.order, strict=True):
        assert f">{place}</b><span>{spoken_names(scene)[name]}</span>" in page
    picture = base64.b64decode(re.search(r'src="data:image/jpeg;base64,([^"]+)"', page).group(1))
    assert Image.open(io.BytesIO(picture)).width < scene.images[0].rgb.shape[1]


def test_a_guessed_side_is_drawn_as_such(half_seen):
    drawn = Drawing.of(half_seen).objects[1]
    away = KDTree(half_seen.clouds["box"]).query(drawn.points)[0]
    assert away[: drawn.seen].max() < LIMITS.guessed
    assert len(away) > drawn.seen + 100 and away[drawn.seen :].max() > 0.05
    assert "Hatched" in show_page(half_seen, {"relations": []}, None)


@pytest.mark.slow
def test_the_picture_shows_each_object_in_its_colour(stack):
    scene, relations, found = stack
    image = np.asarray(Image.open(io.BytesIO(show_picture(scene, relations, found))))
    assert image.shape[1] == 1620
    for name, colour in object_colours(scene.names, scene.fixed).items():
        if name != "table":
            assert (np.abs(image.astype(int) - colour).max(axis=2) <= 12).sum() > 50, name


@pytest.mark.slow
def test_the_same_scene_gives_the_same_page(stack):
    assert show_page(*stack) == show_page(*stack)
    assert show_picture(*stack) == show_picture(*stack)


def test_cycles_and_unresolved_objects_are_told():
    rng = np.random.default_rng(2)
    scene = Scene({name: rng.uniform(size=(30, 3)) * 0.1 + i for i, name in enumerate("abc")}, up=(0, 0, 1))
    found = {
        "targets": ["c"],
        "order": ["a", "b", "c"],
        "groups": [["a", "b"]],
        "unresolved": [["b", "c"]],
        "dependencies": [
            {"first": "a", "then": "b", "reason": "supported", "confidence": 0.3},
            {"first": "b", "then": "a", "reason": "hooked", "confidence": 1},
        ],
        "access": [{"first": "a", "then": "c", "reason": "no room for the fingers"}],
        "risk": {"c": 0.4},
    }
    text = " ".join(Page(show_page(scene, relate(scene), found)).text.split())
    assert "a and b hold each other" in text
    assert "No safe order among b and c" in text
    assert "a bars the way to c: no room for the fingers" in text
    assert "guess" in text
    assert show_picture(scene, relate(scene), found)


def test_an_order_is_animated_object_by_object(stack):
    scene, _, found = stack
    told = []
    film = Image.open(io.BytesIO(order_gif(scene, found, told.append)))
    assert len(told) == len(found.order)
    assert film.n_frames == RISE * len(found.order) + 1

    def pixels(frame):
        film.seek(frame)
        return np.asarray(film.convert("RGB")).astype(int)[: SIZE[1]]

    first, lifting, last = pixels(0), pixels(film.n_frames - 2), pixels(film.n_frames - 1)
    for name in found.order:  # there at first, gone after its turn, there at last
        colour = object_colours(scene.names, scene.fixed)[name]
        lit = [(np.abs(seen - colour).max(axis=2) <= 24).sum() for seen in (first, lifting, last)]
        assert name == found.order[-1] or lit[0] > 3 * lit[1], name
        assert lit[2] > 0.8 * lit[0], name


def test_the_place_of_what_was_taken_away_is_table_and_not_paper():
    table = np.random.default_rng(0).uniform(-0.4, 0.4, (8000, 3)) * [1, 1, 0]
    seen = table[np.linalg.norm(table, axis=1) > 0.12]  # what stood there hid the rest
    drawing = Drawing.of(Scene({"table": seen}, fixed=["table"], up=[0, 0, 1]))
    image = render_clouds(drawing, Projection(drawing, *SIZE), PAPER)
    white = (image == PAPER).all(axis=2)
    middle = [slice(size // 2 - 30, size // 2 + 30) for size in white.shape]
    assert white.any() and not white[tuple(middle)].any()
    assert len(np.unique(image[tuple(middle)].reshape(-1, 3), axis=0)) > 1  # hatched


def test_nothing_to_take_is_no_film(stack):
    scene, _, found = stack
    with pytest.raises(InvalidInput, match="nothing to animate"):
        order_gif(scene, {**found.to_json(), "order": []})


def test_the_graph_for_a_paper_stands_alone(stack):
    scene, _, found = stack
    svg = ElementTree.fromstring(graph_file(scene, found.to_json()))
    texts = [node.text for node in svg.iter("{http://www.w3.org/2000/svg}text")]
    assert {"crate", "tin", "1st", "2nd"} <= set(texts)
    assert "script" not in graph_file(scene, found.to_json()).replace("&lt;/script&gt;", "")
    width, height = float(svg.get("width")), float(svg.get("height"))
    for node in svg.iter("{http://www.w3.org/2000/svg}rect"):
        if node.get("x"):
            assert 0 <= float(node.get("x")) + float(node.get("width")) <= width
            assert float(node.get("y")) <= height


def test_what_lies_on_something_is_not_said_to_lean_on_it(stack):
    found = stack[2].to_json()
    edge = {"first": "tin", "then": "crate", "reason": "leaning", "confidence": 0.9}
    for lies, words in ((None, "leans on"), ("on", "rests on"), ("in", "is inside")):
        said = {**edge, **({"lies": lies} if lies else {})}
        told = dict(order_in_words({**found, "dependencies": [said]}))
        assert told["tin"].startswith(f"it {words} crate")


def test_a_stray_point_is_not_drawn(half_seen):
    cloud = half_seen.clouds["box"]
    strays = np.array([[0.3, 0.0, 0.4], [0.0, 0.3, 0.3]])
    drawn = Drawing.of(half_seen.with_cloud("box", np.concatenate([cloud, strays]))).objects[1]
    assert KDTree(drawn.points[: drawn.seen]).query(strays)[0].min() > 0.05


def test_an_object_whose_name_says_a_colour_is_drawn_in_it():
    names = ("red", "green cube", "Blue", "red_2", "can", "redwood")
    colours = object_colours(names)
    assert [max(range(3), key=colours[name].__getitem__) for name in names[:4]] == [0, 1, 2, 0]
    assert len(set(colours.values())) == len(names)
    assert object_colours(["can", "orange"])["can"] != object_colours(["can"])["can"], "two would look alike"
