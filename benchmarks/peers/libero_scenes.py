"""Write the scenes of LIBERO as plain MJCF, with stored states and what MuJoCo makes of them.

Runs in an environment of its own, with robosuite 1.4.1, bddl and MuJoCo 3.3.0, since later versions let
other things happen; `topple bench libero` says how. A task becomes `TASK.xml`, without what is only looked
at, with three stored states and the same three after time has passed as keyframes, and `TASK.json`.
"""

import json
import os
import pickle
import shutil
import sys
import zipfile
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from xml.etree import ElementTree

import numpy as np

STATES = 3
"""Of each task, the first that are stored."""
REST, LOOKED = 4.0, 1.0
"""[s] until a state counts as at rest, and for which it is watched what moves."""
DROPPED = {
    *("texture", "material", "skybox", "camera", "light", "visual", "site"),
    *("actuator", "sensor", "keyframe"),
}
"""What no collision needs."""


class _Numbers(pickle.Unpickler):
    """Makes arrays, and refuses whatever else a pickle asks for."""

    def find_class(self, module_name: str, global_name: str, /) -> Any:
        known = {"_reconstruct", "ndarray", "dtype", "encode", "scalar"}
        if global_name not in known or module_name.split(".")[0] not in ("numpy", "_codecs"):
            raise pickle.UnpicklingError(f"{module_name}.{global_name}")
        return getattr(import_module(module_name.replace("numpy.core", "numpy._core")), global_name)


def stored(path: Path) -> Any:
    """The (N, 1 + nq + nv) states of a file of LIBERO, which is an archive with one pickle of an array."""
    with zipfile.ZipFile(path) as archive, archive.open("archive/data.pkl") as file:
        return np.asarray(_Numbers(file).load(), np.float64)


def environments(checkout: Path, folder: Path) -> Any:
    """The module of LIBERO's environments; nothing in it needs torch or a picture."""
    home = checkout / "libero" / "libero"
    places = {"benchmark_root": home, "bddl_files": home / "bddl_files", "init_states": home / "init_files"}
    places |= {"datasets": folder, "assets": home / "assets"}
    (folder / "config.yaml").write_text("".join(f"{key}: {place}\n" for key, place in places.items()))
    os.environ |= {"LIBERO_CONFIG_PATH": str(folder), "MUJOCO_GL": "disabled"}
    sys.path.insert(0, str(checkout))
    module = import_module("robosuite.utils.binding_utils")
    read = module.MjSim.from_xml_string.__func__
    module.MjSim.from_xml_string = classmethod(lambda cls, xml: read(cls, without_missing(xml)))
    return import_module("libero.libero.envs")


def without_missing(xml: str) -> str:
    """An MJCF text whose files are all there: of large meshes and pictures a checkout may lack some."""
    root = ElementTree.fromstring(xml)
    lost = set[tuple[str, str | None]]()
    for asset in root.iter("asset"):
        for each in list(asset):
            if "file" in each.attrib and not Path(each.attrib["file"]).is_file():
                lost.add((each.tag, each.attrib["name"]))
                asset.remove(each)
        for each in list(asset):
            if each.tag == "material" and ("texture", each.get("texture")) in lost:
                del each.attrib["texture"]
    for geom in root.iter("geom"):
        if ("mesh", geom.get("mesh")) in lost:
            if (geom.get("contype"), geom.get("conaffinity")) != ("0", "0"):
                raise FileNotFoundError(f"the mesh {geom.get('mesh')}, which can be touched")
            del geom.attrib["mesh"]
            geom.attrib |= {"type": "sphere", "size": "0.001"}
    return ElementTree.tostring(root, "unicode")


def stripped(xml: str, model: Any, assets: Path) -> Any:
    """The same world without what is only looked at, its meshes copied, its bodies where they were put."""
    root = ElementTree.fromstring(xml)
    for parent in list(root.iter()):
        for each in list(parent):
            seen = each.tag == "geom" and (each.get("contype"), each.get("conaffinity")) == ("0", "0")
            if seen or each.tag in DROPPED:
                parent.remove(each)
    for geom in root.iter("geom"):
        geom.attrib.pop("material", None)
    used = {geom.get("mesh") for geom in root.iter("geom")}
    for asset in root.iter("asset"):
        for mesh in list(asset):
            if mesh.get("name") not in used:
                asset.remove(mesh)
                continue
            file = Path(mesh.attrib["file"])
            mesh.attrib["file"] = f"{file.parents[1].name}_{file.parent.name}_{file.name}"
            shutil.copy(file, assets / mesh.attrib["file"])
    for compiler in root.iter("compiler"):
        compiler.attrib |= {"meshdir": assets.name}
        compiler.attrib.pop("texturedir", None)
    for body in root.iter("body"):
        if body.get("name"):
            number = model.body_name2id(body.get("name"))
            body.attrib["pos"] = " ".join(map(str, model.body_pos[number]))
            body.attrib["quat"] = " ".join(map(str, model.body_quat[number]))
            for key in ("euler", "axisangle", "xyaxes", "zaxis"):
                body.attrib.pop(key, None)
    return root


