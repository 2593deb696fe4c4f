"""A library of objects to recognize: `Library`, its `Entry`s, and their samples and distance fields."""

from models.library.build import Built, build
from models.library.entry import Entry
from models.library.field import DistanceField, FieldConfig, distance_field
from models.library.library import Library
from models.library.samples import SampleConfig, SurfaceSamples, surface_samples

__all__ = [
    "Built",
    "DistanceField",
    "Entry",
    "FieldConfig",
    "Library",
    "SampleConfig",
    "SurfaceSamples",
    "build",
    "distance_field",
    "surface_samples",
]
