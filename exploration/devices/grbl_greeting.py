"""The first words with a Grbl controller: whether it answers, stands free, and has the axes that were told.

And the first words again, after its port was away: a cable that is plugged in again may have reset the controller.
"""

from collections.abc import Callable

import numpy as np

from exploration.devices.grbl_link import GrblLink
from exploration.devices.grbl_text import Status
from exploration.devices.kinematic_chain import KinematicChain
from primitives.arrays import Floats
from primitives.errors import PalpateError

_MOVED = 5.0  # [mm, deg] that a stage may have moved on while its port was away
_PATIENCE = 3.0  # [s] of listening


def greet(link: GrblLink, chain: KinematicChain) -> list[int]:
    """Where each number of a report belongs among the chain's axes; raises where the stage cannot be used."""
    report = _first_report(link)
    if report.state == "Alarm":
        raise PalpateError(
            "the stage is in alarm: home it (palpate hardware jog CONFIG --home), then begin again"
        )
    if report.position is None:
        raise PalpateError("the stage reports no machine position; set $10=1")
    axes = next((line for line in link.exchange("$I", 2.0).other if line.startswith("[AXS:")), "")
    letters = axes.rstrip("]").split(":")[-1] if axes else "XYZ"[: len(chain.axes)]
    told = "".join(axis.letter for axis in chain.axes)
    if sorted(letters) != sorted(told):
        raise PalpateError(f"the controller has the axes {letters}, the config {told}; correct the config")
    if len(report.position) != len(told):
        raise PalpateError(
            f"the controller reports {len(report.position)} positions for {len(told)} axes; correct the config"
        )
    return [told.index(letter) for letter in letters]


def greet_again(link: GrblLink, chain: KinematicChain, wanted: Callable[[], bool]) -> bool:
    """Try as long as it is wanted to open the port again; whether the stage answers there."""
    while wanted():
        link.clock.sleep(0.1)
        if link.port.reopened():
            link.forget()
            try:
                greet(link, chain)
            except PalpateError:
                continue
            return True
    return False


def lost_position(chain: KinematicChain, before: Floats, after: Floats) -> str:
    """What to say where the joints (n,) [mm, rad] are elsewhere than before the port was away; empty where not."""
    moved = (np.abs((after - before) * chain.to_wire) > _MOVED).any()
    return "the stage has lost its position; home it, then begin again" if moved else ""


def _first_report(link: GrblLink) -> Status:
    while link.deaf < _PATIENCE:
        link.ask()
        if reports := link.listen().reports:
            return reports[-1][1]
        link.clock.sleep(0.01)
    raise PalpateError(
        f"no answer from {link.port.address}; is it a Grbl controller, and the baud rate right?"
    )
