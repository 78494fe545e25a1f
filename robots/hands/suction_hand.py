"""A suction cup on a sliding rod, composed to a hand or a flange."""

import math
from dataclasses import dataclass
from pathlib import Path

from topple.robots.arm.compose import compose_urdf

CUP_LINK = "suction_cup"
CUP_JOINT = "suction_cup_joint"


@dataclass(frozen=True)
class CupDesign:
    """Dimensions of the cup, z along the tool axis from the origin of the frame it is mounted in.

    Attributes:
        retracted_lip: Where the lip stands when drawn in, in [m]: level with the root of the fingers, inside
            the palm.
        finger_tips: Where the finger tips end in [m].
        beyond: How far the lip then stands out beyond the tips in [m].
        radius: Lip radius in [m]; 30 mm cups are a common size for crockery and boxes.
        height: Height of the bellows in [m].
        rod_radius: Radius of the rod that carries it in [m].
        rod_length: Its length in [m]: reaches from the extended cup back into the palm.
        cup_mass: Mass of the bellows in [kg].
        rod_mass: Mass of the hollow rod in [kg].
        vacuum: Pressure below ambient in [Pa]; what a small ejector reaches on a sealed surface.
        push: Largest force of the drive in [N].
    """

    retracted_lip: float = 0.0584
    finger_tips: float = 0.1121
    beyond: float = 0.020
    radius: float = 0.015
    height: float = 0.020
    rod_radius: float = 0.006
    rod_length: float = 0.062
    cup_mass: float = 0.010
    rod_mass: float = 0.030
    vacuum: float = 60e3
    push: float = 60.0

    @property
    def extended_lip(self) -> float:
        """Where the lip stands when pushed out in [m]."""
        return self.finger_tips + self.beyond

    @property
    def stroke(self) -> float:
        """Travel of the cup in [m]."""
        return self.extended_lip - self.retracted_lip

    @property
    def holding_force(self) -> float:
        """Pull at which the seal breaks in [N]: vacuum times lip area, 42 N here."""
        return self.vacuum * math.pi * self.radius**2


PANDA_CUP = CupDesign()


def panda_with_cup(panda: Path, design: CupDesign) -> Path:
    """Write the URDF of the Panda with the cup and return its path.

    Args:
        panda: The Panda's URDF.
        design: Dimensions of the cup.
    """
    return compose_urdf(panda, "panda-suction", cup_xml(design, "panda_hand"))


def cup_xml(design: CupDesign, link: str, origin: str = "") -> str:
    """The cup's link and joint, in URDF.

    Args:
        design: Dimensions of the cup.
        link: Link it is mounted on.
        origin: Attributes of the joint's `<origin>`; the retracted lip on the link's z axis where not given.
    """
    origin = origin or f"xyz='0 0 {design.retracted_lip}'"
    # the link's origin is the lip's centre, z out of the hand
    cup, rod = -design.height / 2, -design.height - design.rod_length / 2
    mass = design.cup_mass + design.rod_mass
    centre = (design.cup_mass * cup + design.rod_mass * rod) / mass
    across = mass * (design.rod_length + design.height) ** 2 / 12
    along = mass * design.radius**2 / 2
    shapes = _cylinder_xml(cup, design.radius, design.height, "0.1 0.1 0.35 1")
    shapes += _cylinder_xml(rod, design.rod_radius, design.rod_length, "0.6 0.6 0.6 1")
    return (
        f"<link name='{CUP_LINK}'><contact><lateral_friction value='1.0'/></contact>"
        f"<inertial><origin xyz='0 0 {centre}'/><mass value='{mass}'/>"
        f"<inertia ixx='{across}' ixy='0' ixz='0' iyy='{across}' iyz='0' izz='{along}'/>"
        f"</inertial>{shapes}</link>"
        f"<joint name='{CUP_JOINT}' type='prismatic'><parent link='{link}'/><child link='{CUP_LINK}'/>"
        f"<origin {origin}/><axis xyz='0 0 1'/>"
        f"<limit effort='{design.push}' lower='0' upper='{design.stroke}' velocity='0.3'/></joint>"
    )


def _cylinder_xml(z: float, radius: float, length: float, rgba: str) -> str:
    shape = f"<origin xyz='0 0 {z}'/><geometry><cylinder radius='{radius}' length='{length}'/></geometry>"
    paint = f"<material name='cup_{length}'><color rgba='{rgba}'/></material>"
    return f"<visual>{shape}{paint}</visual><collision>{shape}</collision>"
