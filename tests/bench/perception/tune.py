"""The search behind the settings of every baseline: `python -m perception.tune [NAME ...]` in tests/bench.

Each setting of a grid is scored on edges of 5 and 10 % noise and on a 60-count plateau, drawn apart from those of
the table: the mean over kinds of (angle RMS + offset RMS over the bound)/2 with every error capped at a failure's
(15 degrees, 1.5 taxels), a miss counting as one.  The best is what the baseline's config holds.
"""

import sys
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import product

import numpy as np
from perception.bound import bound
from perception.edges import drawn
from perception.noise import Noise
from perception.presses import edge
from perception.scene import Scene
from perception.score import FAR_ANGLE, FAR_OFFSET, line_error

from exploration.sensing.baselines import (
    adaptive_hough,
    burns,
    muthukrishnan,
    opencv_lines,
    plain_hough,
    skimage_lines,
)
from exploration.sensing.frame import TactileImage
from primitives.arrays import Floats

KINDS = (Noise(0.05), Noise(0.10), Noise(counts=60))
FRAMES, SEED = 120, 777
CANNY = opencv_lines.CannyConfig()
STRONG = {"low": (20.0, 40.0, 70.0, 100.0, 150.0), "high": (60.0, 100.0, 150.0, 200.0, 300.0)}
GRIDS = {
    "contour": (
        muthukrishnan.contour_lines,
        muthukrishnan.ContourConfig(),
        {"tolerance": (0.5, 0.8, 1.0, 1.3, 1.8, 2.5, 3.5)},
    ),
    "burns": (
        burns.burns_lines,
        burns.BurnsConfig(),
        {"least": (0.03, 0.05, 0.08, 0.1, 0.12, 0.15), "support": (0.3, 0.5, 0.7), "binary": (False, True)},
    ),
    "plain": (
        plain_hough.plain_hough,
        plain_hough.PlainHoughConfig(),
        {
            "theta": (1.0, 2.0),
            "rho": (0.5, 1.0, 1.5, 2.0),
            "window": (7.0, 10.0, 20.0),
            "least": (0.3, 0.5, 0.6),
        },
    ),
    "adaptive": (
        adaptive_hough.adaptive_hough,
        adaptive_hough.AdaptiveHoughConfig(),
        {"level": (0.7, 0.8, 0.9, 0.95), "least": (0.5, 0.65, 0.75, 0.85)}
        | {"finest": ((2.0, 0.25), (4.0, 0.5), (6.0, 0.75), (8.0, 1.0)), "cells": (9, 13, 17)},
    ),
    "canny": (
        opencv_lines.hough_lines,
        CANNY,
        {"low": (20.0, 70.0, 150.0), "high": (100.0, 200.0, 300.0, 400.0)}
        | {"rho": (0.25, 0.5, 1.0, 1.5), "theta": (0.5, 1.0, 2.0, 4.0), "smooth": (0.0, 0.7)},
    ),
    "enlarged": (
        opencv_lines.hough_lines,
        CANNY,
        {"enlarge": (4, 6, 8), "low": (20.0, 40.0), "high": (60.0, 80.0, 120.0)}
        | {"rho": (1.0, 2.0, 3.0), "theta": (0.25, 0.5), "smooth": (0.7, 1.0, 1.5, 2.0)},
    ),
    "segments": (
        opencv_lines.hough_segments,
        CANNY,
        {
            "low": (70.0, 100.0),
            "high": (150.0, 200.0, 300.0),
            "rho": (0.25, 0.5, 1.0),
            "theta": (0.5, 1.0, 2.0),
        }
        | {"length": (3.0, 5.0), "gap": (3.0, 5.0), "smooth": (0.5, 0.7, 1.0)},
    ),
    "points": (
        opencv_lines.hough_points,
        opencv_lines.PointsConfig(),
        {"rho": (0.25, 0.4, 0.5, 0.7, 1.0), "theta": (0.25, 0.5, 1.0, 2.0)},
    ),
    "skimage": (
        skimage_lines.hough_lines,
        skimage_lines.SkimageConfig(),
        {
            "smooth": (0.7, 1.0, 1.4, 1.8, 2.2),
            "low": (0.05, 0.1),
            "high": (0.1, 0.2),
            "theta": (0.5, 1.0, 2.0),
        },
    ),
    "probabilistic": (
        skimage_lines.hough_segments,
        skimage_lines.SkimageConfig(),
        {"smooth": (1.0, 1.4, 1.8), "low": (0.05,), "high": (0.1, 0.2), "theta": (1.0, 2.0)}
        | {"votes": (3, 5, 8), "length": (4, 6), "gap": (1, 3, 5)},
    ),
}
Pressed = list[tuple[Scene, TactileImage]]


def score(find: Callable[[TactileImage], tuple], pressed: list[tuple[Pressed, Floats]]) -> float:
    """See the module."""
    total = 0.0
    for frames, least in pressed:
        worst = np.array([FAR_ANGLE, FAR_OFFSET * frames[0][0].spec.array.pitch[0]])
        errors = []
        for scene, image in frames:
            lines = find(image)
            error = worst if not lines else line_error((lines[0].angle, lines[0].offset), scene.found[0])
            errors.append(np.minimum(np.abs(error), worst))
        total += float(np.mean(np.sqrt(np.mean(np.square(errors), axis=0) / least)))
    return total / len(pressed)


def main(names: list[str]) -> None:
    pressed = []
    for noise in KINDS:
        frames = drawn(edge, noise, FRAMES, SEED)
        pressed.append((frames, np.mean([np.diag(bound(s, noise)[0]) for s, _ in frames], axis=0)))
    for name in names or GRIDS:
        find, config, grid = GRIDS[name]
        settings = [dict(zip(grid, values, strict=True)) for values in product(*grid.values())]
        settings = [s for s in settings if s.get("low", 0.0) < s.get("high", 1.0)]
        if len(settings) > 60:  # a coarse pass on few frames first
            few = [(frames[:25], least) for frames, least in pressed]
            scored = [
                (score(partial(find, config=replace(config, **s)), few), i) for i, s in enumerate(settings)
            ]
            settings = [settings[i] for _, i in sorted(scored)[:12]]
        ranked = [
            (score(partial(find, config=replace(config, **s)), pressed), i) for i, s in enumerate(settings)
        ]
        now = score(partial(find, config=config), pressed)
        for value, i in sorted(ranked)[:3]:
            print(f"{name:14} {value:7.3f}  {settings[i]}", flush=True)
        print(f"{name:14} {now:7.3f}  as it stands", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
