"""What untouched taxels of a recording read, and how noisily, from the recording itself (our derivation).

Zero.  A recording mostly begins before anything is touched: the frames from the first one on in which no taxel
has left the first frame's value by more than `STILL` noise are still, and their median is the zero of each taxel.
Of an array with a data sheet they count only near its offset; without enough of them the offset itself is taken.
Of any other, what falls clearly below them shows that the recording began in contact, and the lowest that each
taxel settles at is the zero.  One or two frames have no before: the median of the lowest quarter of the taxels is
then the zero of all.

Noise.  The second difference of three neighbors, x0 - 2 x1 + x2, is blind to steady change and has variance
6 sigma^2.  Its size is taken in time and along the rows, without what is far out; the less holds, because touches
add to the one and unequal taxels to the other.  Taxels that a controller holds at zero until they
pass its threshold show no noise, so where half of all differences are zero the others alone are taken.  It is
at least that of rounding to whole counts.

Ends.  Such a controller's threshold lies above all noise, so at least `STILL` noise above zero (our choice; the
recording shows no less).  Two taxels or more whose highest readings are the same to `LEVELED` share a ceiling,
which may lie below the converter's full scale.

Gain.  Without a calibration gains are a data sheet's, or, of an array of which only the shape is known, such that
the recording's own plateau is a nominal press: enough for lines and kinds, whose sigma carries `UNKNOWN_GAIN`.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from math import inf, sqrt

import numpy as np

from exploration.recordings.recording import Pad, PadFrame, Recording
from exploration.sensing.calibration import Calibration
from primitives.arrays import Floats, frozen

STILL = 6.0  # [sigma]
LEVELED = 0.005  # of a ceiling, within which readings at it lie
NOISY = 2.0  # [counts] noise from which a taxel that repeats one reading is held there
ABSURD = 1e12  # [counts] no converter reads so much
WANDER = 0.15  # [plateau] that a zero may be from the data sheet's
UNKNOWN_GAIN = 0.15  # relative 1 sigma over the taxels of an array that nobody calibrated
NOMINAL_SPREAD = 0.6  # [pitch] of rubber that nobody described
NOMINAL_DEPTH = 0.5  # [mm] of a press that nobody measured
_ENOUGH_STILL = 5  # frames
_START = 50  # frames at the start among which the still ones are sought
_KEPT = 300  # triples of successive frames kept for the noise
_GAUSS = 0.6745  # median of |x| over sigma
_OUT, _MEAN = 3.0, 0.791  # sigma from which |x| is left out, and the mean of what is left over sigma
_ROUNDING = 1.0 / 12.0  # [counts^2]


@dataclass(frozen=True)
class Untouched:
    """A pad at rest."""

    zero: Floats  # (rows, columns) [counts]
    noise: float  # [counts] 1 sigma of a reading
    plateau: float  # [counts] above zero that the firmest contacts reach; 0 where none is
    frames: int
    ceiling: float = inf  # [counts] that no reading of this recording exceeds
    threshold: float = 0.0  # [counts] above zero, below which readings arrive as the zero


@dataclass
class _Sample:
    """A bounded choice of a pad's frames."""

    start: list[Floats] = field(default_factory=list)
    triples: list[Floats] = field(default_factory=list)
    last: list[Floats] = field(default_factory=list)
    count: int = 0
    stride: int = 1
    highest: Floats | None = None  # (rows, columns) [counts]

    def offer(self, counts: Floats) -> None:
        self.last = [*self.last[-2:], counts]
        seen = np.where(np.abs(counts) < ABSURD, counts, -np.inf)
        self.highest = seen if self.highest is None else np.maximum(self.highest, seen)
        if self.count < _START:
            self.start.append(counts)
        if len(self.last) == 3 and self.count % self.stride == 0:
            self.triples.append(np.stack(self.last))
            if len(self.triples) == _KEPT:
                self.triples = self.triples[::2]
                self.stride *= 2
        self.count += 1


def at_rest(recording: Recording, frames: Iterable[PadFrame] | None = None) -> tuple[Untouched, ...]:
    """Zero and noise of every pad, from one pass over the recording."""
    samples = [_Sample() for _ in recording.pads]
    for item in recording.frames() if frames is None else frames:
        samples[item.pad].offer(item.frame.counts)
    return tuple(_rest(pad, sample) for pad, sample in zip(recording.pads, samples, strict=True))


