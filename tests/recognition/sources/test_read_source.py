"""What a SOURCE may be, and the one line that each broken one gets."""

import numpy as np
import pytest

from primitives.errors import PalpateError
from recognition.sources import read_source

POINTS = np.array([[1.0, 2, 3], [4, 5, 6], [7, 8, 9.5], [-1, 0, 2]])
NORMALS = np.array([[0, 0, 2.0], [0, 1, 0], [1, 0, 0], [0, 0, 0]])


def written(tmp_path, text, name="c.csv"):
    (tmp_path / name).write_text(text)
    return tmp_path / name


def rows(table, mark=","):
    return "\n".join(mark.join(f"{x:g}" for x in row) for row in table)


@pytest.mark.parametrize("mark", [",", ";", "\t", " "])
@pytest.mark.parametrize("header", ["", "x{0}y{0}z\n"])
def test_columns_are_parted_by_any_mark_with_or_without_a_header(tmp_path, mark, header):
    found = read_source(written(tmp_path, header.format(mark) + rows(POINTS, mark)))
    assert np.array_equal(found.contacts.points, POINTS)
    assert not found.contacts.has_normal.any()
    assert not found.measured_sigma


@pytest.mark.parametrize(
    ("header", "scale"), [("x [m],y [m],z [m]", 1000), ("x_m,y_m,z_m", 1000), ("X (cm),Y (cm),Z (cm)", 10)]
)
def test_a_header_may_say_another_unit(tmp_path, header, scale):
    found = read_source(written(tmp_path, f"{header}\n{rows(POINTS / scale)}"))
    assert found.contacts.points == pytest.approx(POINTS)


def test_between_semicolons_a_comma_is_a_decimal_point(tmp_path):
    found = read_source(written(tmp_path, "x;y;z\n" + rows(POINTS, ";").replace(".", ",")))
    assert np.array_equal(found.contacts.points, POINTS)


@pytest.mark.parametrize(("head", "mark"), [(";", ","), (" ", ","), (",", ";"), (",", " ")])
def test_a_header_may_be_parted_otherwise_than_what_is_below_it(tmp_path, head, mark):
    found = read_source(written(tmp_path, head.join("xyz") + "\n" + rows(POINTS, mark)))
    assert found.contacts.points == pytest.approx(POINTS)


def test_a_cloud_in_metres_that_does_not_say_so_is_told(tmp_path):
    with pytest.raises(PalpateError, match="give mm, or a header that says m"):
        read_source(written(tmp_path, rows(POINTS / 1000)))


def test_normals_are_made_unit_and_one_of_no_length_is_none(tmp_path):
    found = read_source(written(tmp_path, rows(np.hstack([POINTS, NORMALS]))))
    assert found.contacts.has_normal.tolist() == [True, True, True, False]
    assert np.linalg.norm(found.contacts.normals[0]) == pytest.approx(1.0)


def test_a_reading_that_a_file_repeats_counts_once_and_keeps_its_row(tmp_path):
    found = read_source(written(tmp_path, rows(np.repeat(np.hstack([POINTS, NORMALS]), 3, axis=0))))
    assert np.array_equal(found.contacts.points, POINTS)
    assert found.rows.tolist() == [0, 3, 6, 9]
    assert found.warnings == (
        "of 12 that were written, 8 contacts repeat another to the last digit and count once with it",
    )


def test_named_columns_stand_in_any_order_and_empty_normals_are_not_felt(tmp_path):
    text = "sigma,z,y,x,nx,ny,nz,other\n0.1,3,2,1,,,,7\n0.2,6,5,4,0,0,1,7\n"
    found = read_source(written(tmp_path, text))
    assert np.array_equal(found.contacts.points, POINTS[:2])
    assert found.contacts.sigma.tolist() == [0.1, 0.2]
    assert found.measured_sigma


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_a_ply_cloud_is_read_in_every_form(tmp_path, form):
    head = f"ply\nformat {form} 1.0\nelement vertex 4\n" + "".join(f"property double {a}\n" for a in "xyz")
    order = ">" if "big" in form else "<"
    body = rows(POINTS, " ").encode() if form == "ascii" else POINTS.astype(order + "f8").tobytes()
    file = tmp_path / "c.ply"
    file.write_bytes(head.encode() + b"end_header\n" + body)
    assert np.array_equal(read_source(file).contacts.points, POINTS)


@pytest.mark.parametrize(
    "text",
    ["", "  \n", "x,y,z\n",
     "1,2\n3,4\n", "1,2,3\n4,nan,6\n", "1,2,3\n4,five,6\n", "1,2,3\n4,5\n", "a,b,c\n1,2,3\n",
     "x,y,z,sigma\n1,2,3,-1\n", "1,2,3\n1e9,2,3\n"],
)  # fmt: skip
def test_a_broken_table_is_one_line(tmp_path, text):
    with pytest.raises(PalpateError) as said:
        read_source(written(tmp_path, text))
    assert "\n" not in str(said.value)


def test_a_folder_without_a_run_and_a_file_that_is_not_there_are_named(tmp_path):
    for path in (tmp_path, tmp_path / "none.csv", tmp_path / "none"):
        with pytest.raises(PalpateError, match=str(path)):
            read_source(path)


def test_the_scatter_of_contacts_is_found_from_themselves(tmp_path):
    rng = np.random.default_rng(0)
    flat = np.column_stack([rng.uniform(0, 50, (400, 2)), 0.2 * rng.standard_normal(400)])
    found = read_source(written(tmp_path, rows(flat))).with_sigma(None)
    assert np.median(found.contacts.sigma) == pytest.approx(0.2, rel=0.2)
