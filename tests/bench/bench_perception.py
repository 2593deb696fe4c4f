"""Lines, arcs and local surfaces of ray-cast frames, beside the Cramer-Rao bound and the usual image tools.

Frames: 10 x 16 taxels at 1.8 mm, blur 1.8 mm, pressed 0.5 mm, noise 5 % of the plateau, 200 counts to the plateau
(see `perception.presses`, `perception.noise`).  The bound has free whatever an estimator is not told (see
`perception.bound`).  A failure is no line, or one more than 15 degrees or 1.5 taxels off.

`python tests/bench perception --rows edge,corner --frames 200` measures some rows on few frames.
"""

from functools import partial
from typing import Any

import numpy as np
from perception import presses
from perception.arcs import arc_rows
from perception.arrays import OTHERS
from perception.edges import OURS, Asked, Finder, edge_rows, false_rows, many_rows
from perception.hostile import hostile_rows
from perception.noise import Noise
from perception.real import real_rows
from perception.rings import ring_rows
from perception.surfaces import curvature_rows
from perception.times import time_rows

from exploration.sensing.baselines.table import baselines
from exploration.sensing.lines.hough import find_lines, sure_lines
from exploration.sensing.lines.outline import find_outline
from exploration.sensing.lines.region import ONE, THREE, TWO
from exploration.sensing.spec import load_sensor

SURE = f"{OURS}, sure lines"
FRAMES = 2000
FALSE = 5  # times as many for false lines
PLAIN = Noise()
SINGLE = Asked(1.15, 0.02)
FOUND = Asked(1.10, 0.02, findable=True)
SEVERAL = Asked(1.3, within=99.0)
EDGES = {
    "edge": ("5 % noise", presses.edge, PLAIN, Asked(1.10, 0.02, 0.0)),
    "noise": ("10 % noise", presses.edge, Noise(0.10), SINGLE),
    "light": ("60-count plateau", presses.edge, Noise(counts=60), SINGLE),
    "gains": ("10 % gain spread", presses.edge, Noise(gain_spread=0.10), SINGLE),
    "tilted": ("tilted 2 deg", partial(presses.edge, tilt=np.radians(2.0)), PLAIN, SINGLE),
    "dihedral120": ("dihedral 120 deg", partial(presses.edge, dihedral=120.0), PLAIN, SINGLE),
    "dihedral150": ("dihedral 150 deg", partial(presses.edge, dihedral=150.0), PLAIN, SINGLE),
    "dead": ("3 % dead, not known", partial(presses.edge, dead=0.03), PLAIN, Asked(1.25)),
    **{
        name.partition(" ")[0]: (name, partial(presses.edge, spec=spec), PLAIN, FOUND)
        for name, spec in OTHERS.items()
    },
}
TOLD = {"dihedral120": np.radians(120.0), "dihedral150": np.radians(150.0)}  # between the edge's faces
MANY = {
    "corner": (presses.corner, TWO[0]),
    "slot": (presses.slot, TWO[1]),
    "wall": (presses.wall, TWO[0]),
    "vertex": (presses.vertex, THREE[0]),
    "bar-end": (presses.bar_end, THREE[0]),
}
WITHOUT = {"flat": presses.flat, "empty": presses.empty, "sphere": presses.ball, "cylinder": presses.bar}
BUILT = ("lts210", "dsa", "fingertip", "square32")
ROWS = (
    "times",
    *EDGES,
    *MANY,
    "disc-hole",
    "false",
    "false-others",
    "hostile",
    "curvature",
    "rings",
    "built",
    "real",
)


def run(rows: tuple[str, ...] = ROWS, frames: int = FRAMES) -> list[dict[str, Any]]:
    """Rows of the table."""
    if unknown := sorted(set(rows) - set(ROWS)):
        raise SystemExit(f"no rows {unknown[0]!r}; there are: {', '.join(ROWS)}")
    out = []
    for key in rows:
        if key in EDGES:
            name, maker, noise, asked = EDGES[key]
            finders = methods()
            terms = None if key in TOLD else ONE[0]
            if key in TOLD:
                finders |= {OURS: partial(find_lines, dihedral=TOLD[key]), f"{OURS}, not told": find_lines}
            untold = "dihedral" if key in TOLD else None
            out += edge_rows(name, finders, maker, noise, frames, asked, terms, untold)
        elif key in MANY:
            finders = methods() | {SURE: sure_lines}
            out += many_rows(key, finders, *MANY[key], PLAIN, frames, SEVERAL)
        else:
            out += _OTHER_ROWS[key](frames)
    return out


def methods() -> dict[str, Finder]:
    """Ours, and what it is compared with."""
    return {OURS: find_lines, **baselines()}


def _built(frames: int) -> list[dict[str, Any]]:
    """Built-in arrays as they are: their own blur and noise, and a skin that ends near the outer taxels."""
    rows = []
    for name in BUILT:
        spec = load_sensor(name)
        e = spec.electronics
        maker = partial(presses.edge, spec=spec)
        noise = Noise(e.noise, e.plateau)
        rows += edge_rows(f"{name} as built", {OURS: find_lines}, maker, noise, frames, Asked())
    return rows


def _false_others(frames: int) -> list[dict[str, Any]]:
    """The other arrays under balls and bars wider than they are long; nothing is asked: 4x4 taxels hold little."""
    finders = {OURS: find_lines, SURE: sure_lines}
    rows = []
    for name, spec in OTHERS.items():
        makers = {
            f"{kind.__name__}, {name}": partial(presses.wider, kind, spec)
            for kind in (presses.flat, presses.ball, presses.bar)
        }
        rows += false_rows(finders, makers, PLAIN, frames, None)
    return rows


_OTHER_ROWS = {
    "times": lambda frames: time_rows(PLAIN, frames),
    "disc-hole": lambda frames: arc_rows(lambda image: find_outline(image).arcs, PLAIN, frames),
    "false": lambda frames: false_rows(methods() | {SURE: sure_lines}, WITHOUT, PLAIN, FALSE * frames),
    "false-others": _false_others,
    "hostile": lambda frames: hostile_rows(find_lines, PLAIN, frames),
    "curvature": lambda frames: curvature_rows(PLAIN, frames // 10),
    "rings": lambda frames: ring_rows(PLAIN, frames // 20),
    "built": _built,
    "real": lambda frames: real_rows(methods()),
}
