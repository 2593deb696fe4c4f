"""The simulated world of a run: the object at its pose, arrays on one stage over it, and a guard before them.

The object stays here.  What leaves is the guard, and the truth once exploration has ended.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from typing import Any, Protocol, cast

import numpy as np
import trimesh

from exploration.devices.guard import Guard, GuardLimits, Observation
from exploration.devices.simulated import simulate, turret
from exploration.planning.known.told import Told
from exploration.planning.ways.routes import Tool
from exploration.sensing.spec import SensorSpec, load_sensor
from models.formats.units import Units
from models.part import Part, load_part
from models.scene import Scene, table_under
from models.solid import Solid
from primitives import pose as se3
from primitives.arrays import Floats
from primitives.errors import PalpateError
from primitives.surface import Surface
from recognition.config import ExploreOptions
from recognition.running.bench_calibration import calibrated
from recognition.running.resting import resting_attitude


@dataclass(frozen=True)
class WorldConfig:
    """Room round the workspace."""

    offset: float = 60.0  # [mm] greatest distance of a randomly placed part's middle from the workspace's
    reach: float = 300.0  # [mm] that the stage travels past the workspace, to go round the object
    spots: float = 10.0  # [mm] between the places of a table or cover that ways keep clear of
    start: float = 60.0  # [mm] above the workspace, where the stage begins, facing down


class Device(Protocol):
    """What stands in the simulation's place."""

    def guarded(self, observer: Callable[[Guard, Observation], None]) -> Guard:
        """The array on its stage, behind a guard."""
        ...

    def close(self) -> None:
        """Stop, and let go."""
        ...


@dataclass(frozen=True)
class World:
    """What a simulated run takes place in."""

    part: Part
    solid: Solid  # the part at its pose
    specs: tuple[SensorSpec, ...]  # of the arrays on the stage; the first is the one to begin with
    box: Floats  # (2, 3) the workspace [mm]
    config: WorldConfig
    beside: tuple[Solid, ...] = ()  # table and cover, which are told to whoever explores
    device: Device | None = None  # in place of a simulated object, of which then nothing is known

    @property
    def spec(self) -> SensorSpec:
        """The array to begin with."""
        return self.specs[0]

    @property
    def sensor(self) -> str:
        """The arrays' names, with commas between them."""
        return ",".join(spec.name for spec in self.specs)

    @property
    def mounts(self) -> list[Floats]:
        """(4, 4) flange_from_sensor of each array."""
        return turret(self.specs)

    @property
    def surface(self) -> Surface:
        """All that can be touched."""
        return Scene((self.solid, *self.beside)) if self.beside else self.solid

    @property
    def known(self) -> bool:
        """Whether there is a truth to compare with."""
        return self.device is None

    def close(self) -> None:
        """Let go of the devices, if there are any."""
        if self.device is not None:
            self.device.close()

    def resolved(self) -> dict[str, Any]:
        """What the settings came to, for `config.toml`."""
        told: dict[str, Any] = {"sensor": asdict(self.spec)}
        if len(self.specs) > 1:
            told["sensors"] = {spec.name: asdict(spec) for spec in self.specs}
            told["flange_from_sensor"] = {
                spec.name: _pose_told(mount) for spec, mount in zip(self.specs, self.mounts, strict=True)
            }
        if not self.known:
            return told
        size = {"part_extent_mm": self.solid.extent.tolist()}
        return {"world_from_part": _pose_told(self.solid.pose), **size, **told}


def load_world(
    options: ExploreOptions,
    config: WorldConfig | None = None,
    part: Part | None = None,
    several: bool = False,
) -> World:
    """Part and sensor, checked before anything is written; the same for the same seed.

    `part` is in place of the one that the options name.  Who works with `several` arrays says so; for others the
    first of them is on the stage, and a warning tells of it.
    """
    config = config or WorldConfig()
    if options.device is not None:
        from recognition.hardware.world import wired

        device = wired(options.device)
        return World(device.part, cast(Solid, None), (device.spec,), device.box, config, device=device)
    specs = _arrays(options)
    if part is None:
        part = load_part(
            options.part, cast(Units, options.units), options.scale, options.body, options.facets
        )
    if len(specs) > 1 and not several:
        left = ", ".join(spec.name for spec in specs[1:])
        told = f"only the first array, {specs[0].name}, is used; {left}: explore alone changes arrays"
        part, specs = replace(part, warnings=(*part.warnings, told)), specs[:1]
    box = np.reshape(options.workspace, (2, 3))
    world_from_part = options.fixed_pose
    if world_from_part is None:
        rng = np.random.default_rng(options.seed)
        lies = options.support == "table"
        turn = resting_attitude(part.solid, rng) if lies else None
        world_from_part = random_pose(part.solid, box, rng, config, turn)
    solid = part.solid.placed(world_from_part)
    _require_inside(solid, box)
    beside = [table_under(solid)] if options.support == "table" else []
    if options.cover is not None:
        cover = load_part(options.cover, cast(Units, options.units), options.scale)
        beside.append(cover.solid.placed(world_from_part))
    return World(part, solid, specs, box, config, tuple(beside))


