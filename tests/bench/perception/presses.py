"""Scenes at random: each maker draws one press of its kind.

An edge's offset is within `REACH` of the pad's short side from its center; so is the nearest point of an arc, and
the point where several edges meet.
"""

from collections.abc import Callable

import numpy as np
from perception import solids
from perception.arrays import PAD, PRESS
from perception.scene import LOCAL, Numbers, Scene, numbers, seen

from exploration.sensing.spec import SensorSpec
from primitives.arrays import Floats

REACH = 0.3  # of the short side
ARC_RADII = (2.0, 3.0, 4.0, 6.0, 8.0, 10.0, 15.0, 20.0, 30.0, 60.0)  # [mm]
WIDTHS = (4.5, 6.0, 8.0, 10.0)  # [mm] of walls and slots, at 1.8 mm blur
OPENINGS = tuple(np.radians((60.0, 90.0, 120.0)))
BALLS = (10.0, 15.0, 25.0, 40.0, 80.0, 150.0, 200.0)  # [mm]
BARS = (30.0, 45.0, 70.0, 120.0, 200.0, 300.0, 500.0)  # [mm] wider than the pad
LEAN = 0.01  # [rad] 1 sigma of a pad that should lie flat
ASLANT = 0.03  # [rad] the same of one that comes to a ring
Maker = Callable[[np.random.Generator], Scene]


def edge(
    rng: np.random.Generator,
    spec: SensorSpec = PAD,
    tilt: float = 0.0,
    dihedral: float = 90.0,
    dead: float = 0.0,
) -> Scene:
    """One straight edge; the pad leans `tilt` [rad] over a random axis; a share of the taxels is dead."""
    lean = rng.uniform(-np.pi, np.pi)
    n = numbers(
        turn=_turn(rng),
        offset=rng.uniform(-REACH, REACH) * min(spec.array.size),
        depth=PRESS,
        tilt_x=np.tan(tilt) * np.cos(lean),
        tilt_y=np.tan(tilt) * np.sin(lean),
        dihedral=np.radians(dihedral),
    )
    died = rng.random(spec.array.shape) < dead if dead else None
    return Scene(spec, n, _edged, _edge_line, ("turn", "offset", *LOCAL), died)


def corner(rng: np.random.Generator, spec: SensorSpec = PAD) -> Scene:
    """Two edges that meet on the pad."""
    n = _meeting(rng, spec) | {"opening": float(rng.choice(OPENINGS))}
    return Scene(
        spec, n, lambda n: solids.corner(n["opening"]), _corner_lines, ("x", "y", "turn", "opening", *LOCAL)
    )


def wall(rng: np.random.Generator, spec: SensorSpec = PAD) -> Scene:
    """A thin wall: two parallel edges with material between."""
    return _parallel(rng, spec, solids.wall)


def slot(rng: np.random.Generator, spec: SensorSpec = PAD) -> Scene:
    """Two parallel edges with a gap between."""
    return _parallel(rng, spec, solids.slot)


def vertex(rng: np.random.Generator, spec: SensorSpec = PAD) -> Scene:
    """Three edges round the cut corner of a plate; the middle one is 5 to 9 mm long, at 45 degrees."""
    n = _meeting(rng, spec) | {"width": float(rng.choice((5.0, 7.0, 9.0)))}
    n |= {"opening": np.pi / 2, "cut": np.pi / 4}
    unknown = ("x", "y", "turn", "width", "opening", "cut", *LOCAL)
    return Scene(
        spec, n, lambda n: solids.chamfered(n["width"], n["opening"], n["cut"]), _chamfer_lines, unknown
    )


def bar_end(rng: np.random.Generator, spec: SensorSpec = PAD) -> Scene:
    """Three edges round the square end of a bar 7 to 10 mm wide."""
    n = _meeting(rng, spec) | {"width": float(rng.choice((7.0, 8.5, 10.0)))}
    n |= {"first": np.pi / 2, "second": np.pi / 2}
    unknown = ("x", "y", "turn", "width", "first", "second", *LOCAL)
    return Scene(spec, n, lambda n: solids.bar_end(n["width"], n["first"], n["second"]), _end_lines, unknown)


