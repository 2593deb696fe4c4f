"""What stands beside the object and is known beforehand: the table that it lies on, a fixture, a neighbor.

Contacts on it are not the object's, and nothing that only it hides is asked for.  Where the object lies on a table
the face that it hides is inferred to be on the table's top.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exploration.planning.ways.routes import Tool
from primitives import pose as se3
from primitives.arrays import Bools, Floats
from primitives.evidence import NOT_FELT, Contacts, Imprint
from primitives.surface import Surface


@dataclass(frozen=True)
class ToldConfig:
    """When something felt is what was told."""

    near: float = 0.5  # [mm] of a contact from it
    cell: float = 1.0  # [mm] of a touched taxel from it, which is placed less well
    facing: float = 0.9  # least cosine between their normals
    met: float = 6.0  # [mm] of where a stroke was stopped
    nearer: float = 0.5  # [mm] that an array comes on the way to what stops it,
    lately: float = 2.0  # in the last so many mm
    lies: float = 0.2  # [mm] over it, of the middle of a pad that lies on it: the skin gives
    room: float = 0.3  # [mm] round the housing, where the pad is to lie
    over: float = 1.5  # [mm] over the table, where the search for the object stops
    patch: float = 4.0  # [mm] round a place on the table, of the face that lies there
    sigma: float = 0.05  # [mm] of the table's height
    normal_sigma: float = 0.002  # [rad]


class Told:
    """Bodies of known surface and place; `table` [mm] is the height of the top that the object lies on."""

    def __init__(
        self,
        surface: Surface,
        points: Floats,
        tool: Tool,
        table: float | None = None,
        config: ToldConfig = ToldConfig(),
    ) -> None:
        self.surface, self.points, self.table = surface, points, table
        self._tool, self._config = tool, config

    def without(self, contacts: Contacts) -> Contacts:
        """The contacts less those that lie on what was told, or may: one without a normal belongs to either."""
        if not len(contacts):
            return contacts
        near = np.abs(self.surface.signed_distance(contacts.points)) < self._config.near
        alike = (self.surface.normals(contacts.points) * contacts.normals).sum(axis=1) > self._config.facing
        return contacts.select(~(near & (alike | ~contacts.has_normal)))

    def beside(self, cells: Floats) -> Bools:
        """(n,) which of (n, 3) touched places are not on it, by which no face is felt."""
        return np.asarray(self.surface.signed_distance(cells) > self._config.cell)

    def under(self, imprint: Imprint) -> bool:
        """Whether any of what dented the skin may be it."""
        rows, columns = np.nonzero(imprint.depth > 0.1 * imprint.depth.max())
        dented = [imprint.x[columns], imprint.y[rows], -imprint.depth[rows, columns]]
        points = se3.transform_points(imprint.pose, np.column_stack(dented))
        return bool((np.abs(self.surface.signed_distance(points)) < self._config.near).any())

    def stopped(self, front: Floats) -> bool:
        """Whether it is what stopped a stroke, at one of the (n, 3) places at the array's front then."""
        return bool((self.surface.signed_distance(front) < self._config.met).any())

    def holds(self, place: Floats) -> bool:
        """Whether a pad that lies at a (3,) place lies on it."""
        return float(self.surface.signed_distance(place[None])[0]) < self._config.lies

    def leaves_room(self, points: Floats, normals: Floats) -> Bools:
        """(n,) whether a pad centered on (n, 3) points of outward normals (n, 3) would be clear of it."""
        poses = [se3.pose(se3.frame_along(-n, None), p) for p, n in zip(points, normals, strict=True)]
        if not poses:
            return np.zeros(0, dtype=bool)
        return self._tool.clear(np.array(poses), self.points, self._config.room, -1.0)

    @property
    def floor(self) -> float:
        """[mm] height down to which the object is looked for."""
        return -np.inf if self.table is None else self.table + self._config.over

    def may_have_stopped(self, where: Floats, before: Sequence[Floats]) -> bool:
        """Whether an array that was stopped at a (4, 4) pose may have met it: near it, and coming nearer.

        It came by (4, 4) poses `before`, the last first; of one that came from nowhere nothing is known.
        """
        if bool(self._tool.clear(where[None], self.points, self._config.met, self._config.met)[0]):
            return False
        came = (pose for pose in before if se3.apart(pose, where) > self._config.lately)
        last = next(came, before[-1] if before else None)
        return last is None or self._off(where) < self._off(last) - self._config.nearer

    def _off(self, pose: Floats) -> float:
        """[mm] of the corner of the array's box that is nearest to it, or deepest in it."""
        return float(self.surface.signed_distance(se3.transform_points(pose, self._tool.corners)).min())

    def leads_past(self, start: Floats) -> bool:
        """Whether an approach from a (4, 4) pose begins clear of it, and above the table."""
        above = self.table is None or float(start[2, 3]) > self.floor
        return above and bool(self._tool.clear(start[None], self.points, self._config.room, 0.0)[0])

    def resting(self, place: Floats) -> Contacts:
        """Contacts (4) of the face that lies on the table, below a (3,) place of the object."""
        if self.table is None:
            return Contacts.of(np.empty((0, 3)))
        arms = self._config.patch * np.array([[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]])
        points = np.column_stack([place[:2] + arms, np.full(4, self.table)])
        down = np.broadcast_to([0.0, 0.0, -1.0], points.shape)
        return Contacts.of(points, down, self._config.sigma, self._config.normal_sigma, touch=NOT_FELT)
