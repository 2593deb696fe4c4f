import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from primitives import pose

twists = arrays(float, 6, elements=st.floats(-1.7, 1.7))
vectors = arrays(float, 3, elements=st.floats(-1, 1)).filter(lambda v: np.linalg.norm(v) > 1e-3)


@given(twists, twists, twists)
def test_poses_form_a_group(a, b, c):
    a, b, c = pose.exp(a), pose.exp(b), pose.exp(c)
    assert np.allclose((a @ b) @ c, a @ (b @ c))
    assert np.allclose(a @ pose.inverse(a), np.eye(4), atol=1e-12)
    assert np.allclose(pose.inverse(a @ b), pose.inverse(b) @ pose.inverse(a))
    assert np.allclose(a[:3, :3] @ a[:3, :3].T, np.eye(3), atol=1e-12)


@given(twists)
def test_exp_agrees_with_the_matrix_exponential(twist):
    generator = np.zeros((4, 4))
    generator[:3, :3], generator[:3, 3] = pose.hat(twist[3:]), twist[:3]
    assert np.allclose(pose.exp(twist), expm(generator), atol=1e-12)


@given(twists)
def test_log_undoes_exp(twist):
    assert np.allclose(pose.log(pose.exp(twist)), twist, atol=1e-9)


@given(vectors, st.sampled_from([0.0, 1e-12, 1e-8, 1e-6, 1.01e-6, 1e-4, 1e-3]))
def test_log_undoes_exp_near_zero_and_near_half_a_turn(direction, gap):
    axis = direction / np.linalg.norm(direction)
    small = np.concatenate([[1.0, -2.0, 3.0], gap * axis])
    assert np.allclose(pose.log(pose.exp(small)), small, rtol=0, atol=1e-9)
    wide = (np.pi - gap) * axis
    found = pose.rotation_log(pose.rotation_exp(wide))
    assert min(np.abs(found - wide).max(), np.abs(found + wide).max() if gap < 1e-7 else np.inf) < 1e-7
    assert np.linalg.norm(found) <= np.pi + 1e-12
    turned = pose.pose(pose.rotation_exp(wide))
    assert np.isclose(pose.turn_between(turned, np.eye(4)), np.linalg.norm(found), rtol=0, atol=1e-9)


@given(vectors, st.floats(0, np.pi))
def test_quaternions_agree_with_scipy(direction, angle):
    vector = angle * direction / np.linalg.norm(direction)
    ours, theirs = pose.rotation_exp(vector), Rotation.from_rotvec(vector)
    assert np.allclose(ours, theirs.as_matrix(), atol=1e-12)
    wxyz = pose.quaternion_wxyz(ours)
    assert wxyz[0] >= 0
    assert np.isclose(abs(wxyz @ theirs.as_quat(scalar_first=True)), 1.0)
    assert np.allclose(pose.from_quaternion(wxyz)[:3, :3], ours, atol=1e-12)


@given(twists, vectors, vectors)
def test_motions_keep_distances_and_invert(twist, p, q):
    motion = pose.exp(twist)
    moved = pose.transform_points(motion, np.stack([p, q]))
    assert np.linalg.norm(moved[0] - moved[1]) == pytest.approx(np.linalg.norm(p - q), abs=1e-12)
    assert np.allclose(pose.transform_points(pose.inverse(motion), moved), np.stack([p, q]))


def test_batches_agree_with_single_poses():
    many = np.random.default_rng(0).normal(size=(5, 7, 6))
    assert np.allclose(pose.exp(many)[3, 2], pose.exp(many[3, 2]))
    assert np.allclose(pose.log(pose.exp(many))[1, 1], pose.log(pose.exp(many[1, 1])))
    assert np.allclose(pose.inverse(pose.exp(many))[0, 4], pose.inverse(pose.exp(many[0, 4])))


@given(vectors)
def test_frame_along_is_a_rotation_with_its_axis(z):
    frame = pose.frame_along(z)
    assert np.allclose(frame.T @ frame, np.eye(3), atol=1e-12)
    assert np.linalg.det(frame) == pytest.approx(1.0)
    assert np.allclose(frame[:, 2], z / np.linalg.norm(z))


@given(vectors, vectors)
def test_a_frame_is_turned_to_its_hint_as_far_as_its_axis_lets_it(z, hint):
    frame, z = pose.frame_along(z, hint), z / np.linalg.norm(z)
    assert np.allclose(frame @ frame.T, np.eye(3), atol=1e-9)
    assert np.allclose(frame[:, 1], np.cross(frame[:, 2], frame[:, 0]), atol=1e-12)
    left = hint - (hint @ z) * z
    if np.linalg.norm(left) > 1e-6:
        assert np.allclose(frame[:, 0], left / np.linalg.norm(left), atol=1e-6)


@given(vectors, vectors)
def test_one_product_of_two_vectors_is_that_of_many(a, b):
    assert np.allclose(pose.cross(a, b), np.cross(a, b), atol=1e-15)


@given(
    arrays(float, (3, 4), elements=st.floats(-1, 1)).filter(lambda q: (np.abs(q).max(axis=1) > 1e-3).all())
)
def test_a_rotation_of_a_quaternion_agrees_with_scipy(wxyz):
    turned = pose.from_quaternion(wxyz)[:, :3, :3]
    assert np.allclose(turned, Rotation.from_quat(wxyz[:, [1, 2, 3, 0]]).as_matrix(), atol=1e-12)
    assert np.allclose(pose.from_quaternion(wxyz[0])[:3, :3], turned[0], atol=1e-15)


def test_turn_about_leaves_its_axis_where_it_is():
    motion = pose.turn_about([1.0, 2, 3], [0, 0, 1.0], 0.7)
    assert np.allclose(pose.transform_points(motion, np.array([[1.0, 2, 9]])), [[1.0, 2, 9]])
