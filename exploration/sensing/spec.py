"""What a tactile array is: its layout, rubber, housing and electronics, as frozen data that TOML describes.

A stage whose number is zero is absent.  Lengths are in mm, forces in N, times in s; signals are fractions of
the array's full-contact signal, which is the plateau in counts at the nominal press depth.
"""

import tomllib
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field, fields
from difflib import get_close_matches
from importlib import resources
from math import inf, isfinite
from pathlib import Path
from typing import Any

from exploration.sensing.frame import TaxelArray
from primitives.errors import PalpateError

TECHNOLOGIES = ("capacitive", "magnetic", "piezoresistive", "optical", "conductive elastomer", "unspecified")


@dataclass(frozen=True)
class Elastomer:
    """The rubber: a Winkler foundation whose pressure spreads as a Gaussian on its way to the taxels."""

    stiffness: float  # [N/mm^3]
    thickness: float  # [mm] indentation beyond it is an over-press
    spread: float = 0.0  # [mm] standard deviation of the point spread
    margin: float = 0.0  # [mm] skin past the outer taxels on every side
    hysteresis: float = (
        0.0  # half-width of the play between loading and unloading, of the full-contact signal
    )


@dataclass(frozen=True)
class Housing:
    """The box behind the skin: its front face is `proud` behind the skin's plane."""

    size: tuple[float, float, float]  # (x, y, z) [mm]
    proud: float  # [mm]


@dataclass(frozen=True)
class Electronics:
    """From pressure to counts."""

    bits: int = 0  # of the converter; 0: counts are neither whole nor bounded
    plateau: float = 200.0  # [counts] above the offset, at the nominal press depth
    offset: float = 10.0  # [counts] of an untouched taxel
    noise: float = 0.0  # 1 sigma per reading, of the full-contact signal
    gain_spread: float = 0.0  # 1 sigma over taxels, relative
    dead: float = 0.0  # fraction of taxels that always read the offset
    drift: float = 0.0  # random walk of each taxel's zero after one second, of the full-contact signal
    scan: float = 0.0  # [s] from the sampling of the first row to that of the last

    @property
    def full_scale(self) -> float:
        """The largest count; infinite without a converter."""
        return float(2**self.bits - 1) if self.bits else inf


@dataclass(frozen=True)
class Capacitor:
    """Cells that measure how near two electrodes come, under the rubber."""

    gap: float  # [mm] of indentation that would bring the plates together
    fringe: float = 0.0  # [mm] over which the field decays past an electrode's rim


@dataclass(frozen=True)
class Thermal:
    """A layer of the skin that feels temperature: it follows what it touches with one time constant."""

    time_constant: float  # [s] in contact
    ambient: float = 20.0  # [deg C] of the air, and of an object of which nothing else is said
    noise: float = 0.0  # [deg C] 1 sigma of a reading


@dataclass(frozen=True)
class SensorSpec:
    """A whole sensor."""

    array: TaxelArray
    elastomer: Elastomer
    housing: Housing
    electronics: Electronics = field(default_factory=Electronics)
    technology: str = "unspecified"
    period: float = 0.005  # [s] between frames
    press_depth: float = 0.5  # [mm] nominal indentation
    capacitor: Capacitor | None = None  # taxels that measure a gap; None: they measure pressure
    thermal: Thermal | None = None  # None: the array feels no temperature

    @property
    def name(self) -> str:
        """The array's name."""
        return self.array.name

    @property
    def counts_per_pressure(self) -> float:
        """[counts / (N/mm^2)] of an ideal taxel, pressed faintly."""
        signal = self.press_depth
        if self.capacitor is not None:
            signal /= 1.0 - self.press_depth / self.capacitor.gap
        return self.electronics.plateau / (self.elastomer.stiffness * signal)


def whole_body(spec: SensorSpec) -> Housing:
    """Skin and housing as one box from the skin's plane, as an array counts that is not in use."""
    x, y, z = spec.housing.size
    return Housing((x, y, z + spec.housing.proud), 0.0)


def sensor_names() -> tuple[str, ...]:
    """The presets that come with Palpate."""
    folder = resources.files(__package__) / "presets"
    return tuple(sorted(f.name[:-5] for f in folder.iterdir() if f.name.endswith(".toml")))


def load_sensor(name_or_path: str | Path) -> SensorSpec:
    """A preset by name, or a TOML file by path."""
    text = str(name_or_path)
    if text in sensor_names():
        source = (resources.files(__package__) / "presets" / f"{text}.toml").read_text(encoding="utf-8")
        return sensor_from_toml(source, text)
    path = Path(name_or_path)
    if path.suffix.lower() != ".toml":
        near = get_close_matches(text, sensor_names(), n=1)
        hint = f"; did you mean {near[0]}?" if near else ""
        raise PalpateError(
            f"no sensor {text!r}{hint} (built in: {', '.join(sensor_names())}; or a .toml file)"
        )
    try:
        source = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise PalpateError(f"cannot read sensor file {text}: {_reason(error)}") from error
    return sensor_from_toml(source, path.stem)