class Play:
    """A world in which all is free but the robot, which is held where it is."""

    def __init__(self, path: Path) -> None:
        """Read it from its MJCF file."""
        self.engine: Any = import_module("mujoco")
        self.model = self.engine.MjModel.from_xml_path(str(path))
        self.data = self.engine.MjData(self.model)
        kinds = self.engine.mjtObj
        self.free: dict[str, int] = {}
        held: list[int] = []
        for joint in range(self.model.njnt):
            root = self.model.body_rootid[self.model.jnt_bodyid[joint]]
            name = self.engine.mj_id2name(self.model, kinds.mjOBJ_BODY, root)
            if self.model.jnt_type[joint] == self.engine.mjtJoint.mjJNT_FREE:
                self.free[name] = int(self.model.jnt_qposadr[joint])
            elif name.startswith(("robot", "gripper", "mount")):
                held.append(joint)
        self.held = self.model.jnt_qposadr[held], self.model.jnt_dofadr[held]

    def start(self, qpos: Any) -> None:
        """Put all where it is, at rest."""
        self.engine.mj_resetData(self.model, self.data)
        self.data.qpos[:] = qpos
        self.engine.mj_forward(self.model, self.data)

    def run(self, seconds: float) -> None:
        """Let time pass."""
        places, speeds = self.held
        stays = self.data.qpos[places].copy()
        for _ in range(round(seconds / self.model.opt.timestep)):
            self.engine.mj_step(self.model, self.data)
            self.data.qpos[places], self.data.qvel[speeds] = stays, 0.0
        self.engine.mj_forward(self.model, self.data)

    def moved(self, seconds: float) -> dict[str, list[float]]:
        """How far each free thing gets [mm, degrees]."""
        before = self.data.qpos.copy()
        self.run(seconds)
        after, found = self.data.qpos, {}
        for name, k in self.free.items():
            way = 1e3 * (after[k : k + 3] - before[k : k + 3])
            turn = 2 * np.arccos(min(1.0, abs(float(after[k + 3 : k + 7] @ before[k + 3 : k + 7]))))
            found[name] = [round(float(np.linalg.norm(way)), 3), round(float(np.degrees(turn)), 3)]
        return found

    def contacts(self) -> list[list[Any]]:
        """The pairs that press on each other, with the sum of their normal forces [N]."""
        found: dict[tuple[str, str], float] = {}
        force = np.zeros(6)
        for k in range(self.data.ncon):
            pair = sorted(self._owner(int(geom)) for geom in self.data.contact[k].geom)
            self.engine.mj_contactForce(self.model, self.data, k, force)
            if pair[0] != pair[1] and self.free.keys() & set(pair):
                found[pair[0], pair[1]] = found.get((pair[0], pair[1]), 0.0) + float(force[0])
        return [[*pair, round(newton, 5)] for pair, newton in found.items()]

    def _owner(self, geom: int) -> str:
        body = int(self.model.body_rootid[self.model.geom_bodyid[geom]])
        kinds = self.engine.mjtObj
        kind, number = (kinds.mjOBJ_BODY, body) if body else (kinds.mjOBJ_GEOM, geom)
        return self.engine.mj_id2name(self.model, kind, number) or f"{'body' if body else 'geom'}_{number}"


def export(suites: Any, checkout: Path, task: Path, folder: Path) -> None:
    """Write one task."""
    np.random.seed(0)  # by which LIBERO places its furniture
    environment = suites.env_wrapper.ControlEnv(
        bddl_file_name=str(task), use_camera_obs=False, has_offscreen_renderer=False
    )
    environment.seed(0)
    environment.reset()
    sim = environment.sim
    suite = task.parent.name
    path = checkout / "libero" / "libero" / "init_files" / suite / f"{task.stem}.pruned_init"
    states = stored(path)[:STATES] if path.is_file() else np.zeros((0, 0))
    root = stripped(environment.env.model.get_xml(), sim.model, folder / "assets")
    nq = sim.model.nq
    starts = [state[1 : 1 + nq] for state in states if len(state) == 1 + nq + sim.model.nv]
    kind = "stored"
    if len(starts) < STATES:
        kind, starts = "reset", []
        for seed in range(STATES):  # furniture stays where the first reset put it
            environment.seed(seed)
            environment.reset()
            starts.append(np.array(environment.sim.data.qpos))
    environment.close()
    write(root, starts, folder / f"{suite}-{task.stem}.xml", {"suite": suite, "states_are": kind})


def write(root: Any, starts: Any, out: Path, said: dict[str, Any]) -> None:
    """Write a world with its states as keyframes, and beside it what becomes of them.

    Args:
        root: The world as MJCF.
        starts: (nq,) places of all joints, a state each.
        out: Where to.
        said: What else is said of it.
    """
    out.write_text(ElementTree.tostring(root, "unicode"), "utf-8")
    world, told, keys = Play(out), list[dict[str, Any]](), ElementTree.SubElement(root, "keyframe")
    for number, qpos in enumerate(starts):
        world.start(qpos)
        first = world.moved(LOOKED)
        world.run(REST - LOOKED)
        rest = world.data.qpos.copy()
        world.start(rest)
        world.run(0.02)  # forces of contacts settle
        pairs = world.contacts()
        world.start(rest)
        for name, place, extra in (
            (f"state_{number}", qpos, {"moved": first}),
            (f"rest_{number}", rest, {"moved": world.moved(LOOKED), "contacts": pairs}),
        ):
            joints = " ".join(map(repr, map(float, place)))
            ElementTree.SubElement(keys, "key", {"name": name, "qpos": joints})
            told.append({"key": name, **extra})
    out.write_text(ElementTree.tostring(root, "unicode"), "utf-8")
    out.with_suffix(".json").write_text(json.dumps({**said, "states": told}), "utf-8")


def main(checkout: Path, folder: Path) -> None:
    """Write every task that is not there yet."""
    (folder / "assets").mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory() as scratch:
        suites = environments(checkout, Path(scratch))
        for task in sorted((checkout / "libero" / "libero" / "bddl_files").glob("*/*.bddl")):
            if not (folder / f"{task.parent.name}-{task.stem}.json").exists():
                export(suites, checkout, task, folder)
                sys.stdout.write(f"{task.parent.name} {task.stem}\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
