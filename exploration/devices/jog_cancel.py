"""A stop of jogs: canceled (0x85) again and again until the controller stands Idle, or else reset.

A cancel may be lost on the wire, and a jog that was still on its way may begin after it; so one cancel proves
nothing, and only Idle, reported after it, ends the stop.
"""

from exploration.devices.grbl_link import GrblLink
from exploration.devices.jog_plan import StreamConfig

_RESET, _CANCEL = b"\x18", b"\x85"


class JogCancel:
    """One stop at a time."""

    def __init__(self, link: GrblLink, config: StreamConfig) -> None:
        self._link, self._config = link, config
        self._last = 0.0  # [s] when the jogs were canceled last
        self._defied = 0.0  # [s] since when the stage has jogged on
        self.pending = False

    def begin(self, now: float) -> None:
        """Cancel now."""
        if not self.pending:
            self._defied = now
        self.pending = True
        self._say(now)

    def again(self, now: float) -> bool:
        """Whether the last cancel is so old that it may have been lost."""
        return now - self._last > self._config.again

    def look(self, state: str, moment: float, now: float) -> str:
        """A report of `moment` said `state`; why the stage had to be reset, or nothing."""
        if moment <= self._last:
            return ""
        if state == "Idle" and not self._link.unanswered:
            self.pending = False
        elif state != "Jog":
            self._defied = now
        elif now - self._defied > self._config.obeys:
            self._link.realtime(_RESET)
            return "the stage did not obey a jog cancel and was reset; home it, then begin again"
        elif self.again(now):
            self._say(now)
        return ""

    def _say(self, now: float) -> None:
        self._last = now
        self._link.realtime(_CANCEL)
