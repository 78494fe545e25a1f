"""What the figures share: off-screen 3-D drawing in one style, by PyVista (extra `docs`)."""

import sys
from pathlib import Path

import numpy as np
import pyvista
import trimesh
from numpy.typing import NDArray
from PIL import Image, ImageChops, ImageDraw, ImageFont
from vtkmodules.vtkCommonCore import vtkObject

from topple.topology.geometry.hull import Hull

HERE = Path(__file__).parent
ORANGE, BLUE, GREEN, GREY, RED = "#e07b39", "#3b78b5", "#4c9f70", "#d9d6cf", "#c0392b"
INK, SOFT, PAPER = "#1c1e21", "#5d6167", "white"
Points = NDArray[np.float64]


class Studio:
    """A view of solids and clouds, lit the same way in every figure.

    Args:
        size: Width and height [px].
    """

    def __init__(self, size: tuple[int, int] = (900, 640)) -> None:
        vtkObject.GlobalWarningDisplayOff()  # there is no display, and need not be
        self.plot = pyvista.Plotter(off_screen=True, window_size=list(size), lighting="three lights")
        self.plot.set_background(PAPER)
        self.plot.enable_anti_aliasing("ssaa")
        self.plot.enable_depth_peeling(8)

    def mesh(self, mesh: trimesh.Trimesh, colour: str, opacity: float = 1.0) -> None:
        """A shaded surface."""
        smooth = pyvista.wrap(mesh).compute_normals(feature_angle=35, split_vertices=True)
        self.plot.add_mesh(
            smooth, color=colour, opacity=opacity, smooth_shading=True, ambient=0.2, diffuse=0.85
        )

    def points(self, points: Points, colour: str, size: float = 5) -> None:
        """A cloud."""
        self.plot.add_mesh(
            pyvista.PolyData(points),
            color=colour,
            point_size=size,
            render_points_as_spheres=True,
            ambient=0.35,
        )

    def hull(self, points: Points, colour: str, opacity: float = 0.12) -> None:
        """The hull of a cloud, translucent, with its creases."""
        hull = Hull.of(points)
        faces = np.hstack([np.full((len(hull.faces), 1), 3), hull.faces]).ravel()
        mesh = pyvista.PolyData(np.asarray(hull.vertices), faces)
        self.plot.add_mesh(mesh, color=colour, opacity=opacity, specular=0)
        self.plot.add_mesh(
            mesh.extract_feature_edges(12, boundary_edges=False), color=colour, line_width=1.5, opacity=0.7
        )

    def arrow(self, start: Points, end: Points, colour: str, radius: float = 0.0028) -> None:
        """An arrow between two points [m]."""
        along = np.asarray(end) - np.asarray(start)
        length = float(np.linalg.norm(along))
        head = min(0.45, 4.5 * radius / length)
        self.plot.add_mesh(
            pyvista.Arrow(
                start=start, direction=along, scale=length, shaft_radius=radius / length,
                tip_radius=2.6 * radius / length, tip_length=head, tip_resolution=32, shaft_resolution=24,
            ),
            color=colour, ambient=0.3,
        )  # fmt: skip

    def label(self, at: Points, text: str, size: int = 20) -> None:
        """A name beside a place."""
        self.plot.add_point_labels(
            [np.asarray(at, dtype=float)], [text], font_size=size, text_color=INK, shape_color=PAPER,
            shape_opacity=0.85, show_points=False, always_visible=True, margin=4,
        )  # fmt: skip

    def image(self, eye: tuple[float, ...], target: tuple[float, ...], angle: float = 24) -> Image.Image:
        """Look from one place at another [m]."""
        self.plot.camera_position = [eye, target, (0, 0, 1)]
        self.plot.camera.view_angle = angle
        shot = np.asarray(self.plot.screenshot(return_img=True))
        self.plot.close()
        return Image.fromarray(shot)


def font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """The font of all figures."""
    return ImageFont.load_default(size=size)


def beside(*images: Image.Image, titles: tuple[str, ...] = ()) -> Image.Image:
    """Pictures side by side, a title over each."""
    top = 46 if titles else 0
    whole = Image.new("RGB", (sum(i.width for i in images), max(i.height for i in images) + top), PAPER)
    pen, x = ImageDraw.Draw(whole), 0
    for number, image in enumerate(images):
        whole.paste(image, (x, top))
        if titles:
            pen.text((x + 20, 14), titles[number], font=font(22), fill=INK)
        x += image.width
    return whole


def save(image: Image.Image, name: str) -> None:
    """Write a figure beside the scripts without its empty margins above and below, and say so."""
    _, top, _, low = ImageChops.difference(image, Image.new("RGB", image.size, PAPER)).getbbox() or (
        0,
        0,
        0,
        0,
    )
    image = image.crop((0, max(top - 14, 0), image.width, min(low + 14, image.height)))
    place = HERE / f"{name}.png"
    image.quantize(192, dither=Image.Dither.NONE).save(place, optimize=True)
    sys.stdout.write(f"{place.name}: {image.width} x {image.height}, {place.stat().st_size // 1000} kB\n")
