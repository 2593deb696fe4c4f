"""Parts of what a pad sees, each as an observation of its own.

Where several edges meet under the pad, as at the mouth of a groove, no model of the whole frame tells them apart;
in a part that only one of them crosses, that one is as plain as ever (our derivation).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from exploration.control.sighting import Sighting
from exploration.devices.guard import Observation
from primitives import pose as se3
from primitives.arrays import Floats

LEAST = 4  # taxels either way, that a part is worth looking at from
ALIKE = 0.998  # least cosine between the directions of an edge in two parts
ASIDE = 0.4  # [mm] of it in one part from its line in another
APART = 3.0  # [mm] along it, between the two


def windows(seen: Observation, length: float) -> Iterator[Observation]:
    """Rectangles of at most `length` mm either way, two thirds overlapping; none but parts of the pad."""
    image = seen.image
    rows, columns = (
        _spans(count, length / pitch)
        for count, pitch in zip(image.array.shape, image.array.pitch[::-1], strict=True)
    )
    for top, bottom in rows:
        for left, right in columns:
            if (bottom - top, right - left) == image.array.shape:
                continue
            yield _part(seen, slice(top, bottom), slice(left, right))


def window_about(seen: Observation, place: Floats, half: float) -> Observation | None:
    """The part within `half` mm, either way, of a (2,) place on the pad; None where that is hardly a part."""
    array = seen.image.array
    spans = []
    for axis, at in ((array.y, place[1]), (array.x, place[0])):
        (near,) = np.nonzero(np.abs(axis - at) < half)
        if len(near) < LEAST:
            return None
        spans.append(slice(int(near[0]), int(near[-1]) + 1))
    return _part(seen, *spans)


def going_on(edges: Sequence[Sighting]) -> list[Sighting]:
    """Those of the edges seen in parts that go on in another: a round rim looks straight in each, and turns."""
    return [
        seen
        for seen in edges
        if any(
            other.tangent @ seen.tangent > ALIKE
            and abs(float((other.point - seen.point) @ seen.outward)) < ASIDE
            and abs(float((other.point - seen.point) @ seen.tangent)) > APART
            for other in edges
        )
    ]


def _part(seen: Observation, rows: slice, columns: slice) -> Observation:
    """Some taxels, about whose middle the part has its own frame."""
    image = seen.image
    part = replace(
        image,
        array=replace(image.array, rows=rows.stop - rows.start, columns=columns.stop - columns.start),
        depth=image.depth[rows, columns],
        sigma=image.sigma[rows, columns],
        saturated=None if image.saturated is None else image.saturated[rows, columns],
    )
    x, y = image.array.x[columns].mean(), image.array.y[rows].mean()
    return replace(
        seen, image=part, world_from_sensor=seen.world_from_sensor @ se3.pose(np.eye(3), [x, y, 0.0])
    )


def _spans(count: int, most: float) -> list[tuple[int, int]]:
    """Begin and end of overlapping runs of taxels that cover `count` of them."""
    size = min(count, max(LEAST, int(most)))
    starts = {*range(0, count - size, max(1, size // 3)), count - size}
    return [(start, start + size) for start in sorted(starts)]
