"""`palpate track`: one tracker alone, from a contact that it finds, over a stage that obeys late."""

from __future__ import annotations

from typing import Any

from primitives.evidence import Contacts
from recognition.running.felt_run import FeltConfig, FeltRun, felt_json, felt_run
from recognition.running.simulation import load_world
from recognition.tracking.edge import EdgeTrack, track_edge
from recognition.tracking.options import TrackOptions
from recognition.tracking.surface import ELSEWHERE, SurfaceTrack, track_surface
from recognition.tracking.truth import edge_truth, surface_truth
from recognition.tracking.view import View


def run(options: TrackOptions, view: View) -> dict[str, Any]:
    """Track, and leave a run folder; returns what `summary.json` holds.

    The object is asked for the truth when the tracker has ended.
    """
    world = load_world(options)
    config = FeltConfig(latency=options.latency_s)
    with felt_run(options, "track", world, view.told, config=config) as felt:
        felt.guard.observers = (*felt.guard.observers, view.seen)
        if options.what == "edge":
            return _edge(felt, options, view)
        return _surface(felt, options, view)


def _edge(felt: FeltRun, options: TrackOptions, view: View) -> dict[str, Any]:
    track = track_edge(felt, options.speed_mm_s, view.doing)
    points, normals = track.points, track.normals
    if track and track.ended == "lost":
        felt.warnings.append(_lost(options))
    said = felt_json(
        points,
        normals,
        track.dihedral,
        track.ended == "closed",
        not track or track.ended == "lost",
        list(track.forces),
        _found_edge(track),
        edge_truth(felt.world.solid, *(trace.points for trace in track.traces)) if felt.world.known else None,
    )
    return felt.finish({"what": "edge", **said}, Contacts.of(points, normals, sigma=track.sigma))


def _found_edge(track: EdgeTrack) -> dict[str, Any]:
    return track.found() if track else {"ended": track.ended, "why": track.why, "edges": []}


def _surface(felt: FeltRun, options: TrackOptions, view: View) -> dict[str, Any]:
    track: SurfaceTrack = track_surface(felt, options.speed_mm_s, view.doing)
    contacts = track.contacts
    if track.lost and len(contacts):
        felt.warnings.append(_lost(options))
    said = felt_json(
        contacts.points,
        contacts.normals,
        None,
        "closed" in track.ended,
        track.lost,
        track.forces,
        track.found(),
        surface_truth(felt.world.solid, contacts) if felt.world.known else None,
    )
    return felt.finish({"what": "surface", **said}, contacts)


def _lost(options: TrackOptions) -> str:
    return f"the {options.what} was lost before its end; {ELSEWHERE}"
