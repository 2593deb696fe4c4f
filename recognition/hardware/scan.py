"""`palpate hardware scan`: the ports of this machine, and a config to start from."""

from __future__ import annotations

from pathlib import Path

from exploration.devices.ports import scan
from primitives.errors import PalpateError

_START = """# A set-up for palpate: mend what is not as yours, then: palpate hardware check {name}
[array]
port = "{array}"
protocol = "lines"        # dsa, wts, flexitac, matrix or lines
sensor = "lts210"         # palpate sensors, or a TOML file of your own
# baud = 115200           # the protocol's own, where left out
# calibration = "my-array.toml"
translation_mm = [0.0, 0.0, 0.0]   # where the array sits on the flange
quaternion_wxyz = [1.0, 0.0, 0.0, 0.0]

[stage]                   # leave it out to look at frames alone
port = "{stage}"
axes = "XYZ"              # a gantry's letters, or one table an axis
speed_mm_s = 20.0
acceleration_mm_s2 = 200.0
# crash_pin = "P"         # where a breakaway switch is wired to the probe input

[limits]
force_n = 20.0
reach_mm = [-150.0, -150.0, -100.0, 150.0, 150.0, 100.0]
workspace_mm = [-50.0, -50.0, -50.0, 50.0, 50.0, 50.0]
"""


def found_ports() -> list[dict[str, str]]:
    """A row for every port."""
    return [{"port": p.address, "what": p.description, "trouble": p.trouble} for p in scan()]


def start_config(ports: list[dict[str, str]], out: Path) -> None:
    """A config with the first two ports, or with names to be filled in."""
    if out.exists():
        raise PalpateError(f"{out} is there already; name a new file")
    names = [row["port"] for row in ports if not row["trouble"]] + ["/dev/ttyUSB0", "/dev/ttyUSB1"]
    try:
        out.write_text(_START.format(name=out.name, array=names[0], stage=names[1]), encoding="utf-8")
    except OSError as error:
        raise PalpateError(
            f"cannot write {out} ({error.strerror or error}); choose another folder"
        ) from error


def text(ports: list[dict[str, str]]) -> str:
    """The ports, a line each."""
    if not ports:
        return "no serial ports; plug the array and the stage in (palpate hardware emulate needs none)"
    return "\n".join(
        f"{p['port']:16} {p['what']}{'  ' + p['trouble'] if p['trouble'] else ''}" for p in ports
    )
