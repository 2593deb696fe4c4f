from types import SimpleNamespace

import pytest
from numba import njit

from recognition.console import compiling


@pytest.fixture
def slowly(monkeypatch):
    """`slowly(n)`: compile n kernels, each of which takes two seconds by the clock."""
    clock = iter(range(0, 1000, 2))
    monkeypatch.setattr(compiling, "time", SimpleNamespace(monotonic=lambda: float(next(clock))))

    def compile_some(count):
        for _ in range(count):
            njit(lambda x: x + 1)(1)

    return compile_some


def test_a_long_compilation_is_told_once(slowly):
    said = []
    with compiling.told(said.append):
        slowly(4)
    assert said == [compiling.TEXT]


def test_a_single_kernel_is_not_worth_a_word(slowly):
    said = []
    with compiling.told(said.append):
        slowly(1)
    slowly(2)
    assert said == []
