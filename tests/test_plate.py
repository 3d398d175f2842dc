"""The annular plate: frequencies, shapes and modal masses."""

from __future__ import annotations

from itertools import pairwise

import mpmath
import numpy as np
import pytest

from fiv_cli.plate import AnnularPlate, mode, orthogonality, ritz_wave_numbers

DISC = AnnularPlate(a=0.044, b=0.12, h=0.002, rho=7200.0, E=150e9, nu=0.211)  # Table 4.1
HALF = AnnularPlate(a=0.5, b=1.0, h=0.01, rho=1.0, E=1.0, nu=0.3)


@pytest.mark.parametrize(
    ("diameters", "frequency", "inverse_mass"),
    [
        (0, 1491.92691, 2.331299),
        (1, 1516.75732, 4.654327),
        (2, 1823.88110, 4.618520),
        (3, 2774.19385, 4.541565),
    ],
)
def test_the_disc_of_chapter_4(diameters: int, frequency: float, inverse_mass: float) -> None:
    found = mode(DISC, 0, diameters)
    assert found.frequency == pytest.approx(frequency, abs=5e-6)
    assert found.inverse_modal_mass(0.1) == pytest.approx(inverse_mass, abs=5e-7)


@pytest.mark.parametrize(
    ("diameters", "expected"), [(0, 13.024), (1, 13.290), (2, 14.704), (3, 18.562)]
)
def test_tabulated_frequency_parameters(diameters: int, expected: float) -> None:
    assert mode(HALF, 0, diameters).beta ** 2 == pytest.approx(expected, abs=5e-4)


def _precise_determinant(plate: AnnularPlate, n: int, beta: mpmath.mpf) -> mpmath.mpf:
    """The corrected rows of thesis 3.53, typed with J_n and J_{n+1}, in 40 digits."""
    a, b, nu = (mpmath.mpf(repr(value)) for value in (plate.a, plate.b, plate.nu))
    za, zb = beta * a, beta * b
    rows: list[list[mpmath.mpf]] = [[], [], [], []]
    functions = (mpmath.besselj, mpmath.bessely, mpmath.besseli, mpmath.besselk)
    for function, step, kind in zip(functions, (1, 1, -1, 1), (-1, -1, 1, 1), strict=True):
        near, near_above = function(n, za), function(n + 1, za)
        far, far_above = function(n, zb), function(n + 1, zb)
        rows[0].append(near)
        rows[1].append(n / a * near - step * beta * near_above)
        rows[2].append(
            (n * (n - 1) * (1 - nu) / b**2 + kind * beta**2) * far
            + step * (1 - nu) * beta / b * far_above
        )
        rows[3].append(
            (kind * n * beta**2 * b**2 + (1 - n) * (1 - nu) * n**2) / b**3 * far
            + step * (-kind * beta**3 * b**3 + beta * b * (1 - nu) * n**2) / b**3 * far_above
        )
    return mpmath.det(mpmath.matrix(rows))


@pytest.mark.parametrize(
    ("circles", "diameters"), [(0, 0), (0, 3), (1, 0), (2, 1), (5, 2), (0, 20), (3, 12)]
)
def test_frequencies_to_ten_digits_against_many_digit_arithmetic(
    circles: int, diameters: int
) -> None:
    found = mode(DISC, circles, diameters)
    with mpmath.workdps(40):
        beta = mpmath.mpf(found.beta)
        root = mpmath.findroot(
            lambda x: _precise_determinant(DISC, diameters, x),
            (beta * (1 - mpmath.mpf("1e-7")), beta * (1 + mpmath.mpf("1e-7"))),
            solver="anderson",
            tol=1e-50,
            verify=False,
        )
    assert found.beta == pytest.approx(float(root), rel=5e-13)


@pytest.mark.parametrize("diameters", [0, 1, 4, 15])
def test_no_mode_is_skipped(diameters: int) -> None:
    """The mode called k has k nodal circles, up to high order."""
    radii = np.linspace(DISC.a, DISC.b, 20001)[100:]
    for circles in range(0, 31, 5):
        shape = mode(DISC, circles, diameters).shape(radii)
        assert np.count_nonzero(shape[1:] * shape[:-1] < 0.0) == circles


