"""Faults at random moments of random motions on an emulated rig: `make faults`, and a sample of it in the tests.

python tests/bench/fault_soak.py [COUNT] [PACE] [FIRST]
"""

import sys
import time
from collections import defaultdict
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from devices.fault_trial import KINDS, trial


def main(count: int, pace: float, first: int) -> int:
    began, failed, by_kind = time.perf_counter(), 0, defaultdict(list)
    seeds = range(first, first + count)
    kinds = [list(KINDS)[seed % len(KINDS)] for seed in seeds]
    with ThreadPoolExecutor(4) as several:
        for seed, told in zip(seeds, several.map(trial, kinds, seeds, [pace] * count), strict=True):
            by_kind[told.kind].append(told)
            failed += bool(told.wrong)
            if told.wrong:
                where = f"{seed} {told.kind} in {told.motion} at {told.speed:.0f} mm/s"
                print(f"{where}: {'; '.join(told.wrong)}", flush=True)
    for kind, told in by_kind.items():
        late = np.array([1e3 * t.stopped for t in told])
        force = max(t.most_force for t in told)
        stops = f"{np.median(late):.0f} ms, at most {late.max():.0f} ms" if np.isfinite(late).all() else "-"
        good = sum(not t.wrong for t in told)
        print(
            f"{kind:16} {good} of {len(told)} as they must be; stopped after {stops}; at most {force:.1f} N"
        )
    print(f"{count - failed} of {count} in {time.perf_counter() - began:.0f} s")
    return failed


if __name__ == "__main__":
    given = [float(word) for word in sys.argv[1:]] + [200.0, 1.0, 0.0][len(sys.argv) - 1 :]
    sys.exit(main(int(given[0]), given[1], int(given[2])) > 0)
