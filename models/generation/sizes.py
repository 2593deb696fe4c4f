"""Sizes as a designer would write them: stock lengths, drill radii, whole millimeters."""

import numpy as np

_RADII = (1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.5, 9.0, 10.0, 12.0, 15.0, 18.0, 20.0, 25.0, 30.0, 40.0, 50.0)


def stock(rng: np.random.Generator, least: float, most: float) -> float:
    """A length between two [mm], small ones likelier: whole mm below 20, fives to 100, tens above."""
    length = float(np.exp(rng.uniform(np.log(least), np.log(most))))
    step = 1.0 if length < 20 else 5.0 if length < 100 else 10.0
    return float(np.clip(round(length / step) * step, least, most))


def drill(rng: np.random.Generator, most: float) -> float | None:
    """A radius up to `most` [mm], one of the four largest that fit; none where the smallest does not."""
    fitting = [radius for radius in _RADII if radius <= most]
    return float(rng.choice(fitting[-4:])) if fitting else None


def whole(rng: np.random.Generator, least: float, most: float) -> float | None:
    """A length in whole mm; none where there is none between the two."""
    low, high = int(np.ceil(least)), int(np.floor(most))
    return float(rng.integers(low, high + 1)) if low <= high else None
