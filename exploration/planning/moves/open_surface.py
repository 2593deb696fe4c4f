"""Surface that goes on where nothing was felt: stroked toward from where the pad lies, or come down on.

Where something that was felt leaves the pad no room there, as the side of a boss, it comes down from over that, on
what stands on the open place.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exploration.control.procedures.land import AS_TOLD
from exploration.control.procedures.settle import AS_IT_CAME
from exploration.control.sighting import Sighting
from exploration.planning.open.frontier import Predicted
from exploration.planning.open.lying import lying_places
from exploration.planning.touching.findings import Attempts, Done, ExplorerConfig, SeenRim
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.study import Study
from exploration.planning.ways.box_kernels import in_box
from primitives import pose as se3
from primitives.arrays import Bools, Floats
from primitives.fit import Fit


@dataclass(frozen=True)
class OpenSurfaceConfig:
    """How long open surface is believed in."""

    stuck: float = 1.0  # [mm] of a stroke, less than which there is no way from where the pad lies
    beside: float = 2.5  # [mm] between places that count as one
    misses: int = 5  # in a row on one face, from which it is taken to end where it was felt
    known: int = 60  # contacts of a face, from which
    known_misses: int = 12  # as many are
    over: float = 24.0  # [mm] over open surface that leaves no room, from which it is come down on
    flush: float = (
        0.6  # [mm] from a pad that lies on a face, within which places of that face are: no boss tilts it
    )
    level: float = 0.99  # least cosine between a pad and the face that it lies on, or where it was to lie
    lain: int = 2  # times that a pad lay over a place, from which another touch tells no more of it
    apart: float = 9.0  # [mm] between such places that are one
    guessed: float = 1.0  # [mm] 1 sigma of where a face that there is no room on may end
    top: float = 0.6  # [mm] over it, from which a felt place is the top of what stands there
    alike: float = 0.7  # least cosine between the ways that the two look
    off: float = 2.0  # [mm] from a pad that met nothing, within which surface would have been met


class OpenSurface:
    """What is tried where faces seem to go on."""

    def __init__(
        self, study: Study, reach: Reach, explorer: ExplorerConfig, config: OpenSurfaceConfig | None = None
    ) -> None:
        self.study, self.reach, self.feature = study, reach, explorer.feature
        self.config = config or OpenSurfaceConfig()
        self._tried = Attempts(explorer.tries - 1, self.config.beside)
        self._stuck = Attempts(1, self.config.beside)  # what no stroke led to; it may be come down on yet
        self._over = Attempts(1, self.config.apart)  # where it was come down from over what leaves no room
        self._missed: dict[int, int] = {}  # times in a row that the pad met something else, by face
        self._lain: list[tuple[Floats, int]] = []  # (4, 4) poses at which it lay where a face was open
        self._nothing: list[Floats] = []  # (4, 4) poses at which it met nothing

    def left(self, opened: Predicted) -> Predicted:
        """What of it is still worth a try: not of a face that was missed too often."""
        done = [face for face, count in self._missed.items() if count >= self._most(face)]
        keep = ~np.isin(opened.face, done)
        for pose in self._nothing:
            keep &= ~self._under(opened, pose)
        lain = np.zeros(len(keep), dtype=np.int64)
        for pose, face in self._lain:
            lain += self._under(opened, pose, self.config.flush) & (opened.face == face)
        keep &= lain < self.config.lain
        believed = Predicted(opened.points[keep], opened.normals[keep], opened.face[keep])
        return self._tried.unfinished(believed)

    def near(self, left: Predicted, face: int) -> Floats | None:
        """(3,) the place of a face that is left, nearest to the pad on it, that a stroke may lead to."""
        points = left.points[left.face == face]
        points = points[self._stuck.counts(points) == 0]
        if not len(points):
            return None
        here = self.study.pad.guard.world_from_sensor[:3, 3]
        return np.asarray(points[np.argmin(np.linalg.norm(points - here, axis=1))])

    def _most(self, face: int) -> int:
        """Misses in a row, from which a face is taken to end where it was felt: rims are all round a large one."""
        felt = next((len(f.contacts) for f in self.study.found.graph.faces if f.id == face), 0)
        return self.config.known_misses if felt >= self.config.known else self.config.misses

    def _under(self, opened: Predicted, pose: Floats, off: float | None = None) -> Bools:
        """(n,) which places a pad at a (4, 4) pose would have felt, up to `off` mm from it."""
        (x, y), off = self.study.pad.size, self.config.off if off is None else off
        low, high = (-0.5 * x, -0.5 * y, -off), (0.5 * x, 0.5 * y, off)
        return in_box(opened.points, pose, low, high)

    def stroke_to(self, goal: Floats, face: int) -> Done:
        """From where the pad lies, over a (3,) goal and on."""
        here = self.study.pad.guard.world_from_sensor
        toward = here[:3, :2].T @ (goal - here[:3, 3])
        distance = float(np.linalg.norm(toward))
        if distance < 1.0:
            self._tried.note(goal)
            return face, "lay on what was open"
        stroke = self.study.pad.stroke(toward / distance, distance + 0.5 * self.feature)
        self.study.note_wall(stroke)
        home = self.study.take_in(stroke.contacts) if len(stroke.contacts) else face
        (self._stuck if stroke.travel < self.config.stuck else self._tried).note(goal)
        return None if stroke.ended in ("wall", "lost") else home, "stroked what was open"

    def come_down(self, left: Predicted, chosen: int) -> Done:
        """Lie on open surface where the pad has room, with as much of it under the pad as may be."""
        point, face = left.points[chosen], int(left.face[chosen])
        self._tried.note(point)
        places = list(lying_places(left, chosen, self.alongs(left.normals[chosen]), self.study.pad.size))
        for pose in places:
            if self.reach.clear(pose):
                return self._lie(pose, face)
        self._tried.note(point)
        over = self._from_over(places) if places else None
        if over is None:
            self.study.found.barred += self._ends_before(point, left.normals[chosen], face)
        return over or (None, "the pad has no room on what is open")

    def _lie(self, pose: Floats, face: int) -> Done:
        """Come down on a face at a (4, 4) pose: rolling flush, or as it came where it rolls off a narrow land."""
        met = self.reach.touch(pose)
        there = met and self._lies_on(face)
        home = self.study.face_here() if met else None
        if home is None and not there and self.reach.led and self._rolled(pose):
            met = self.reach.touch(pose, False, AS_IT_CAME, AS_TOLD)
            there = met and self._lies_on(face)
            home = self.study.take_in(self.study.pad.feel()) if there else None
        if met:
            self._lain.append((self.study.pad.guard.world_from_sensor, face))
        elif self.reach.led:
            self._nothing.append(pose)
        if home == face or not there:
            self._missed[face] = 0 if home == face else self._missed.get(face, 0) + 1
        if home is None:
            return None, "what was open told no face" if there else "what seemed open was not there"
        return home, "came down on what was open"

    def _rolled(self, pose: Floats) -> bool:
        """Whether the pad has turned from a (4, 4) pose, at which it met something then."""
        return float(pose[:3, 2] @ self.study.pad.guard.world_from_sensor[:3, 2]) < self.config.level

    def _lies_on(self, face: int) -> bool:
        """Whether the pad lies where a face is, though it may not be able to tell it."""
        fit, pose = self.study.found.fit_of(face), self.study.pad.guard.world_from_sensor
        if fit is None:
            return False
        at = pose[None, :3, 3]
        faces = (1.0 if fit.convex else -1.0) * float(fit.shape.normals(at)[0] @ -pose[:3, 2])
        off = abs(float(fit.shape.signed_distance(at)[0]))
        return off < self.config.off and faces > self.config.level

    def _ends_before(self, point: Floats, normal: Floats, face: int) -> list[SeenRim]:
        """A flat face's edge as it may be where it was felt last before an open (3,) place, to be looked at."""
        fit, felt = self.study.found.fit_of(face), self.reach.felt
        if fit is None or fit.kind != "plane":
            return []
        cells = felt.points[felt.on(fit.shape, 1.0 if fit.convex else -1.0)]
        away = np.linalg.norm(cells - point, axis=1)
        if not len(cells) or away.min() > self.feature:
            return []
        last = cells[int(np.argmin(away))]
        out = point - last - float((point - last) @ normal) * normal
        out = out / max(float(np.linalg.norm(out)), 1e-9)
        tangent = np.cross(normal, out)
        return [(Sighting(last, tangent, out, normal, self.config.guessed, self.feature), face)]

    def _from_over(self, places: Sequence[Floats]) -> Done | None:
        """Down on what stands on an open place, if its top is not known; None where nobody can come over it."""
        for pose in places:
            up = self.reach.off(pose, self.config.over)
            if up <= 0.0 or self._over.given_up(pose[:3, 3]) or self._topped(pose):
                continue
            self._over.note(pose[:3, 3])
            met = self.reach.touch(pose @ se3.pose(translation=[0.0, 0.0, -up]))
            if met:
                return self.study.face_here(), "came down on what stands where surface was open"
            if self.reach.led:
                return None, "nothing stands where surface was open"
        return None

    def _topped(self, pose: Floats) -> bool:
        """Whether the top of what stands under a pad at a (4, 4) pose was felt."""
        felt, (x, y) = self.reach.felt, self.study.pad.size
        low, high = (-0.5 * x, -0.5 * y, -self.config.over), (0.5 * x, 0.5 * y, -self.config.top)
        over = in_box(felt.points, pose, low, high)
        return bool((felt.facing[over] @ -pose[:3, 2] > self.config.alike).any())

    def alongs(self, normal: Floats) -> list[Floats]:
        """Directions for the pad's x axis in a plane: along and across the faces that stand on it."""
        out: list[Floats] = []
        for face in self.study.found.graph.faces:
            if isinstance(face.fit, Fit) and face.fit.kind == "plane":
                across = se3.cross(face.fit.shape.direction, normal)
                if np.linalg.norm(across) > 0.3:
                    across = across / np.linalg.norm(across)
                    out += [
                        w for w in (across, se3.cross(normal, across)) if all(abs(w @ o) < 0.98 for o in out)
                    ]
        return out[:6] or [self.study.pad.guard.world_from_sensor[:3, 0]]
