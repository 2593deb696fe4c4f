"""Surface that the faces so far predict and nothing has touched: stroked over, or come down on."""

from __future__ import annotations

import numpy as np

from exploration.control.procedures.settle import NARROW
from exploration.control.track_surface import Stroke
from exploration.planning.open.frontier import Predicted
from exploration.planning.touching.findings import Attempts, Done, ExplorerConfig
from exploration.planning.touching.study import Study
from exploration.planning.ways.transit import Support
from primitives import pose as se3
from primitives.arrays import Floats


class Covering:
    """Touches what is only predicted."""

    def __init__(self, study: Study, tried: Attempts, config: ExplorerConfig) -> None:
        self.study, self.tried, self.config = study, tried, config
        self.doubted: dict[int, int] = {}  # how often each face was touched again
        self.revisited = Attempts(1, config.overlap)
        self.pressed = Attempts(2, 1.5)  # where the prediction was contradicted
        self._visited = Attempts(config.tries, config.beside)
        self._missed = False  # whether nothing was where it touched down last

    def cover(self, missing: Predicted, face: int | None) -> Done:
        """Stroke from here over what is untouched on this face, or touch down where it is nearest."""
        pad = self.study.pad
        fresh = self.tried.counts(missing.points) == 0
        on_face = (missing.face == face) & fresh
        if face is not None and on_face.any() and self._flush_on(face):
            points = missing.points[on_face]
            goal = points[np.argmin(np.linalg.norm(points - pad.here.point, axis=1))]
            self.tried.note(goal)
            here = pad.guard.world_from_sensor
            toward = here[:3, :2].T @ (goal - here[:3, 3])
            distance = float(np.linalg.norm(toward))
            if distance > 1.0:
                stroke = pad.stroke(toward / distance, distance + self.config.feature)
                self._note_edges(stroke, face, toward / distance)
                if stroke.travel < 1.0:
                    self.tried.note(*_beyond(points, goal, pad.here.point))
                taken = self.study.take_in(stroke.contacts) if len(stroke.contacts) else None
                return face if taken is None else taken, "stroked what was untouched"
        return self._visit(missing)

    def _note_edges(self, stroke: Stroke, face: int, heading: Floats) -> None:
        if stroke.ended == "edge":
            self.study.seen.extend((edge, face) for edge in self.study.pad.sightings(heading))

    def _visit(self, missing: Predicted) -> Done:
        """Touch down at a predicted point; where that did not help before, come to the middle of what is open.

        Faces that go on too far, as a cone to an apex that was cut off, predict points where nothing is.
        The mean of their normals is the way in from outside.  A pad that settles may slip off a place beside an
        edge: the last try presses there unmoved.  Who met nothing goes on next to what was touched, where the face
        is yet, and not next to where it is not.
        """
        pad = self.study.pad
        off_pad = np.linalg.norm(missing.points - pad.here.point, axis=1)
        nearest = int(np.argmin(pad.covered.away(missing.points) if self._missed else off_pad))
        point, normal = missing.points[nearest], missing.normals[nearest]
        standoff, overtravel = 8.0, 10.0
        last = self.tried.count(point) == self.config.tries - 1
        again = self._visited.count(point) > 0 and not last
        self._visited.note(point)
        if again:
            around = np.linalg.norm(missing.points - point, axis=1) < self.config.region
            middle = missing.normals[around].mean(axis=0)
            if np.linalg.norm(middle) > 0.2:
                normal = middle / np.linalg.norm(middle)
                point = missing.points[around].mean(axis=0)
                standoff = float(((missing.points[around] - point) @ normal).max()) + standoff
                overtravel = self.config.region
        self.tried.note(missing.points[nearest])
        hint = pad.guard.world_from_sensor[:3, 0]
        target = se3.pose(se3.frame_along(-normal, hint), point)
        pad.travel(target, Support(point, normal), standoff)
        self._missed = not pad.touch(target, standoff, overtravel, settling=NARROW if last else None)
        if self._missed:
            return None, "nothing was where the faces so far predict the surface"
        if last:
            return self.study.take_in(pad.feel()), "pressed on a place that was only predicted"
        return self.study.face_here(), "touched a place that was only predicted"

    def revisit(self, doubtful: Predicted) -> Done:
        """Touch again, unmoved, where a known face is least certain."""
        pad = self.study.pad
        point, normal, face = doubtful.points[0], doubtful.normals[0], int(doubtful.face[0])
        self.revisited.note(point)
        self.doubted[face] = self.doubted.get(face, 0) + 1
        target = se3.pose(se3.frame_along(-normal, pad.guard.world_from_sensor[:3, 0]), point)
        pad.travel(target, Support(point, normal), 8.0)
        if not pad.touch(target, 8.0, 10.0, settling=NARROW):
            return None, "nothing was where a face is in doubt"
        found = self.study.take_in(pad.feel())
        return found, "touched a face again that is in doubt"

    def worth_revisiting(self, doubtful: Predicted) -> Predicted:
        """Those of the doubtful points that were not tried often, on faces that were not."""
        left = self.revisited.unfinished(doubtful)
        keep = np.array([self.doubted.get(int(f), 0) < self.config.doubts for f in left.face], dtype=bool)
        return Predicted(left.points[keep], left.normals[keep], left.face[keep])

    def press_where_free(self, opened: Predicted) -> Done:
        """Press, unmoved, where the skin felt free space that the faces so far take for material."""
        pad = self.study.pad
        nearest = int(np.argmin(np.linalg.norm(opened.points - pad.here.point, axis=1)))
        around = np.linalg.norm(opened.points - opened.points[nearest], axis=1) < self.config.beside
        self.pressed.note(*opened.points[around])
        normals = np.unique(np.round(opened.normals[around], 1), axis=0)
        normal = normals.mean(axis=0)
        if float(np.linalg.norm(normal)) < 0.2:
            normal = opened.normals[nearest]
        normal = normal / np.linalg.norm(normal)
        point = opened.points[around].mean(axis=0)
        standoff = 8.0 + float(((opened.points[around] - point) @ normal).max())
        target = se3.pose(se3.frame_along(-normal, pad.guard.world_from_sensor[:3, 0]), point)
        pad.travel(target, Support(point, normal), standoff)
        if not pad.touch(target, standoff, self.config.region, settling=NARROW):
            return None, "pressed where a corner is missing and met nothing"
        return self.study.face_here(), "pressed where less is than the faces so far predict"

    def _flush_on(self, face: int) -> bool:
        """Whether the pad lies on that face now."""
        fit = self.study.found.fit_of(face)
        if fit is None or not self.study.pad.touches():
            return False
        return abs(float(fit.shape.signed_distance(self.study.pad.here.point[None])[0])) < 2.0


def _beyond(points: Floats, goal: Floats, here: Floats) -> Floats:
    """Those of (n, 3) points that lie the same way from `here` as a goal that could not be stroked to."""
    toward = points - here
    ahead = toward @ (goal - here) > 0.8 * np.linalg.norm(toward, axis=1) * np.linalg.norm(goal - here)
    return np.asarray(points[ahead])
