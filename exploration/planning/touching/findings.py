"""What exploration was told and what it has so far: its settings, its findings, and the places it went for."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from scipy.spatial import KDTree

from exploration.control.sighting import Sighting
from exploration.devices.guard import Cost
from exploration.planning.faces.attribution import CONVEX, AttributionConfig
from exploration.planning.open.frontier import Predicted
from exploration.planning.open.round_rims import RoundRim
from primitives.arrays import Floats, Ints
from primitives.evidence import EdgeTrace
from primitives.fit import Fit
from primitives.patch_graph import Face, PatchGraph
from primitives.plate import Plate

Done = tuple[int | None, str]  # the face that a move ended on, and what it did
SeenRim = tuple[Sighting, int]  # a rim, and the face that ends there


@dataclass(frozen=True)
class ExplorerConfig:
    """Distances and limits of exploration."""

    feature: float = 10.0  # [mm] the smallest feature that must not be missed
    max_touches: int = 500
    max_minutes: float = 30.0  # of the stage
    early: float = 0.65  # of what is left of both, that an array before the last may take
    explained: float = 0.8  # [mm] from a known face, an edge seen needs no crossing
    passes: float = 2.0  # [mm] from a face that a crossing led to, its edge is explained by it
    roll: tuple[float, ...] = (60.0, 95.0)  # [deg] attitudes from which an edge is crossed, in turn
    aside: float = 2.0  # [mm] beyond an edge that leads only to known faces, where a narrow one is looked for
    overlap: float = 5.0  # [mm] of the pad that reaches back over the edge
    tries: int = 3  # at the same open thing
    doubts: int = 10  # touches more on a face that is not known well
    beside: float = 8.0  # [mm] from a place that was tried before, where another way in is taken
    region: float = 40.0  # [mm] of open surface that is come at as one
    change: float = 20.0  # [mm] off the object, before another array is turned to it
    stopped: int = 8  # moves on end that something stopped where a convex object leaves room: it is none
    first_tries: int = 60  # touches after which an object that shows no face is given up
    attribution: AttributionConfig = field(default_factory=AttributionConfig)
    policy: str = "closure"  # or one of `survey.POLICIES`, to measure against
    seed: int = 0  # of a policy that draws at random

    def spent(self, cost: Cost) -> bool:
        """Whether all touches, or all time, that it may take are taken."""
        return cost.touches >= self.max_touches or cost.seconds >= 60.0 * self.max_minutes

    def before_others(self, cost: Cost) -> ExplorerConfig:
        """The same for an array after which another comes: it may take a share of what is left."""
        touches, minutes = cost.touches, cost.seconds / 60.0
        return replace(
            self,
            max_touches=touches + int(self.early * max(0, self.max_touches - touches)),
            max_minutes=minutes + self.early * max(0.0, self.max_minutes - minutes),
        )


class Stopped(NamedTuple):
    """What came down in a round hole, and where it was stopped."""

    rim: Floats  # (3,) [mm] center of the hole's rim
    off: float  # [mm] from its axis
    deep: float  # [mm] behind it


class Bore(NamedTuple):
    """The wall of a round hole, where an array that went aside in it was stopped."""

    center: Floats  # (3,) [mm] on its axis, at the level of its rim
    axis: Floats  # (3,) out of it
    radius: float  # [mm]
    deep: float  # [mm] behind its rim, where that was


@dataclass
class Findings:
    """What exploration has so far; read it whenever the generator yields."""

    graph: PatchGraph = field(default_factory=lambda: PatchGraph(options=CONVEX))
    traces: list[tuple[EdgeTrace, tuple[int, int]]] = field(default_factory=list)
    inside: list[Floats] = field(default_factory=list)  # (n, 3) places [mm] that an array was in
    rims: list[RoundRim] = field(default_factory=list)  # of round holes, looked at
    refuted: list[Floats] = field(default_factory=list)  # (3,) where a rim was looked for, and none is
    odd: list[RoundRim] = field(default_factory=list)  # likewise, though something opens there
    stopped: list[Stopped] = field(default_factory=list)  # in holes that narrow
    bores: list[Bore] = field(default_factory=list)  # holes that an array went aside in
    wall_rims: list[SeenRim] = field(default_factory=list)  # others looked at
    barred: list[SeenRim] = field(
        default_factory=list
    )  # edges that there was no room to roll over, or to lie past
    glimpsed: list[SeenRim] = field(default_factory=list)  # edges that parts of a pad showed
    strip_ends: list[Sighting] = field(default_factory=list)  # edges that ended a narrow contact under a pad
    plates: list[Plate] = field(default_factory=list)  # pairs of faces whose outlines are known
    openings: list[RoundRim] = field(default_factory=list)  # whose depth is not known
    hollow: bool = False  # whether the object has turned out not to be convex
    ended: str = ""
    open: int = 0  # things still open, when last counted
    note: str = ""
    warnings: list[str] = field(default_factory=list)

    def fit_of(self, face: int | None) -> Fit | None:
        """The fitted surface of a face, where it has one."""
        found = next((f.fit for f in self.graph.faces if f.id == face), None)
        return found if isinstance(found, Fit) else None

    def rename(self, gone: dict[int, int]) -> None:
        """Call faces that turned out to be others by the ids of those, wherever a rim is on one."""
        self.wall_rims, self.glimpsed, self.barred = (
            [(sighting, gone.get(own, own)) for sighting, own in seen]
            for seen in (self.wall_rims, self.glimpsed, self.barred)
        )
        self.rims = [replace(rim, face=gone.get(rim.face, rim.face)) for rim in self.rims]

    @property
    def named(self) -> frozenset[int]:
        """The faces that have a shape."""
        return frozenset(face.id for face in self.graph.faces if isinstance(face.fit, Fit))


class Attempts:
    """The places that moves have gone for, so that none is tried for ever."""

    def __init__(self, tries: int, within: float = 1.5) -> None:
        self._most, self._within = tries, within
        self._places: list[Floats] = []

    def note(self, *places: Floats) -> None:
        """Remember (3,) places that a move goes for."""
        self._places.extend(places)

    def counts(self, places: Floats, within: float | None = None) -> Ints:
        """(n,) how often a move has gone for each of (n, 3) places."""
        if not self._places or not len(places):
            return np.zeros(len(places), dtype=np.int64)
        within = self._within if within is None else within
        return np.asarray(KDTree(self._places).query_ball_point(places, within, return_length=True))

    def count(self, place: Floats, within: float | None = None) -> int:
        """How often a move has gone for this place."""
        if not self._places:
            return 0
        within = self._within if within is None else within
        away = np.concatenate(self._places).reshape(-1, 3) - place
        return int(np.count_nonzero((away * away).sum(axis=1) <= within * within))

    def given_up(self, place: Floats) -> bool:
        """Whether it was tried often enough."""
        return self.count(place) >= self._most

    def unfinished(self, missing: Predicted) -> Predicted:
        """The predicted points that are still worth a try."""
        keep = self.counts(missing.points) < self._most
        return Predicted(missing.points[keep], missing.normals[keep], missing.face[keep])


def outward_normal(face: Face, point: Floats) -> Floats:
    """(3,) outward normal of a fitted face at the place on it nearest to a (3,) point."""
    assert isinstance(face.fit, Fit)
    return np.asarray(face.fit.shape.normals(point[None])[0] * (1.0 if face.fit.convex else -1.0))
