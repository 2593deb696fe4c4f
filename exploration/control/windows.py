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
            x, y = image.array.x[left:right].mean(), image.array.y[top:bottom].mean()
            part = replace(
                image,
                array=replace(image.array, rows=bottom - top, columns=right - left),
                depth=image.depth[top:bottom, left:right],
                sigma=image.sigma[top:bottom, left:right],
            )
            shifted = seen.world_from_sensor @ se3.pose(np.eye(3), [x, y, 0.0])
            yield replace(seen, image=part, world_from_sensor=shifted)


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


def _spans(count: int, most: float) -> list[tuple[int, int]]:
    """Begin and end of overlapping runs of taxels that cover `count` of them."""
    size = min(count, max(LEAST, int(most)))
    starts = {*range(0, count - size, max(1, size // 3)), count - size}
    return [(start, start + size) for start in sorted(starts)]
