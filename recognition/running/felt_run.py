"""What `track` and `probe` share: a world, a guard that writes everything down, the object found, a folder.

    with felt_run(options, "track", watch) as run:      # recording, latency measured, config.toml
        run.find()                                      # the pad lies on a face of the object
        ...                                             # run.guard, run.pad, run.announce
    summary = run.finish(felt, contacts)                # contacts.csv, report.html, summary.json

The stage obeys late, as real ones do, and the explorer measures how late; the object is asked for the truth by
whoever calls, after the block has ended.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from importlib.metadata import version
from typing import Any

import numpy as np

from exploration.control.latency import measure_latency
from exploration.control.procedures.approach import ApproachConfig
from exploration.devices.guard import Collision, Guard, Observation, OverPress
from exploration.planning.touching.pad import Pad, TouchesSpent
from exploration.planning.ways.search import sweeps
from exploration.planning.ways.transit import box_supports
from exploration.recordings.mcap import Recorder
from primitives import pose as se3
from primitives.arrays import Floats
from primitives.errors import PalpateError
from primitives.evidence import Contacts
from primitives.surface import Surface
from recognition.config import ExploreOptions, settings, to_toml
from recognition.console import bugs, interrupts
from recognition.report.against import drawn_truth
from recognition.report.page import write_report
from recognition.report.run_report import RunReport
from recognition.running.folder import RunFolder
from recognition.running.logbook import Logbook, force_sigma
from recognition.running.progress import Progress
from recognition.running.simulation import World, guarded
from recognition.running.summary import counted

Watcher = Callable[[Progress], None]
_DOING = {"identify": "identifying", "track": "tracking", "probe": "probing"}


@dataclass(frozen=True)
class FeltConfig:
    """The plant, and how often whoever watches is told."""

    latency: float = 0.02  # [s] of the simulated stage; measured, never told
    every: int = 20  # frames between two words of progress
    sigmas: float = 6.0  # of force out of its noise, from which a frame is in contact


@dataclass
class FeltRun:
    """One run of one procedure or tracker."""

    options: ExploreOptions
    command: str
    world: World
    folder: RunFolder
    guard: Guard
    logbook: Logbook
    pad: Pad
    began: float
    forces: list[float] = field(default_factory=list)  # [N] of every frame in contact, since it was cleared
    warnings: list[str] = field(default_factory=list)

    @cached_property
    def _sweeps(self) -> Iterator[tuple[Floats, Floats]]:
        """Those of the workspace that were not made yet."""
        return sweeps(self.pad.box, self.pad.size, self.options.feature)

    def find(self) -> None:
        """Sweep the workspace from its middle outward until the pad lies on the object."""
        for start, end in self._sweeps:
            try:
                self.guard.go_to(start)
                distance = float(np.linalg.norm(end[:3, 3] - start[:3, 3]))
                settled = self.pad.come_down(start[:3, 2], distance, ApproachConfig().search_speed)
                if settled or self.pad.touches():
                    self.forces.clear()
                    return
            except (OverPress, Collision) as error:
                self.warnings.append(str(error))
            except TouchesSpent as error:
                raise PalpateError(
                    f"nothing was found: {error}; raise --max-touches, or give a smaller --workspace"
                ) from error
            here = self.guard.world_from_sensor
            self.guard.go_to(se3.pose(start[:3, :3], [here[0, 3], here[1, 3], start[2, 3]]))
        raise PalpateError("nothing was found in the workspace; give one that holds the object")

    def find_elsewhere(self) -> None:
        """Round the object to over the workspace, and on with its sweeps."""
        over = box_supports(self.pad.box)[-1]
        middle = 0.5 * (self.pad.box[:3] + self.pad.box[3:])
        target = se3.pose(np.diag([1.0, -1.0, -1.0]), [middle[0], middle[1], self.pad.box[5]])
        try:
            if self.pad.touches():
                self.pad.lie(np.empty((0, 3)))
            self.pad.travel(target, over, 0.0)
        except (OverPress, Collision) as error:
            raise PalpateError(f"no way back over the object: {error}") from error
        self.find()

    def announce(self, kind: str, detail: Mapping[str, object]) -> None:
        """Write an event into the recording."""
        self.logbook.announce(kind, detail)

    def stand(self, note: str) -> Progress:
        """Where it stands, with a few words of what it does."""
        cost = self.guard.cost
        return Progress(
            _DOING.get(self.command, self.command),
            cost.touches,
            cost.strokes,
            cost.frames,
            cost.travel,
            cost.seconds,
            note=note,
            folder=self.folder.path,
        )

    def finish(self, felt: Mapping[str, Any], contacts: Contacts) -> dict[str, Any]:
        """Write `contacts.csv`, the page and `summary.json`: `felt` between what every run says."""
        summary = self.told(felt)
        summary["files"] = {**summary["files"], "report": "report.html"}
        with self.folder.writing("report.html") as path:
            write_report(path, self._report(summary, contacts))
        self.folder.write_contacts(contacts, np.full(len(contacts), -1))
        self.folder.finish(summary)
        return summary

    def _report(self, summary: Mapping[str, Any], contacts: Contacts) -> RunReport:
        world, trace = self.world, np.asarray(summary.get("trace", ()), dtype=float).reshape(-1, 3)
        return RunReport(
            summary=summary,
            settings=settings(self.options),
            model=None,
            contacts=contacts.points,
            contact_face=np.full(len(contacts), -1),
            frames=self.logbook.frames(),
            pad_size=world.spec.array.size,
            housing_size=world.spec.housing.size,
            truth=drawn_truth(world.part, world.solid) if world.known else None,
            traces=[trace] if len(trace) > 1 and summary.get("what") != "surface" else [],
        )

    def told(self, felt: Mapping[str, Any]) -> dict[str, Any]:
        """The summary: `felt` between what every run says."""
        cost = self.guard.cost
        return {
            "command": self.command,
            "version": version("palpate"),
            "part": self.world.part.name,
            "sensor": self.world.spec.name,
            "seed": self.options.seed,
            **felt,
            "latency_ms": 1e3 * self.guard.pending.latency,
            "touches": cost.touches,
            "strokes": cost.strokes,
            "frames": cost.frames,
            "travel_mm": cost.travel,
            "device_seconds": cost.seconds,
            "wall_seconds": time.perf_counter() - self.began,
            "warnings": counted([*self.world.part.warnings, *self.warnings, *felt.get("warnings", [])]),
            "files": {"recording": "episode.mcap", "contacts": "contacts.csv"},
        }


@contextmanager
def felt_run(
    options: ExploreOptions,
    command: str,
    world: World,
    watch: Watcher,
    surface: Surface | None = None,
    config: FeltConfig | None = None,
) -> Iterator[FeltRun]:
    """A recorded run over a world; what goes wrong in it and should not is told as our bug."""
    config, began = config or FeltConfig(), time.perf_counter()
    folder = RunFolder.create(options.out, world.part.name, options.overwrite)
    try:
        with interrupts.held(), Recorder(folder.recording) as recorder:
            folder.write_text("config.toml", to_toml(options, version("palpate"), world.resolved(), command))
            logbook = Logbook(recorder)
            guard = guarded(world, options, logbook.observe, surface, config.latency)
            pad = Pad(guard, world.box.ravel(), logbook.announce)
            pad.most = options.max_touches
            run = FeltRun(options, command, world, folder, guard, logbook, pad, began)
            guard.observers = (*guard.observers, lambda seen: _look(run, seen, watch, config))
            guard.pending.latency = measure_latency(guard).seconds
            yield run
    except PalpateError:
        raise
    except Exception as error:
        if interrupt := interrupts.behind(error):
            raise interrupt from None
        raise bugs.told(error, folder.path) from error
    finally:
        world.close()


def _look(run: FeltRun, seen: Observation, watch: Watcher, config: FeltConfig) -> None:
    """Keep the force of a frame in contact, and tell whoever watches now and then."""
    if seen.force > config.sigmas * force_sigma(seen.image):
        run.forces.append(seen.force)
    cost = run.guard.cost
    if cost.frames % config.every == 0:
        interrupts.checkpoint()
        watch(run.stand(f"{max(0.0, seen.force):.1f} N"))


def felt_json(
    trace: Floats | None = None,
    normals: Floats | None = None,
    dihedral: float | None = None,
    closed: bool = False,
    lost: bool = False,
    forces: list[float] | None = None,
    found: Mapping[str, Any] | None = None,
    truth: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """What `track` and `probe` say, under the names that they share; `dihedral` in radians."""
    return {
        "trace": np.empty((0, 3)) if trace is None else trace,
        "normals": np.empty((0, 3)) if normals is None else normals,
        "dihedral_deg": None if dihedral is None else float(np.degrees(dihedral)),
        "closed": closed,
        "lost": lost,
        "force_n": force_json(forces or []),
        "found": dict(found or {}),
        "truth": None if truth is None else dict(truth),
    }


def force_json(forces: list[float]) -> dict[str, float | None]:
    """Mean, root mean square and greatest force [N] in contact."""
    if not forces:
        return {"mean": None, "rms": None, "max": None}
    f = np.asarray(forces)
    return {"mean": float(f.mean()), "rms": float(np.sqrt(np.mean(f**2))), "max": float(f.max())}
