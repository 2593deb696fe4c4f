"""Run every benchmark, or those whose names are given: `make bench`, or `python tests/bench NAME ...`.

`python tests/bench NAME --rows A,B --frames N` measures some rows of a benchmark whose `run` takes them, on few
frames, and only prints them.

Each `bench_NAME.py` has `run() -> list[dict]` with the keys bench, method, metric, value, unit, and `asked` where
a number is asked for.  The rows go to `bench.json` and, as a table, to stdout.  A benchmark that has nothing to
run on (outside data, a competitor) says so on stderr and returns the rows that it has.
"""

import argparse
import importlib
import inspect
import json
import sys
import time
import traceback
from pathlib import Path

from rich.console import Console
from rich.table import Table

HERE = Path(__file__).parent
KEYS = ("bench", "method", "metric", "value", "unit")


def main(arguments: list[str]) -> int:
    sys.path.insert(0, str(HERE))
    parser = argparse.ArgumentParser(prog="python tests/bench")
    parser.add_argument("names", nargs="*")
    parser.add_argument("--rows", type=lambda text: tuple(text.split(",")))
    parser.add_argument("--frames", type=int)
    given = vars(parser.parse_args(arguments))
    names = given.pop("names")
    some = {key: value for key, value in given.items() if value is not None}
    known = sorted(path.stem.removeprefix("bench_") for path in HERE.glob("bench_*.py"))
    if unknown := sorted(set(names) - set(known)):
        print(f"no benchmark {unknown[0]!r}; there are: {', '.join(known)}", file=sys.stderr)
        return 2
    rows, failed = [], []
    for name in names or known:
        began = time.perf_counter()
        try:
            run = importlib.import_module(f"bench_{name}").run
            found = run(**{k: v for k, v in some.items() if k in inspect.signature(run).parameters})
        except Exception:
            traceback.print_exc()
            failed.append(name)
            continue
        rows += [{key: row[key] for key in (*KEYS, *({"asked"} & set(row)))} for row in found]
        print(
            f"{name}: {len(found)} rows in {time.perf_counter() - began:.1f} s", file=sys.stderr, flush=True
        )
    if not some:
        temporary = Path("bench.json.partial")
        temporary.write_text(json.dumps(rows, indent=1) + "\n")
        temporary.replace("bench.json")
    print_table(rows)
    if failed:
        print(f"failed: {', '.join(failed)}", file=sys.stderr)
    return 1 if failed else 0


def print_table(rows: list[dict]) -> None:
    table = Table(box=None, header_style="bold", pad_edge=False)
    for title, align in zip(("bench", "method", "metric", "value", "unit", "asked"), "lllrll", strict=True):
        table.add_column(title, justify="right" if align == "r" else "left")
    last = None
    for row in rows:
        value = row["value"]
        table.add_row(
            "" if row["bench"] == last else row["bench"],
            row["method"],
            row["metric"],
            f"{value:.4g}" if isinstance(value, float) else str(value),
            row["unit"],
            str(row.get("asked", "")),
        )
        last = row["bench"]
    Console(width=None if sys.stdout.isatty() else 160).print(table)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