def _arrays(options: ExploreOptions) -> tuple[SensorSpec, ...]:
    """Those that the options name, each once: a recording tells them apart by name."""
    specs = [load_sensor(name.strip()) for name in options.sensors]
    names = [spec.name for spec in specs]
    if twice := [name for name in names if names.count(name) > 1]:
        raise PalpateError(f"--sensor names {twice[0]} twice; give each array of a stage a name of its own")
    if options.noise is not None:
        specs = [replace(s, electronics=replace(s.electronics, noise=options.noise)) for s in specs]
    return tuple(specs)


def _pose_told(pose: Floats) -> dict[str, Any]:
    return {"translation_mm": pose[:3, 3], "quaternion_wxyz": se3.quaternion_wxyz(pose)}


def random_pose(
    solid: Solid, box: Floats, rng: np.random.Generator, config: WorldConfig, turn: Floats | None = None
) -> Floats:
    """Any attitude alike, or a given (3, 3) `turn`; the middle in a ball round the workspace's own.

    The ball is smaller where room is scarce.
    """
    middle = solid.bounds.mean(axis=0)
    radius = float(np.linalg.norm(solid.vertices - middle, axis=1).max())
    room = float(np.ptp(box, axis=0).min()) / 2.0 - radius
    turn = se3.random_rotation(rng) if turn is None else turn
    way = rng.normal(size=3)
    distance = min(config.offset, max(room, 0.0)) * rng.uniform() ** (1.0 / 3.0)
    center = box.mean(axis=0) + distance * way / np.linalg.norm(way)
    return se3.pose(turn, center - turn @ middle)


def guarded(
    world: World,
    options: ExploreOptions,
    observer: Callable[[Guard, Observation], None],
    surface: Surface | None = None,
    latency: float = 0.0,
) -> Guard:
    """The arrays over the object, behind a guard that shows every observation to `observer`.

    `surface` stands for the object where that is made of something; the stage obeys `latency` [s] late.
    """
    if world.device is not None:
        return world.device.guarded(observer)
    low, high = world.box
    x, y = (low + high)[:2] / 2.0
    above = se3.pose(np.diag([1.0, -1.0, -1.0]), [x, y, high[2] + world.config.start])
    rng = np.random.default_rng(options.seed)
    stage, arrays = simulate(
        surface or world.surface,
        world.specs,
        rng,
        pose_noise=options.pose_noise,
        start_pose=above @ se3.inverse(world.mounts[0]),
        flange_from_sensor=world.mounts,
        latency=latency,
    )
    reach = (*(low - world.config.reach), *(high + world.config.reach))
    known = [calibrated(array, rng.spawn(1)[0]) for array in arrays]
    guard = Guard(stage, arrays, known, GuardLimits(reach=tuple(map(float, reach))))
    guard.observers = (lambda seen: observer(guard, seen),)
    return guard


def beside(world: World, options: ExploreOptions) -> Told | None:
    """What whoever explores is told of the bodies beside the part; none where there are none."""
    if not world.beside:
        return None
    spots = [
        trimesh.remesh.subdivide_to_size(body.vertices, body.triangles, world.config.spots)[0]
        for body in world.beside
    ]
    top = float(world.beside[0].bounds[1, 2]) if options.support == "table" else None
    return Told(Scene(world.beside), np.concatenate(spots), tools(world)[0], top)


def tools(world: World) -> tuple[Tool, ...]:
    """What each array is to whoever plans its way."""
    return Tool.each(world.specs, world.mounts)


def _require_inside(solid: Solid, box: Floats) -> None:
    low, high = solid.bounds
    if (low < box[0]).any() or (high > box[1]).any():
        spans = ", ".join(f"{a:.0f} to {b:.0f}" for a, b in zip(low, high, strict=True))
        raise PalpateError(
            f"the part would reach out of the workspace ({spans} mm in x, y, z); "
            "give a larger --workspace, another --pose, or --scale"
        )
