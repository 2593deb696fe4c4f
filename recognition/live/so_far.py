"""What a page shows of a run that goes on: no model yet, but faces as far as they were felt."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from exploration.planning.touching.findings import Findings
from primitives.evidence import Contacts, EdgeTrace
from primitives.fit import Fit
from primitives.shapes import parameters
from recognition.report.felt import felt_faces
from recognition.report.run_report import ReportFrames, ReportMesh, RunReport
from recognition.running.simulation import World


def explored(findings: Findings, world: World, frames: ReportFrames) -> RunReport:
    """An exploration until now."""
    felt = findings.graph.faces
    contacts = Contacts.concatenate([face.contacts for face in felt])
    owner = np.repeat(np.arange(len(felt)), [len(face.contacts) for face in felt]).astype(np.int64)
    rows = [
        {"id": number, "shape": face.fit.kind, "parameters": parameters(face.fit.shape)}
        if isinstance(face.fit, Fit)
        else {"id": number, "shape": "freeform", "parameters": {}}
        for number, face in enumerate(felt)
    ]
    model = felt_faces(rows, contacts.points, owner)
    return _report({"faces": rows}, world, frames, contacts, owner, findings_traces(findings), model)


def identified(
    history: Sequence[Mapping[str, Any]],
    evidence: tuple[Contacts, Sequence[EdgeTrace]],
    world: World,
    frames: ReportFrames,
    model: ReportMesh | None,
) -> RunReport:
    """An identification until now; `model` is what is believed most, where it is believed to be."""
    contacts, traces = evidence
    owner = np.full(len(contacts), -1)
    return _report({"history": list(history)}, world, frames, contacts, owner, traces, model)


def findings_traces(findings: Findings) -> list[EdgeTrace]:
    """The edges that were followed."""
    return [trace for trace, _ in findings.traces]


def _report(
    summary: dict[str, Any],
    world: World,
    frames: ReportFrames,
    contacts: Contacts,
    owner: np.ndarray,
    traces: Sequence[EdgeTrace],
    model: ReportMesh | None,
) -> RunReport:
    return RunReport(
        summary=summary,
        settings={},
        model=model,
        contacts=contacts.points,
        contact_face=owner,
        frames=frames,
        pad_size=world.spec.array.size,
        housing_size=world.spec.housing.size,
        traces=[trace.points for trace in traces],
    )