@pytest.mark.parametrize("ratio", [0.01, 0.003])
def test_a_small_hole_needs_more_trial_shapes(ratio: float) -> None:
    """With one nodal diameter the plate turns about its hole, and bends most beside it."""
    pinhole = AnnularPlate(a=ratio, b=1.0, h=0.01, rho=1.0, E=1.0, nu=0.3)
    found = mode(pinhole, 0, 1)
    with mpmath.workdps(40):
        beta = mpmath.mpf(found.beta)
        sides = [beta * (1 + side * mpmath.mpf("1e-11")) for side in (-1, 1)]
        low, high = (_precise_determinant(pinhole, 1, side) for side in sides)
    assert low * high < 0.0
    assert np.all(found.shape(np.linspace(1.1 * ratio, 1.0, 2001)) > 0.0)


def test_a_hole_too_small_is_said() -> None:
    with pytest.raises(ValueError, match="hole, a/b = 1e-06, is too small"):
        mode(AnnularPlate(a=1e-6, b=1.0, h=0.01, rho=1.0, E=1.0, nu=0.3), 0, 1)


def test_ritz_bounds_from_above_and_converges() -> None:
    for diameters in (0, 2, 7):
        exact = np.array([mode(HALF, k, diameters).beta for k in range(6)])
        ritz = ritz_wave_numbers(HALF, diameters, 6)
        # rounding of the reciprocals 1/beta^4 is relative to the largest one; a root has 4 eps
        rounding = np.finfo(float).eps * (4.0 + (exact / exact[0]) ** 4 / 4.0)
        assert np.all(ritz >= exact * (1.0 - rounding))
        assert np.allclose(ritz, exact, rtol=1e-9)


def test_rayleigh_quotient_of_another_discretisation() -> None:
    """Splines know nothing of Bessel functions or Jacobi polynomials."""
    from scipy.interpolate import BSpline
    from scipy.linalg import eigh

    degree, pieces, n = 7, 40, 2
    edges = np.linspace(DISC.a, DISC.b, pieces + 1)
    knots = np.concatenate([[DISC.a] * degree, edges, [DISC.b] * degree])
    splines = BSpline(knots, np.eye(pieces + degree), degree)
    nodes, weights = np.polynomial.legendre.leggauss(degree + 2)
    r = np.concatenate([low + (high - low) * (nodes + 1) / 2 for low, high in pairwise(edges)])
    weight = np.tile(weights, pieces) * (DISC.b - DISC.a) / pieces / 2 * r
    # The first two splines do not vanish with their slope at the clamp.
    w, w1, w2 = (
        splines.derivative(order)(r).T[2:] if order else splines(r).T[2:] for order in range(3)
    )
    lap = w2 + w1 / r - n**2 * w / r**2
    saddle = w1 / r - n**2 * w / r**2
    twist = n * (w1 / r - w / r**2)
    gauss = (w2 * weight) @ saddle.T - (twist * weight) @ twist.T
    stiffness = (lap * weight) @ lap.T - (1 - DISC.nu) * (gauss + gauss.T)
    squares = eigh(stiffness, (w * weight) @ w.T, eigvals_only=True)[:3]
    assert np.allclose(squares**0.25, [mode(DISC, k, n).beta for k in range(3)], rtol=1e-8)


def test_shapes_are_orthonormal_and_satisfy_the_clamp() -> None:
    shapes = [mode(DISC, k, 3) for k in range(5)]
    masses = np.array([[orthogonality(i, j) for j in shapes] for i in shapes])
    assert np.allclose(masses, np.eye(5), atol=1e-12)
    for shape in shapes:
        scale = float(shape.shape(DISC.b))
        assert abs(float(shape.shape(DISC.a))) < 1e-11 * scale


def test_a_scale_of_length_scales_frequencies() -> None:
    large = AnnularPlate(0.44, 1.2, 0.02, DISC.rho, DISC.E, DISC.nu)
    assert mode(large, 1, 2).frequency == pytest.approx(
        mode(DISC, 1, 2).frequency / 10.0, rel=1e-12
    )


@pytest.mark.parametrize(("circles", "diameters"), [(-1, 0), (0, -2)])
def test_negative_numbers_are_no_modes(circles: int, diameters: int) -> None:
    with pytest.raises(ValueError, match="nodal"):
        mode(DISC, circles, diameters)


def test_radii_must_make_an_annulus() -> None:
    with pytest.raises(ValueError, match="annulus"):
        mode(AnnularPlate(0.12, 0.044, 0.002, 7200.0, 150e9, 0.211), 0, 0)
