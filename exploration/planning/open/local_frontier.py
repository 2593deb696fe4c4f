"""What is open on an object of any form, face by face: surface that goes on, and rims that no face explains.

Round every touched place of a face its surface is asked for a little further on.  There it is touched already; or
free, and the face has a rim in between; or a wall stands in between, and the face ends at an inside edge; or it is
open.  A rim is explained where another face passes by that looks to its free side (our derivation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import KDTree

from exploration.control.sighting import Sighting
from exploration.planning.known.mosaic import Mosaic
from exploration.planning.known.seen_pits import SeenPit
from exploration.planning.known.surface_map import SurfaceMap, clusters
from exploration.planning.open.frontier import Predicted
from exploration.planning.open.gaps import gaps
from exploration.planning.open.known_face import KnownFace
from exploration.planning.open.mouths import Mouth, mouths
from exploration.planning.open.pictured_pits import pictured_pits
from exploration.planning.open.pit_rims import pit_rims
from exploration.planning.open.rim_sightings import by_heading, rim_sighting
from exploration.planning.open.ring_ends import ring_ends
from exploration.planning.open.round_gaps import round_gaps
from exploration.planning.open.round_rims import RoundRim
from primitives.arrays import Bools, Floats
from primitives.evidence import NOT_FELT
from primitives.fit import Fit
from primitives.patch_graph import Face


@dataclass(frozen=True)
class LocalFrontierConfig:
    """Distances on a face."""

    explained: float = 2.5  # [mm] from a rim, within which a face that explains it passes
    felt: float = 16.0  # [mm] from a rim, within which that face was touched
    least_rim: int = 4  # touched cells of one
    known: float = 0.5  # share of a round gap's rim that a face must explain
    boss: tuple[float, float] = (1.0, 8.0)  # [mm] above a face, where something stands in a gap of it
    eccentric: tuple[float, float] = (3.0, 0.25)  # [mm], or of its radius, that a bore's gap is off its ring
    cluster: float = 6.0  # [mm] between neighbors of one rim


class LocalFrontier:
    """The open things of one moment; each is found once.

    What was felt and found free only grows: of a face that the `last` one knew, only what is new is looked at.
    """

    def __init__(
        self,
        faces: Sequence[Face],
        felt: SurfaceMap,
        free: Floats,
        feature: float,
        config: LocalFrontierConfig | None = None,
        last: LocalFrontier | None = None,
        pits: Sequence[SeenPit] = (),
        mosaic: Mosaic | None = None,
    ) -> None:
        self.config, self.reach = config or LocalFrontierConfig(), min(max(feature / 2.0, 3.0), 8.0)
        self.pits, self._mosaic = pits, mosaic
        old = {} if last is None else {id(own.face): own for own in last.known}
        seen = (0, 0) if last is None else last.extent
        self.known: list[KnownFace] = [
            old[id(face)].grown(felt, free, seen)
            if id(face) in old
            else KnownFace.of(face, face.fit, felt, free, self.reach)
            for face in faces
            if isinstance(face.fit, Fit)
        ]
        self.extent: tuple[int, int] = (len(felt.points), len(free))  # of what was known

    @cached_property
    def open(self) -> Predicted:
        """Places where a face may go on and nothing was felt."""
        points, normals, ids = [np.empty((0, 3))], [np.empty((0, 3))], [np.empty(0, dtype=np.int64)]
        for own in self.known:
            if not len(own.cells):
                continue
            at, came = own.further
            at = _thinned(at[~self._behind_wall(own, at, came)], 0.7 * self.reach)
            points.append(at)
            normals.append(own.side * own.fit.shape.normals(at))
            ids.append(np.full(len(at), own.face.id))
        return Predicted(np.concatenate(points), np.concatenate(normals), np.concatenate(ids))

    @cached_property
    def rims(self) -> list[tuple[Sighting, int]]:
        """Rims that no known face explains, each as an edge seen from its face; the longest first."""
        found: list[tuple[int, Sighting, int]] = []
        for own in self.known:
            at, out = own.rim
            left = ~self._explained(own, at, out)
            at, out = at[left], out[left]
            for members in clusters(at, self.config.cluster):
                if members.sum() < self.config.least_rim:
                    continue
                for part in by_heading(out[members]):
                    rows = np.flatnonzero(members)[part]
                    if len(rows) >= self.config.least_rim:
                        edge = rim_sighting(own.fit.shape, own.side, at[rows], out[rows])
                        found.append((len(rows), edge, own.face.id))
        return [(edge, face) for _, edge, face in sorted(found, key=lambda item: -item[0])]

    def mouths(self) -> list[Mouth]:
        """Ways across what is missing of each flat face, where no face is known behind the rim."""
        found: list[Mouth] = []
        for own, (at, out) in zip(self.known, self.ends(), strict=True):
            if own.fit.kind == "plane":
                found += mouths(own.cells, at, out, own.side * own.fit.shape.direction)
        return found

    def ends(self) -> list[tuple[Floats, Floats]]:
        """(n, 3) places at which each known face was felt last and no other explains it, and the ways out."""
        found = []
        for own in self.known:
            at, out = own.rim
            left = ~self._explained(own, at, out)
            found.append((at[left], out[left]))
        return found

    @cached_property
    def openings(self) -> list[RoundRim]:
        """Round gaps in flat faces, behind whose rim no face is known, and from which nothing stands up."""
        rings = [rim for rim in ring_ends(self.known) if not self._filled(rim)]
        found: list[RoundRim] = []
        for own in self.known:
            if own.fit.kind != "plane":
                continue
            axis = own.side * own.fit.shape.direction
            for rim in gaps(own.cells, own.free, axis, own.face.id):
                if any(self._concentric(rim, ring) for ring in rings):
                    continue
                at, ways = rim.places()
                if self._explained(own, at, -ways).mean() < self.config.known and not self._filled(rim):
                    found.append(rim)
                    rings = [ring for ring in rings if not rim.holds(ring.center)]
        found = [*rings, *found]
        for rim in pit_rims(self.pits, self.known):
            found += [] if self._known_as(rim, found) else [rim]
        return found

    @cached_property
    def narrow(self) -> list[RoundRim]:
        """Rims of narrow holes that only the pictures of flat faces show."""
        found = [] if self._mosaic is None else pictured_pits(self.known, self._mosaic)
        return [rim for rim in found if not self._known_as(rim, self.openings) and not self._filled(rim)]

    @cached_property
    def round_gaps(self) -> list[RoundRim]:
        """Mouths of round holes in round faces, behind whose rim no face is known, and which nothing fills."""
        found: list[RoundRim] = []
        for own in self.known:
            for rim in round_gaps(own):
                at, ways = rim.places()
                if self._explained(own, at, -ways).mean() < self.config.known and not self._filled(rim):
                    found.append(rim)
        return found

    def _concentric(self, rim: RoundRim, ring: RoundRim) -> bool:
        """Whether a gap is the bore of a ring, and no pocket beside the middle of what only seems one."""
        off = float(np.linalg.norm(rim.center - ring.center))
        least, share = self.config.eccentric
        return rim.holds(ring.center) and off < max(least, share * rim.radius)

    def _known_as(self, rim: RoundRim, others: Sequence[RoundRim]) -> bool:
        """Whether a narrow hole is one of other openings, or a face is known behind its rim."""
        if any(other.holds(rim.center) for other in others):
            return True
        own = next(own for own in self.known if own.face.id == rim.face)
        at, ways = rim.places()
        return bool(self._explained(own, at, -ways).mean() >= self.config.known)

    def _filled(self, rim: RoundRim) -> bool:
        """Whether a boss stands in a round gap: the face is not there, and no more is a hole."""
        low, high = self.config.boss
        away = np.concatenate([own.cells for own in self.known]) - rim.center
        up = away @ rim.axis
        aside = np.linalg.norm(away - up[:, None] * rim.axis, axis=1)
        return int(((up > low) & (up < high) & (aside < rim.radius)).sum()) >= self.config.least_rim

    def dented(self) -> bool:
        """Whether a flat face is not there among places where it is: no convex object has such."""
        return any(own.dented for own in self.known) or bool(pit_rims(self.pits, self.known))

    def placed(self) -> list[Face]:
        """The faces, flat ones without contacts where the face is not there.

        Contacts of a pad that bridged a slot stand for the plane on both its sides, not for places of their own.
        """
        return [self._without_bridges(own) for own in self.known]

    def _without_bridges(self, own: KnownFace) -> Face:
        free, points = own.free, own.face.contacts.points
        if own.fit.kind != "plane" or not len(free) or not len(own.cells):
            return own.face
        away = own.fit.shape.project(free)
        kept = np.asarray(own.near.query(points)[0] < KDTree(away).query(points)[0])
        kept |= own.face.contacts.touch == NOT_FELT
        return own.face.only(kept)

    def _behind_wall(self, own: KnownFace, at: Floats, came: Floats) -> Bools:
        """Whether another touched face stands between, or the place is inside its material."""
        out = np.zeros(len(at), dtype=bool)
        for other in self.known:
            if other is own or not len(other.cells) or not len(at):
                continue
            before = other.side * other.fit.shape.signed_distance(came)
            after = other.side * other.fit.shape.signed_distance(at)
            rows = np.flatnonzero(~out & (before > -1.0) & (after < 1.2) & (after < before - 0.3))
            out[rows] = other.touched(at[rows], self.config.felt)
        return out

    def _explained(self, own: KnownFace, at: Floats, out: Floats) -> Bools:
        told = np.zeros(len(at), dtype=bool)
        for other in self.known:
            if other is own or not len(other.cells) or not len(at):
                continue
            near = np.abs(other.fit.shape.signed_distance(at)) < self.config.explained
            looks = (other.side * other.fit.shape.normals(at) * out).sum(axis=1) > 0.1
            rows = np.flatnonzero(~told & near & looks)
            told[rows] = other.touched(at[rows], self.config.felt)
        return told


def _thinned(points: Floats, spacing: float) -> Floats:
    """One of every lot of points that share a cell."""
    if not len(points):
        return points
    _, first = np.unique(np.round(points / spacing).astype(int), axis=0, return_index=True)
    return np.asarray(points[np.sort(first)])
