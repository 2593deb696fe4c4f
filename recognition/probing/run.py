"""`palpate probe`: one procedure alone, from a contact that it finds, over a stage that obeys late."""

from __future__ import annotations

from typing import Any

from exploration.control.procedures.thermal import WITHOUT
from models.material import MadeOf
from primitives.errors import PalpateError
from recognition.probing.felt import probe
from recognition.probing.options import ProbeOptions
from recognition.probing.truth import probe_truth
from recognition.running.felt_run import FeltConfig, felt_json, felt_run
from recognition.running.simulation import load_world
from recognition.tracking.truth import edge_truth
from recognition.tracking.view import View


def run(options: ProbeOptions, view: View) -> dict[str, Any]:
    """Probe, and leave a run folder; returns what `summary.json` holds.

    The object is asked what it is made of when the procedure has ended.
    """
    procedure, materials = options.known(), options.materials()
    world = load_world(options)
    if procedure.name == "thermal" and world.spec.thermal is None:
        raise PalpateError(WITHOUT)
    made = MadeOf(world.solid, materials, options.seed)
    surface = made if materials else None
    config = FeltConfig(latency=options.latency_s)
    with felt_run(options, "probe", world, view.told, surface, config) as felt_run_:
        felt_run_.guard.observers = (*felt_run_.guard.observers, view.seen)
        felt = probe(felt_run_, options, view.doing)
        contacts = felt.contacts
        truth = probe_truth(made, contacts)
        if procedure.name == "edge" and felt.trace is not None:
            truth = edge_truth(world.solid, felt.trace)
        said = felt_json(
            contacts.points if felt.trace is None else felt.trace,
            contacts.normals if felt.normals is None else felt.normals,
            felt.dihedral,
            felt.closed,
            felt.lost,
            felt_run_.forces,
            felt.found,
            truth,
        )
        return felt_run_.finish({"procedure": procedure.name, "property": procedure.serves, **said}, contacts)
