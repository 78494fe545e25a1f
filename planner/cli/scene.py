"""`topple scene`: several views whose camera poses are only roughly known, made one scene file."""

import argparse
from typing import TYPE_CHECKING, Any

import numpy as np

from topple.planner.cli.arguments import COMMON, add
from topple.planner.cli.console import print_json, print_table, print_text
from topple.planner.cli.main import DONE
from topple.planner.cli.options import Reading, scene_paths
from topple.planner.cli.progress import Progress
from topple.planner.cli.tables import print_assumptions
from topple.topology.base.files import check_writable

if TYPE_CHECKING:
    from topple.topology.scene.scene import Scene

SPACING, TABLE_SPACING = 0.002, 0.008
"""[m] between the points that are written of an object, and of the table, which is flat and large."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options; see `topple.planner.cli.main`."""
    views = "RGB-D .npz: depth, K, pose_camera_to_world as far as it is known, a mask where there is one"
    parser.add_argument("scenes", nargs="*", metavar="VIEW...", help=views)
    add(parser, "-o/--output", more=" (scene.npz)", default="scene.npz")
    add(parser, "--same-labels", *COMMON)


def execute(args: argparse.Namespace) -> int:
    """Merge the views, say how far each step can be trusted, and write the scene."""
    from topple.topology.io.views import read_view
    from topple.topology.merging.merge import merge_views

    paths = scene_paths(args)
    place = check_writable(args.output)
    with Progress("scene") as progress:
        images = []
        for path in paths:
            progress(f"reading {path}")
            images.append(read_view(path, max_bytes=Reading.of(args).max_bytes))
        progress(f"merging {len(images)} views")
        merged = merge_views(images, paths, up=args.up, same_labels=args.same_labels)
        _write(place, merged.scene)
    document = {**merged.to_json(), "file": str(place)}
    if args.json:
        print_json(document)
    else:
        _print(document)
    return DONE


def _write(place: Any, scene: "Scene") -> None:
    """The scene as an `.npz` of clouds, thinned."""
    import io

    from topple.topology.base.files import write_whole
    from topple.topology.geometry.thin import thinned

    clouds: dict[str, Any] = {
        name: thinned(cloud, TABLE_SPACING if name in scene.fixed else SPACING).astype(np.float32)
        for name, cloud in scene.clouds.items()
    }
    about: dict[str, Any] = {
        "up": scene.up, "fixed": np.array(sorted(scene.fixed)), "viewpoints": scene.viewpoints,
        "matter": scene.matter,
    }  # fmt: skip
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **clouds, **about)
    write_whole(place, buffer.getvalue())


def _print(document: dict[str, Any]) -> None:
    rows: list[tuple[str, ...]] = []
    for view in document["views"]:
        fit, ground = view["registration"], view["ground"]
        found: tuple[str, ...] = ("", "", "", "", "")
        if fit is not None:
            moved = f"{100 * fit['shift']:.1f} cm", f"{np.degrees(fit['turn']):.1f}°", str(fit["common"])
            found = (*moved, f"{1e3 * fit['residual']:.1f} mm", f"{fit['conflict']:.1%}")
        rows.append((view["view"], *found, f"{ground['share']:.0%}", f"{1e3 * ground['residual']:.1f} mm"))
    headings = ("view", "moved", "turned", "common", "residual", "looked through", "ground", "its residual")
    print_table(headings, rows, right=range(1, 8))
    how = "by their masks" if document["masked"] else "by their shape"
    names = [name for name in document["objects"] if name not in document["fixed"]]
    print_text(
        f"{document['file']}: {len(names)} objects {how}, {', '.join(names)}; of what stands there "
        f"{document['outliers']:.1%} dropped as outliers, {document['loose']:.1%} in no object"
    )
    print_assumptions(document["assumptions"])
