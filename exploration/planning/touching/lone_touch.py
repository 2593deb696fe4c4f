"""One guarded approach, and everything that one touch tells: contacts, edges, and where there is no material.

Recognizing needs touches apart from each other more than faces followed to their ends.  The pad advances along
its own normal, settles on what it meets, and is read there.  What it swept on its way is free, and so is the place
over every taxel that felt nothing while its neighbors did (our derivation).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.ndimage import uniform_filter

from exploration.control.dwell import dwell
from exploration.control.feel import Felt, feel
from exploration.control.free_cells import free_cells
from exploration.control.kept_contacts import keep
from exploration.control.procedures.approach import ApproachConfig, advance, touched
from exploration.control.procedures.land import LandConfig, land, strongest
from exploration.control.procedures.settle import SettleConfig, settle
from exploration.control.procedures.tare import tare
from exploration.control.sighting import Sighting, ends_by_curving, sight
from exploration.devices.guard import Collision, Guard, Observation, OverPress
from exploration.planning.known.swept import Swept, behind_skin, over_free_taxels
from exploration.planning.ways.travel import room_behind
from exploration.sensing.contacts import slid
from exploration.sensing.lines.hough import sure_lines
from primitives import pose as se3
from primitives.arrays import Floats, frozen
from primitives.evidence import Contacts, EdgeTrace, FreeSpace, Imprint

_SHORT = 10.0  # [mm] of an approach's end, from which something stopped it


@dataclass(frozen=True)
class Approach:
    """A straight advance of the pad along its own normal."""

    start: Floats  # (4, 4) world_from_sensor where it begins
    length: float  # [mm] at most
    flown: float = 0.0  # [mm] of these, which are known to be empty enough to be flown through

    @property
    def direction(self) -> Floats:
        """(3,) unit direction of the advance."""
        return np.asarray(self.start[:3, 2])

    @property
    def felt(self) -> Approach:
        """What is left after the flight: from where the pad has to feel its way."""
        begin = self.start.copy()
        begin[:3, 3] += self.flown * self.direction
        return Approach(begin, self.length - self.flown)


@dataclass(frozen=True)
class LoneTouch:
    """What one touch told; false where nothing was met."""

    touch: int
    approach: Approach
    contacts: Contacts
    edges: tuple[EdgeTrace, ...]
    free: FreeSpace
    met: bool
    note: str  # what was felt, in a few words
    pose: Floats  # (4, 4) world_from_sensor where the pad lay, or where it gave up
    untouched: Floats = field(
        default_factory=lambda: np.empty((0, 3))
    )  # (n, 3) [mm] of the skin, under which
    # nothing was felt while the pad lay pressed
    imprint: Imprint | None = None  # None where the pad does not lie pressed

    def __bool__(self) -> bool:
        return self.met

    @property
    def stopped(self) -> bool:
        """Whether it ended well before its end on something that the skin did not feel."""
        gone = float((self.pose[:3, 3] - self.approach.start[:3, 3]) @ self.approach.direction)
        return not self.met and gone < self.approach.length - _SHORT

    @property
    def told(self) -> bool:
        """Whether it says anything: of an approach that was blocked on its way nothing is known."""
        return self.met or len(self.free.poses) > 0


@dataclass(frozen=True)
class LoneTouchConfig:
    """How a touch is made."""

    averaged: int = 8  # frames of what is felt
    pressed: float = 0.3  # [mm] from which the whole skin tells, and not only where it was met
    clear: float = 2.0  # [mm] off what the pad lies on where it should begin, at which its zero is taken
    least_line: float = 4.0  # [mm] of a line that counts as an edge
    speed: float = 50.0  # [mm/s] of the advance, through space that was not seen yet
    spacing: float = 3.0  # [mm] between the points of an edge
    edge_floor: float = 0.1  # [mm] error of an edge that its line's covariance does not show
    roundest: float = 20.0  # [mm] radius of an edge that still looks straight
    point_sigma: float = 0.4  # [mm] of a contact too sharp or too small to show a surface
    landing: LandConfig = field(default_factory=lambda: LandConfig(tries=1))
    settling: SettleConfig = field(default_factory=lambda: SettleConfig(patience=500))


def touch_once(guard: Guard, approach: Approach, config: LoneTouchConfig | None = None) -> LoneTouch:
    """Advance from where the pad is, which must be the approach's start; it stays where it comes to lie."""
    config = config or LoneTouchConfig()
    guard.cost.touches += 1
    number, swept = guard.cost.touches, Swept(guard)
    with swept.watching():
        back = _off_what_it_lies_on(guard, config)
        if not _lies(guard.hold(), config):
            tare(guard)
        met, why = _come_down(guard, approach.direction, approach.length + back, config)
    if not met:
        return LoneTouch(
            number, approach, Contacts.of([]), (), swept.boxes(), False, why, guard.world_from_sensor
        )
    seen = dwell(guard, config.averaged)
    felt = feel(seen.image)
    kept: list[Contacts] = []
    guard.cost.strokes += 1
    edges: tuple[EdgeTrace, ...] = ()
    free = [swept.boxes()]
    if felt:
        keep(seen, number, guard.cost.strokes, kept)
        kept = [_on_touched(contacts, seen, felt) for contacts in kept]
        if not any(map(len, kept)):
            kept.append(_bare_point(seen, number, guard.cost.strokes, config))
        edges = _edges(seen, felt, number, guard.cost.strokes, config)
        free += [behind_skin(guard, seen), over_free_taxels(seen, felt)]
    contacts = Contacts.concatenate(kept)
    return LoneTouch(
        number,
        approach,
        contacts,
        edges,
        joined(free),
        True,
        _words(contacts, edges, felt or None, why),
        seen.world_from_sensor,
        free_cells(seen, felt) if felt else np.empty((0, 3)),
        _imprint(seen, number) if felt and felt.depth > config.pressed else None,
    )


