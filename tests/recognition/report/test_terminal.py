"""What a terminal says of a run that goes on."""

import pytest

from recognition.report.terminal import progress_text
from recognition.running.progress import Progress


@pytest.mark.parametrize(
    ("progress", "said"),
    [
        (Progress("writing"), "writing"),
        (Progress("reading", note="contacts.csv"), "reading: contacts.csv"),
        (Progress("exploring", 1, 0, 1, 4.4, open=2), "exploring: 1 touch, 1 frame, 4 mm of travel, 2 open"),
        (Progress("exploring", 0, 0, 40, 96.0), "exploring: 0 touches, 40 frames, 96 mm of travel"),
        (Progress("identifying", 3, note="an edge"), "identifying: 3 touches, an edge"),
    ],
)
def test_progress_tells_what_there_is_and_counts_in_words(progress, said):
    assert progress_text(progress) == said
