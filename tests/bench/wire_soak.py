"""Random and mutated byte streams for every codec: `make soak`, and a sample of it in the tests.

After whatever damage, good frames follow; the last of them must come out whole, nothing may raise, and what waits
in the stream may not outgrow a frame.
"""

import resource
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from exploration.devices.wire import flexitac, line_text, matrix_text, weiss_dsa, weiss_wts
from exploration.devices.wire.stream import Stream

SHAPE = (3, 4)
CELLS = 12


@dataclass(frozen=True)
class Protocol:
    encode: Callable
    cut: Callable
    highest: int
    longest: int  # bytes that may wait

    def random(self, rng):
        values = rng.integers(0, self.highest + 1, CELLS)
        return np.where(rng.random(CELLS) < 0.5, 0, values)


PROTOCOLS = {
    "weiss dsa": Protocol(
        lambda f, i: weiss_dsa.encode_frame(f, i, bool(i % 2)),
        lambda b, _: weiss_dsa.cut(b, CELLS),
        4095,
        200,
    ),
    "weiss wts": Protocol(
        lambda f, i: weiss_wts.encode(f, i), lambda b, _: weiss_wts.cut(b, CELLS), 65535, 200
    ),
    "flexitac": Protocol(lambda f, i: flexitac.encode(f), lambda b, k: flexitac.cut(b, CELLS, k), 255, 20),
    "matrix text": Protocol(
        lambda f, i: matrix_text.encode(f.reshape(SHAPE)), lambda b, _: matrix_text.cut(b, SHAPE), 65535, 200
    ),
    "line text": Protocol(
        lambda f, i: line_text.encode(f, i, i), lambda b, _: line_text.cut(b, CELLS), 65535, 200
    ),
}


def mutated_streams(protocol: Protocol, count: int, seed: int) -> int:
    """How many of `count` damaged streams ended with their last frame read."""
    rng = np.random.default_rng(seed)
    pool = [protocol.random(rng) for _ in range(64)]
    coded = [protocol.encode(f, i) for i, f in enumerate(pool)]
    good = 0
    for _ in range(count):
        damaged = bytearray(_damage(rng, coded))
        pick = rng.integers(0, len(pool), 6)
        tail = b"".join(coded[k] for k in pick)
        stream = Stream(protocol.cut)
        cut = int(rng.integers(0, len(damaged) + 1))
        stream.feed(bytes(damaged[:cut]))
        stream.feed(bytes(damaged[cut:]))
        if rng.random() < 0.5:
            stream.gap()
        got = [*stream.feed(tail)]
        assert stream.waiting <= protocol.longest, stream.waiting
        good += bool(got) and np.array_equal(np.ravel(got[-1].counts), pool[pick[-1]])
    return good


def _damage(rng, coded):
    kind = rng.integers(0, 4)
    if kind == 0:
        return rng.integers(0, 256, int(rng.integers(0, 120)), dtype=np.uint8).tobytes()
    data = bytearray(b"".join(coded[k] for k in rng.integers(0, len(coded), 2)))
    if kind == 1:
        for at in rng.integers(0, len(data), 3):
            data[at] = int(rng.integers(0, 256))
    elif kind == 2:
        at = int(rng.integers(0, len(data)))
        del data[at : at + int(rng.integers(1, 9))]
    else:
        data = data[int(rng.integers(0, len(data))) :][: int(rng.integers(0, len(data)))]
    return bytes(data)


def main(count: int) -> int:
    failed = 0
    for name, protocol in PROTOCOLS.items():
        began, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        good = sum(mutated_streams(protocol, min(1000, count), seed) for seed in range(max(1, count // 1000)))
        grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
        total = max(1, count // 1000) * min(1000, count)
        print(
            f"{name}: {good} of {total} in {time.perf_counter() - began:.0f} s, memory +{grown} kB",
            flush=True,
        )
        failed += good < total
    return failed


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000))
