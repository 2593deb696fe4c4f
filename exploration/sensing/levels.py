"""Noise floor, background and plateau of one frame, each with its sigma.

Noise: the differences between taxels and their predictions from their neighbors (`neighbors`) hold nothing of a
smooth press and all of the noise; their median over `gain` is the noise, whatever is pressed on the rest of the
pad.  Background: the zeros may all have shifted since they were taken.  Taxels farther than `CLEAR` response
widths from all contact feel nothing, and their median is the shift.  Where contact leaves fewer than `LEAST` of
them, one frame cannot tell a shift from a deeper press: the background is then 0 with infinite sigma, and zeros
are renewed in free air.  Plateau: the highest 3 x 3 mean above the background.
"""

from dataclasses import dataclass, replace
from math import inf, sqrt

import numpy as np
from scipy.ndimage import distance_transform_edt
from scipy.special import ndtri

from exploration.sensing.contact_mask import contact_mask, local_plateau, repaired
from exploration.sensing.frame import TactileImage
from exploration.sensing.neighbors import Neighbors, neighbors
from exploration.sensing.response import response_of
from exploration.sensing.suspects import unsuspected
from primitives.arrays import Floats, frozen

CLEAR = 2.6  # [response widths] from contact
LEAST = 6  # taxels
LOW = 0.05  # of the taxels: so many at least are free where the background is seen
SHIFTED = 3.0  # [sigma] of a background that is taken away
_MEDIAN = 1.2533141373155  # sigma of a median over that of a mean
_MAD = 0.6744897501960817  # median of |normal deviate|


@dataclass(frozen=True)
class Levels:
    """What one frame tells of its own levels."""

    noise: float  # [mm] 1 sigma of a taxel
    background: float  # [mm]
    background_sigma: float  # [mm]; inf where contact hides it
    plateau: float  # [mm] above the background


def levels(image: TactileImage) -> Levels:
    """Of a usable frame (`contact_mask.usable`)."""
    image = unsuspected(image)
    depth, alive = repaired(image.depth, image.sigma)
    noise = _noise(image, depth)
    width = response_of(image).mean_width
    low = float(np.quantile(depth[alive], LOW)) - float(ndtri(LOW)) * noise
    shifted = replace(image, depth=frozen(image.depth - low))
    touched = contact_mask(shifted)
    far = alive & ~touched
    if touched.any():
        py, px = image.array.pitch[1], image.array.pitch[0]
        far &= np.asarray(distance_transform_edt(~touched, sampling=(py, px))) > CLEAR * width
    background, sigma = 0.0, inf
    if far.sum() >= max(LEAST, LOW * far.size) and not (touched.sum() == 0 and _flat(depth, noise)):
        background = float(np.median(depth[far]))
        sigma = _MEDIAN * noise / sqrt(float(far.sum()))
    plateau = float(local_plateau(depth, 0, 0).max()) - background
    return Levels(noise, background, sigma, plateau)


def leveled(image: TactileImage) -> TactileImage:
    """The image less its background, where one is seen; itself where none is."""
    told = levels(image)
    if abs(told.background) <= SHIFTED * told.background_sigma:
        return image
    return replace(image, depth=frozen(image.depth - told.background))


def _flat(depth: Floats, noise: float) -> bool:
    """Whether the whole frame is one level above the noise: contact all over, or a shift all over."""
    return abs(float(np.median(depth))) > SHIFTED * noise


def _noise(image: TactileImage, depth: Floats) -> float:
    rows, columns = image.array.shape
    known = neighbors(response_of(image).mean_width, image.array.pitch)
    r, c = Neighbors.classes(rows), Neighbors.classes(columns)
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(depth, 2), (5, 5)).reshape(rows, columns, 25)
    predicted = np.einsum("rck,rck->rc", known.weights[r[:, None], c], windows)
    live = np.isfinite(image.sigma) & (known.gain[r[:, None], c] > 1.0)
    if live.sum() < LEAST:
        return float(np.median(image.sigma[np.isfinite(image.sigma)]))
    difference = np.abs(depth - predicted) / known.gain[r[:, None], c]
    return float(np.median(difference[live])) / _MAD
