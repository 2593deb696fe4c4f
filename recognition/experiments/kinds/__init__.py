"""The kinds of trial: what each may be told, what it tells, and where it is done.

The tables below are read when a suite is, so they import nothing heavy; a trial's own module is imported by
whoever carries it out.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module

from recognition.experiments.settings import Metric, Setting, Value
from recognition.experiments.trial import Work

Carry = Callable[[Mapping[str, Value], Work], Mapping[str, Value]]


@dataclass(frozen=True)
class Kind:
    """One kind of trial."""

    name: str
    about: str
    settings: Mapping[str, Setting]
    metrics: Mapping[str, Metric]
    needed: tuple[str, ...] = ()  # settings without a default
    shown: tuple[str, ...] = ()  # the metrics that a page draws

    @property
    def carry(self) -> Carry:
        """What does a trial of this kind: settings and a place to work, to metrics."""
        out: Carry = import_module(f"{__name__}.{self.name}").carry
        return out


_SEED = Setting(int, 0, "of everything random", 0)
_PART = Setting(str, "", "a built-in part, a CAD file, @convex or @all")
_SENSOR = {
    "sensor": Setting(str, "lts210", "a built-in array, or its TOML file"),
    "pitch_mm": Setting(float, None, "between taxels, the pad as large as before", 0.05),
    "pad_scale": Setting(float, None, "times as many rows and columns", 0.1, 20.0),
    "bits": Setting(int, None, "of the converter; 0: none", 0, 32),
    "spread_mm": Setting(float, None, "of the rubber: the cross-talk between taxels", 0.0),
    "dead": Setting(float, None, "share of taxels that read nothing", 0.0, 1.0),
    "gain_spread": Setting(float, None, "1 sigma of the taxels' gains", 0.0, 1.0),
    "noise": Setting(float, None, "1 sigma, as a fraction of the full-contact signal", 0.0),
}
_POSE_NOISE = {"pose_noise_mm": Setting(float, 0.0, "1 sigma of the stage's position", 0.0)}
_COST = {
    "touches": Metric(int, "guarded approaches", "low"),
    "strokes": Metric(int, "tracked motions"),
    "frames": Metric(int, "frames read"),
    "travel_mm": Metric(float, "way of the pad", "low"),
    "device_seconds": Metric(float, "time on the device", "low"),
    "wall_seconds": Metric(float, "time here", "low"),
}
_BELIEF = {
    "decision": Metric(str, "the name decided for"),
    "answer": Metric(str, "the right name"),
    "correct": Metric(bool, "whether the name is right", "high"),
    "confidence": Metric(float, "probability given to the decision", most=1.0),
    "answer_probability": Metric(float, "probability given to the right name", "high", 1.0),
    "translation_error_mm": Metric(float, "of the pose, where the name is right", "low"),
    "rotation_error_deg": Metric(float, "of the pose, where the name is right", "low"),
}
_LIBRARY = {
    "library": Setting(str, "", "folder of CAD files; empty: built-in parts"),
    "library_size": Setting(int, None, "built-in parts in the library, this one among them", 1),
    "unknown": Setting(bool, False, "whether this part is taken out of the library"),
}

KINDS = {
    kind.name: kind
    for kind in (
        Kind(
            "explore",
            "explore an object until its boundary is closed",
            {
                "part": _PART,
                "cover": Setting(str, "", "a file with a body in the way"),
                **_SENSOR,
                **_POSE_NOISE,
                "feature_mm": Setting(float, 10.0, "smallest feature that must not be missed", 0.1),
                "policy": Setting(
                    str, "closure", "who plans", choices=("closure", "grid", "random", "raster")
                ),
                "max_touches": Setting(int, 500, "after which exploration stops", 1),
                "seed": _SEED,
            },
            {
                "closed": Metric(bool, "whether the boundary closed", "high"),
                "ended": Metric(str, "why it ended"),
                **_COST,
                "faces": Metric(int, "faces found"),
                "edges": Metric(int, "edges found"),
                "leaves": Metric(int, "primitives of the tree"),
                "iou": Metric(float, "overlap with the truth", "high", 1.0),
                "hausdorff_mm": Metric(float, "greatest distance from the truth", "low"),
                "surface_rms_mm": Metric(float, "distance from the truth, root mean square", "low"),
                "surface_mean_mm": Metric(float, "distance from the truth, mean", "low"),
                "face_shape_accuracy": Metric(float, "share of the area with the right shape", "high", 1.0),
                "extent_median_mm": Metric(float, "error of the faces' extents, median", "low"),
                "extent_max_mm": Metric(float, "error of the faces' extents, greatest", "low"),
            },
            ("part",),
            ("closed", "surface_rms_mm", "extent_max_mm", "iou", "touches"),
        ),
        Kind(
            "track",
            "follow an edge or a surface from a contact",
            {
                "part": _PART,
                "what": Setting(str, "edge", "what to follow", choices=("edge", "surface")),
                **_SENSOR,
                **_POSE_NOISE,
                "speed_mm_s": Setting(float, 20.0, "along the edge, or over the surface", 1.0, 200.0),
                "latency_s": Setting(float, 0.02, "by which the stage obeys late", 0.0, 0.2),
                "seed": _SEED,
            },
            {
                "closed": Metric(bool, "whether the track came back to its start"),
                "lost": Metric(bool, "whether the track was lost", "low"),
                **_COST,
                "track_rms_mm": Metric(float, "distance from the truth, root mean square", "low"),
                "track_max_mm": Metric(float, "distance from the truth, greatest", "low"),
                "force_mean_n": Metric(float, "force in contact, mean"),
                "force_max_n": Metric(float, "force in contact, greatest", "low"),
                "shape_right": Metric(bool, "whether the surface's shape was named right", "high"),
            },
            ("part",),
            ("lost", "track_rms_mm", "track_max_mm", "force_max_n"),
        ),
        Kind(
            "frames",
            "find lines in simulated frames",
            {
                "scene": Setting(
                    str,
                    "edge",
                    "what is pressed",
                    choices=("edge", "corner", "wall", "slot", "flat", "ball", "nothing"),
                ),
                "detector": Setting(str, "palpate", "palpate, or a comparator by name"),
                **_SENSOR,
                "count": Setting(int, 100, "frames of a trial", 1, 100_000),
                "seed": _SEED,
            },
            {
                "lines": Metric(int, "lines there were"),
                "found": Metric(int, "lines found within 15 degrees and 1.5 taxels", "high"),
                "found_share": Metric(float, "the same as a share", "high", 1.0),
                "false_lines": Metric(int, "lines found that there were not", "low"),
                "angle_rms_deg": Metric(float, "error of found lines, root mean square", "low"),
                "offset_rms_mm": Metric(float, "error of found lines, root mean square", "low"),
                "frame_seconds": Metric(float, "time of one frame, median", "low"),
            },
            shown=("found_share", "false_lines", "angle_rms_deg", "offset_rms_mm"),
        ),
        Kind(
            "recognize",
            "name an object from contacts on its surface, passively",
            {
                "part": _PART,
                **_LIBRARY,
                "contacts": Setting(int, 30, "contacts on its surface", 1, 100_000),
                "sigma_mm": Setting(float, 0.1, "1 sigma of a contact", 0.0),
                "normals": Setting(bool, True, "whether contacts have normals"),
                "occlusion": Setting(float, 0.0, "share of the surface that is out of reach", 0.0, 0.99),
                "seed": _SEED,
            },
            {
                **_BELIEF,
                "wall_seconds": _COST["wall_seconds"],
            },
            ("part",),
            ("correct", "answer_probability", "translation_error_mm", "rotation_error_deg"),
        ),
        Kind(
            "identify",
            "touch an object until sure of its name",
            {
                "part": _PART,
                **_LIBRARY,
                **_SENSOR,
                **_POSE_NOISE,
                "policy": Setting(
                    str,
                    "information",
                    "who plans",
                    choices=("information", "random", "grid", "largest-gap", "planar"),
                ),
                "stop_confidence": Setting(float, 0.95, "at which identification stops", 0.0, 1.0),
                "max_touches": Setting(int, 30, "after which identification stops", 1),
                "seed": _SEED,
            },
            {
                **_BELIEF,
                **_COST,
                "touches_to_correct": Metric(int, "from which on the right name led", "low"),
                "first_touches_right": Metric(str, "after each touch, whether the right name led: 0 or 1"),
            },
            ("part",),
            ("correct", "touches", "touches_to_correct", "device_seconds", "rotation_error_deg"),
        ),
    )
}
