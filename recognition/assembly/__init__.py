"""Fitted faces into a boundary and a short tree of named primitives."""

from recognition.assembly.assemble import Assembly, AssemblyOptions, assemble
from recognition.assembly.closure import NotClosed

__all__ = ["Assembly", "AssemblyOptions", "NotClosed", "assemble"]
