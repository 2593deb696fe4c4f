"""The grain of a surface, from the frames of one stroke.

From every frame its own plane is taken, and from every taxel its mean over the stroke: what is left, the
high-passed signal, is the surface's grain as the rubber passes it on, and the noise.  Noise is white in time, and
the grain moves past the taxels, so their autocovariances part them: at a travel of x > 0 that of the grain alone,

    c(x) = v h_w(x),    h_w(x) = tr((I - P) C_w(x)) / n - its mean over the stroke,

is left, with C_w,ij(x) = exp(-|r_ij + x|^2 / (2 w^2)) between the n taxels, P the projection on planes, v the felt
variance and w its size: no noise level needs to be known.  Rubber and taxels blur with a Gaussian of variance s^2
along each axis, hence for grains of size l

    w^2 = l^2 + 2 s^2,     roughness^2 = v (l^2 + 2 s^2) / l^2     (our derivation).

Grains finer than the blur all feel alike, and count as `expected`; coarser ones tell their size.
A swept area B holds about B / (2 pi w^2) independent patches, whose scatter is most of the sigma.
"""

from dataclasses import dataclass

import numpy as np

from primitives.arrays import Floats, frozen


@dataclass(frozen=True)
class GrainConfig:
    """What is looked for in a stroke."""

    taxels: int = 70  # whose places stand for all where the grain is modeled
    lags: int = 16  # that are compared, of
    lag: float = 3.0  # [mm] of travel up to which autocovariances are compared
    grains: tuple[float, float] = (0.4, 5.0)  # [mm] sizes that are told apart
    expected: float = 1.0  # [mm] size where the signal is too weak to tell
    sure: float = 8.0  # standard deviations by which a size must differ from the expected one to be told
    weak: float = 10.0  # times the noise's share that a signal must have for its size to be told
    bands: tuple[float, ...] = (16.0, 8.0, 4.0, 2.0)  # [mm] wavelengths, octave by octave


@dataclass(frozen=True)
class Texture:
    """The grain of a surface."""

    roughness: float  # [mm] root mean square height
    sigma: float  # [mm]
    mean: float  # [mm] of the taxels' indentation
    deviation: float  # [mm] of the high-passed signal, its noise taken off
    noise: float  # [mm] of one taxel in one frame
    grain: float  # [mm] over which heights are alike
    wavelengths: Floats  # (b,) [mm] middles of the octaves
    spectrum: Floats  # (b,) [mm^2] felt variance in each
    travel: float  # [mm] stroked

    @property
    def felt(self) -> bool:
        """Whether the surface is surely not smooth."""
        return self.roughness > 3.0 * self.sigma


@dataclass(frozen=True)
class Sweep:
    """Frames of one straight stroke."""

    frames: Floats  # (t, n) [mm] depth of the taxels that stayed in contact
    travel: Floats  # (t,) [mm]
    taxels: Floats  # (n, 2) [mm] where they are
    heading: Floats  # (2,)
    blur: float  # [mm] s, of rubber and taxel
    cell: float  # [mm^2] of a taxel

    @property
    def area(self) -> float:
        """[mm^2] that the taxels have felt."""
        across = self.taxels @ np.array([-self.heading[1], self.heading[0]])
        return self.cell * len(self.taxels) + float(np.ptp(self.travel)) * float(np.ptp(across))