def disc(rng: np.random.Generator, radius: float, spec: SensorSpec = PAD) -> Scene:
    """The rim of a boss."""
    return _rim(rng, radius, spec, solids.disc)


def hole(rng: np.random.Generator, radius: float, spec: SensorSpec = PAD) -> Scene:
    """The rim of a hole."""
    return _rim(rng, radius, spec, solids.hole)


def flat(rng: np.random.Generator, spec: SensorSpec = PAD) -> Scene:
    """A face that fills the pad, nearly parallel to it."""
    gx, gy = rng.normal(0.0, LEAN, 2)
    return _without_lines(spec, numbers(depth=PRESS, tilt_x=gx, tilt_y=gy), lambda n: solids.flat(), LOCAL)


def empty(rng: np.random.Generator, spec: SensorSpec = PAD) -> Scene:
    """Nothing."""
    return _without_lines(spec, numbers(depth=-PRESS), lambda n: solids.flat(), LOCAL)


def ball(
    rng: np.random.Generator, radius: float | None = None, wander: float = 6.0, spec: SensorSpec = PAD
) -> Scene:
    """A sphere, whose pole may lie anywhere near the center."""
    x, y = rng.uniform(-wander, wander, 2)
    n = numbers(x=x, y=y, depth=PRESS) | {"radius": radius or float(rng.choice(BALLS))}
    return _without_lines(
        spec, n, lambda n: solids.ball(n["radius"]), ("x", "y", "radius", "depth", "background")
    )


def bar(
    rng: np.random.Generator, radius: float | None = None, wander: float = 6.0, spec: SensorSpec = PAD
) -> Scene:
    """A cylinder on its side."""
    n = numbers(turn=_turn(rng), offset=rng.uniform(-wander, wander), depth=PRESS)
    n |= {"radius": radius or float(rng.choice(BARS))}
    unknown = ("turn", "offset", "radius", "depth", "tilt_x", "tilt_y", "background")
    return _without_lines(spec, n, lambda n: solids.bar(n["radius"]), unknown)


def ring(
    rng: np.random.Generator, radius: float, tube: float, around: float, spec: SensorSpec = PAD
) -> Scene:
    """A ring, `around` [rad] from its crest uppermost."""
    gx, gy = rng.normal(0.0, ASLANT, 2)
    n = numbers(turn=_turn(rng), offset=rng.uniform(-3.0, 3.0), depth=PRESS, tilt_x=gx, tilt_y=gy)
    n |= {"radius": radius, "tube": tube, "around": around}
    return _without_lines(spec, n, lambda n: solids.ring(n["radius"], n["tube"], n["around"]), LOCAL)


def wider(kind: Callable[..., Scene], spec: SensorSpec, rng: np.random.Generator) -> Scene:
    """A flat face, a ball or a bar, of the radii that are greater than the pad is long."""
    if kind is flat:
        return flat(rng, spec)
    radii = BALLS if kind is ball else BARS
    return kind(rng, float(rng.choice([r for r in radii if r > max(spec.array.size)])), spec=spec)


def _parallel(
    rng: np.random.Generator, spec: SensorSpec, solid: Callable[[float, float], solids.Solid]
) -> Scene:
    n = numbers(turn=_turn(rng), offset=rng.uniform(-0.15, 0.15) * min(spec.array.size), depth=PRESS)
    n |= {"width": float(rng.choice(WIDTHS)), "taper": 0.0}
    unknown = ("turn", "offset", "width", "taper", *LOCAL)
    return Scene(spec, n, lambda n: solid(n["width"], n["taper"]), _parallel_lines, unknown)


