"""Poses of one object that all fit leave places to other objects, which fit as well."""

from dataclasses import replace

import numpy as np

from models.csg import Cone, Cube, Cylinder
from models.library import Library
from models.solid import Solid
from primitives.evidence import Contacts
from recognition.matching import Evidence, match
from recognition.matching.evidence import Prior
from recognition.matching.hypotheses import Found
from recognition.matching.likelihood import NoiseConfig
from recognition.matching.match import MatchConfig
from recognition.matching.modes import Felt
from recognition.matching.refining import Refining
from recognition.matching.sifted import Sieve, SiftConfig, _best
from recognition.recognizing.answer import warnings_of

BODIES = {"cone": Cone(20.0, 0.0, 50.0), "plate": Cube((80.0, 60.0, 8.0)), "block": Cube((40.0, 40.0, 40.0)),
          "bar": Cube((90.0, 20.0, 10.0)), "rod": Cylinder(12.0, 60.0)}  # fmt: skip


def test_contacts_on_a_line_are_on_whatever_is_straight_somewhere() -> None:
    library = Library.of({name: Solid.from_csg(body) for name, body in BODIES.items()})
    line = np.outer(np.arange(30.0), [0.6, 0.8, 0.0])
    evidence = Evidence(Contacts.of(line, sigma=0.1))
    belief = match(evidence, library)
    assert all(belief.probabilities[name] > 0.02 for name in BODIES)
    assert belief.confidence < 0.7
    assert any("on one line" in warning for warning in warnings_of(belief, evidence))


def test_objects_that_tie_take_turns() -> None:
    poses = {"many": np.zeros((50, 3, 4)), "few": np.zeros((3, 3, 4)), "behind": np.zeros((3, 3, 4))}
    scores = {"many": np.zeros(50), "few": np.full(3, -0.001), "behind": np.full(3, -9.0)}
    kept = _best(poses, scores, 5.0, 8, 0.02)
    assert {name: len(p) for name, p in kept.items()} == {"many": 5, "few": 3}


def test_no_pose_far_behind_on_the_field_is_looked_at_but_one_that_was_given() -> None:
    library = Library.of({name: Solid.from_csg(BODIES[name]) for name in ("block", "bar")})
    sides = np.concatenate([np.eye(3), -np.eye(3)])
    evidence = Evidence(Contacts.of(20.0 * sides, sides, 0.1, 0.02))
    n, poses = len(sides), np.repeat(np.eye(4)[None, :3], 3, axis=0)
    far = SiftConfig().far * n
    costs = np.array([1.0, 0.9 * far, 1.1 * far])

    def looked_at(evidence: Evidence, **found: Found) -> dict[str, int]:
        sieve = Sieve(
            library, Felt.of(evidence), evidence, NoiseConfig(), SiftConfig(behind=np.inf, on_field=np.inf)
        )
        return {name: len(kept) for name, kept in sieve.through(found).items()}

    assert looked_at(evidence, block=Found(poses, costs)) == {"block": 2}
    assert looked_at(evidence, block=Found(poses, costs), bar=Found(poses, costs + 2.0 * far)) == {"block": 2}
    assert looked_at(evidence, block=Found(poses[:1], costs[:1]), bar=Found(poses, costs + 2.0 * far, 1)) == {
        "block": 1,
        "bar": 1,
    }
    untold = replace(evidence, scale_known=False)
    assert looked_at(untold, block=Found(poses, costs)) == {"block": 3}


def test_what_was_left_out_is_looked_at_once_it_is_asked_for_closer() -> None:
    library = Library.of({name: Solid.from_csg(BODIES[name]) for name in ("block", "bar")})
    sides = np.concatenate([np.eye(3), -np.eye(3)])
    evidence = Evidence(Contacts.of(20.0 * sides, sides, 0.1, 0.02))
    config, far = MatchConfig(), SiftConfig().far * len(sides)
    poses = np.eye(4)[None, :3]
    found = {"block": Found(poses, np.array([1.1 * far])), "bar": Found(poses, np.array([0.0]))}
    prior = Prior.around(evidence.contacts)
    refining = Refining(library, evidence, prior, config.noise, config.sift, config.polished, config.slid)
    assert {m.hypothesis.name for m in refining.modes(found)} == {"bar"}
    assert max(refining.closer(found, config.closer), key=lambda m: m.log_known).hypothesis.name == "block"


def test_poses_are_looked_at_closer_only_where_nothing_is_settled(monkeypatch) -> None:
    library = Library.of({name: Solid.from_csg(body) for name, body in BODIES.items()})
    asked, closer = [], Refining.closer
    monkeypatch.setattr(Refining, "closer", lambda self, *how: asked.append(1) or closer(self, *how))
    samples, rng = library["plate"].samples, np.random.default_rng(0)
    rows = rng.permutation(len(samples.points))[:40]
    match(Evidence(Contacts.of(samples.points[rows], samples.normals[rows], 0.1, 0.02)), library)
    assert not asked
    side = np.array([[0.0, 0.0, 0.0], [9.0, 0.0, 0.0], [0.0, 9.0, 0.0], [9.0, 9.0, 0.0], [5.0, 2.0, 0.0]])
    match(Evidence(Contacts.of(side, np.tile([0.0, 0.0, 1.0], (5, 1)), 0.1, 0.02)), library)
    assert asked
    match(Evidence(Contacts.of(side, sigma=0.1)), library)  # without normals it would be the same again
    assert len(asked) == 1
