"""The page of commands as the commands are when the site is built, whatever the file says."""

import importlib.util
from pathlib import Path
from typing import Any


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Called by mkdocs for each page."""
    if page.file.src_uri != "commands.md":
        return markdown
    spec = importlib.util.spec_from_file_location("make_pages", Path(__file__).with_name("make_pages.py"))
    assert spec is not None
    assert spec.loader is not None
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    told: str = script.commands_page()
    return told