def blocked(number: int, approach: Approach, where: Floats) -> LoneTouch:
    """An approach that something stopped before it began; the pad stays at (4, 4) `where`."""
    nothing = Contacts.of([]), (), joined([])
    return LoneTouch(number, approach, *nothing, False, "the way was blocked", where)


def _off_what_it_lies_on(guard: Guard, config: LoneTouchConfig) -> float:
    """[mm] that the pad goes back where it seems to lie on something: its zero must not be taken there."""
    seen = guard.hold()
    if not _lies(seen, config):
        return 0.0
    room = room_behind(seen.world_from_sensor, np.array(guard.limits.reach))
    back = min(_deepest(seen) + config.clear, room)
    guard.go_to(seen.world_from_sensor @ se3.pose(translation=[0.0, 0.0, -back]))
    return back


def _lies(seen: Observation, config: LoneTouchConfig) -> bool:
    """Whether the pad is pressed farther than its zero drifts."""
    return touched(seen.image) and _deepest(seen) > config.pressed


def _deepest(seen: Observation) -> float:
    return float(np.where(np.isfinite(seen.image.sigma), seen.image.depth, 0.0).max(initial=0.0))


def _come_down(guard: Guard, direction: Floats, length: float, config: LoneTouchConfig) -> tuple[bool, str]:
    """Whether the pad came to touch something, and how."""
    try:
        if advance(guard, direction, length, config.speed) is None:
            return False, "nothing"
        settled = settle(guard, config=config.settling)
        return True, "" if settled else "unsettled"
    except (Collision, OverPress) as fault:
        felt_at = strongest(fault.seen.image) if fault.seen is not None else np.zeros(2)
    try:
        speed = ApproachConfig().speed
        landed = land(guard, direction, 25.0, speed, config.landing, config.settling, felt_at)
    except (Collision, OverPress):
        return False, "the housing was in the way"
    if landed or touched(guard.hold().image):
        return True, "" if landed else "unsettled"
    return False, "the housing was in the way"


