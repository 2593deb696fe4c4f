"""The `palpate` command: parse, call, print.

Every import that is not needed to parse sits inside its subcommand: `palpate --help` takes 0.06 s, against
0.03 s for a bare `import typer` and 0.13 s when typer lays the help out with rich, which is why
`rich_markup_mode` is off (median of 10, one 2-core machine).  Results go to stdout, progress and errors to
stderr.
"""

from __future__ import annotations

import gc
import os
import sys
from typing import NoReturn

import typer

from recognition.commands import (
    builtin,
    doctor,
    experiment,
    explore,
    frames,
    hardware,
    library,
    probe,
    reconstruct,
    replay,
    report,
    track,
)
from recognition.commands.answering import INTERRUPTED
from recognition.commands.identify import identify
from recognition.commands.locate import locate
from recognition.commands.recognize import recognize
from recognition.console import interrupts

app = typer.Typer(
    name="palpate",
    help="Recognize objects by touch: explore with a tactile array, reconstruct as CSG.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)
for command in (
    explore.explore,
    reconstruct.reconstruct,
    track.track,
    probe.probe,
    experiment.experiment,
    replay.replay,
    report.report,
    identify,
    locate,
    recognize,
    builtin.parts,
    builtin.sensors,
    frames.frames,
    doctor.doctor,
):
    app.command()(command)
app.add_typer(library.app, name="library")
app.add_typer(hardware.app, name="hardware")


# Objects more than before, from which cycles are looked for: imports make half a million, none of them garbage,
# and the arrays of a run go when they are used last.
_GARBAGE = 50_000

# Matrices here are small: a second thread wins next to nothing on them, and where another process has the core it
# takes ten times as long (`inv` of 200 rows, two processes on two cores).
_ONE_THREAD = ("OMP", "OPENBLAS", "MKL", "NUMBA")


def main() -> None:
    """Run the command line: whatever happens is one line on stderr and an exit code, and never a traceback."""
    gc.set_threshold(_GARBAGE)
    for name in _ONE_THREAD:
        os.environ.setdefault(f"{name}_NUM_THREADS", "1")
    interrupts.heed()
    if sys.stdout is None:
        _end("standard output is closed; send it to a file or to /dev/null")
    try:
        with interrupts.held():
            command = typer.main.get_command(app)
        command()
    except (KeyboardInterrupt, SystemExit):
        if code := interrupts.asked():  # while arguments were parsed, where nobody else says so
            _end(INTERRUPTED, code)
        raise
    except OSError as error:
        if error.filename is not None:
            _end(_bug_text(error))
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # or the exit would try again
        _end(f"cannot print the result ({error.strerror or error}); send standard output elsewhere")
    except Exception as error:
        _end(_bug_text(error))


def _end(text: str, exit_code: int = 1) -> NoReturn:
    typer.echo(f"palpate: {text}", err=True)
    sys.exit(exit_code)


def _bug_text(error: Exception) -> str:
    from recognition.console import bugs

    return str(bugs.told(error))


if __name__ == "__main__":
    main()