def _rim(
    rng: np.random.Generator, radius: float, spec: SensorSpec, solid: Callable[[float], solids.Solid]
) -> Scene:
    """Where the circle fits on the pad its center is near the pad's; else its nearest point is, anywhere round.

    The origin is the point of the rim that is nearest the pad's center, or farthest, so that the radius bends the
    rim and moves it nowhere else: differences then tell a radius of 60 mm from a shift.
    """
    reach = REACH * min(spec.array.size)
    round_, near = rng.uniform(-np.pi, np.pi), rng.uniform(-reach, reach)
    away = 0.5 * near - radius if radius < 0.4 * min(spec.array.size) else near
    n = numbers(x=away * np.cos(round_), y=away * np.sin(round_), depth=PRESS, turn=round_ - np.pi / 2)
    return Scene(
        spec, n | {"radius": radius}, lambda n: solid(n["radius"]), _circle, ("x", "y", "radius", *LOCAL)
    )


def _without_lines(
    spec: SensorSpec, n: Numbers, solid: Callable[[Numbers], solids.Solid], unknown: tuple[str, ...]
) -> Scene:
    return Scene(spec, n, solid, lambda n: np.array([[n.get("radius", 0.0)]]), unknown)


def _edged(n: Numbers) -> solids.Solid:
    return solids.edge(float(np.degrees(n["dihedral"])))


def _turn(rng: np.random.Generator) -> float:
    return float(rng.uniform(-np.pi, np.pi))


def _meeting(rng: np.random.Generator, spec: SensorSpec) -> dict[str, float]:
    reach = REACH * min(spec.array.size)
    return numbers(x=rng.uniform(-reach, reach), y=rng.uniform(-reach, reach), turn=_turn(rng), depth=PRESS)


def _through(n: Numbers, pairs: list[tuple[tuple[float, float], tuple[float, float]]]) -> Floats:
    """(m, 2) angle and offset, as the pad sees them, of lines through pairs of points of the part's face.

    Angles are counted from `turn`, so that they change smoothly with it and never jump by a whole turn.
    """
    ends = seen(n, np.array(pairs, dtype=float))
    along = ends[:, 1] - ends[:, 0]
    c, s = np.cos(n["turn"]), np.sin(n["turn"])
    angle = n["turn"] + np.arctan2(along @ [-s, c], along @ [c, s])
    offset = ends[:, 0, 1] * np.cos(angle) - ends[:, 0, 0] * np.sin(angle)
    return np.stack([angle, offset], axis=1)


def _edge_line(n: Numbers) -> Floats:
    return _through(n, [((1.0, 0.0), (0.0, 0.0))])


def _corner_lines(n: Numbers) -> Floats:
    end = (np.cos(n["opening"]), np.sin(n["opening"]))
    return _through(n, [((1.0, 0.0), (0.0, 0.0)), (end, (0.0, 0.0))])


def _parallel_lines(n: Numbers) -> Floats:
    h, slant = n["width"] / 2, np.tan(n["taper"])
    return _through(n, [((1.0, -h), (0.0, -h)), ((1.0, h + slant), (0.0, h))])


def _chamfer_lines(n: Numbers) -> Floats:
    a, b = solids.chamfer_ends(n["width"], n["opening"], n["cut"])
    end = (np.cos(n["opening"]), np.sin(n["opening"]))
    return _through(n, [((1.0, 0.0), (0.0, 0.0)), (end, (0.0, 0.0)), ((a, 0.0), b)])


def _end_lines(n: Numbers) -> Floats:
    h = n["width"] / 2
    low = (np.sin(n["first"]), np.cos(n["first"]) - h)
    high = (np.sin(n["second"]), h - np.cos(n["second"]))
    return _through(n, [(low, (0.0, -h)), (high, (0.0, h)), ((0.0, -h), (0.0, h))])


def _circle(n: Numbers) -> Floats:
    return np.array([[*seen(n, np.array([0.0, n["radius"]])), n["radius"]]])
