"""Relations and round sizes that a designer meant, accepted only where the measured uncertainty allows them."""

from recognition.assembly.regularities.regularize import regularize
from recognition.assembly.regularities.relation import RegularityOptions, Regularized, Relation

__all__ = ["RegularityOptions", "Regularized", "Relation", "regularize"]
