"""An array on a port: a thread reads, cuts and stamps; `read` takes the next frame and never the bytes.

A frame's time is the host's clock when its last byte came, less what held it up (`FrameTimes`).  A control loop
that takes long finds the newest frame, not a queue of old ones; what it missed is counted.
"""

import threading
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from exploration.devices.clock import MACHINE, Clock
from exploration.devices.frame_times import FrameTimes
from exploration.devices.ports import Port
from exploration.devices.wire import flexitac, line_text, matrix_text, weiss_dsa, weiss_wts
from exploration.devices.wire.stream import Cutter, RawFrame, Stream
from exploration.sensing.frame import TaxelArray, TaxelFrame
from primitives.arrays import Floats, frozen
from primitives.errors import PalpateError

PROTOCOLS = ("dsa", "wts", "flexitac", "matrix", "lines")
BAUDS = {"dsa": 115200, "wts": 115200, "flexitac": 2_000_000, "matrix": 2_000_000, "lines": 115200}
_AWAY = 0.1  # [s] between two looks, beyond which nobody listened
_PATIENCE = 3.0  # [s] without a frame, after which reading is in vain
_RESTARTED = 10_000  # frames that are missing at once mean an array that began to count anew
_ENDS = 1.0  # [s] of the machine's time for the thread to end by itself


@dataclass
class FrameCounts:
    """What became of the frames."""

    read: int = 0
    missed: int = 0  # came while the loop was busy
    late: int = 0  # more than half a period after they were due
    lost: int = 0  # never came, as the array's own count of them says
    skipped_bytes: int = 0  # belonged to no frame
    reconnects: int = 0  # of a port that had gone

    @property
    def remark(self) -> str:
        """What did not go well on the wire, in one line; empty where all did."""
        told = {
            "came late": self.late,
            "never came": self.lost,
            "bytes belonged to none": self.skipped_bytes,
            "times its port had gone": self.reconnects,
        }
        said = ", ".join(f"{count} {what}" for what, count in told.items() if count)
        return f"of {self.read} frames of the array {said}" if said else ""


def cutter(protocol: str, shape: tuple[int, int]) -> Cutter:
    """The codec of a protocol, for an array of (rows, columns)."""
    cells = shape[0] * shape[1]
    table: dict[str, Cutter] = {
        "dsa": lambda data, _: weiss_dsa.cut(data, cells),
        "wts": lambda data, _: weiss_wts.cut(data, cells),
        "flexitac": lambda data, locked: flexitac.cut(data, cells, locked),
        "matrix": lambda data, _: matrix_text.cut(data, shape),
        "lines": lambda data, _: line_text.cut(data, cells),
    }
    if protocol not in table:
        raise PalpateError(f"no array protocol {protocol!r}; there are {', '.join(PROTOCOLS)}")
    return table[protocol]


