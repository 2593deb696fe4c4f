"""`palpate track surface`: find the object, stroke the surface under the pad along two axes to its edges.

What the surface is, is told by four-direction curvature in its middle, and by the shape that fits all
contacts of the strokes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from exploration.control.dwell import dwell
from exploration.control.feel import feel
from exploration.control.procedures.curvature import FeltCurvature, four_direction_curvature
from exploration.control.sighting import Sighting
from exploration.control.track_surface import Stroke, StrokeConfig, follow_surface
from exploration.devices.guard import Collision, OverPress
from primitives.arrays import Floats
from primitives.classify import RankedFit, rank
from primitives.errors import PalpateError
from primitives.evidence import Contacts
from primitives.shapes import parameters
from recognition.running.felt_run import FeltRun

Say = Callable[[str], None]
LONGEST = 400.0  # [mm] of one stroke
SHORTEST = 0.5  # [mm] of strokes, below which nothing was followed
_PLACES = 3  # of the object, at which strokes begin
_WORTH = 10.0  # [mm] of strokes, from which they tell a surface
ELSEWHERE = "touch it elsewhere (in simulation: another --seed)"
_STOPPED = "stopped"  # as a stroke that the housing or a skin pressed through has ended is called
_AT = {"edge": "an edge", "concavity": "a concavity", "wall": "a wall", "workspace": "the workspace's end"}


@dataclass(frozen=True)
class SurfaceTrack:
    """Strokes over one surface, and what it is."""

    contacts: Contacts
    curvature: FeltCurvature | None
    fits: tuple[RankedFit, ...]
    ended: tuple[str, ...]  # of each stroke
    edges: tuple[Sighting, ...] = ()  # that strokes stopped before
    travel: float = 0.0  # [mm]
    forces: list[float] = field(default_factory=list)  # [N]

    def found(self) -> dict[str, Any]:
        """As the summary's `found`."""
        out: dict[str, Any] = {
            "strokes": list(self.ended),
            "length_mm": self.travel,
            "edges_mm": [edge.point for edge in self.edges],
        }
        if self.curvature is not None:
            four = self.curvature.four
            out["order"] = {"name": self.curvature.order, "probability": self.curvature.probability}
            out["curvature_per_mm"] = {"k1": float(four.k1[0]), "k2": float(four.k2[0])}
            out["curvature_sigma_per_mm"] = np.sqrt(four.covariance[0, [0, 1], [0, 1]])
        out["shape"], out["parameters"] = None, {}
        if self.fits:
            best = self.fits[0]
            out["shape"], out["probability"] = best.fit.shape.kind, best.probability
            out["parameters"] = parameters(best.fit.shape)
        if self.travel < SHORTEST or not len(self.contacts):
            out["why"] = self.why
        return out

    @property
    def lost(self) -> bool:
        """Whether contact was, or had to be given up, before a stroke had ended."""
        return not self.ended or any(ended in ("lost", _STOPPED) for ended in self.ended)

    @property
    def whole(self) -> bool:
        """Whether strokes came to their ends, and are long enough to tell a surface."""
        return not self.lost and self.travel > _WORTH

    @property
    def why(self) -> str:
        """What kept strokes from feeling anything, where they did not."""
        if set(self.ended) <= {_STOPPED}:
            return f"the pad was stopped where it came down, before it had stroked anything; {ELSEWHERE}"
        if self.lost:
            return f"contact was lost; {ELSEWHERE}"
        met = " and ".join(_AT[end] for end in dict.fromkeys(self.ended) if end in _AT) or "nothing"
        return f"strokes met {met} where the pad came down; {ELSEWHERE}"


def track_surface(run: FeltRun, speed: float, say: Say) -> SurfaceTrack:
    """Find the object and stroke the surface under the pad, along two axes, at `speed` [mm/s].

    Where it is lost, or strokes have no room, another place of the object is found; what came to an end is kept,
    or what was followed longest.
    """
    say("looking for the object")
    run.find()
    tracks = [_followed(run, speed, say)]
    while not tracks[-1].whole and len(tracks) < _PLACES:
        say("looking for another place")
        try:
            run.find_elsewhere()
        except PalpateError as error:
            run.warnings.append(f"no other place was come to: {error}")
            break
        tracks.append(_followed(run, speed, say))
    return max(tracks, key=lambda track: (track.whole, track.travel))


def _followed(run: FeltRun, speed: float, say: Say) -> SurfaceTrack:
    pad = run.pad
    first = pad.feel()
    axes = pad.axes()
    strokes: list[Stroke] = []
    edges: list[Sighting] = []
    stopped = False
    run.forces.clear()
    try:
        for heading in (axes[:, 0], axes[:, 1]):
            say("following the surface")
            _across(run, heading, speed, strokes, edges)
    except (OverPress, Collision) as error:
        run.warnings.append(str(error))
        first, stopped = Contacts.concatenate([first, error.kept]), True
    say("feeling the curvature")
    seen = dwell(run.guard, pad.config.averaged)
    felt = feel(seen.image)
    cut = bool(pad.sightings())  # by an edge, which four directions would take for curvature
    curvature = four_direction_curvature(seen.image, felt) if felt and not cut else None
    contacts = Contacts.concatenate([first, *(stroke.contacts for stroke in strokes)])
    return SurfaceTrack(
        contacts,
        curvature,
        rank(contacts) if len(contacts) else (),
        (*(stroke.ended for stroke in strokes), *([_STOPPED] if stopped else ())),
        tuple(edges),
        float(sum(stroke.travel for stroke in strokes)),
        list(run.forces),
    )


def _across(
    run: FeltRun, heading: Floats, speed: float, strokes: list[Stroke], edges: list[Sighting]
) -> None:
    """To the edge on one side, to the edge on the other, and back to the middle."""
    pad, cost, travel = run.pad, run.guard.cost, 0.0
    for sign in (1.0, -1.0):
        cost.strokes += 1
        config = StrokeConfig(speed=speed)
        stroke = follow_surface(run.guard, sign * heading, LONGEST, cost.touches, cost.strokes, config=config)
        strokes.append(stroke)
        travel = stroke.travel
        if stroke.ended == "edge":
            edges.extend(pad.sightings(sign * heading))
        if stroke.ended in ("closed", "lost"):
            return
    pad.stroke(heading, travel / 2.0)