def calibration_at_rest(pad: Pad, rest: Untouched) -> Calibration:
    """The calibration that a recording allows: its own zero and noise, gains as far as anybody knows them."""
    shape = pad.array.shape
    if pad.spec is None:
        gain = frozen(np.full(shape, max(rest.plateau, 1.0) / NOMINAL_DEPTH))
        spread = NOMINAL_SPREAD * float(np.mean(pad.array.pitch))
        return Calibration(
            rest.zero,
            gain,
            pad.absent,
            spread,
            1.0,
            rest.noise,
            gain_sigma=UNKNOWN_GAIN,
            full_scale=min(pad.full_scale, rest.ceiling),
            threshold=rest.threshold,
        )
    sheet = Calibration.nominal(pad.spec)
    return replace(
        sheet,
        zero=rest.zero,
        gain=frozen(np.full(shape, pad.spec.counts_per_pressure)),
        dead=pad.absent,
        noise=rest.noise,
        gain_sigma=UNKNOWN_GAIN if pad.foreign else sheet.gain_sigma,
        full_scale=min(pad.full_scale, rest.ceiling),
        threshold=rest.threshold,
    )


def _rest(pad: Pad, sample: _Sample) -> Untouched:
    triples = np.array(sample.triples).reshape(-1, 3, *pad.array.shape)
    triples = triples[(np.abs(triples) < ABSURD).all(axis=(1, 2, 3))]
    frames = np.array([*sample.start, *triples[:, 2]]).reshape(-1, *pad.array.shape)
    frames = frames[(np.abs(frames) < ABSURD).all(axis=(1, 2))]
    if not len(frames):
        return Untouched(frozen(np.zeros(pad.array.shape)), 1.0, 0.0, sample.count)
    zero, noise = _zero_and_noise(pad, frames, min(_in_time(triples), _in_space(frames)))
    risen = (frames - zero)[:, ~pad.absent]
    high = np.sort(risen[risen > STILL * noise])
    plateau = float(np.quantile(high, 0.9)) if len(high) else 0.0
    threshold = STILL * noise if noise > NOISY and _held(triples) else 0.0
    return Untouched(frozen(zero), noise, plateau, sample.count, _ceiling(sample, zero + noise), threshold)


def _ceiling(sample: _Sample, untouched: Floats) -> float:
    """[counts] where the readings of a ceiling that taxels share begin; infinite where none is."""
    if sample.highest is None:
        return inf
    top = sample.highest - untouched
    level = np.sort(np.where(np.isfinite(top), top, 0.0).ravel())[-2:]
    shared = len(level) == 2 and level[0] > 0.0 and level[1] - level[0] < LEVELED * level[1]
    if not shared:
        return inf
    return float(sample.highest.max() - LEVELED * level[1])


def _held(triples: Floats) -> bool:
    """Whether most taxels repeat their readings to the count."""
    if not len(triples):
        return False
    return bool(np.count_nonzero(np.diff(triples, axis=1)) * 2 < triples[:, 1:].size)


def _zero_and_noise(pad: Pad, frames: Floats, noise: float) -> tuple[Floats, float]:
    if pad.zero is not None:
        return np.full(pad.array.shape, pad.zero), noise
    moved = np.abs(frames - frames[0]).max(axis=(1, 2)) > STILL * sqrt(2.0) * noise
    still = frames[: int(np.argmax(moved)) if moved.any() else len(frames)]
    zero: Floats = np.median(still, axis=0)
    if pad.spec is not None:
        sheet = pad.spec.electronics
        far = np.abs(zero - sheet.offset).max() > WANDER * sheet.plateau
        if len(still) < _ENOUGH_STILL or far:
            nominal = float(np.hypot(sheet.noise * sheet.plateau, np.sqrt(_ROUNDING)))
            return np.full(pad.array.shape, sheet.offset), nominal
        return zero, noise
    if len(frames) < 3:
        return np.full(pad.array.shape, np.quantile(frames[0][~pad.absent], 0.125) + 0.9 * noise), noise
    lowest = np.quantile(frames, 0.05, axis=0) + 1.64 * noise
    began_in_contact = bool((zero - lowest > STILL * noise).any())
    return (lowest if began_in_contact or len(still) < 3 else zero), noise


def _in_time(triples: Floats) -> float:
    """[counts] noise from second differences in time."""
    if not len(triples):
        return np.inf
    jump = np.abs(triples[:, 0] - 2 * triples[:, 1] + triples[:, 2])
    if np.count_nonzero(jump) * 2 < jump.size:
        jump = jump[(triples > triples.min(axis=(0, 1))).all(axis=1)]
    return _sigma(jump)


def _in_space(frames: Floats) -> float:
    """[counts] noise from second differences along the rows, the median over frames."""
    if frames.shape[2] < 3:
        return np.inf if len(frames) > 2 else float(np.sqrt(_ROUNDING))
    jump = np.abs(frames[:, :, :-2] - 2 * frames[:, :, 1:-1] + frames[:, :, 2:])
    return float(np.median([_sigma(one[one > 0.0]) for one in jump]))


def _sigma(jumps: Floats) -> float:
    """[counts] behind second differences; the median starts, the mean of what is not far out is finer."""
    if not jumps.size:
        return sqrt(_ROUNDING)
    start = max(float(np.median(jumps)) / _GAUSS, 1.0)
    size = float(np.mean(jumps[jumps <= _OUT * start]))
    return max(size / (_MEAN * sqrt(6.0)), sqrt(_ROUNDING))