class SerialArray:
    """A tactile array behind a port; `watch` is called with every frame, in the reader's thread."""

    def __init__(
        self,
        port: Port,
        protocol: str,
        array: TaxelArray,
        period: float,
        flange_from_sensor: Floats,
        clock: Clock = MACHINE,
    ) -> None:
        self._clock = clock
        self._port, self._protocol, self._array, self._period = port, protocol, array, period
        self._mount = frozen(flange_from_sensor)
        self._stream = Stream(cutter(protocol, array.shape))
        self._news = threading.Condition()
        self._newest: TaxelFrame | None = None
        self._taken = -1
        self._fault = ""
        self._open = True
        self._times = FrameTimes(period)
        self._index = 0
        self._sequence = -1  # of the newest frame, as the array counts
        self._strange = 0  # bytes of no frame before the newest frame
        self._last = self._listened = self._clock.now()
        self._deaf = 0.0  # [s] of listening without a frame; what nobody listened to does not count
        self.counts = FrameCounts()
        self.watch: Callable[[TaxelFrame], None] = lambda frame: None
        self.gone: Callable[[], None] = lambda: None  # called when the port has gone, in the reader's thread
        self.before: Callable[[TaxelFrame], None] = lambda frame: None  # called before `read` returns a frame
        self.fault: Callable[[], str] = lambda: ""  # why reading is in vain, as others know
        self._greet()
        self._thread = threading.Thread(target=self._run, name=f"array {array.name}", daemon=True)

    @property
    def array(self) -> TaxelArray:
        """Its layout."""
        return self._array

    @property
    def flange_from_sensor(self) -> Floats:
        """(4, 4) where it is mounted."""
        return self._mount

    @property
    def period(self) -> float:
        """Seconds from one frame to the next."""
        return self._period

    def start(self) -> None:
        """Begin to listen."""
        self._thread.start()

    def read(self) -> TaxelFrame:
        """The next frame; one that came while nobody read is taken only if no newer one has come."""
        with self._news:
            while self._newest is None or self._newest.index <= self._taken:
                if why := self._fault or self.fault():
                    raise PalpateError(why)
                if self._deaf > _PATIENCE:
                    raise PalpateError(self._no_frame())
                self._news.wait(0.02)
            frame = self._newest
            self.counts.missed += frame.index - self._taken - 1 if self._taken >= 0 else 0
            self._taken = frame.index
        if why := self._fault or self.fault():
            raise PalpateError(why)
        self.before(frame)
        return frame

    def _no_frame(self) -> str:
        strange = self._stream.skipped - self._strange
        why = f", only {strange} bytes that are none; check protocol and baud rate" if strange else ""
        return f"no frame from {self._port.address} for {_PATIENCE:.0f} s{why or '; check cable and power'}"

    def close(self) -> None:
        """Stop listening."""
        self._open = False
        if self._thread.is_alive():
            self._thread.join(_ENDS)
        stop = {"dsa": weiss_dsa.configure(False), "wts": weiss_wts.stop()}.get(self._protocol)
        if stop and not self._fault:
            try:
                self._port.write(stop)
            except PalpateError as error:
                self._fault = str(error)
        self._port.close()

    def _greet(self) -> None:
        rate = max(1, round(1.0 / self._period))
        start = {
            "dsa": weiss_dsa.configure(True, rate=min(rate, 30)),
            "wts": weiss_wts.start(round(1000.0 * self._period)),
        }.get(self._protocol)
        if start:
            self._port.write(start)

    def _run(self) -> None:
        try:
            while self._open:
                try:
                    self._listen()
                except PalpateError as error:
                    self.gone()
                    if self._open and not self._reconnected():
                        self._fault = str(error)
                        return
        except PalpateError as error:
            self._fault = str(error)
        except Exception as error:
            self._fault = (
                f"the array's thread failed ({type(error).__name__}: {error}); no frame comes any more"
            )

    def _listen(self) -> None:
        heard = self._clock.now()
        while self._open:
            data = self._port.read()
            now = self._clock.now()
            self._deaf += min(now - self._listened, _AWAY)
            self._listened = now
            if not data:
                if self._stream.waiting and now - heard > max(0.5 * self._period, 0.004):
                    self._stream.gap()
                continue
            heard = now
            for raw in self._stream.feed(data):
                self._take(raw, now)
            self.counts.skipped_bytes = self._stream.skipped

    def _reconnected(self) -> bool:
        """Whether the port came again within the patience of who reads."""
        until = self._clock.now() + 0.8 * _PATIENCE
        while self._open and self._clock.now() < until:
            self._clock.sleep(0.1)
            if self._port.reopened():
                self._stream.gap()
                self._times = FrameTimes(self._period)
                self._greet()
                self.counts.reconnects += 1
                return True
        return False

    def _take(self, raw: RawFrame, now: float) -> None:
        self.counts.read += 1
        self.counts.late += bool(self._index and now - self._last > 1.5 * self._period)
        lost = 0
        if raw.sequence is not None:
            ahead = raw.sequence - self._sequence - 1
            lost = ahead if self._sequence >= 0 and 0 < ahead < _RESTARTED else 0
            self._sequence = raw.sequence
        self.counts.lost += lost
        moment = self._times.stamp(now, lost, raw.sequence is None and self._stream.skipped > self._strange)
        frame = TaxelFrame(frozen(np.reshape(raw.counts, self._array.shape)), moment, self._index)
        self._index += 1
        self._last, self._strange, self._deaf = now, self._stream.skipped, 0.0
        self.watch(frame)
        with self._news:
            self._newest = frame
            self._news.notify_all()
