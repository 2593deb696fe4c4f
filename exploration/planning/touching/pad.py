"""The pad on a convex object: touch down, stroke, look for edges, and travel in between.

It remembers where it lies and what it has covered, and counts touches and strokes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from exploration.control.dwell import dwell
from exploration.control.feel import Felt, feel
from exploration.control.kept_contacts import keep, touched_cells
from exploration.control.procedures.approach import ApproachConfig, retreat, touched
from exploration.control.procedures.curvature import four_direction_curvature
from exploration.control.procedures.land import LandConfig, land
from exploration.control.procedures.look import look_closely
from exploration.control.procedures.settle import SettleConfig, Unsettled
from exploration.control.procedures.tare import tare
from exploration.control.sighting import Sighting, brink, ends_by_curving, sight, strip_ends
from exploration.control.track_surface import Stroke, StrokeConfig, follow_surface
from exploration.control.windows import going_on, windows
from exploration.devices.guard import Collision, Guard, Observation, OverPress
from exploration.planning.known.skin import Skin
from exploration.planning.known.swept_cells import SweptCells
from exploration.planning.known.told import Told
from exploration.planning.known.touched import Touched
from exploration.planning.touching.bumps import Bump
from exploration.planning.touching.way_back import WayBack
from exploration.planning.ways.routes import Tool
from exploration.planning.ways.transit import Support, TransitConfig, box_supports, keeps_clear, way
from exploration.sensing.lines.hough import sure_lines
from exploration.sensing.lines.line import Line
from primitives import pose as se3
from primitives.arrays import Floats
from primitives.errors import PalpateError
from primitives.evidence import Contacts

Announce = Callable[[str, dict[str, object]], None]


@dataclass(frozen=True)
class PadConfig:
    """Distances of touching and traveling."""

    longest: float = 400.0  # [mm] of one stroke
    least_line: float = 4.0  # [mm] of a line that counts as an edge
    part: float = 11.0  # [mm] either way, of what is looked at where the whole shows too much
    averaged: int = 8  # frames of a place that is studied
    narrow: float = 0.04  # [1/mm] curvature from which a contact may be a strip that ends under the pad
    back: float = 12.0  # [mm] from a touch that met nothing
    lift: float = 8.0  # [mm] before any travel
    alike: float = 0.95  # cosine above which two supporting planes are one


class TouchesSpent(PalpateError):
    """As many touches as were allowed are made; the pad has not moved."""


class Pad:
    """Carried by a guard through a (6,) workspace box [mm]."""

    def __init__(
        self,
        guard: Guard,
        box: Floats,
        announce: Announce,
        config: PadConfig = PadConfig(),
        told: Told | None = None,
        tools: Sequence[Tool] = (),
    ) -> None:
        self.guard, self.box, self.announce, self.config, self.told = guard, box, announce, config, told
        self.covered = Touched()
        self.skin, self.swept = Skin(told), SweptCells(box)
        self.way_back = WayBack(guard)
        self.felt: list[tuple[Floats, Floats]] = []  # (n, 3) touched cells [mm], and how they face
        self.strip_ends: list[Sighting] = []  # edges that ended a narrow contact under the pad
        self.slipped: list[
            tuple[Floats, Floats]
        ] = []  # (3,) places met and not lain on, and (3,) the ways there
        self.bumps: list[Bump] = []  # where the skin was stopped on its way
        self.most: int | None = None  # touches that are allowed
        self._tools = tuple(tools) or tuple(Tool.of_size(sensor.array.size) for sensor in guard.sensors)
        guard.learners = (*guard.learners, self._watch)
        self.here = Support(np.array([0.0, 0.0, box[5]]), np.array([0.0, 0.0, 1.0]))

    @property
    def size(self) -> tuple[float, float]:
        """Of the array along its x and y [mm]."""
        return self.guard.sensor.array.size

    @property
    def tool(self) -> Tool:
        """The array in use, its housing, and what is carried with it."""
        return self._tools[self.guard.active]

    def attitude(self, normal: Floats, along: Floats) -> Floats:
        """(3, 3) of the pad on a surface of (3,) outward `normal`, its longer side along a (3,) direction."""
        x, y = self.size
        return se3.frame_along(-normal, along if x >= y else np.cross(normal, along))

    def come_down(self, direction: Floats, distance: float, speed: float | None = None) -> bool:
        """Advance from where the pad is, along a (3,) direction, and settle; one touch, hit or miss."""
        self.count_touch()
        tare(self.guard)
        return self._landed(land(self.guard, direction, distance, speed or ApproachConfig().speed), direction)

    def touch(
        self,
        target: Floats,
        standoff: float,
        overtravel: float,
        settling: SettleConfig | None = None,
        landing: LandConfig | None = None,
    ) -> bool:
        """One guarded approach to a (4, 4) target from `standoff` mm before it, and its settling."""
        self.count_touch()
        back = target @ se3.pose(translation=[0.0, 0.0, -standoff])
        if self.guard.go_to(back, until=lambda seen: touched(seen.image)) is None:
            tare(self.guard)
        speed = ApproachConfig().speed
        way = target[:3, 2]
        if self._landed(
            land(self.guard, way, standoff + overtravel, speed, landing or LandConfig(), settling), way
        ):
            return True
        retreat(self.guard, self.config.back)  # free, because the pad came that way
        return False

    def _landed(self, felt: Felt | Unsettled, way: Floats) -> bool:
        """Whether the pad lies; else note what it met and could not lie on, coming along a (3,) way."""
        if isinstance(felt, Unsettled) and felt.met is not None:
            self.slipped.append((felt.met, way))
        return bool(felt)

    def count_touch(self) -> None:
        """Count one more touch, about to be made; `TouchesSpent` where no more are allowed."""
        if self.most is not None and self.guard.cost.touches >= self.most:
            raise TouchesSpent(f"all touches that were allowed are made ({self.most})")
        self.guard.cost.touches += 1

    def travel(self, target: Floats, far: Support, standoff: float) -> None:
        """Through free space to `standoff` mm before a (4, 4) target on the supporting plane `far`."""
        retreat(self.guard, self.config.lift)
        tare(self.guard)  # what the rubber remembers would pass for a contact on the way
        goal = target @ se3.pose(translation=[0.0, 0.0, -standoff])
        here = self.guard.world_from_sensor
        same = self.here.normal @ far.normal > 0.995
        close = abs((self.here.point - far.point) @ far.normal) < 2.0
        close &= (
            float((here[:3, 3] - self.here.point) @ self.here.normal) > -2.0
        )  # not past it, having met nothing
        if same and close:
            poses = [se3.pose(here[:3, :3], here[:3, 3] + 14.0 * far.normal)]
            poses.append(se3.pose(goal[:3, :3], goal[:3, 3] + 22.0 * far.normal))
            poses.append(goal)
        else:
            poses = self._way(here, goal, far)
        for pose in poses:
            self.guard.go_to(pose)
        self.here = far  # who meets nothing there goes on from in front of it

    def _way(self, here: Floats, goal: Floats, far: Support) -> list[Floats]:
        """Round the object; farther out where what is carried with the array would come too near."""
        stops = [*self._supports(), *self._outside()]
        poses = way(here, self.here, goal, far, stops)
        if not self.tool.carried or keeps_clear(self.tool, here, poses[:-1], [self.here, far, *stops]):
            return poses
        reach = float(np.linalg.norm(self.tool.corners, axis=1).max())
        config = TransitConfig(clearance=reach + TransitConfig().beside)
        return way(here, self.here, goal, far, stops, config)

    def feel(self) -> Contacts:
        """Contacts of the place under the pad, from averaged frames."""
        seen = dwell(self.guard, self.config.averaged)
        felt = feel(seen.image)
        seen = look_closely(self.guard, seen, felt) if felt else seen
        kept: list[Contacts] = []
        self.guard.cost.strokes += 1
        keep(seen, self.guard.cost.touches, self.guard.cost.strokes, kept)
        felt = feel(seen.image)
        self.skin.dwell(seen)
        self.lie(touched_cells(seen, felt) if felt else np.empty((0, 3)))
        return self._own(Contacts.concatenate(kept))

    def stroke(self, heading: Floats, length: float | None = None) -> Stroke:
        """Follow the surface along a (2,) heading in the pad's plane, to an edge or for `length` mm.

        A fault that ends it carries the contacts kept until then.
        """
        cost = self.guard.cost
        cost.strokes += 1
        longest = self.config.longest if length is None else length
        walls = StrokeConfig(walls=True)
        felt = Contacts.of([])
        try:
            stroke = follow_surface(self.guard, heading, longest, cost.touches, cost.strokes, config=walls)
            felt = stroke.contacts
            self.lie(stroke.cells, stroke.facing)
        except (OverPress, Collision) as fault:
            fault.kept = self._own(Contacts.concatenate([felt, fault.kept]))
            raise
        return stroke if self.told is None else replace(stroke, contacts=self._own(stroke.contacts))

    def _own(self, contacts: Contacts) -> Contacts:
        """The contacts of the object, not of what is told to stand beside it."""
        return contacts if self.told is None else self.told.without(contacts)

    def lie(self, cells: Floats, facing: Floats | None = None) -> None:
        """Note where the pad lies now, and the (n, 3) cells [mm] that it has covered, with their normals."""
        pose = self.guard.world_from_sensor
        told = np.broadcast_to(-pose[:3, 2], cells.shape) if facing is None else facing
        own = slice(None) if self.told is None or not len(cells) else self.told.beside(cells)
        self.felt.append((cells[own], told[own]))
        seen = self.guard.hold()
        felt = feel(seen.image)
        if felt and felt.curvature[0] > self.config.narrow:
            self.strip_ends += strip_ends(dwell(self.guard, self.config.averaged), felt)
        offset = np.array([*(felt.centroid if felt else (0.0, 0.0)), 0.0])
        self.here = Support(pose[:3, :3] @ offset + pose[:3, 3], -pose[:3, 2])
        self.covered.add(cells, self.here)

    def touches(self) -> bool:
        """Whether anything is under the pad now, from averaged frames: noise of a single one may pass for it."""
        return touched(dwell(self.guard, self.config.averaged).image)

    def on_told(self) -> bool:
        """Whether the pad's middle lies on what is told to stand beside the object."""
        return self.told is not None and self.told.holds(self.guard.world_from_sensor[:3, 3])

    def axes(self) -> Floats:
        """(2, 2) columns to stroke along: the edge that is seen, or the least curvature; and across it."""
        seen = dwell(self.guard, self.config.averaged)
        felt = feel(seen.image)
        long = np.array([1.0, 0.0])
        if felt:
            curved = four_direction_curvature(seen.image, felt)
            self.announce(
                "curvature",
                {
                    "order": curved.order,
                    "probability": curved.probability,
                    "k1_per_mm": float(curved.four.k1[0]),
                    "k2_per_mm": float(curved.four.k2[0]),
                    "consistency": float(curved.four.consistency[0]),
                },
            )
            lines = [line for line in sure_lines(seen.image, 3) if line.length > self.config.least_line]
            if curved.order != "plane":
                long = curved.ridge
            elif lines:
                long = max(lines, key=lambda line: line.length).direction
        return np.array([[long[0], -long[1]], [long[1], long[0]]])

    def sightings(self, heading: Floats | None = None) -> list[Sighting]:
        """Edges under the pad; where contact ends ahead and no line says where, the end itself."""
        seen = dwell(self.guard, self.config.averaged)
        felt = feel(seen.image)
        if not felt:
            return []
        lines = self._lines(seen, felt)
        found = [sight(line, seen) for line in lines]
        if heading is not None and not any(-line.inward @ heading > 0.4 for line in lines):
            found.append(brink(seen, felt, heading))
        return found

    def sightings_in_parts(self) -> list[Sighting]:
        """Straight edges that cross parts of the pad, where the whole shows more than can be told apart."""
        parts = windows(dwell(self.guard, self.config.averaged), self.config.part)
        felt_parts = [(part, felt) for part in parts if (felt := feel(part.image))]
        return going_on([sight(line, part) for part, felt in felt_parts for line in self._lines(part, felt)])

    def _lines(self, seen: Observation, felt: Felt) -> list[Line]:
        lines = [line for line in sure_lines(seen.image, 3) if line.length > self.config.least_line]
        return [line for line in lines if not ends_by_curving(line, felt)]

    def _watch(self, seen: Observation) -> None:
        """Note where the array is, and what the skin shows, whatever it does."""
        here = seen.world_from_sensor
        self.swept.pass_through(here, self.tool.low, self.tool.high)
        self.way_back.note(seen)
        self.skin.look(seen)

    def _outside(self) -> list[Support]:
        """The workspace's sides, below which nothing leads where the object lies on a table."""
        sides = box_supports(self.box)
        lies = self.told is not None and self.told.table is not None
        return [side for side in sides if not lies or side.normal[2] > -0.5]

    def _supports(self) -> list[Support]:
        """One support for each face, which is enough to go round."""
        kept: list[Support] = []
        for support in self.covered.supports:
            if all(support.normal @ other.normal < self.config.alike for other in kept):
                kept.append(support)
        return kept
