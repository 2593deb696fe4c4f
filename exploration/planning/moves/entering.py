"""Going into slots and pockets with an array that has room there: to the floor, then against what stands round it.

No taxel looks sideways, and an array in a slot cannot turn to its walls.  But on the floor every wall stops
strokes, and two stops from places apart tell how it lies (`inferred_walls`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

import numpy as np
from scipy.spatial import KDTree

from exploration.control.procedures.approach import retreat
from exploration.control.procedures.settle import AS_IT_CAME
from exploration.devices.guard import Collision, OverPress
from exploration.planning.moves.slot_ledges import SlotLedges
from exploration.planning.open.mouths import Mouth, gathered, lids
from exploration.planning.touching.findings import Attempts, Done
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.study import Study
from primitives import pose as se3
from primitives.arrays import Bools, Floats
from primitives.evidence import Contacts
from primitives.fit import Fit

Move = Callable[[], Done]
_Told = TypeVar("_Told")

_ALIKE = 0.95  # cosine from which two faces look the same way
_PLANE = 1.5  # [mm] off a face's plane, that is still in it
_ACROSS = np.array([-1.0, 0.0, 1.0])
_BESIDE = 4.0  # [mm] beside a way, that is still on it
_WAYS = 20  # across one mouth, that are looked at for room


@dataclass(frozen=True)
class EnteringConfig:
    """Where an array goes in, and how it feels round."""

    inside: float = 2.0  # [mm] behind a mouth, where the array must have room
    between: float = 9.0  # [mm] between two soundings
    known: float = 25.0  # [mm] beside a felt floor, where it goes on and is not sounded again
    under: float = 1.5  # [mm] beside a way across a mouth, that is under it
    aside: float = 4.5  # [mm] from the middle, of the two strokes to one side
    spare: float = 1.5  # [mm] of room beside them
    lift: float = 5.0  # [mm] off the floor between them
    land: float = 1.5  # [mm] beside the way from a mouth to a floor, where its face bars that
    narrow: float = 3.6  # half widths of an array, below which a mouth leaves it no other turn
    turns: int = 3  # of an array, that are tried in one mouth
    near: float = 8.0  # [mm] from a way across a mouth to others,
    wide: float = 3.0  # [mm] and between their widths,
    alike: float = 0.9  # and least cosine between them, where they run as it does
    floors: int = 12  # places of floors, nearest to a mouth, that are looked at
    through: float = 0.6  # of its length, that an array came into a hole where it was not barred
    came_through: int = 4  # arrays that went into one mouth and met nothing, after which none goes in there
    vain: int = 3  # strokes that came to nothing, after which no more are made there
    within: float = 1.0  # [mm] of skin and housing, where there is surely nothing else
    rim: float = 6.0  # [mm] from a mouth's end, within which its face goes on


class Entering:
    """What is tried in the mouths of an object."""

    def __init__(self, study: Study, reach: Reach, config: EnteringConfig | None = None) -> None:
        self.study, self.reach, self.config = study, reach, config or EnteringConfig()
        self._deep = -float(study.pad.tool.low[2])
        self._sounded = Attempts(1, self.config.between)
        self._through = Attempts(1, self.config.between)  # mouths behind which there was no floor
        self._ledges = SlotLedges(study, reach)  # but at their sides, perhaps

    def ways_in(
        self, across: Sequence[Mouth], alongs: Callable[[Floats], list[Floats]]
    ) -> Iterator[tuple[Floats, Move]]:
        """Where the array may go in, with the move; `alongs` gives directions to turn to on a (3,) normal.

        What is behind a mouth is closed to all other ways from now on, unless it turned out to have no floor: then
        its rims are all that leads to its walls.
        """
        self.reach.lids = lids([mouth for mouth in across if not self._through.count(mouth.center)])
        if (sides := self._ledges.next(across)) is not None:
            yield sides.center, partial(self._ledges.feel, across)
            return
        turns = _once(alongs)
        wide, faced = 2.0 * float(self.study.pad.tool.high[:2].min()), _once(self._faced(lids(across)))
        untold = [mouth for mouth in across if mouth.width > wide and self._untold(mouth, faced)]
        for ways in gathered(untold):
            if self._open_behind(ways[0]):
                continue
            some = ways[:: max(1, len(ways) // _WAYS)]
            rooms = ((mouth, self._room(mouth, turns, _straight(mouth, ways, self.config))) for mouth in some)
            if way := next(((mouth, room) for mouth, room in rooms if room), None):
                yield way[0].center, partial(self._sound, *way)

    def _open_behind(self, middle: Mouth) -> bool:
        """Whether arrays that went into a wide mouth came through it so often that there is no floor."""
        return self._through.count(middle.center, 0.5 * middle.width) >= self.config.came_through

    def _room(self, mouth: Mouth, alongs: Callable[[Floats], list[Floats]], across: Floats) -> list[Floats]:
        """(4, 4) poses just inside a mouth, at which nothing known is in the way: an island may be.

        Straight along and `across` (3,) a narrow mouth comes first: there is room for nothing else.
        """
        upright, others = [across, np.cross(mouth.normal, across)], alongs(mouth.normal)
        narrow = mouth.width < self.config.narrow * float(self.study.pad.tool.high[:2].max())
        turns = [*upright, *others] if narrow else [*others, *upright]
        poses = [se3.pose(se3.frame_along(-mouth.normal, turn), self._inside(mouth)) for turn in turns]
        return self.reach.with_room(poses)[: self.config.turns]

    def _untold(self, mouth: Mouth, faced: Callable[[Floats], tuple[Floats, Bools]]) -> bool:
        """Whether neither a sounding nor a floor tells what is behind a mouth."""
        return self._sounded.count(mouth.center) == 0 and not self._floored(mouth, *faced(mouth.normal))

    def _faced(self, places: tuple[Floats, Floats]) -> Callable[[Floats], tuple[Floats, Bools]]:
        """Of a (3,) normal the (n, 3) felt places on known faces that face along it, and which are under mouths.

        What a rolling pad felt of a bowl's side is no floor.  `places` are those of the mouths, and how they face.
        """
        felt, on = self.reach.felt, np.zeros(len(self.reach.felt.points), dtype=bool)
        for face in self.study.found.graph.faces:
            if isinstance(face.fit, Fit):
                on |= felt.on(face.fit.shape, 1.0 if face.fit.convex else -1.0)
        points, facing = felt.points[on], felt.facing[on]

        def of(normal: Floats) -> tuple[Floats, Bools]:
            flat = np.eye(3) - np.outer(normal, normal)
            over, alike = places[0][places[1] @ normal > _ALIKE] @ flat, points[facing @ normal > _ALIKE]
            away = KDTree(over).query(alike @ flat)[0] if len(over) else np.full(len(alike), np.inf)
            return alike, np.asarray(away < self.config.under)

        return of

    def _floored(self, mouth: Mouth, places: Floats, under: Bools) -> bool:
        """Whether one of (n, 3) places that face as a mouth does is a floor behind it, and not beyond its land.

        A step that a slot opens onto is not `under` (n,) any mouth.
        """
        cells = places - mouth.center
        deep = cells @ mouth.normal
        flat = cells - deep[:, None] * mouth.normal
        beside = np.linalg.norm(flat, axis=1)
        near = beside < self.config.known
        behind = np.flatnonzero(under & near & (deep < -_PLANE) & (deep > -self._deep))
        nearest = behind[np.argsort(beside[behind])[: self.config.floors]]
        land = flat[(np.abs(deep) < _PLANE) & near]
        return bool(len(nearest)) and not all(_crossed(land, way, self.config.land) for way in flat[nearest])

    def _inside(self, mouth: Mouth) -> Floats:
        return mouth.center - self.config.inside * mouth.normal

    def _sound(self, mouth: Mouth, poses: Sequence[Floats]) -> Done:
        """Go into a mouth, down to its floor."""
        self._sounded.note(mouth.center)
        barred = False
        for pose in poses:
            if self._met(pose):
                self._went(mouth, self.study.pad.guard.world_from_sensor)
                return self._felt_round(mouth)
            here = self.study.pad.guard.world_from_sensor
            came = float((mouth.center - here[:3, 3]) @ mouth.normal) + self.study.pad.config.back
            if self.reach.led and came > self.config.through * self._deep:
                self._sounded.note(here[:3, 3])  # perhaps out on the other side
                self._through.note(mouth.center)
                self._ledges.went_through(mouth)
                self._went(mouth, here)
                self.reach.come_out()
                return None, "went in and met nothing"
            barred |= self.reach.led
            self.reach.come_out()
        return None, "the housing found no room in a mouth" if barred else "no way led in"

    def _met(self, pose: Floats) -> bool:
        """Whether the array lies on something behind a (4, 4) pose.

        Half off the end of a floor it would roll, and its housing comes to the walls: there it lies as it came.
        """
        slipped = len(self.study.pad.slipped)
        return self.reach.sound(pose) or (
            len(self.study.pad.slipped) > slipped and self.reach.sound(pose, AS_IT_CAME)
        )

    def _felt_round(self, mouth: Mouth) -> Done:
        """Stroke over the floor toward each side that has a rim, from two places apart."""
        pad, felt = self.study.pad, [self.study.pad.feel()]
        home = pad.guard.world_from_sensor
        x, y = home[:3, 0], home[:3, 1]
        room = {sign: [self._to_rim(mouth, sign * way) for way in (x, y)] for sign in (1.0, -1.0)}
        half = pad.tool.high[:2] + self.config.spare
        stopped = 0
        for k, (way, aside) in enumerate(((x, y), (y, x))):
            shift = min(self.config.aside, *(room[sign][1 - k][0] - half[1 - k] for sign in (1.0, -1.0)))
            for sign in (1.0, -1.0):
                length, stands = room[sign][k]
                for beside in (shift, -shift) if stands and shift > 0.0 else ():
                    place = se3.pose(home[:3, :3], home[:3, 3] + beside * aside)
                    if stopped < self.config.vain:
                        stopped += not self._stroke(
                            mouth, place, sign * way, length + self.config.spare, felt
                        )
        note = "went in and felt part of a floor" if stopped else "went in and felt a floor and its walls"
        return self.study.take_in(Contacts.concatenate(felt)), note

    def _went(self, mouth: Mouth, pose: Floats) -> None:
        """Note what the array fills of a mouth at a (4, 4) pose: no material is there."""
        deep = float((pose[:3, 3] - mouth.center) @ pose[:3, 2])
        half = self.study.pad.tool.high[:2] - self.config.within
        axes = [half[0] * _ACROSS, half[1] * _ACROSS, -np.arange(self.config.within, deep, 2.0)]
        local = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
        self.study.found.inside.append(se3.transform_points(pose, local))

    def _to_rim(self, mouth: Mouth, way: Floats) -> tuple[float, bool]:
        """[mm] from a mouth's middle to where it ends along a (3,) direction, and whether its face goes on."""
        places, facing = self.reach.lids
        end = _farthest(places[facing @ mouth.normal > _ALIKE] - mouth.center, mouth.normal, way, np.inf)
        cells = self.reach.felt.points[self.reach.felt.facing @ mouth.normal > _ALIKE] - mouth.center
        rim = _farthest(cells, mouth.normal, way, end + self.config.rim)
        return max(end, 0.0), rim > end

    def _stroke(self, mouth: Mouth, place: Floats, way: Floats, length: float, felt: list[Contacts]) -> bool:
        """From a (4, 4) place on the floor along a (3,) way, to what stops it; false where it got lost."""
        pad = self.study.pad
        try:
            retreat(pad.guard, self.config.lift)
            if not pad.touch(place, self.config.lift, self.config.lift):
                return False
            heading = pad.guard.world_from_sensor[:3, :2].T @ way
            stroke = pad.stroke(heading / np.linalg.norm(heading), length)
        except (Collision, OverPress) as error:
            self.study.found.warnings.append(str(error))
            return False
        felt.append(stroke.contacts)
        self.study.note_wall(stroke)
        self._went(mouth, pad.guard.world_from_sensor if stroke.met is None else stroke.met)
        return stroke.ended in ("wall", "length", "concavity")


