"""What every command that touches an object can be told: the object, where it is, the array, the seed, the folder.

A command takes all of these as one parameter of type `RunFlags`, and `spread` shows them as flags of its own; what
is usual for the command is that parameter's default.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Annotated, Any, TypeVar, get_type_hints

import typer

from recognition.commands import flags
from recognition.console import interrupts

if TYPE_CHECKING:
    from recognition.config import ExploreOptions

EVERYWHERE = "-300,-300,-300,300,300,300"
Part = Annotated[str, typer.Argument(metavar="PART", help="A built-in part (palpate parts) or a CAD file.")]
Latency = Annotated[
    float, typer.Option(help="By which the simulated stage obeys late [s]; measured, never told.")
]
_Options = TypeVar("_Options", bound="ExploreOptions")


@dataclass(frozen=True)
class RunFlags:
    """The flags as they were typed."""

    units: flags.Units = "auto"
    scale: flags.Scale = 1.0
    body: flags.Body = None
    facets: flags.Facets = False
    workspace: flags.Workspace = EVERYWHERE
    feature_mm: flags.FeatureMm = 10.0
    pose: flags.Pose = "random"
    sensor: flags.Sensor = "lts210"
    support: flags.Support = "none"
    cover: flags.Cover = None
    noise: flags.Noise = None
    pose_noise_mm: flags.PoseNoise = 0.0
    seed: flags.Seed = 0
    out: flags.Out = None
    overwrite: flags.Overwrite = False

    def options(self, kind: Callable[..., _Options], **own: object) -> _Options:
        """The checked settings of a command, its `own` among them."""
        with interrupts.held():
            from recognition.config import parse_numbers, parse_pose

        return kind(
            units=self.units,
            scale=self.scale,
            body=self.body,
            facets=self.facets,
            workspace=parse_numbers(self.workspace, 6, "--workspace", "X0,Y0,Z0,X1,Y1,Z1 in mm"),
            feature=self.feature_mm,
            pose=parse_pose(self.pose),
            sensors=tuple(self.sensor.split(",")),
            support=self.support,
            cover=self.cover,
            noise=self.noise,
            pose_noise=self.pose_noise_mm,
            seed=self.seed,
            out=self.out,
            overwrite=self.overwrite,
            **own,
        )


def spread(command: Callable[..., None]) -> Callable[..., None]:
    """The same command, with each of its `RunFlags` as a flag in their place."""
    hints = get_type_hints(command, include_extras=True)
    shared = get_type_hints(RunFlags, include_extras=True)
    taken: list[inspect.Parameter] = []
    for parameter in inspect.signature(command).parameters.values():
        if hints[parameter.name] is RunFlags:
            place, own = parameter.name, parameter.default
            usual = own if isinstance(own, RunFlags) else RunFlags()
            taken += [
                _flag(field.name, shared[field.name], getattr(usual, field.name))
                for field in fields(RunFlags)
            ]
        else:
            taken.append(_flag(parameter.name, hints[parameter.name], parameter.default))

    @functools.wraps(command)
    def told(**values: Any) -> None:
        given = {field.name: values.pop(field.name) for field in fields(RunFlags)}
        command(**values, **{place: RunFlags(**given)})

    told.__signature__ = inspect.Signature(taken)  # type: ignore[attr-defined]
    told.__annotations__ = {parameter.name: parameter.annotation for parameter in taken}
    del told.__wrapped__  # its hints would hide these
    return told


def _flag(name: str, annotation: object, default: object) -> inspect.Parameter:
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=annotation)