def _imprint(seen: Observation, touch: int) -> Imprint:
    image = seen.image
    margin = float(min(image.margin, 4.0 * image.spread))
    return Imprint(
        seen.world_from_sensor,
        image.array.x,
        image.array.y,
        image.depth,
        image.sigma,
        image.spread,
        margin,
        touch,
    )


def _on_touched(contacts: Contacts, seen: Observation, felt: Felt) -> Contacts:
    """Contacts of a flat patch, each moved within its plane to a touched taxel: a hole has no surface."""
    rows, columns = np.nonzero(felt.inner if felt.inner.sum() >= len(contacts) else felt.mask)
    if len(contacts) < 4 or not contacts.has_normal.all() or not len(rows):
        return contacts
    taxels = np.column_stack([seen.image.array.x[columns], seen.image.array.y[rows]])
    local = se3.transform_points(se3.inverse(seen.world_from_sensor), contacts.points)
    nearest = np.linalg.norm(taxels[None] - local[:, None, :2], axis=2).argmin(axis=1)
    return slid(contacts, taxels[nearest], seen.world_from_sensor)


def _bare_point(seen: Observation, touch: int, stroke: int, config: LoneTouchConfig) -> Contacts:
    """The deepest place under the pad, without a normal."""
    depth = uniform_filter(np.where(np.isfinite(seen.image.sigma), seen.image.depth, 0.0), 3)
    row, column = np.unravel_index(int(np.argmax(depth)), depth.shape)
    local = [seen.image.array.x[column], seen.image.array.y[row], -float(depth[row, column])]
    point = se3.transform_points(seen.world_from_sensor, np.array([local]))
    return Contacts.of(point, None, config.point_sigma, touch=touch, stroke=stroke, sensor=seen.sensor)


def _edges(
    seen: Observation, felt: Felt, touch: int, stroke: int, config: LoneTouchConfig
) -> tuple[EdgeTrace, ...]:
    lines = [line for line in sure_lines(seen.image, 3) if line.length > config.least_line]
    lines = [line for line in lines if not ends_by_curving(line, felt)]
    return tuple(_trace(sight(line, seen), touch, stroke, config) for line in lines)


def _trace(edge: Sighting, touch: int, stroke: int, config: LoneTouchConfig) -> EdgeTrace:
    """What was seen of an edge, as points along it; farther out a round edge may have left its tangent."""
    along = np.linspace(-0.5, 0.5, max(2, round(edge.length / config.spacing))) * edge.length
    n = len(along)
    bend = along**2 / (2.0 * config.roundest)
    return EdgeTrace(
        frozen(edge.point + along[:, None] * edge.tangent),
        frozen(np.tile(edge.tangent, (n, 1))),
        frozen(np.tile(edge.normal, (n, 1))),
        frozen(np.sqrt(edge.sigma**2 + config.edge_floor**2 + bend**2)),
        False,
        touch,
        stroke,
    )


def joined(spaces: list[FreeSpace]) -> FreeSpace:
    """All boxes of all of them."""
    spaces = [space for space in spaces if len(space.poses)]
    if not spaces:
        return FreeSpace(frozen(np.empty((0, 4, 4))), frozen(np.empty((0, 3))))
    return FreeSpace(
        frozen(np.concatenate([s.poses for s in spaces])),
        frozen(np.concatenate([s.half_extents for s in spaces])),
    )


def _words(contacts: Contacts, edges: tuple[EdgeTrace, ...], felt: Felt | None, why: str) -> str:
    if felt is None:
        return "contact was lost"
    sharp = not contacts.has_normal.any()
    what = "something sharp" if sharp else "a flat face" if len(contacts) >= 4 else "a curved face"
    more = f" with {len(edges)} edge{'s' if len(edges) > 1 else ''}" if edges else ""
    return f"{what}{more}" + (f" ({why})" if why else "")