def _straight(mouth: Mouth, ways: Sequence[Mouth], config: EnteringConfig) -> Floats:
    """(3,) the way across a mouth that those beside it agree on: each is known to some degrees."""
    beside = [
        way.across
        for way in ways
        if np.linalg.norm(way.center - mouth.center) < config.near
        and abs(way.width - mouth.width) < config.wide
        and abs(way.across @ mouth.across) > config.alike
    ]
    across = np.linalg.svd(np.array(beside))[2][0]
    return np.asarray(across - (across @ mouth.normal) * mouth.normal)


def _once(told: Callable[[Floats], _Told]) -> Callable[[Floats], _Told]:
    """The same answer, asked for once on each normal: many ways lead across one mouth."""
    known: dict[bytes, _Told] = {}

    def answer(normal: Floats) -> _Told:
        key = normal.tobytes()
        if key not in known:
            known[key] = told(normal)
        return known[key]

    return answer


def _crossed(land: Floats, way: Floats, near: float) -> bool:
    """Whether (n, 3) places of a face lie on the straight way from its mouth's middle to a place beside."""
    length = max(float(np.linalg.norm(way)), 1e-9)
    along = land @ (way / length)
    off = np.linalg.norm(land - np.outer(along, way / length), axis=1)
    return bool(((along > 0.0) & (along < length) & (off < near)).any())


def _farthest(places: Floats, normal: Floats, way: Floats, most: float) -> float:
    """[mm] along a way in a face's plane, of the farthest of (n, 3) places beside it, up to `most`."""
    ahead, aside = places @ way, places @ np.cross(normal, way)
    near = (np.abs(places @ normal) < _PLANE) & (np.abs(aside) < _BESIDE) & (ahead <= most)
    return float(ahead[near].max(initial=0.0))