def texture_of(sweep: Sweep, share: float, travel: float, config: GrainConfig = GrainConfig()) -> Texture:
    """What one sweep says of an object that takes its `share` of a press, of `travel` [mm] stroked in all."""
    planes = np.column_stack([np.ones(len(sweep.taxels)), sweep.taxels])
    basis = np.linalg.qr(planes)[0]
    signal = sweep.frames - (sweep.frames @ basis) @ basis.T
    signal = signal - signal.mean(axis=0)
    step = float(np.ptp(sweep.travel)) / (len(signal) - 1)
    farthest = max(3, min(int(config.lag / step), len(signal) // 2))
    lags = np.unique(np.linspace(1, farthest, config.lags).astype(int))
    covariance: Floats = np.array([np.mean(signal[:-j] * signal[j:]) for j in lags])
    white = float(np.mean(signal**2) - covariance[0])
    covariance = covariance + white / len(signal)  # what taking the mean took from the noise
    of_noise = abs(white) / float(np.sqrt(signal.size * min(farthest, sweep.blur / step)))
    travels: Floats = lags * step
    grain, v, expected = _fitted(travels, covariance, of_noise, sweep, config)
    free = 1.0 - basis.shape[1] / len(sweep.taxels)
    noise = float(np.sqrt(max(np.mean(signal**2) - v * expected, 0.0) / free))
    w2 = grain**2 + 2.0 * sweep.blur**2
    lift = np.sqrt(w2) / grain / share
    doubt = float(np.hypot(v * np.sqrt(2.0 * np.pi * w2 / sweep.area), of_noise))
    felt = float(np.sqrt(max(v, 0.0)))
    sigma = 0.5 * doubt / max(felt, float(np.sqrt(doubt)))
    wavelengths, spectrum = _spectrum(signal, step, config)
    return Texture(
        felt * lift,
        sigma * lift,
        float(sweep.frames.mean()),
        felt,
        noise,
        grain,
        frozen(wavelengths),
        frozen(spectrum),
        travel,
    )


def _fitted(
    x: Floats, covariance: Floats, doubt: float, sweep: Sweep, config: GrainConfig
) -> tuple[float, float, float]:
    """Grain size [mm], felt variance [mm^2], and h_w(0), by least squares over a grid of sizes.

    `doubt` [mm^2] is the noise's share in a covariance.
    """
    sizes = np.append(np.geomspace(*config.grains, 12), config.expected)
    some = sweep.taxels[:: max(1, len(sweep.taxels) // config.taxels)]
    apart = some[:, None] - some[None]
    basis = np.linalg.qr(np.column_stack([np.ones(len(some)), some]))[0]
    within = float(np.ptp(sweep.travel))
    wide = np.concatenate([np.arange(0.0, 12.0, 1.0), [within]])
    wide = np.minimum(wide, within)
    tried = []
    for size in sizes:
        w2 = size**2 + 2.0 * sweep.blur**2
        shape = _shape(np.concatenate([[0.0], x, wide]), apart, sweep.heading, w2, basis)
        tail = shape[len(x) + 1 :] * (within - wide)
        shape = shape - 2.0 * float(np.sum((tail[1:] + tail[:-1]) * np.diff(wide))) / 2.0 / within**2
        model = shape[1 : len(x) + 1]
        v = float(model @ covariance / (model @ model))
        tried.append((float(np.sum((covariance - v * model) ** 2)), float(size), v, float(shape[0])))
    best, usual = min(tried[:-1]), tried[-1]
    usual_w2, best_w2 = (size**2 + 2.0 * sweep.blur**2 for size in (config.expected, best[1]))
    unsure = config.weak * doubt / max(usual[2], 1e-12)
    scatter = np.sqrt(2.0 * np.pi * usual_w2 / sweep.area + unsure**2)
    told = usual[2] > 0.0 and best_w2 > usual_w2 * (1.0 + config.sure * scatter)
    _, size, v, start = best if told else usual
    return size, v, start


def _shape(x: Floats, apart: Floats, heading: Floats, w2: float, basis: Floats) -> Floats:
    """tr((I - P) C_w(x)) / n for each travel."""
    n = len(apart)
    out = np.empty(len(x))
    for i, shift in enumerate(x):
        moved = apart + shift * heading
        alike = np.exp(-0.5 * np.sum(moved**2, axis=-1) / w2)
        out[i] = (np.trace(alike) - np.sum((basis.T @ alike) * basis.T)) / n
    return out


def _spectrum(signal: Floats, step: float, config: GrainConfig) -> tuple[Floats, Floats]:
    """Felt variance in octaves of wavelength, noise taken off by crossing even frames with odd ones."""
    even, odd = signal[0 : len(signal) // 2 * 2 : 2], signal[1 : len(signal) // 2 * 2 : 2]
    window = np.hanning(len(even))[:, None]
    a, b = (np.fft.rfft(part * window, axis=0) for part in (even, odd))
    power = np.mean((a * b.conj()).real, axis=1) / float(np.sum(window**2)) / len(even) * 2.0
    frequency = np.fft.rfftfreq(len(even), 2.0 * step)
    middles = np.array(config.bands)
    inside = [(frequency > 1 / (m * np.sqrt(2))) & (frequency <= np.sqrt(2) / m) for m in middles]
    return middles, np.array([float(power[band].sum()) for band in inside])
