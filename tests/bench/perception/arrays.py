"""The arrays of the table: blur of one taxel on a skin that ends far away, 8 bit."""

from dataclasses import replace

from exploration.sensing.frame import TaxelArray
from exploration.sensing.spec import SensorSpec, load_sensor

PRESS = 0.5  # [mm] nominal


def array(rows: int, columns: int, pitch: float, blur: float | None = None) -> SensorSpec:
    """A pad whose blur is one taxel, or `blur` [mm]."""
    like = load_sensor("lts210")
    blur = pitch if blur is None else blur
    size = (columns * pitch, rows * pitch, 40.0)
    return replace(
        like,
        array=TaxelArray(f"{rows}x{columns}", rows, columns, (pitch, pitch)),
        elastomer=replace(like.elastomer, spread=blur, margin=3 * blur, hysteresis=0.0),
        housing=replace(like.housing, size=size),
        press_depth=PRESS,
    )


PAD = array(10, 16, 1.8)
OTHERS = {
    "14x6 at 3.4 mm": array(14, 6, 3.4),
    "32x32 at 1 mm": array(32, 32, 1.0),
    "4x4 at 2 mm": array(4, 4, 2.0),
}