def sensor_from_toml(source: str, name: str) -> SensorSpec:
    """A sensor from TOML text; `name` is used where the text gives none."""
    try:
        table = tomllib.loads(source)
    except tomllib.TOMLDecodeError as error:
        raise PalpateError(f"sensor {name}: not valid TOML: {error}") from error
    top = {f.name for f in fields(SensorSpec)} | {"name"}
    _refuse_unknown(table, top, f"sensor {name}")
    array = {"name": table.get("name", name), **_table(table, "array", name)}
    spec = SensorSpec(
        _build(TaxelArray, array, f"sensor {name} [array]"),
        _build(Elastomer, _table(table, "elastomer", name), f"sensor {name} [elastomer]"),
        _build(Housing, _table(table, "housing", name), f"sensor {name} [housing]"),
        _build(Electronics, table.get("electronics", {}), f"sensor {name} [electronics]"),
        capacitor=_build(Capacitor, table["capacitor"], f"sensor {name} [capacitor]")
        if "capacitor" in table
        else None,
        thermal=_build(Thermal, table["thermal"], f"sensor {name} [thermal]") if "thermal" in table else None,
        **_values(
            SensorSpec, {k: table[k] for k in ("technology", "period", "press_depth") if k in table}, name
        ),
    )
    _refuse_nonsense(spec)
    return spec


def _reason(error: Exception) -> str:
    return (error.strerror or str(error)) if isinstance(error, OSError) else "it is not text"


def _table(table: Mapping[str, Any], key: str, name: str) -> Mapping[str, Any]:
    if not isinstance(table.get(key), dict):
        raise PalpateError(f"sensor {name}: the table [{key}] is missing")
    found: Mapping[str, Any] = table[key]
    return found


def _refuse_unknown(table: Mapping[str, Any], valid: set[str], where: str) -> None:
    for key in table:
        if key not in valid:
            raise PalpateError(f"{where}: unknown key {key!r}; valid keys: {', '.join(sorted(valid))}")


def _build(kind: type[Any], table: Any, where: str) -> Any:
    if not isinstance(table, Mapping):
        raise PalpateError(f"{where}: must be a table")
    _refuse_unknown(table, {f.name for f in fields(kind)}, where)
    missing = [f.name for f in fields(kind) if f.default is MISSING and f.name not in table]
    if missing:
        raise PalpateError(f"{where}: missing {', '.join(missing)}")
    return kind(**_values(kind, table, where))


def _values(kind: type[Any], table: Mapping[str, Any], where: str) -> dict[str, Any]:
    """Each value as its field's type."""
    return {
        f.name: _value(f.type, table[f.name], f"{where}: {f.name}") for f in fields(kind) if f.name in table
    }


def _value(wanted: Any, value: Any, where: str) -> Any:
    count = {tuple[float, float]: 2, tuple[float, float, float]: 3}.get(wanted)
    if count is not None:
        if not isinstance(value, list) or len(value) != count:
            raise PalpateError(f"{where} must be a list of {count} numbers, not {value!r}")
        return tuple(_value(float, v, where) for v in value)
    if wanted is str and isinstance(value, str):
        return value
    if wanted is int and isinstance(value, int) and not isinstance(value, bool):
        return value
    if wanted is float and isinstance(value, int | float) and not isinstance(value, bool):
        if not isfinite(value):
            raise PalpateError(f"{where} must be finite, not {value!r}")
        return float(value)
    raise PalpateError(f"{where} must be {wanted.__name__}, not {value!r}")


def _refuse_nonsense(spec: SensorSpec) -> None:
    e, r, a = spec.electronics, spec.elastomer, spec.array
    rules = {
        "array.rows and array.columns must be from 1 to 1024": min(a.shape) >= 1 and max(a.shape) <= 1024,
        "array.pitch must be positive": min(a.pitch) > 0,
        "elastomer.stiffness and elastomer.thickness must be positive": min(r.stiffness, r.thickness) > 0,
        "elastomer.spread, margin and hysteresis must not be negative": min(r.spread, r.margin, r.hysteresis)
        >= 0,
        "housing.size and housing.proud must be positive": min(*spec.housing.size, spec.housing.proud) > 0,
        "electronics.bits must be from 0 (no converter) to 32": 0 <= e.bits <= 32,
        "electronics.plateau and offset must fit below full scale": 0 < e.plateau <= e.full_scale - e.offset,
        "electronics values must not be negative": min(e.offset, e.noise, e.gain_spread, e.drift, e.scan)
        >= 0,
        "electronics.dead must be from 0 to 1": 0 <= e.dead <= 1,
        "period must be positive, and not shorter than electronics.scan": spec.period > 0
        and e.scan <= spec.period,
        "press_depth must be positive, and below elastomer.thickness": 0 < spec.press_depth < r.thickness,
        "capacitor.gap must be greater than elastomer.thickness, and the rubber must spread": spec.capacitor
        is None
        or (spec.capacitor.gap > r.thickness and spec.capacitor.fringe >= 0 and r.spread > 0),
        "thermal.time_constant must be positive, and thermal.noise not negative": spec.thermal is None
        or (spec.thermal.time_constant > 0 and spec.thermal.noise >= 0),
        f"technology must be one of {', '.join(TECHNOLOGIES)}": spec.technology in TECHNOLOGIES,
    }
    for rule, kept in rules.items():
        if not kept:
            raise PalpateError(f"sensor {spec.name}: {rule}")
