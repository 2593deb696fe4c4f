"""Round holes that no array has room in: their rims looked at.

The pad lies over a rim and averages; one circle explains all frames (`sensing.lines.round_hole`).  What lies
between two rims is inferred (`open.holes`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product

import numpy as np

from exploration.control.dwell import dwell
from exploration.control.procedures.land import AS_TOLD
from exploration.control.procedures.settle import AS_IT_CAME, SettleConfig
from exploration.planning.open.round_rims import RoundRim, aside
from exploration.planning.touching.findings import Attempts, Done, SeenRim
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.study import Study
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.round_hole import RoundHole, fit_round_hole
from primitives import pose as se3
from primitives.arcs import around
from primitives.arrays import Floats
from primitives.evidence import Contacts
from primitives.fit import Fit
from primitives.pose import frame_along
from primitives.shapes import Shape


@dataclass(frozen=True)
class RoundHolesConfig:
    """How rims are looked at."""

    frames: int = 16  # averaged
    under: float = 0.35  # of the pad's shorter side: a hole of less radius is seen whole by one look
    looks: int = 4  # at a larger one
    most: int = 6  # touches for one rim
    over: float = 1.5  # [mm] of the pad's middle outside the rim of a large one
    apart: float = 0.6  # [rad] between two looks
    off: float = 2.5  # [mm] of the pad from the face, that it lies on yet
    flush: float = 0.93  # least cosine between the two, likewise
    upright: float = 0.1  # most cosine between a hole's axis and the face behind an edge beside it
    edge: float = 40.0  # [mm] from its axis, where an edge is beside it
    felt: float = 20.0  # [mm] from that, within which that face was felt
    own_outer: float = 1.0  # [mm] from the outer circle of its ring, within which an edge is that circle
    just_past: tuple[float, float] = (1.0, 4.0)  # [mm] past an edge, where a face was felt that goes on
    strays: int = 3  # contacts there, up to which it ends all the same
    beside: float = 4.0  # [mm] between rims that are tried as one,
    as_wide: float = 4.0  # [mm] and between their radii
    middle: float = 0.6  # of its radius, where a hole shows if there is one,
    round_it: float = 6.0  # [mm] outside it, up to which the face shows,
    missing: float = 0.4  # and share of what shows there, that shows inside at most
    closed: float = 4.5  # [rad] round what is missing, over which the face shows at least
    guessed: float = 2.0  # [mm] between edges that one end of a tube was guessed from
    narrow: float = 0.5  # of the pad's shorter side, of a ring as guessed: on one no wider no pad can lie


class RoundHoles:
    """The rims of one exploration."""

    def __init__(self, study: Study, reach: Reach, config: RoundHolesConfig = RoundHolesConfig()) -> None:
        self.study, self.reach, self.config = study, reach, config
        self._seen = Attempts(1, config.beside)
        self._missed: list[RoundRim] = []

    def next(self, openings: Sequence[RoundRim]) -> Callable[[], Done] | None:
        """A look at the nearest rim that was not looked at yet."""
        here = self.study.pad.guard.world_from_sensor[:3, 3]
        left = [rim for rim in openings if not self._given_up(rim) and not self._on_a_ring(rim, openings)]
        if not left:
            return None
        nearest = min(left, key=lambda rim: float(np.linalg.norm(rim.center - here)))
        return partial(self._measure, nearest)

    def _on_a_ring(self, rim: RoundRim, openings: Sequence[RoundRim]) -> bool:
        """Whether another opening, looked at from the same side, is a rim's, and tells where its face ends."""
        return not np.isfinite(rim.outer) and any(
            np.isfinite(other.outer)
            and float(rim.axis @ other.axis) > 0.0
            and float(np.linalg.norm(rim.center - other.center)) < self.config.beside
            and not self._given_up(other)
            for other in openings
        )

    def _bare(self, rim: RoundRim) -> bool:
        """Whether nobody lay on what is round a rim, so that it counts to the round face beside it."""
        own = self.study.found.fit_of(rim.face)
        return own is not None and own.kind != "plane"

    def _slim(self, rim: RoundRim) -> bool:
        """Whether the ring round a rim is too narrow for the pad to lie on."""
        return self._bare(rim) or rim.outer - rim.radius < self.config.narrow * min(self.study.pad.size)

    def _given_up(self, rim: RoundRim) -> bool:
        """Whether one was seen there, or none about as wide: a far end is guessed as wide as the near one."""
        return self._seen.given_up(rim.center) or any(
            float(np.linalg.norm(rim.center - other.center)) < self.config.beside
            and abs(rim.radius - other.radius) < self.config.as_wide
            for other in self._missed
        )

    def _measure(self, rim: RoundRim) -> Done:
        pad, frames, used = self.study.pad, list[tuple[TactileImage, Floats]](), list[Floats]()
        small = rim.radius < self.config.under * min(pad.size)
        looks, led = 1 if small else self.config.looks, 0
        found: RoundHole | None = None
        ends = self._ends(rim)
        bare, slim = self._bare(rim), self._slim(rim)
        settling = AS_IT_CAME if slim else SettleConfig()
        for give, (way, pose) in product((False, True), self._places(rim, small)):
            if not small and any(way @ other > np.cos(self.config.apart) for other in used):
                continue
            met = self.reach.touch(pose, give, settling, AS_TOLD)
            led += self.reach.led
            if met and self._lies(rim):
                seen = dwell(pad.guard, self.config.frames)
                frames.append((seen.image, seen.world_from_sensor))
                used.append(way)
                found = fit_round_hole(frames, rim.center, rim.axis, rim.radius, rim.outer, ends, flush=slim)
            if led >= self.config.most or (found is not None and len(frames) >= looks):
                break
        if found is None:
            self._missed.append(rim)
            if frames and not bare:
                self.study.found.refuted.append(rim.center)
                wide = max(self._opening(*look, rim) for look in frames)
                self.study.found.odd += [replace(rim, radius=wide)] if wide > 0.0 else []
            return None, "no round rim was made out"
        better = replace(rim, center=found.center, radius=found.radius, sigma=found.sigma, measured=True)
        self._seen.note(rim.center, found.center)
        ring = self.study.narrow_face(found.face, rim.axis, len(frames)) if bare or slim else None
        if ring is not None:
            rise = float(((found.face - found.center) @ rim.axis).mean())
            better = replace(better, face=ring, center=found.center + rise * rim.axis)
            guessed = self.study.found.wall_rims
            self.study.found.wall_rims = [edge for edge in guessed if not self._led_here(edge, rim)]
        self.study.found.rims.append(better)
        return None, "looked at the rim of a round hole"

    def _opening(self, image: TactileImage, pose: Floats, rim: RoundRim) -> float:
        """[mm] radius of as much as is missing of a face where a hole was thought; 0 where it is not missing."""
        x, y = np.meshgrid(image.array.x, image.array.y)
        flat = np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3)
        away = aside(se3.transform_points(pose, flat), rim.center, rim.axis)
        seen = np.isfinite(image.sigma.ravel()) & (away < rim.radius + self.config.round_it)
        if not seen.any():
            return 0.0
        depth = image.depth.ravel()
        missing = seen & (depth < self.config.missing * float(np.quantile(depth[seen], 0.9)))
        if not missing[away < self.config.middle * rim.radius].any():
            return 0.0
        face = se3.transform_points(pose, flat[seen & ~missing]) @ frame_along(rim.axis)
        middle = se3.transform_points(pose, flat[missing]).mean(axis=0) @ frame_along(rim.axis)
        if around(np.arctan2(*(face - middle)[:, 1::-1].T)) < self.config.closed:
            return 0.0  # where the face ends, much is missing beside it
        cell = image.array.pitch[0] * image.array.pitch[1]
        return float(np.sqrt(missing.sum() * cell / np.pi))

    def _led_here(self, edge: SeenRim, rim: RoundRim) -> bool:
        """Whether an edge is where a tube was guessed to end, which the look at its ring told better."""
        seen, own = edge
        off = abs(float((seen.point - rim.center) @ rim.axis))
        out = float(seen.outward @ rim.axis)
        return own == rim.face and off < self.config.guessed and out > self.config.flush

    def _lies(self, rim: RoundRim) -> bool:
        """Whether the pad lies on the face that a rim is on, and has not rolled off it."""
        pose = self.study.pad.guard.world_from_sensor
        off = abs(float((pose[:3, 3] - rim.center) @ rim.axis))
        return off < self.config.off and float(pose[:3, 2] @ rim.axis) < -self.config.flush

    def _ends(self, rim: RoundRim) -> list[tuple[Shape, float]]:
        """What its face ends at beside it: upright faces felt near it, each with the sign of distances past it.

        A neck behind a flange is no end of the flange's face, which was felt past it.
        """
        found: list[tuple[Shape, float]] = []
        faces = self.study.found.graph.faces
        own = Contacts.concatenate([face.contacts for face in faces if face.id == rim.face]).points
        for face in faces:
            if not isinstance(face.fit, Fit) or not len(face.contacts):
                continue
            shape, side = face.fit.shape, 1.0 if face.fit.convex else -1.0
            foot = shape.project(rim.center[None])[0]
            past = side * float(shape.signed_distance(rim.center[None])[0])
            leans = abs(float(shape.normals(foot[None])[0] @ rim.axis))
            near = float(np.linalg.norm(face.contacts.points - foot, axis=1).min()) < self.config.felt
            beyond = side * shape.signed_distance(own[np.linalg.norm(own - foot, axis=1) < self.config.felt])
            first, end = self.config.just_past
            if np.count_nonzero((beyond > first) & (beyond < end)) > self.config.strays:
                continue
            if abs(past + rim.outer) < self.config.own_outer:
                continue  # the ring's own outer circle, which is told by `outer` already
            if near and leans < self.config.upright and -self.config.edge < past < -0.5 * rim.radius:
                found.append((shape, side))
        return found

    def _places(self, rim: RoundRim, small: bool) -> list[tuple[Floats, Floats]]:
        """Ways from the center of a rim, each with a (4, 4) place of the pad over it; the best first."""
        half = 0.5 * min(self.study.pad.size)
        ways = rim.places(16)[1][[0, 4, 8, 12, 2, 6, 10, 14, 1, 5, 9, 13, 3, 7, 11, 15]]
        found: list[tuple[Floats, Floats]] = []
        over = min(rim.radius + self.config.over, 0.5 * (rim.radius + rim.outer))
        for far in (0.0, 0.5 * half, half) if small else (over,):
            for way in ways[::4] if far == 0.0 else ways:
                for along in (np.cross(rim.axis, way), way):
                    turn = self.study.pad.attitude(rim.axis, along)
                    found.append((way, se3.pose(turn, rim.center + far * way)))
        return found
