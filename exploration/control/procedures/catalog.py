"""Every exploratory procedure by name, the property class that it serves, and those that no single array can do.

The classes are Klatzky and Lederman's: substance and surface, structure, function.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType


@dataclass(frozen=True)
class Procedure:
    """One procedure."""

    name: str
    serves: str  # the property class
    does: str


PROCEDURES = (
    Procedure(
        "approach", "none: how the others begin", "advance to a force; stop on heat or a sharp contact"
    ),
    Procedure("contact", "structural: first contact", "roll from any first contact to a flush one"),
    Procedure("normal", "structural: exact shape", "null the moments at two places"),
    Procedure("surface", "structural: exact shape", "follow the surface to its edge"),
    Procedure("edge", "structural: exact shape", "follow the nearest edge"),
    Procedure("enclosure", "structural: global shape, volume", "outline of a part smaller than the pad"),
    Procedure("curvature", "structural: exact shape", "four directions from one place"),
    Procedure("compliance", "surface: hardness", "distance from contact to a force"),
    Procedure("elasticity", "surface: hardness", "press, back off, touch again: permanent set"),
    Procedure("hardness", "surface: hardness", "force against depth, the skin's own stiffness taken off"),
    Procedure("texture", "surface: texture", "stroke at constant force: mean, deviation, spectrum"),
    Procedure("thermal", "surface: temperature", "rest until the skin's temperature settles"),
)

CANNOT: Mapping[str, str] = MappingProxyType(
    {
        "weight": "unsupported holding needs a grasp, and one array on one stage cannot lift",
        "part-motion": "the part motion test needs a grasp; one array on one stage only feels what a push moves",
        "function": "a function test needs hands that use the object; one array on one stage has none",
    }
)


def named(name: str) -> Procedure | None:
    """The procedure of that name."""
    return next((procedure for procedure in PROCEDURES if procedure.name == name), None)
