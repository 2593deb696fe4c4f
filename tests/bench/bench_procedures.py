"""Exploratory procedures on 100 seeds: stiffness and roughness, ranked and measured.

Each seed draws plates of one material each, half of them felt by pressing and half by stroking; their order is
asked for, and every stiffness by itself.  The plant: 5 % noise, 200 Hz, a stage that obeys 20 ms late by a latency
that is measured and not given, 0.05 mm of white error on every reading of its encoders, 0.02 mm and 0.02 degrees
that stay the same over a contact.

The competitor for roughness is what the literature's systems take, the deviation of the taxels over the stroke;
for stiffness it is the slope of force against travel over the area, the skin's own stiffness not taken off.
"""

from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from exploration.control.latency import measure_latency
from exploration.control.procedures.hardness import HardnessConfig, stiffness_of
from exploration.control.procedures.land import land
from exploration.control.procedures.press import Pressed, press
from exploration.control.procedures.texture import TextureConfig, texture
from exploration.devices.guard import Guard
from exploration.devices.simulated import PoseNoise, simulate
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import load_sensor
from models.csg import Cube
from models.material import MadeOf, Material, Materials
from models.solid import Solid
from primitives import pose as se3

BENCH = "procedures"
SEEDS = 100
PLATE = Solid.from_csg(Cube((100.0, 60.0, 40.0)))
LATE = 0.02  # [s]
STIFFNESSES = (0.05, 0.4)  # [N/mm^3] least and greatest: half and four times the skin's own
APART = 1.3  # least factor between two that are ranked
ROUGHNESSES = (0.008, 0.016, 0.032)  # [mm] grades a factor of two apart, as in ISO 1302, times up to 1.25
PRESSED = 3  # plates of a seed that are pressed
SURE = HardnessConfig(relative=0.03)
STROKE = TextureConfig(length=13.0)


@dataclass(frozen=True)
class _Found:
    true: float
    felt: float
    sigma: float
    crude: float


def run() -> list[dict[str, object]]:
    """All rows."""
    with ProcessPoolExecutor() as pool:
        pressed = list(pool.map(_pressed, range(SEEDS), chunksize=5))
        stroked = list(pool.map(_stroked, range(SEEDS), chunksize=5))
    every = [plate for seed in pressed for plate in seed]
    off = np.array([abs(p.felt / p.true - 1.0) for p in every])
    z = np.array([(p.felt - p.true) / p.sigma for p in every])
    crude = np.array([abs(p.crude / p.true - 1.0) for p in every])
    rough = [plate for seed in stroked for plate in seed]
    rough_off = np.array([p.felt / p.true - 1.0 for p in rough])
    ours, plain, taxels = "series springs", "force over travel", "deviation of the taxels"
    return [
        _row(ours, f"stiffness ranked right, of {SEEDS}", _ranked(pressed), "seeds", SEEDS),
        _row(plain, f"stiffness ranked right, of {SEEDS}", _ranked(pressed, crude=True), "seeds"),
        _row(ours, "stiffness within 10 %", 100.0 * np.mean(off < 0.1), "%", 100),
        _row(plain, "stiffness within 10 %", 100.0 * np.mean(crude < 0.1), "%"),
        _row(ours, "stiffness error, median", 100.0 * np.median(off), "%"),
        _row(ours, "stiffness error, greatest", 100.0 * off.max(), "%", 10),
        _row(plain, "stiffness error, median", 100.0 * np.median(crude), "%"),
        _row(ours, "stiffness error over stated sigma, rms", np.sqrt(np.mean(z**2)), ""),
        _row("autocovariance", f"roughness ranked right, of {SEEDS}", _ranked(stroked), "seeds", SEEDS),
        _row(taxels, f"roughness ranked right, of {SEEDS}", _ranked(stroked, crude=True), "seeds"),
        _row("autocovariance", "roughness error, rms", 100.0 * np.sqrt(np.mean(rough_off**2)), "%"),
        _row("autocovariance", "roughness error, mean", 100.0 * np.mean(rough_off), "%"),
    ]


def _row(method: str, metric: str, value: float, unit: str, asked: float | None = None) -> dict[str, object]:
    told = {"bench": BENCH, "method": method, "metric": metric, "value": float(value), "unit": unit}
    return told if asked is None else {**told, "asked": asked}


def _ranked(seeds: list[list[_Found]], crude: bool = False) -> int:
    """Seeds whose plates come out in their true order."""
    right = 0
    for plates in seeds:
        true = [p.true for p in plates]
        felt = [p.crude if crude else p.felt for p in plates]
        right += bool((np.argsort(true) == np.argsort(felt)).all())
    return right


def _pressed(seed: int) -> list[_Found]:
    rng = np.random.default_rng([seed, 1])
    while True:
        chosen = np.exp(rng.uniform(*np.log(STIFFNESSES), PRESSED))
        if np.diff(np.sort(np.log(chosen))).min() > np.log(APART):
            break
    out = []
    for number, stiffness in enumerate(chosen.tolist()):
        guard = _landed(Material(stiffness), [seed, 2, number])
        taken: list[Pressed] = []
        while True:
            taken.append(press(guard, SURE.cycles))
            felt = stiffness_of(taken, SURE)
            known = felt.stiffness is not None and felt.sigma < SURE.relative * felt.stiffness
            if known or len(taken) * SURE.cycles >= SURE.most:
                break
        slope = np.polyfit(taken[0].travel, taken[0].force, 1)[0] / felt.area
        out.append(_Found(stiffness, felt.stiffness or felt.bound, felt.sigma, float(slope)))
    return out


def _stroked(seed: int) -> list[_Found]:
    rng = np.random.default_rng([seed, 3])
    out = []
    for number, grade in enumerate(rng.permutation(ROUGHNESSES).tolist()):
        roughness = grade * rng.uniform(1.0, 1.25)
        guard = _landed(Material(roughness=roughness), [seed, 4, number], seed % 8)
        felt = texture(guard, np.array([1.0, 0.0]), config=STROKE)
        crude = float(np.hypot(felt.deviation, felt.noise))
        out.append(_Found(roughness, felt.roughness, felt.sigma, crude))
    return out


def _landed(material: Material, seed: list[int], grain: int = 0) -> Guard:
    """A guard whose array lies flush on a plate of that material, somewhere on its top."""
    rng = np.random.default_rng(seed)
    spec = load_sensor("lts210")
    spec = replace(spec, electronics=replace(spec.electronics, noise=0.05))
    place = [*rng.uniform(-8.0, 8.0, 2), 24.0]
    stage, arrays = simulate(
        MadeOf(PLATE, Materials(material), grain),
        [spec],
        rng,
        pose_noise=PoseNoise(0.05, 0.02, 0.0, np.radians(0.02)),
        start_pose=se3.pose(np.diag([1.0, -1.0, -1.0]), place),
        latency=LATE,
    )
    guard = Guard(stage, arrays, [Calibration.nominal(spec)])
    guard.pending.latency = measure_latency(guard).seconds
    if not land(guard, guard.world_from_sensor[:3, 2].copy(), 20.0, 25.0):
        raise RuntimeError(f"the pad did not come to lie on the plate of seed {seed}")
    return guard
