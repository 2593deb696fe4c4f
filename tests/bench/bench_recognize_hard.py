"""Recognizing where it is hard: twins that differ in one place, a half that is covered, poses that look alike.

Twins stand alone in their library; beside their score is the limit, with the true object started at its true pose,
and how often the touch that is proposed to tell them apart meets what differs.  Contacts of a robot hand are read
from $PALPATE_DATA/contacts, where there are any.  PALPATE_BENCH_QUERIES sets the queries a row.
"""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

import numpy as np
from bench_recognize import QUERIES, Table, trials_of
from recognizing.objects import DATA, library, twins
from recognizing.ray_hand import RayHand
from recognizing.trials import NOISE, TURN, Trial, add_s, on_surface

from exploration.devices.guard import Cost
from exploration.planning.touching.lone_touch import Approach
from exploration.planning.touching.pace import Pace
from exploration.planning.ways.round_ball import Ball
from models.library import Library
from models.solid import Solid
from models.symmetry import pose_error
from primitives.arrays import Floats
from primitives.evidence import Contacts
from primitives.pose import pose, random_rotation, rotate, transform_points
from recognition.identifying.bounds import believed_ball
from recognition.identifying.learned import evidence_of as evidence_of_touches
from recognition.identifying.placed import is_placed
from recognition.matching import Belief, Evidence, Prior, match
from recognition.matching.next_touch import Choice, separating
from recognition.matching.next_touch.sampled import sampled
from recognition.recognizing.kept_model import kept_model
from recognition.recognizing.run import Asked, evidence_of, prior_of
from recognition.sources import read_source

PAD = (28.8, 18.0)  # [mm]
PITCH = 1.8  # [mm]
UNLIKE = 0.5  # [mm] that first contact, or the surface under a taxel, is another
TAXELS = 3  # of these
MOST = 6  # touches that are made as proposed, one after another
CORNERS = np.array([[0, 0, 0], [100, 0, 0], [30, 80, 0], [35, 25, 70.0]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])


def run() -> list[dict[str, Any]]:
    """Rows of the table."""
    table = Table("recognize, hard")
    near_duplicates(table)
    covered(table)
    tetrahedron(table)
    fingers(table)
    return table.rows


def near_duplicates(table: Table) -> None:
    """Pairs that differ in one hole, radius or length, alone in their library."""
    for kind, pair in twins().items():
        known = Library.of(dict(zip(("first", "second"), pair, strict=True)))
        trials = trials_of(known, QUERIES, 20, False, True)
        for method, starts in (("palpate", False), ("limit", True)):
            beliefs = [
                match(Evidence(t.contacts), known, starts=[(t.name, t.world)] if starts else ())
                for t in trials
            ]
            right = [b.decision == t.name for b, t in zip(beliefs, trials, strict=True)]
            table.share(method, f"twins in a {kind}, 20 contacts", right)
        sure = [(b, t) for b, t in zip(beliefs, trials, strict=True) if b.confidence > 0.95]
        wrong = sum(b.decision != t.name for b, t in sure) / max(len(sure), 1)
        table.add("palpate", f"sure and wrong, twins in a {kind}", wrong, "share", "<= 0.05")
        open_still = [(b, t) for b, t in zip(beliefs, trials, strict=True) if b.confidence <= 0.95]
        both = [min(b.probabilities[name] for name in known) > 0.02 for b, _ in open_still]
        if both:
            table.share("palpate", f"both named where open, twins in a {kind}", both)
        after = [_named_after(t, known, k) for k, (_, t) in enumerate(open_still)]
        if after:
            what = (
                f"named surely after at most {MOST} touches as proposed, twins in a {kind}, pose open or not"
            )
            table.share("palpate", what, [a <= MOST for a in after])
            table.add("palpate", f"touches for that, twins in a {kind}, median", float(np.median(after)), "")
        placed = [_placed(b, t, known) for b, t in open_still]
        hits = [_separated(b, t, known, k) for k, (b, t) in enumerate(open_still)]
        for where, rows in (("", placed), (" (pose open too)", [not p for p in placed])):
            some = [hit for hit, row in zip(hits, rows, strict=True) if row]
            if some:
                what = f"separating touch hits what differs, twins in a {kind}{where}"
                table.share("palpate", what, some, None if where else ">= 95")


def _placed(belief: Belief, t: Trial, known: Library) -> bool:
    """Whether the object's own poses leave no doubt where it is: else no one touch can be known to tell."""
    return (
        is_placed(belief, known[t.name], 0.9)
        and add_s(known[t.name], belief.best(t.name).pose, t.world) < 0.02
    )


def _separated(belief: Belief, t: Trial, known: Library, seed: int) -> bool:
    """Whether the pad of the touch proposed would feel unlike on the true one and on where the other would be."""
    middle = transform_points(t.world, np.asarray(known[t.name].samples.points)).mean(axis=0)
    here = pose(np.diag([1.0, -1.0, -1.0]), [*middle[:2], middle[2] + 150.0])
    pace, rng = Pace(), np.random.default_rng(seed)
    may_be = sampled(belief, known, Evidence(t.contacts), rng)
    found = separating(belief, known, here, Ball(middle, 90.0), PAD, pace, rng, known=may_be)
    if not isinstance(found, Choice):
        return False
    rival = next(name for name in known if name != t.name)
    there = belief.best(rival)
    if there is None:
        return False
    placed = known[t.name].solid.placed(t.world), known[rival].solid.placed(there.pose)
    one, other = (_felt(solid, found.approach) for solid in placed)
    if not (np.isfinite(one[0]) and np.isfinite(other[0])):
        return bool(np.isfinite(one[0]) != np.isfinite(other[0]))
    unlike = np.abs(one[1] - other[1]) > UNLIKE
    return bool(abs(one[0] - other[0]) > UNLIKE or unlike.sum() >= TAXELS)


