"""The covariance of fits whose contacts share errors."""

import numpy as np

from primitives.evidence import Contacts
from primitives.fit import fit
from primitives.shared_error import design_effect, with_shared_error

SIGMA = 0.02  # [mm]


def plate(rng, touches, each, share):
    """Contacts on the plane z = 0 in strips along y, and what a fit makes of them."""
    x, y = np.repeat(np.linspace(-30, 30, touches), each), np.tile(np.linspace(-20, 20, each), touches)
    common = np.sqrt(share) * SIGMA * rng.standard_normal(touches)
    own = np.sqrt(1 - share) * SIGMA * rng.standard_normal(touches * each)
    touch = np.repeat(np.arange(touches), each)
    contacts = Contacts.of(np.column_stack([x, y, common[touch] + own]), sigma=SIGMA, touch=touch)
    return fit("plane", contacts), contacts


def test_the_scatter_of_many_fits_is_what_the_covariance_says():
    rng = np.random.default_rng(0)
    tilts, said = [], []
    for _ in range(300):
        found, contacts = plate(rng, 6, 20, share=0.5)
        honest = with_shared_error(found, contacts, share=0.5)
        tilt = found.shape.normal * np.sign(found.shape.normal[2])
        tilts.append(tilt[0])
        toward_x = honest.shape.frame[0, :2]  # how much each of the two tilts leans toward x
        said.append(toward_x @ honest.covariance[1:, 1:] @ toward_x)
    ratio = np.std(tilts) / np.sqrt(np.median(said))
    assert 0.8 < ratio < 1.25


def test_contacts_that_are_each_their_own_touch_change_nothing():
    found, contacts = plate(np.random.default_rng(1), 60, 1, share=0.0)
    honest = with_shared_error(found, contacts)
    scale = max(1.0, found.chi2 / found.dof)
    assert np.allclose(honest.covariance, scale * found.covariance, rtol=1e-6)


def test_sharing_makes_a_fit_less_certain_and_never_more():
    found, contacts = plate(np.random.default_rng(2), 4, 30, share=0.5)
    honest = with_shared_error(found, contacts)
    assert np.trace(honest.covariance) > 2 * np.trace(found.covariance)


def test_scatter_beyond_the_stated_sigmas_makes_a_fit_less_certain():
    rng = np.random.default_rng(3)
    x, y = rng.uniform(-20, 20, (2, 80))
    contacts = Contacts.of(
        np.column_stack([x, y, 3 * SIGMA * rng.standard_normal(80)]), sigma=SIGMA, touch=np.arange(80)
    )
    found = fit("plane", contacts)
    ratio = np.diag(with_shared_error(found, contacts).covariance) / np.diag(found.covariance)
    assert np.allclose(ratio, found.chi2 / found.dof)
    assert 6.0 < ratio[0] < 13.0


def test_contacts_count_for_as_many_as_the_scatter_of_their_mean_says():
    rng = np.random.default_rng(4)
    touch = np.repeat([0, 1, 2, 3], [2, 5, 10, 30])
    contacts = Contacts.of(np.zeros((len(touch), 3)), sigma=SIGMA, touch=touch)
    errors = np.sqrt(0.5) * (
        rng.standard_normal((4000, 4))[:, touch] + rng.standard_normal((4000, len(touch)))
    )
    found = float(np.var(errors.mean(axis=1)) * len(touch))
    assert 0.9 < design_effect(contacts) / found < 1.1
    assert design_effect(Contacts.of(np.zeros((9, 3)), touch=np.arange(9))) == 1.0
