"""STEP on stdin, GLB on stdout: run as a program of its own, because the reader may crash or grow without end.

Run by file name in isolated mode, so it imports nothing of ours.  Arguments: facets' tolerance [mm], their
angle [rad], most memory [bytes], most processor time [s].  What the reader prints goes nowhere.
"""

import os
import sys
from contextlib import suppress


def main() -> int:
    """0 with the GLB written; 3 where the reader found nothing it could read."""
    tolerance, angle, memory, seconds = float(sys.argv[1]), float(sys.argv[2]), *map(int, sys.argv[3:5])
    _limit(memory, seconds)
    answer = os.dup(1)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.dup2(nowhere, 2)
    import cascadio

    data = cascadio.load(
        sys.stdin.buffer.read(),
        tol_linear=tolerance,
        tol_angular=angle,
        use_parallel=False,
        include_brep=True,
    )
    with os.fdopen(answer, "wb") as out:
        out.write(data)
    return 0 if data else 3


def _limit(memory: int, seconds: int) -> None:
    try:
        import resource
    except ImportError:  # Windows has no such limits; the parent's clock still ends us
        return
    # past the first of the two the parent is told why by the signal, past the second there is no answer
    limits = ((resource.RLIMIT_CORE, 0, 0), (resource.RLIMIT_CPU, seconds, seconds + 5))
    for kind, most, hard in (*limits, (resource.RLIMIT_AS, memory, memory)):
        with suppress(OSError, ValueError):  # a system may refuse a limit; it then does without
            resource.setrlimit(kind, (most, hard))


if __name__ == "__main__":
    sys.exit(main())
