"""The array of a trial: one that is built in or a file, with what the trial changes about it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, replace
from typing import Any

from exploration.sensing.spec import SensorSpec, load_sensor, sensor_from_toml
from primitives.toml_text import toml_lines
from recognition.experiments.settings import Value
from recognition.experiments.trial import Work


def spec_of(settings: Mapping[str, Value], work: Work) -> SensorSpec:
    """The array, noise and all; refuses what no array can be."""
    s: Mapping[str, Any] = settings
    spec = load_sensor(work.file(s["sensor"]))
    array, housing, rubber, electronics = spec.array, spec.housing, spec.elastomer, spec.electronics
    x, y = array.size
    if s["pitch_mm"] is not None:
        columns, rows = max(1, round(x / s["pitch_mm"])), max(1, round(y / s["pitch_mm"]))
        array = replace(array, rows=rows, columns=columns, pitch=(x / columns, y / rows))
    if s["pad_scale"] is not None:
        rows, columns = (max(1, round(n * s["pad_scale"])) for n in array.shape)
        array = replace(array, rows=rows, columns=columns)
    wider = (array.size[0] - x, array.size[1] - y)
    size = (housing.size[0] + wider[0], housing.size[1] + wider[1], housing.size[2])
    if s["spread_mm"] is not None:
        rubber = replace(rubber, spread=s["spread_mm"])
    if s["bits"] is not None:
        full = float(2 ** s["bits"] - 1) if s["bits"] else 0.0
        share = full / electronics.full_scale if full and electronics.bits else 1.0
        electronics = replace(
            electronics,
            bits=s["bits"],
            plateau=electronics.plateau * share,
            offset=electronics.offset * share,
        )
    changed = {key: s[key] for key in ("dead", "gain_spread", "noise") if s[key] is not None}
    made = replace(
        spec,
        array=array,
        housing=replace(housing, size=size),
        elastomer=rubber,
        electronics=replace(electronics, **changed),
    )
    return made if made == spec else sensor_from_toml(_toml(made), spec.name)


def sensor_of(settings: Mapping[str, Value], work: Work) -> str:
    """The same as a name or a file that commands take."""
    spec = spec_of(settings, work)
    named = work.file(str(settings["sensor"]))
    if spec == load_sensor(named):
        return named
    path = work.scratch / "sensor.toml"
    path.write_text(_toml(spec), encoding="utf-8")
    return str(path)


def _toml(spec: SensorSpec) -> str:
    told = asdict(spec)
    array = told.pop("array")
    name = array.pop("name")
    return "\n".join(toml_lines({"name": name, **told, "array": array})) + "\n"
