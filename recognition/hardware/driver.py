"""A stage of one's own: a class in a file of one's own, named in the set-up as `driver = "arm.py:Arm"`."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import cast

from exploration.devices.protocols import MotionStage
from primitives.errors import PalpateError
from recognition.hardware.config import StageConfig

_NEEDS = ("limits", "pose", "move", "go_to", "moving", "stop", "events")


def driven(config: Path, told: StageConfig) -> MotionStage:
    """The stage that the driver makes of its port; the file is looked for beside the set-up's."""
    name, _, kind = told.driver.partition(":")
    file = config.parent / name
    if not kind or not file.is_file():
        raise PalpateError(
            f"{config} [stage]: driver {told.driver!r} must be FILE.py:CLASS, the file beside it"
        )
    spec = importlib.util.spec_from_file_location(file.stem, file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
        stage = getattr(module, kind)(told.port)
    except PalpateError:
        raise
    except Exception as error:
        raise PalpateError(
            f"{told.driver} cannot be used ({type(error).__name__}: {error}); mend it"
        ) from error
    missing = [name for name in _NEEDS if not hasattr(stage, name)]
    if missing:
        raise PalpateError(
            f"{told.driver} lacks {', '.join(missing)} of a MotionStage; docs/hardware.md shows one"
        )
    return cast(MotionStage, stage)
