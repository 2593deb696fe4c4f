"""Compile every numba kernel once, into the cache beside its source: `python -m recognition.warm`.

Part of installing: a kernel compiles the first time that it is called, which would otherwise be in the middle
of somebody's first exploration.  One whole exploration of a built-in part calls them all.
"""

import tempfile
import time
from pathlib import Path

from recognition.config import ExploreOptions
from recognition.explore import run


def main() -> None:
    """Explore a block into a folder that is thrown away, and say how long that took."""
    began = time.perf_counter()
    print("compiling the kernels, once ...", flush=True)
    with tempfile.TemporaryDirectory(dir=Path.cwd()) as folder:
        run(ExploreOptions(part="block", out=Path(folder) / "run"), lambda _: None)
    print(f"compiled in {time.perf_counter() - began:.1f} s")


if __name__ == "__main__":
    main()
