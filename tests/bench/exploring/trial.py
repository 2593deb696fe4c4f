"""One exploration on a stage that errs as the trackers' benchmark has it, and what its model is worth."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
import trimesh
from exploring.reachable import Reach, reach

from exploration.devices.simulated import PoseNoise, simulate
from exploration.sensing.spec import load_sensor
from models import parts
from models.formats.units import Units
from models.part import load_part
from models.solid import Solid
from primitives.errors import PalpateError
from primitives.pose import from_quaternion
from recognition.config import ExploreOptions
from recognition.explore import run as explore
from recognition.running import simulation

TRACKERS = PoseNoise(white=0.05, contact=0.02, white_turn=0.0, contact_turn=float(np.radians(0.02)))
SIZES = 60.0, 160.0  # [mm] longest side that a file is drawn at
SCALES = 0.9, 1.1  # of a built-in part
NOISE = 0.05  # of the full-contact signal


@dataclass(frozen=True)
class Trial:
    """What is explored, and how."""

    part: str  # a built-in one, or FILE[#N][@UNIT]: the Nth of the bodies in a file, its unit where it tells none
    seed: int
    sensors: tuple[str, ...]
    folder: Path  # of its run
    erring: bool = True
    reached: bool = False  # whether to compare what an array could reach, too, which takes long


def explored(trial: Trial) -> dict[str, Any]:
    """What `summary.json` says, with what the part itself is; `fault` in its place where that ended it."""
    name, units, body = _named(trial.part)
    try:
        scale = drawn_scale(name, units, body, trial.seed)
        part = load_part(name, units, scale, body).solid
    except PalpateError as error:
        return {"part": trial.part, "fault": str(error)}
    told: dict[str, Any] = {"part": trial.part, "scale": scale, "bound": 1.0 - 0.05 * part.area / part.volume}
    options = ExploreOptions(
        name,
        units=units,
        body=body,
        seed=trial.seed,
        sensors=trial.sensors,
        noise=NOISE,
        scale=scale,
        out=trial.folder,
        overwrite=True,
    )
    try:
        with patch.object(simulation, "simulate", _erring if trial.erring else simulate):
            explore(options, lambda _: None)
    except PalpateError as error:
        return told | {"fault": str(error)}
    told = json.loads((trial.folder / "summary.json").read_text()) | told
    if trial.reached and (compared := _reached(part, told, trial)):
        told["reach"] = {"iou": compared.iou, "touched": compared.touched, "area": compared.area}
    return told


def _named(part: str) -> tuple[str, Units, int | None]:
    """Name or path, unit and body of a part as a `Trial` has it."""
    rest, _, units = part.partition("@")
    name, _, number = rest.partition("#")
    return name, units or "auto", int(number) if number else None


def drawn_scale(name: str, units: Units, body: int | None, seed: int) -> float:
    """The factor on a part's size that its name and the seed draw: no sizes are round numbers then."""
    share = float(np.random.default_rng([seed, *Path(name).name.encode()]).uniform())
    low, high = SCALES
    if name not in parts.names():
        corners = np.asarray(load_part(name, units, body=body).solid.bounds).reshape(2, 3)
        low, high = (size / float((corners[1] - corners[0]).max()) for size in SIZES)
    return low + share * (high - low)


def _erring(*given: Any, **named: Any) -> Any:
    """`simulate` on that stage: its turns have no flag, for a number stands for them all."""
    return simulate(*given, **named | {"pose_noise": TRACKERS})


def _reached(part: Solid, told: dict[str, Any], trial: Trial) -> Reach | None:
    """The comparison with all filled that no array could come to; None without a model."""
    truth = told["truth"]
    if truth["iou"] is None:
        return None
    felt = np.loadtxt(trial.folder / "contacts.csv", delimiter=",", skiprows=1, usecols=(0, 1, 2), ndmin=2)
    where = truth["world_from_part"]
    placed = part.placed(from_quaternion(where["quaternion_wxyz"], where["translation_mm"]))
    housings = [load_sensor(sensor).housing for sensor in trial.sensors]
    tools = [np.array([*h.size[:2], h.size[2] + h.proud]) for h in housings]
    model = trimesh.load_mesh(trial.folder / "model.stl")  # of any number of pieces
    return reach(Solid.from_mesh(model.vertices, model.faces), placed, tools, felt)