def _named_after(t: Trial, known: Library, seed: int) -> float:
    """How many touches, made as proposed, it took until the right name was sure; inf if never."""
    rng, touches = np.random.default_rng(seed), []
    hand = RayHand(known[t.name].solid.placed(t.world), rng, cost=Cost(touches=1000))
    for count in range(MOST + 1):
        felt = evidence_of_touches(touches)
        evidence = replace(felt, contacts=Contacts.concatenate([t.contacts, felt.contacts]))
        belief = match(evidence, known)
        if belief.confidence > 0.95:
            return float(count) if belief.decision == t.name else np.inf
        ball = believed_ball(evidence.contacts, MOST, belief, known, PAD)
        may_be = sampled(belief, known, evidence, rng)
        found = separating(belief, known, hand.here, ball, PAD, hand.pace, rng, known=may_be)
        if not isinstance(found, Choice):
            return np.inf
        touches.append(hand.touch(found.approach, ball))
        hand.leave(ball)
    return np.inf


def _felt(solid: Solid, approach: Approach) -> tuple[float, Floats]:
    """[mm] of advance to first contact, and how far every taxel is then from the surface, up to a millimeter."""
    x, y = (PITCH * (np.arange(n) - 0.5 * (n - 1)) for n in (16, 10))
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    origins = approach.start[:3, 3] + grid @ approach.start[:3, :2].T
    ways = np.ascontiguousarray(np.broadcast_to(approach.start[:3, 2], origins.shape))
    cast = solid.cast_rays(origins, ways)
    k = int(np.argmin(cast.distance))
    if not cast.distance[k] <= approach.length:
        return np.inf, np.empty(0)
    reached = np.where(np.isfinite(cast.distance), cast.distance, cast.distance[k] + 50.0)
    points = origins + reached[:, None] * ways
    return float(cast.distance[k]), np.clip((points[k] - points) @ cast.normals[k], -1.0, 1.0)


def covered(table: Table) -> None:
    """Half of the object out of reach, at twice the contacts, beside the whole of it."""
    known = library()
    names = list(known)
    for count in (12, 20):
        rng = np.random.default_rng(count)
        whole, half = [], []
        for k in range(QUERIES):
            entry = known[names[k % len(names)]]
            for hits, hidden, many in ((whole, False, count), (half, True, 2 * count)):
                points, facing = on_surface(entry.solid, 40 * many, False, rng)
                side = (points - points.mean(axis=0)) @ random_rotation(rng)[:, 2]
                rows = rng.permutation(np.flatnonzero(side > 0.0) if hidden else np.arange(len(points)))[
                    :many
                ]
                world = pose(random_rotation(rng), rng.uniform(-60.0, 60.0, 3))
                noisy = facing[rows] + TURN * rng.standard_normal((many, 3))
                noisy = rotate(world, noisy / np.linalg.norm(noisy, axis=1, keepdims=True))
                felt = transform_points(world, points[rows]) + NOISE * rng.standard_normal((many, 3))
                belief = match(Evidence(Contacts.of(felt, noisy, NOISE, TURN)), known)
                hits.append(belief.decision == entry.name)
        table.share("palpate", f"top-1, {count} contacts on the whole", whole)
        wanted = f">= {95.0 * float(np.mean(whole)):.0f}"
        table.share("palpate", f"top-1, {2 * count} contacts on one half", half, wanted)


def tetrahedron(table: Table) -> None:
    """Nine exact contacts without normals, 25 poses: the right basin first, others below it."""
    known = Library.of({"tetrahedron": Solid.from_mesh(CORNERS, FACES)})
    entry, hits, others = known["tetrahedron"], [], []
    for seed in range(25):
        rng = np.random.default_rng(seed)
        places = np.array([rng.dirichlet([1, 1, 1]) @ CORNERS[FACES[k % 4]] for k in range(9)])
        world = pose(random_rotation(rng), rng.uniform(-100, 100, 3))
        evidence = Evidence(Contacts.of(transform_points(world, places), None, 0.05))
        belief = match(evidence, known, Prior(np.zeros(3), 200.0), unknown=0.0)
        error = pose_error(entry.symmetry, belief.hypotheses[0].pose, world)
        hits.append(error.distance < 2.0 and error.angle < 0.05)
        others.append(len(belief.hypotheses) - 1)
    table.share("palpate", "tetrahedron, 9 exact contacts, right basin", hits, "25 of 25")
    table.add("palpate", "tetrahedron, other modes told, mean", float(np.mean(others)), "")


def fingers(table: Table) -> None:
    """Contacts of a robot hand, without normals and of unknown noise, on models of their objects."""
    for name, asked in (("lego", 6.90), ("cleaner", 6.86), ("robot", 5.48)):
        contacts, model = DATA / "contacts" / f"{name}.csv", DATA / "contacts" / f"{name}.off"
        if not model.exists():
            continue
        request = Asked(str(contacts))
        evidence = evidence_of(request, read_source(request.source))
        entry, _ = kept_model(str(model), "m", 1.0)
        known = Library({entry.name: lambda entry=entry: entry})
        for _ in range(2):  # the first one loads what is compiled
            began = time.process_time()
            belief = match(evidence, known, prior_of(request, evidence), unknown=0.0)
            seconds = time.process_time() - began
        table.add("palpate", f"{name}, mean distance", belief.hypotheses[0].residual, "mm", f"<= {asked}")
        table.add("palpate", f"{name}, processor time", seconds, "s", "<= 0.5")
