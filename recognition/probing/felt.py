"""Each procedure by its name: run it from a flush contact, and say what it found under names with units."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from exploration.control.dwell import dwell
from exploration.control.feel import feel
from exploration.control.procedures.approach import approach, retreat
from exploration.control.procedures.compliance import compliance
from exploration.control.procedures.curvature import four_direction_curvature
from exploration.control.procedures.elasticity import elasticity
from exploration.control.procedures.enclosure import enclosure
from exploration.control.procedures.hardness import Hardness, HardnessConfig, hardness
from exploration.control.procedures.settle import settle
from exploration.control.procedures.surface_normal import surface_normal
from exploration.control.procedures.texture import texture
from exploration.control.procedures.thermal import thermal
from primitives.arrays import Floats
from primitives.errors import PalpateError
from primitives.evidence import Contacts
from recognition.probing.options import ProbeOptions
from recognition.running.felt_run import FeltRun
from recognition.tracking.edge import track_edge
from recognition.tracking.surface import track_surface

_LOOK = HardnessConfig(most=3)  # before a stroke, to know what share of every height the skin takes
_BACK = 20.0  # [mm] off the surface, from where an approach begins


@dataclass(frozen=True)
class Felt:
    """What a procedure yields, whichever it is."""

    found: Mapping[str, Any]
    contacts: Contacts = field(default_factory=lambda: Contacts.of([]))
    trace: Floats | None = None  # (n, 3) [mm]; None: the contacts
    normals: Floats | None = None
    dihedral: float | None = None  # [rad]
    closed: bool = False
    lost: bool = False


Say = Callable[[str], None]
Probe = Callable[[FeltRun, ProbeOptions, Say], Felt]


def probe(run: FeltRun, options: ProbeOptions, say: Say) -> Felt:
    """Find the object and carry the procedure out."""
    if options.procedure in TRACKERS:
        return TRACKERS[options.procedure](run, options, say)
    say("looking for the object")
    run.find()
    contacts = run.pad.feel()
    if not len(contacts):  # too rough for a surface to be fitted
        here = _contact(run, options)
        contacts = Contacts.of(here["point_mm"], here["normal"])
    say(options.procedure)
    run.forces.clear()
    run.guard.cost.strokes += 1
    found = AT_REST[options.procedure](run, options)
    run.announce("found", {"procedure": options.procedure, **found})
    return Felt(found, contacts)


def _approach(run: FeltRun, options: ProbeOptions) -> dict[str, Any]:
    retreat(run.guard, _BACK)
    run.pad.count_touch()
    met = approach(run.guard, run.guard.world_from_sensor[:3, 2].copy(), 2.0 * _BACK, options.force_n)
    return {
        "stopped": met.stopped,
        "travel_mm": met.travel,
        "force_n": met.force,
        "temperature_c": met.temperature,
    }


def _contact(run: FeltRun, options: ProbeOptions) -> dict[str, Any]:
    seen = dwell(run.guard, 8)
    felt = _sure(feel(seen.image))
    place = seen.world_from_sensor
    return {
        "point_mm": place[:3, :3] @ np.array([*felt.centroid, -felt.depth]) + place[:3, 3],
        "normal": -place[:3, 2],
        "depth_mm": felt.depth,
        "area_mm2": felt.area,
        "force_n": seen.force,
    }


def _normal(run: FeltRun, options: ProbeOptions) -> dict[str, Any]:
    felt = _sure(surface_normal(run.guard, run.pad.axes()[:, 0]))
    return {
        "point_mm": felt.point,
        "normal": felt.normal,
        "places": felt.places,
        "disagreement_deg": float(np.degrees(felt.disagreement)),
    }


def _enclosure(run: FeltRun, options: ProbeOptions) -> dict[str, Any]:
    felt = _sure(enclosure(run.guard))
    return {
        "enclosed": felt.enclosed,
        "area_mm2": felt.area,
        "extent_mm": felt.extent,
        "center_mm": felt.center,
        "axis": felt.axis,
        "round": felt.round,
        "lines": len(felt.lines),
        "radii_mm": [arc.radius for arc in felt.arcs],
    }


def _curvature(run: FeltRun, options: ProbeOptions) -> dict[str, Any]:
    seen = dwell(run.guard, run.pad.config.averaged)
    felt = four_direction_curvature(seen.image, _sure(feel(seen.image)))
    return {
        "order": felt.order,
        "probability": felt.probability,
        "k1_per_mm": float(felt.four.k1[0]),
        "k2_per_mm": float(felt.four.k2[0]),
        "sigma_per_mm": np.sqrt(felt.four.covariance[0, [0, 1], [0, 1]]),
    }


def _compliance(run: FeltRun, options: ProbeOptions) -> dict[str, Any]:
    felt = _sure(compliance(run.guard, options.force_n))
    return {
        "force_n": felt.force,
        "distance_mm": felt.distance,
        "distance_sigma_mm": felt.sigma,
        "skin_mm": felt.skin,
        "object_mm": felt.object,
    }


def _elasticity(run: FeltRun, options: ProbeOptions) -> dict[str, Any]:
    felt = _sure(elasticity(run.guard))
    return {
        "permanent_set_mm": felt.permanent_set,
        "permanent_set_sigma_mm": felt.sigma,
        "given_mm": felt.given,
        "recovered": felt.recovered,
        "press_n": felt.force,
    }


def _hardness(run: FeltRun, options: ProbeOptions) -> dict[str, Any]:
    felt: Hardness = _sure(hardness(run.guard))
    return {
        "hardness_n_mm": felt.hardness,
        "hardness_sigma_n_mm": None if felt.hardness is None else felt.sigma * felt.area,
        "stiffness_n_mm3": felt.stiffness,
        "stiffness_sigma_n_mm3": felt.sigma,
        "stiffer_than_n_mm3": felt.bound,
        "area_mm2": felt.area,
    }


def _texture(run: FeltRun, options: ProbeOptions) -> dict[str, Any]:
    yields = _sure(hardness(run.guard, _LOOK))
    settle(run.guard)
    start, axes = run.guard.world_from_sensor, run.pad.axes()
    stroked = texture(run.guard, axes[:, 0], yields.share)
    if not stroked:  # the face may be wide enough across, where the pad is less long
        retreat(run.guard)
        if run.pad.touch(start, 6.0, 6.0):
            stroked = texture(run.guard, axes[:, 1], yields.share)
    felt = _sure(stroked)
    return {
        "roughness_mm": felt.roughness,
        "roughness_sigma_mm": felt.sigma,
        "mean_mm": felt.mean,
        "deviation_mm": felt.deviation,
        "noise_mm": felt.noise,
        "grain_mm": felt.grain,
        "wavelengths_mm": felt.wavelengths,
        "spectrum_mm2": felt.spectrum,
        "stroke_mm": felt.travel,
    }


def _thermal(run: FeltRun, options: ProbeOptions) -> dict[str, Any]:
    felt = _sure(thermal(run.guard))
    return {
        "temperature_c": felt.celsius,
        "temperature_sigma_c": felt.sigma,
        "time_constant_s": felt.time_constant,
    }


def _edge(run: FeltRun, options: ProbeOptions, say: Say) -> Felt:
    track = track_edge(run, 20.0, say)
    if not track:
        raise PalpateError(f"no edge was followed: {track.why or track.ended}")
    contacts = Contacts.of(track.points, track.normals, sigma=track.sigma)
    closed, lost = track.ended == "closed", track.ended == "lost"
    return Felt(track.found(), contacts, track.points, track.normals, track.dihedral, closed, lost)


def _surface(run: FeltRun, options: ProbeOptions, say: Say) -> Felt:
    track = track_surface(run, 20.0, say)
    return Felt(track.found(), track.contacts, closed="closed" in track.ended, lost="lost" in track.ended)


TRACKERS: Mapping[str, Probe] = {"edge": _edge, "surface": _surface}
AT_REST: Mapping[str, Callable[[FeltRun, ProbeOptions], dict[str, Any]]] = {
    "approach": _approach,
    "contact": _contact,
    "normal": _normal,
    "enclosure": _enclosure,
    "curvature": _curvature,
    "compliance": _compliance,
    "elasticity": _elasticity,
    "hardness": _hardness,
    "texture": _texture,
    "thermal": _thermal,
}


def _sure(felt: Any) -> Any:
    """What was felt, or a line that says why nothing was."""
    if not felt:
        raise PalpateError(f"the procedure could not be carried out: {felt.reason}")
    return felt
