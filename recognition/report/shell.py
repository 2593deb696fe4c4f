"""What every page has in common: one HTML file that needs nothing else, neither network nor server.

A template's `{{name}}` places are filled once, from left to right; what fills them is never searched again.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from importlib.resources import files

from recognition.running.folder import json_text


def shell(
    *,
    title: str,
    lede: str,
    figures: str,
    main: str,
    footer: str,
    styles: Sequence[str] = (),
    scripts: Sequence[str] = (),
    data: object = None,
    asks: bool = False,
) -> str:
    """A page; texts are HTML already.  Only one that `asks` its server for more may connect to it."""
    policy = ["default-src 'none'", "style-src 'unsafe-inline'", "img-src data:"]
    policy += ["connect-src 'self'"] if asks else []
    policy += ["script-src 'unsafe-inline'"] if scripts else []
    return filled(
        "shell.html",
        title=title,
        lede=lede,
        figures=figures,
        main=main,
        footer=footer,
        policy="; ".join(policy),
        style="".join(_resource(name) for name in ("style.css", *styles)),
        script=_script(scripts, data) if scripts else "",
    )


def view(seen: str, layers: str = "", *, plays: bool = False) -> str:
    """The 3-D view with its buttons."""
    return filled(
        "view.html",
        seen=seen,
        keys="; the space bar plays the run" if plays else "",
        layers=layers,
        layers_are="Layers" if layers else "View",
    )


def filled(template: str, **places: str) -> str:
    """A template of this folder with all of its places filled."""
    return re.sub(r"\{\{(\w+)\}\}", lambda place: places[place[1]], _resource(template))


def _script(scripts: Sequence[str], data: object) -> str:
    told = json_text(data).replace("<", "\\u003c")
    code = "\n".join(_resource(name) for name in scripts).replace('"use strict";\n', "")
    return f'<script type="application/json" id="data">{told}</script>\n<script>\n{code}\n</script>'


def _resource(name: str) -> str:
    return (files(__package__) / name).read_text(encoding="utf-8")
