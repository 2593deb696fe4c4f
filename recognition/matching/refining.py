"""The modes of the poses that were found, as more and more objects are searched.

Of an object that was searched before only what is new is done: the exact surface takes most of the time where many
objects are searched and none fits.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from models.library import Entry
from primitives.arrays import Floats
from recognition.matching.evidence import Evidence, Prior
from recognition.matching.hypotheses import Begun, Found, SearchConfig
from recognition.matching.likelihood import NoiseConfig
from recognition.matching.modes import Felt, Mode, modes_of
from recognition.matching.sharpened import among, sharpened
from recognition.matching.sifted import Sieve, SiftConfig
from recognition.matching.sliding import slid
from recognition.matching.target import target_of

_MORE = 0.5  # of log likelihood, by which a mode is more than another that its covariance spans


@dataclass
class Refining:
    """Of one evidence; each object's poses are the same whenever they are asked for."""

    library: Mapping[str, Entry]
    evidence: Evidence
    prior: Prior
    noise: NoiseConfig
    sift: SiftConfig
    polished: int
    slid: int
    _seen: Felt = field(init=False)
    _sieve: Sieve = field(init=False)
    # by object and by how many of its poses stayed
    _modes: dict[tuple[str, int], list[Mode]] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        self._seen = Felt.of(self.evidence)
        self._sieve = Sieve(self.library, self._seen, self.evidence, self.noise, self.sift)

    def modes(self, found: Mapping[str, Found]) -> list[Mode]:
        """The modes of those poses that may be among the likeliest of all."""
        kept = self._sieve.through(found)
        modes = [mode for name, poses in kept.items() for mode in self._of(name, poses)]
        return sharpened(modes, self.library, self._seen, self.evidence, self.prior, self.noise)

    def closer(self, found: Mapping[str, Found], sift: SiftConfig) -> list[Mode]:
        """The same, with all poses looked at anew, as `sift` has it."""
        return replace(self, sift=sift).modes(found)

    def beside(self, modes: list[Mode], begun: Begun, search: SearchConfig) -> list[Mode]:
        """The modes, and those that the likeliest slide to."""
        fresh: list[Mode] = []
        for h in [m.hypothesis for m in sorted(modes, key=lambda m: -m.log_known)[: self.slid]]:
            entry = self.library[h.name]
            poses = slid(h, begun, target_of(entry), search)
            found = modes_of(entry, poses, self._seen, self.evidence, self.prior, self.noise, self.polished)
            fresh += [m for m in found if not among(_as_good(modes, m), m, entry)]
        if not fresh:
            return modes
        kept: list[Mode] = []
        for mode in sorted([*modes, *fresh], key=lambda m: -m.log_known):
            if not among(kept, mode, self.library[mode.hypothesis.name]):
                kept.append(mode)
        return sharpened(kept, self.library, self._seen, self.evidence, self.prior, self.noise)

    def _of(self, name: str, poses: Floats) -> list[Mode]:
        """The best poses stay, so that their number says which."""
        key = name, len(poses)
        if key not in self._modes:
            entry = self.library[name]
            self._modes[key] = modes_of(
                entry, poses, self._seen, self.evidence, self.prior, self.noise, self.polished
            )
        return self._modes[key]


def _as_good(modes: list[Mode], than: Mode) -> list[Mode]:
    return [m for m in modes if m.log_known > than.log_known - _MORE]
