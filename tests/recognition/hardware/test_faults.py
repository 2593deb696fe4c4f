"""A sample of `make faults`: faults in random motions over pseudo-terminals, judged by the emulator's physics."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

BENCH = Path(__file__).parents[2] / "bench"
SAMPLE = (
    "unplugged array",
    "wrong baud",
    "deaf stage",
    "reset in motion",
    "Ctrl-C",
    "dropped ok",
)


@pytest.mark.slow
def test_faults_cost_neither_the_force_limit_nor_the_recording_and_can_be_mended(monkeypatch):
    monkeypatch.syspath_prepend(str(BENCH))
    from devices.fault_trial import trial

    with ThreadPoolExecutor(3) as several:  # each mostly waits for its rig's clock
        told = list(several.map(trial, SAMPLE, range(len(SAMPLE))))
    crowded = [k for k, t in enumerate(told) if _wrong(t)]  # a starved rig may be judged before its fault
    alone = {told[k].kind: _wrong(trial(told[k].kind, k)) for k in crowded}
    assert not any(alone.values()), (alone, [_wrong(told[k]) for k in crowded])


def _wrong(told) -> list[str]:
    return [name for name in told.wrong if not name.endswith("late")]
