"""A belief as `locate`, `recognize` and `identify` answer: candidates with pose, uncertainty and probability."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from models.library import Entry, Library
from models.symmetry import pose_error
from primitives.arrays import Floats, Ints
from primitives.pose import inverse, quaternion_wxyz, transform_points
from recognition.matching import Belief, Evidence, Hypothesis
from recognition.matching.belief import UNKNOWN
from recognition.matching.lone_face import lone_face
from recognition.matching.next_touch import Choice

_LEAST = 1e-4  # a candidate less probable than this is not told, unless it is the best of its object
_TOLD_INWARD = 0.05  # probability that normals point in, from which on it is told
_CROWDED = 0.1  # of the length of the smallest object: contacts nearer together are hardly in mm,
_MANY = 6  # where there are so many of them
_SIGMAS = 2.0  # sigmas of the contacts, within which they lie on a line,
_NARROW = 0.02  # or within this share of its length
_OFF = 4.0  # sigmas of the contacts, where they were told, off which a model is another object,
_OFF_SIZE = 0.02  # or share of its size, where they were not,
_OFF_SHARE = 0.25  # if so many of them are


def pose_json(world_from_object: Floats) -> dict[str, Any]:
    """As in every summary."""
    return {
        "translation_mm": world_from_object[:3, 3].tolist(),
        "quaternion_wxyz": quaternion_wxyz(world_from_object).tolist(),
    }


def candidate(
    h: Hypothesis, entry: Entry, probability: float, beside: Sequence[Hypothesis] = ()
) -> dict[str, Any]:
    """One object at one pose; `beside` are all poses that it may have instead, this one among them."""
    place, turn = _sigma(h, entry, beside or (h,))
    return {
        "name": h.name,
        "probability": probability,
        "pose": pose_json(h.pose),
        "pose_sigma": {"translation_mm": place, "rotation_deg": float(np.degrees(turn))},
        "symmetry": entry.symmetry.name,
        "residual_mm": h.residual,
    }


def _sigma(h: Hypothesis, entry: Entry, beside: Sequence[Hypothesis]) -> tuple[float, float]:
    """[mm], [rad] root mean square error to be expected of a pose, of all poses with their shares."""
    shares = np.exp(np.array([b.log_weight for b in beside]) - max(b.log_weight for b in beside))
    off = [pose_error(entry.symmetry, b.pose, h.pose) for b in beside]
    places = [b.translation_sigma**2 + o.distance**2 for b, o in zip(beside, off, strict=True)]
    turns = [b.rotation_sigma**2 + o.angle**2 for b, o in zip(beside, off, strict=True)]
    place, turn = (float(np.sqrt(shares @ np.array(x) / shares.sum())) for x in (places, turns))
    return place, min(turn, float(np.pi))


def without_pose(name: str, probability: float) -> dict[str, Any]:
    """A name that nothing places."""
    nothing: dict[str, Any] = dict.fromkeys(("pose", "pose_sigma", "symmetry", "residual_mm"))
    return {"name": name, "probability": probability, **nothing}


def objects(belief: Belief, library: Mapping[str, Entry], most: int = 10) -> list[dict[str, Any]]:
    """One candidate an object, likeliest first, each at its likeliest pose; "unknown" has none."""
    ranked = sorted(belief.probabilities.items(), key=lambda item: -item[1])
    best = [(name, belief.best(name), p) for name, p in ranked]
    told = [
        without_pose(name, p) if h is None else candidate(h, library[name], p, _poses(belief, name))
        for name, h, p in best[:most]
    ]
    return [c for i, c in enumerate(told) if i == 0 or c["probability"] >= _LEAST]


def _poses(belief: Belief, name: str) -> list[Hypothesis]:
    return [h for h in belief.hypotheses if h.name == name]


def modes(belief: Belief, entry: Entry, most: int = 32) -> list[dict[str, Any]]:
    """One candidate a mode of the pose; their probabilities sum to one."""
    weights = np.array([h.log_weight for h in belief.hypotheses])
    share = np.exp(weights - weights.max())
    share = share / share.sum()
    pairs = zip(belief.hypotheses[:most], share, strict=False)
    return [candidate(h, entry, float(p)) for h, p in pairs]


def why(belief: Belief, separate: Choice | None = None, rows: Ints | None = None) -> dict[str, Any]:
    """The runner-up, the contacts that speak against it, and the touch that would settle what is left.

    Of the contacts (n,) `rows` are told in their place, where they are other than those in the evidence.
    """
    ranked = sorted(belief.probabilities.items(), key=lambda item: -item[1])
    if len(ranked) < 2:
        return {"runner_up": None, "separating_contacts": []}
    first, second = ranked[0][0], ranked[1][0]
    named = [name for name, _ in ranked if name != UNKNOWN]
    rival = second if second != UNKNOWN else (named[1] if len(named) > 1 else None)
    contacts: Sequence[int] = belief.separating(first, rival) if rival and first != UNKNOWN else ()
    told: dict[str, Any] = {
        "runner_up": second,
        "separating_contacts": [i if rows is None else int(rows[i]) for i in contacts],
    }
    if separate is not None:
        told["separating_touch"] = {
            "start": pose_json(separate.approach.start),
            "direction": separate.approach.direction.tolist(),
            "length_mm": separate.approach.length,
            "bits": separate.name_bits,
            "seconds": separate.seconds,
        }
    return told


def warnings_of(belief: Belief, evidence: Evidence) -> list[str]:
    """What a person should know before the answer is used."""
    said = of_contacts(belief, evidence)
    if belief.confidence < 0.95:
        said += _of_one_face(evidence)
        said.append(f"not sure: {belief.decision} has {_percent(belief.confidence)}; {_advice(belief)}")
    return said


def of_contacts(belief: Belief, evidence: Evidence) -> list[str]:
    """What the contacts lack, and what was taken in its place."""
    said = []
    if evidence.lacking:
        have = "1 contact has" if evidence.lacking == 1 else f"{evidence.lacking} contacts have"
        said.append(f"{have} no normal; with normals far fewer contacts are enough")
    return said + facing_of(belief) + _taken_scatter(belief, evidence)


def _taken_scatter(belief: Belief, evidence: Evidence) -> list[str]:
    """What was taken for noise that nobody told."""
    if evidence.scale_known:
        return []
    taken = f"about {np.median(evidence.contacts.sigma):.2g} mm was taken"
    otherwise = (
        "if it is more, say how much" if belief.decision == UNKNOWN else "if you know it better, say so"
    )
    return [
        f"the file does not say how far its contacts scatter, and {taken}; {otherwise} (--contact-sigma MM)"
    ]


def _of_one_face(evidence: Evidence) -> list[str]:
    """Why many contacts may tell little."""
    c = evidence.contacts
    if where := _place(evidence):
        return [f"all {len(c)} contacts lie {where}, which says little of an object; touch other sides"]
    flat = lone_face(c.points, c.normals, c.has_normal) is not None
    if not flat and evidence.round_face is None:
        return []
    return [
        f"all {len(c)} contacts lie on one {'flat' if flat else 'round'} face, which says little of the rest of "
        "an object; touch other sides"
    ]


def _place(evidence: Evidence) -> str | None:
    """Where many contacts lie that span no area."""
    c = evidence.contacts
    if len(c) < _MANY:
        return None
    wide, broad, _ = np.linalg.svd(c.points - c.points.mean(axis=0), compute_uv=False) / np.sqrt(len(c))
    least = _SIGMAS * float(np.median(c.sigma))
    if broad > max(least, _NARROW * wide):
        return None
    return "on one line" if wide > least else "at one place"


def facing_of(belief: Belief) -> list[str]:
    """A warning where normals were probably given that point into the object."""
    if belief.inward < _TOLD_INWARD:
        return []
    return [
        f"the normals of the contacts seem to point into the object ({_percent(belief.inward)}), and were turned "
        "round; turn them in the file, for others rely on them too"
    ]


def other_object(best: Hypothesis, evidence: Evidence, entry: Entry) -> list[str]:
    """A warning where too many contacts lie off the model that was looked for, at its likeliest pose."""
    c = evidence.contacts
    apart = np.abs(entry.solid.signed_distance(transform_points(inverse(best.pose), c.points)))
    size = np.full(len(c), _OFF_SIZE * float(entry.solid.extent.max()))
    off = apart > (_OFF * c.sigma if evidence.scale_known else size)
    if off.mean() < _OFF_SHARE:
        return []
    return [
        f"{off.sum()} of the {len(c)} contacts lie {float(apart[off].min()):.2g} mm and more off {entry.name}, "
        "where it fits best: they are probably another object's, or --scale, --units or --prior-center is wrong"
    ]


def other_unit(evidence: Evidence, library: Library, names: Iterable[str]) -> list[str]:
    """A warning where contacts lie too close together for objects of these names: they are hardly in mm."""
    points = evidence.contacts.points
    across = float(np.linalg.norm(np.ptp(points, axis=0)))
    least = min((float(library[name].solid.extent.max()) for name in set(names)), default=0.0)
    if len(points) < _MANY or across > _CROWDED * least:
        return []
    return [
        f"all {len(points)} contacts lie within {across:.2g} mm, and no object that was matched is shorter than "
        f"{least:.0f} mm; contacts are in mm: multiply them by 1000 if these are in m, by 25.4 if in inches"
    ]


def _advice(belief: Belief) -> str:
    """What to do; twins that share what speaks for the library would else pass for an unknown object."""
    known = 1.0 - belief.probabilities.get(UNKNOWN, 0.0)
    if belief.decision != UNKNOWN or known <= belief.confidence:
        return "give more contacts"
    names = [name for name in belief.probabilities if name != UNKNOWN]
    first, second = sorted(names, key=lambda name: -belief.probabilities[name])[:2]
    return (f"objects of the library have {_percent(known)} together, {first} and {second} the most; "
            "give contacts where these differ")  # fmt: skip


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %"
