"""The series of seeds, or of recorded frames, that `topple bench run` plays, with their bars."""

from dataclasses import dataclass
from pathlib import Path

from topple.benchmarks.episodes import IDEAL, TOPPLE, Episode
from topple.benchmarks.other_piles import NAME as OTHER_PILE
from topple.benchmarks.rules import RULES


@dataclass(frozen=True)
class Series:
    """Seeds of one scenario, or the frames of a folder.

    Attributes:
        scenario: Its name.
        seeds: How many, from the first on.
        cameras: How many look.
        rule: What decides the order.
        bar: Of the share of successes that is aimed at [%], None where there is none.
        folder: Where the frames are; None for a scenario.
        frames: Their names.
        mask_noise: Pixels by which edges of masks are wrong (deviation); one in twenty is missing then.
        shuffle_labels: Whether names of objects are not kept between looks.
        wrist_camera: Whether the arm carries one more camera for a second look.
        meshes: Folder of models that other piles are made of.
        ahead: Whether the next step is chosen while the arm acts.
        alone: Whether there is one arm, also where the scene is made for two.
    """

    scenario: str
    seeds: int
    cameras: int = 3
    rule: str = TOPPLE
    bar: str | None = None
    folder: Path | None = None
    frames: tuple[str, ...] = ()
    mask_noise: float = 0.0
    shuffle_labels: bool = False
    wrist_camera: bool = False
    meshes: Path | None = None
    ahead: bool = False
    alone: bool = False

    def episodes(self, seed: int) -> list[Episode]:
        """Its episodes, from a first seed on."""
        if self.folder is not None:
            return [Episode(name, seed, self.cameras, self.rule, str(self.folder)) for name in self.frames]
        return [
            Episode(
                self.scenario, seed + number, self.cameras, self.rule,
                mask_noise=self.mask_noise, shuffle_labels=self.shuffle_labels,
                wrist_camera=self.wrist_camera, ahead=self.ahead, alone=self.alone,
                meshes="" if self.meshes is None else str(self.meshes),
            )
            for number in range(self.seeds)
        ]  # fmt: skip

    def __str__(self) -> str:
        """As it stands in a table."""
        eyes = f"{self.cameras} camera{'s' if self.cameras > 1 else ''}"
        eyes += " and one on the wrist" if self.wrist_camera else ""
        masks = f", masks {self.mask_noise:g} px off, one in twenty missing" if self.mask_noise else ""
        names = ", labels shuffled" if self.shuffle_labels else ""
        kinds = " of models too" if self.meshes is not None else ""
        rule = "" if self.rule == TOPPLE else f", {self.rule}"
        ahead = ", chosen ahead" if self.ahead else ""
        arms = ", one arm" if self.alone else ""
        return f"{self.scenario}{kinds}, {eyes}{masks}{names}{rule}{ahead}{arms}"


FULL = (
    Series("dishes", 60, bar=">= 97"),
    Series("tower", 60, bar=">= 97"),
    Series("lemon", 60, bar=">= 90"),
    Series("sort", 60, bar=">= 92"),
    Series("pile", 100, bar=">= 88"),
    Series("pile", 100, cameras=1, bar=">= 70"),
    Series("pile", 100, cameras=1, bar=">= 85", wrist_camera=True),
    Series(OTHER_PILE, 100, bar=">= 80"),
    Series("shelf", 60, bar=">= 85"),
)
BESIDE = (
    Series("pile", 100, rule=IDEAL),
    *(Series("pile", 60, rule=rule) for rule in RULES),
    Series("pile", 60, mask_noise=1.5),
    Series("pile", 60, shuffle_labels=True),
    Series(OTHER_PILE, 60, cameras=1),
    Series("hold", 20),
    Series("hold", 20, alone=True),
)
"""What the figures of `FULL` are held against: played once those are."""
QUICK = (Series("dishes", 1), Series("tower", 1), Series("pile", 1), Series("pile", 1, rule=RULES[1]))
