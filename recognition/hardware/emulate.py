"""`palpate hardware emulate`: a virtual array and stage over a part, and the config that reaches them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import cast

import numpy as np

from exploration.devices.emulators.rig import EmulatedRig
from exploration.devices.kinematic_chain import KinematicChain
from exploration.devices.serial_array import PROTOCOLS
from exploration.sensing.spec import load_sensor
from models.formats.units import Units
from models.part import load_part
from models.solid import Solid
from primitives import pose as se3
from primitives.arrays import Floats
from primitives.errors import PalpateError
from primitives.toml_text import toml_lines
from recognition.config import ExploreOptions
from recognition.hardware import artifact
from recognition.hardware.config import StageConfig
from recognition.running.simulation import WorldConfig, random_pose

BOX = (-80.0, -80.0, -80.0, 80.0, 80.0, 80.0)  # [mm] workspace of an emulated rig


def emulated(options: ExploreOptions, protocol: str, letters: str, pace: float = 1.0) -> EmulatedRig:
    """The rig over a part at its pose, the pad above the workspace and facing down."""
    if protocol not in PROTOCOLS:
        raise PalpateError(f"no protocol {protocol!r}; there are {', '.join(PROTOCOLS)}")
    if set(letters) - set("XYZABC") or not set("XYZ") <= set(letters):
        raise PalpateError(f"--axes {letters!r} must be X, Y, Z and any of A, B, C")
    box = np.reshape(options.workspace, (2, 3))
    solid = _solid(options, box)
    spec = load_sensor(options.sensors[0])
    chain = KinematicChain.gantry(letters)
    above = se3.pose(np.diag([1.0, -1.0, -1.0]), [0.0, 0.0, box[1][2] + WorldConfig().start])
    start = chain.reach(above, np.zeros(len(letters))).q
    return EmulatedRig(solid, spec, chain, start, protocol, options.seed, pace=pace)


def _solid(options: ExploreOptions, box: Floats) -> Solid:
    """The part at its pose, or the artifact to calibrate on."""
    if options.part == artifact.NAME:
        return Solid.from_csg(artifact.emulated_artifact())
    part = load_part(options.part, cast(Units, options.units), options.scale, options.body, options.facets)
    pose = options.fixed_pose
    if pose is None:
        pose = random_pose(part.solid, box, np.random.default_rng(options.seed), WorldConfig(offset=20.0))
    return part.solid.placed(pose)


def config_text(rig: EmulatedRig, options: ExploreOptions, protocol: str, letters: str) -> str:
    """The TOML that reaches an emulated rig."""
    array: dict[str, object] = {"port": rig.array_path, "protocol": protocol, "sensor": options.sensors[0]}
    stage: dict[str, object] = {
        "port": rig.stage_path,
        "axes": letters,
        "speed_mm_s": 60.0,
        "acceleration_mm_s2": 2000.0,
        "turn_speed_deg_s": StageConfig("").turn_speed_deg_s,
        "crash_pin": "P",
    }
    limits: dict[str, object] = {"force_n": 60.0, "workspace_mm": options.workspace}
    clock: dict[str, object] = {"clock": str(rig.clock_path)}
    tables = {"array": array, "stage": stage, "limits": limits, "emulation": clock}
    if options.part == artifact.NAME:
        tables["artifact"] = artifact.Artifact().table()
    return "\n".join(f"[{name}]\n" + "\n".join(toml_lines(t)) + "\n" for name, t in tables.items())


def serve(
    options: ExploreOptions,
    protocol: str,
    letters: str,
    config: Path,
    seconds: float,
    say: Callable[[str], object],
    pace: float = 1.0,
) -> None:
    """Write the config, then answer until Ctrl-C or for some seconds."""
    rig = emulated(options, protocol, letters, pace)
    partial = config.with_suffix(".partial")
    try:
        partial.write_text(config_text(rig, options, protocol, letters), encoding="utf-8")
        partial.replace(config)
    except OSError as error:
        raise PalpateError(
            f"cannot write {config} ({error.strerror or error}); choose another --config"
        ) from error
    say(f"array at {rig.array_path} ({protocol}), stage at {rig.stage_path} ({letters}); config: {config}")
    until = seconds or np.inf
    try:
        rig.serve(lambda: rig.clock.now() > until)
    except KeyboardInterrupt:
        pass
    finally:
        say(
            f"most force {rig.most_force:.1f} N, housing hits {rig.housing_hits}, "
            f"refused lines {len(rig.machine.violations)} {sorted(set(rig.machine.violations))}, "
            f"waited {rig.waited:.1f} s for its driver"
        )
        rig.close()
