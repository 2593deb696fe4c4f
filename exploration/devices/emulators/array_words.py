"""What an emulated array says: its frames, and its answers to questions about itself."""

import numpy as np

from exploration.devices.wire import flexitac, line_text, matrix_text, weiss_dsa, weiss_wts
from exploration.sensing.frame import TaxelFrame
from exploration.sensing.spec import SensorSpec


def replies(protocol: str, data: bytes, spec: SensorSpec) -> bytes:
    """The answers to the questions that some bytes hold."""
    a, full = spec.array, min(spec.electronics.full_scale, 65535.0)
    told = weiss_dsa.MatrixInfo(a.pitch, (a.columns, a.rows), full)
    if protocol == "dsa" and weiss_dsa.ask_matrix() in data:
        return weiss_dsa.encode_matrix_info(told)
    if protocol == "wts" and weiss_wts.ask_matrix() in data:
        return weiss_wts.encode_matrix_info(told)
    return b""


def encoded(protocol: str, frame: TaxelFrame) -> bytes:
    """A frame as an array of that protocol sends it."""
    counts = np.rint(frame.counts).astype(int)
    milliseconds = round(1000 * frame.time)
    if protocol == "dsa":
        return weiss_dsa.encode_frame(np.minimum(counts, 4095), milliseconds)
    if protocol == "wts":
        return weiss_wts.encode(np.minimum(counts, 65535), milliseconds)
    if protocol == "flexitac":
        return flexitac.encode(np.minimum(counts, 255))
    return (
        matrix_text.encode(counts)
        if protocol == "matrix"
        else line_text.encode(counts, frame.index, milliseconds)
    )
