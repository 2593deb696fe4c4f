"""Edges that were seen: which of them lead to a face not known yet, and the way over one."""

from __future__ import annotations

import numpy as np

from exploration.control.procedures.settle import NARROW
from exploration.control.sighting import Sighting
from exploration.planning.open.frontier import Predicted
from exploration.planning.touching.findings import Done, ExplorerConfig, outward_normal
from exploration.planning.touching.study import Study
from exploration.planning.ways.transit import Support
from primitives import pose as se3
from primitives.arrays import Floats
from primitives.fit import Fit

_STANDOFF = 10.0  # [mm] before an approach
_BESIDE_EDGE = 4.0  # [mm] within which two crossings went over the same edge
_PAST, _ASIDE = 2.0, 20.0  # [mm] past an edge, and along it, where the face that it ends is not
_ALONG = 0.9  # least cosine between an edge's way out and a round face's straight lines, which it ends square


class Crossing:
    """Rolls over edges that no other known face explains."""

    def __init__(self, study: Study, config: ExplorerConfig) -> None:
        self.study, self.config = study, config
        self._crossed: list[Floats] = []

    def open_sighting(self, face: int | None) -> tuple[Sighting, int] | None:
        """An edge seen from one face that no other explains; from the present face if there is one."""
        study = self.study
        study.seen = [(s, own) for s, own in study.seen if not self._explained(s, own)]
        here = study.pad.here.point
        return min(
            study.seen,
            key=lambda pair: (pair[1] != face, float(np.linalg.norm(pair[0].point - here))),
            default=None,
        )

    def cross(self, sighting: Sighting, own: int) -> Done:
        """Roll over an edge onto the face behind it."""
        pad, tried = self.study.pad, self._times_crossed(sighting)
        self._crossed.append(sighting.point)
        if tried >= len(self.config.roll):
            return self._press_between(sighting, own)
        angle = np.radians(self.config.roll[tried])
        normal = np.cos(angle) * sighting.normal + np.sin(angle) * sighting.outward
        down = np.cos(angle) * sighting.outward - np.sin(angle) * sighting.normal
        reach = 0.5 * min(pad.size) - self.config.overlap
        target = se3.pose(pad.attitude(normal, sighting.tangent), sighting.point + max(reach, 0.0) * down)
        if self._is_barred(target):
            self.study.found.barred.append((sighting, own))
            return None, "what lies beside leaves no room over an edge"
        pad.travel(target, Support(sighting.point, sighting.normal), standoff=_STANDOFF)
        if not pad.touch(target, standoff=_STANDOFF, overtravel=16.0):
            return None, "crossed an edge and met nothing"
        face = self.study.face_here()
        if face is not None and face != own and self._passes(face, sighting.point):
            self._crossed.extend([sighting.point] * len(self.config.roll))
        return face, "rolled back onto the same face" if face == own else "crossed an edge"

    def this_side(self, predicted: Predicted) -> Predicted:
        """Those predicted places of a face that are not past an edge of it that there was no room to cross."""
        past = np.zeros(len(predicted.points), dtype=bool)
        for edge, own in self.study.found.barred:
            away, way = predicted.points - edge.point, self._way_past(edge, own)
            beside = np.abs(away @ edge.tangent) < _ASIDE
            past |= (predicted.face == own) & beside & (away @ way > _PAST)
        return Predicted(predicted.points[~past], predicted.normals[~past], predicted.face[~past])

    def _way_past(self, edge: Sighting, own: int) -> Floats:
        """(3,) way to where a convex face is not that ends at an edge; zero where that is not so all along it.

        A round face goes on beyond the tangent at an edge along its axis, as of a flat on a bar.
        """
        fit = self.study.found.fit_of(own)
        if fit is None or fit.kind == "plane":
            return edge.outward
        if fit.kind not in ("cylinder", "cone"):
            return np.zeros(3)
        axis = fit.shape.direction
        line = axis - float(axis @ edge.normal) * edge.normal
        along = float(line @ edge.outward) / max(float(np.linalg.norm(line)), 1e-9)
        return axis * np.sign(along) if abs(along) > _ALONG else np.zeros(3)

    def _press_between(self, sighting: Sighting, own: int) -> Done:
        """Press on what may be a face too narrow to roll onto: midway between the two beside it, unmoved."""
        normal = sighting.outward
        behind = [f for f in self.study.found.graph.faces if f.id != own and isinstance(f.fit, Fit)]
        facing = [n for f in behind if (n := outward_normal(f, sighting.point)) @ sighting.outward > 0.1]
        if facing:
            nearest = min(facing, key=lambda n: abs(float(n @ sighting.tangent)))
            normal = nearest + sighting.normal
            normal = normal - (normal @ sighting.tangent) * sighting.tangent
            normal = normal / np.linalg.norm(normal)
        down = np.cross(sighting.tangent, normal)
        down = down * -np.sign(down @ sighting.normal)
        attitude = self.study.pad.attitude(normal, sighting.tangent)
        target = se3.pose(attitude, sighting.point + self.config.aside * down)
        if self._is_barred(target):
            return None, "what lies beside leaves no room between two faces"
        self.study.pad.travel(target, Support(sighting.point, sighting.normal), standoff=_STANDOFF)
        if not self.study.pad.touch(target, standoff=_STANDOFF, overtravel=16.0, settling=NARROW):
            return None, "pressed between two faces and met nothing"
        return self.study.face_here(), "pressed between two faces"

    def _is_barred(self, target: Floats) -> bool:
        """Whether what is known to stand beside the object leaves no room to come at a (4, 4) target."""
        told, back = self.study.pad.told, se3.pose(translation=[0.0, 0.0, -_STANDOFF])
        return told is not None and not (told.leads_past(target @ back) and told.leads_past(target))

    def _explained(self, sighting: Sighting, own: int) -> bool:
        if self._times_crossed(sighting) > len(self.config.roll):
            return True
        for face in self.study.found.graph.faces:
            if face.id == own or not isinstance(face.fit, Fit):
                continue
            normal = outward_normal(face, sighting.point)
            slack = self.config.explained + 2.0 * sighting.sigma
            near = abs(float(face.fit.shape.signed_distance(sighting.point[None])[0])) < slack
            if near and abs(normal @ sighting.tangent) < 0.5 and normal @ sighting.outward > 0.1:
                return True
        return self._goes_on(sighting, own)

    def _goes_on(self, sighting: Sighting, own: int) -> bool:
        """Whether the face was touched beyond the edge that was seen, which then was none."""
        fit = self.study.found.fit_of(own)
        if fit is None:
            return all(face.id != own for face in self.study.found.graph.faces)
        beyond = fit.shape.project((sighting.point + 5.0 * sighting.outward)[None])
        return bool(self.study.pad.covered.covers(beyond, 2.0)[0])

    def _times_crossed(self, sighting: Sighting) -> int:
        return sum(float(np.linalg.norm(p - sighting.point)) < _BESIDE_EDGE for p in self._crossed)

    def _passes(self, face: int, point: Floats) -> bool:
        """Whether a face, once found, runs so near a place that it bounds the edge seen there."""
        fit = self.study.found.fit_of(face)
        return fit is not None and abs(float(fit.shape.signed_distance(point[None])[0])) < self.config.passes
