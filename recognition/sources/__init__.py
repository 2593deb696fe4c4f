"""What touch left behind, as one kind of evidence: contact tables, run folders, recordings."""

from recognition.sources.read import read_source
from recognition.sources.source import Felt, Source

__all__ = ["Felt", "Source", "read_source"]
