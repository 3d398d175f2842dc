"""Annular Kirchhoff plate, clamped inside and free outside: frequencies and mode shapes.

    rho h w_tt + D* lap lap w = 0,   w = 0, w_r = 0 at r = a,   M_r = 0, V_r = 0 at r = b

Thesis 3.3. A mode (k, l) has k nodal circles and l nodal diameters:
w = R(r) cos(l theta) (or sin), R = C1 J_l + C2 Y_l + C3 I_l + C4 K_l of beta r, and
omega = beta^2 sqrt(D*/(rho h)) (3.54).

The boundary matrix is not the printed one (3.53), which gives 1674, 1616, 1840 and 2737 rad/s for
the disc of Table 4.1. It is derived from the natural boundary conditions of the plate's energy:

    M_r ~ R'' + nu (R'/r - l^2 R/r^2)
    V_r ~ (lap R)' - (1 - nu) l^2/r (R'/r - R/r^2)

against 3.51, where M_rtheta lacks (1/r) dW/dtheta, and 3.52, where Q_r is the derivative of the
Laplacian and not of M_r. Row 2 of the print has lambda for beta, its row 3 lost the factor
(1 - nu) beta/b at the Bessel functions of order l + 1 and their signs. Corrected, the frequencies
are 1492, 1517, 1824 and 2774 rad/s, as the thesis itself says.

No root is skipped: the values of a Rayleigh-Ritz computation, each an upper bound of the frequency
of the same number, count the modes, and each brackets a root of the determinant. Bessel functions
are scaled by their exponential growth and each column of the matrix by its largest entry, so that
nothing is lost at high order. Shapes are mass-normalised; only R(r0)^2/M and ratios of R enter any
physical answer.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

EXTRA_TERMS = 16  # Ritz terms beyond twice the number of modes asked for
REFINEMENTS = (1, 2, 4, 8)  # times as many where these are too few: a small hole, a < b/50
SMALLEST_HOLE = 1e-15  # a/b; below, Bessel functions overflow at the hole
BRACKET = 1e-4  # half-width of the bracket about a Ritz value, relative


class ModeNotFoundError(ValueError):
    """No root of the determinant stands where the energies say that there is one."""


@dataclass(frozen=True)
class AnnularPlate:
    """A plate of uniform thickness, clamped at its inner and free at its outer edge.

    Attributes
    ----------
    a, b : inner and outer radius, m
    h : thickness, m
    rho : density, kg/m^3
    E : Young's modulus, Pa
    nu : Poisson's ratio
    """

    a: float
    b: float
    h: float
    rho: float
    E: float
    nu: float

    @property
    def rigidity(self) -> float:
        """Bending rigidity D* = E h^3 / (12 (1 - nu^2)), N m (thesis 3.41)."""
        return self.E * self.h**3 / (12.0 * (1.0 - self.nu**2))

    @property
    def mass_per_area(self) -> float:
        """rho h, kg/m^2."""
        return self.rho * self.h


@dataclass(frozen=True)
class PlateMode:
    """A mode shape R(r) cos(l theta), mass-normalised: its modal mass is 1 kg.

    Attributes
    ----------
    plate : the plate
    circles, diameters : k and l
    beta : wave number, 1/m
    coefficients : of the scaled J, Y, I, K; shape (4,)
    """

    plate: AnnularPlate
    circles: int
    diameters: int
    beta: float
    coefficients: Vector

    @property
    def frequency(self) -> float:
        """Natural frequency, rad/s (thesis 3.54)."""
        return self.beta**2 * float(np.sqrt(self.plate.rigidity / self.plate.mass_per_area))

    def shape(self, radius: Vector | float) -> Vector:
        """R(r) in kg^(-1/2); the shape of `radius`, in m."""
        return self._derivatives(radius)[0]

    def _derivatives(self, radius: Vector | float) -> Matrix:
        """R, R', R'', R''' at `radius`; shape (4, ...)."""
        basis = _basis(self.plate, self.diameters, self.beta, np.asarray(radius, dtype=float))
        found: Matrix = np.tensordot(basis, self.coefficients, axes=(1, 0))
        return found

    def inverse_modal_mass(self, radius: float) -> float:
        """R(r0)^2/M, 1/kg: by how much a unit force at `radius` accelerates the mode there."""
        return float(self.shape(radius)) ** 2


def mode(plate: AnnularPlate, circles: int, diameters: int) -> PlateMode:
    """The mode with `circles` nodal circles and `diameters` nodal diameters.

    Raises
    ------
    ValueError
        when a number is negative or the radii are no annulus
    ModeNotFoundError
        the hole is too small for the numbers of a double
    """
    _check(plate, circles, diameters)
    return _mode(plate, circles, diameters)


def orthogonality(first: PlateMode, second: PlateMode) -> float:
    """The modal mass of a pair of modes with the same diameters: 1 or 0 (thesis 3.58)."""
    nodes, weights = _quadrature(first.plate, first.circles + second.circles + first.diameters)
    product = first.shape(nodes) * second.shape(nodes)
    return _circumference(first) * float(np.sum(weights * nodes * product))


def _check(plate: AnnularPlate, circles: int, diameters: int) -> None:
    if circles < 0 or diameters < 0:
        raise ValueError(f"a mode has no ({circles}, {diameters}) nodal circles and diameters")
    if not 0.0 < plate.a < plate.b:
        raise ValueError(f"the radii {plate.a!r} and {plate.b!r} m make no annulus: 0 < a < b")


@cache
def _mode(plate: AnnularPlate, circles: int, diameters: int) -> PlateMode:
    if plate.a < SMALLEST_HOLE * plate.b:
        raise _not_found(plate, circles, diameters)
    beta = _wave_number(plate, circles, diameters)
    unscaled = PlateMode(plate, circles, diameters, beta, _null_vector(plate, diameters, beta))
    size = np.sqrt(orthogonality(unscaled, unscaled))
    # Positive at the outer edge, where no mode has a node.
    sign = np.sign(unscaled.shape(plate.b))
    return PlateMode(plate, circles, diameters, beta, unscaled.coefficients * sign / size)


def _circumference(mode: PlateMode) -> float:
    """rho h times the integral of cos^2(l theta) (thesis 3.59)."""
    turn = 2.0 * np.pi if mode.diameters == 0 else np.pi
    return mode.plate.mass_per_area * turn


def _quadrature(plate: AnnularPlate, waves: int) -> tuple[Vector, Vector]:
    """Gauss nodes and weights over [a, b], enough for `waves` half-waves."""
    nodes, weights = _gauss(40 + 6 * waves)
    half = 0.5 * (plate.b - plate.a)
    return plate.a + half * (nodes + 1.0), half * weights


@cache
def _gauss(count: int) -> tuple[Vector, Vector]:
    """Gauss-Legendre nodes and weights on [-1, 1]."""
    from scipy.special import roots_legendre

    nodes, weights = roots_legendre(count)
    return nodes, weights


# --- the boundary-value problem -------------------------------------------------------------------
def _basis(plate: AnnularPlate, order: int, beta: float, radius: Vector) -> Matrix:
    """Derivatives 0 to 3 with respect to r of the scaled J, Y, I, K; shape (4, 4, ...).

    I is divided by exp(beta b) and K by exp(-beta a), by which they grow over the plate.
    """
    from scipy.special import ive, jv, kve, yv

    z = beta * radius
    rising, falling = np.exp(z - beta * plate.b), np.exp(beta * plate.a - z)
    functions = (
        lambda n: jv(n, z),
        lambda n: yv(n, z),
        lambda n: ive(n, z) * rising,
        lambda n: kve(n, z) * falling,
    )
    # f' = n f/z - s f_{n+1} with s = 1, 1, -1, 1, and f'' from Bessel's equation.
    kinds = zip(functions, (1.0, 1.0, -1.0, 1.0), (1.0, 1.0, -1.0, -1.0), strict=True)
    columns = [_derivatives(f, order, z, s, e) for f, s, e in kinds]
    powers = beta ** np.arange(4.0)
    found: Matrix = np.stack(columns, axis=1) * powers.reshape(4, *([1] * (1 + np.ndim(z))))
    return found


def _derivatives(function: Any, n: int, z: Vector, step: float, kind: float) -> Matrix:
    """f, f', f'', f''' of a Bessel function; kind +1: z^2 f'' + z f' + (z^2 - n^2) f = 0."""
    f, above = function(n), function(n + 1)
    first = n * f / z - step * above
    second = -first / z - (kind - n**2 / z**2) * f
    third = -second / z + first / z**2 - (kind - n**2 / z**2) * first - 2.0 * n**2 / z**3 * f
    return np.stack([f, first, second, third])


def _boundary_matrix(plate: AnnularPlate, order: int, beta: float) -> Matrix:
    """Conditions at r = a (R, R') and r = b (M_r, V_r) on the four coefficients; (4, 4)."""
    inside = _basis(plate, order, beta, np.array(plate.a))
    value, slope, curvature, third = _basis(plate, order, beta, np.array(plate.b))
    r, n2, nu = plate.b, float(order**2), plate.nu
    moment = curvature + nu * (slope / r - n2 * value / r**2)
    laplacian_slope = third + curvature / r - (1.0 + n2) * slope / r**2 + 2.0 * n2 * value / r**3
    shear = laplacian_slope - (1.0 - nu) * n2 / r * (slope / r - value / r**2)
    lengths = (1.0, beta, beta**2, beta**3)
    rows = (inside[0], inside[1], moment, shear)
    return np.stack([row / length for row, length in zip(rows, lengths, strict=True)])


def _scaled(matrix: Matrix) -> tuple[Matrix, Vector]:
    """Columns divided by their largest entry, and those entries."""
    sizes = np.max(np.abs(matrix), axis=0)
    return matrix / sizes, sizes


def _determinant(plate: AnnularPlate, order: int, beta: float) -> float:
    return float(np.linalg.det(_scaled(_boundary_matrix(plate, order, beta))[0]))


def _null_vector(plate: AnnularPlate, order: int, beta: float) -> Vector:
    matrix, sizes = _scaled(_boundary_matrix(plate, order, beta))
    null: Vector = np.linalg.svd(matrix)[2][-1] / sizes
    return null


def _wave_number(plate: AnnularPlate, circles: int, diameters: int) -> float:
    """Root of the determinant that the Ritz computation counts as number `circles`."""
    from scipy.optimize import brentq

    def determinant(beta: float) -> float:
        return _determinant(plate, diameters, beta)

    for finer in REFINEMENTS:
        guess = float(ritz_wave_numbers(plate, diameters, circles + 1, finer)[circles])
        low, high = guess * (1.0 - BRACKET), guess * (1.0 + BRACKET)
        if determinant(low) * determinant(high) < 0.0:
            return float(brentq(determinant, low, high, xtol=1e-300, rtol=8.9e-16))
    raise _not_found(plate, circles, diameters)


def _not_found(plate: AnnularPlate, circles: int, diameters: int) -> ModeNotFoundError:
    named, share = f"mode ({circles}, {diameters})", f"{plate.a / plate.b:.2g}"
    return ModeNotFoundError(f"{named} is not found: the hole, a/b = {share}, is too small")


# --- Rayleigh and Ritz ----------------------------------------------------------------------------
def ritz_wave_numbers(plate: AnnularPlate, diameters: int, count: int, finer: int = 1) -> Vector:
    """The `count` lowest wave numbers with `diameters` nodal diameters, 1/m, from the energies.

    Trial shapes (r - a)^2 P_j(r) with Jacobi polynomials that are nearly orthogonal in the mass,
    `finer` times as many as do for a plate with a hole of some size. The k-th value of a Ritz
    computation lies above the k-th of the plate, so the order of the values counts the modes.
    """
    from scipy.linalg import eigh

    terms = finer * (2 * count + EXTRA_TERMS + diameters // 2)
    stiffness, mass = _ritz_matrices(plate, diameters, terms)
    # mass x = mu stiffness x: the largest mu, the lowest modes, are the accurate ones.
    reciprocals = eigh(mass, stiffness, eigvals_only=True)[::-1][:count]
    found: Vector = reciprocals**-0.25
    return found


def _ritz_matrices(plate: AnnularPlate, diameters: int, terms: int) -> tuple[Matrix, Matrix]:
    """Bending energy / D* and mass / (rho h), both over r dr, of the trial shapes."""
    r, weights = _quadrature(plate, terms)
    value, slope, curvature = _trial_shapes(plate, r, terms)
    n2 = float(diameters**2)
    ring = slope / r - n2 * value / r**2  # the part of the Laplacian besides the curvature
    twist = slope / r - value / r**2
    laplacian = curvature + ring
    weight = weights * r
    stiffness = (laplacian * weight) @ laplacian.T
    mixed = (curvature * weight) @ ring.T
    stiffness -= (1.0 - plate.nu) * (mixed + mixed.T - 2.0 * n2 * (twist * weight) @ twist.T)
    return stiffness, (value * weight) @ value.T


def _trial_shapes(plate: AnnularPlate, r: Vector, terms: int) -> tuple[Matrix, Matrix, Matrix]:
    """(1 + x)^2 P_j^(0,4)(x) and two derivatives with respect to r; shape (terms, len(r))."""
    from scipy.special import eval_jacobi

    half = 0.5 * (plate.b - plate.a)
    x = (r - plate.a) / half - 1.0
    u, degrees = 1.0 + x, np.arange(terms)[:, None]
    p = eval_jacobi(degrees, 0, 4, x)
    p1 = 0.5 * (degrees + 5) * _lower(degrees - 1, 1, x)
    p2 = 0.25 * (degrees + 5) * (degrees + 6) * _lower(degrees - 2, 2, x)
    value, slope = u**2 * p, 2 * u * p + u**2 * p1
    curvature = 2 * p + 4 * u * p1 + u**2 * p2
    norm = np.sqrt((2.0 * degrees + 5.0) / 32.0)
    return value * norm, slope * norm / half, curvature * norm / half**2


def _lower(degrees: NDArray[np.int64], by: int, x: Vector) -> Matrix:
    """Jacobi polynomials of the derivatives of P^(0,4); zero where the degree is negative."""
    from scipy.special import eval_jacobi

    found: Matrix = np.where(degrees >= 0, eval_jacobi(np.maximum(degrees, 0), by, 4 + by, x), 0.0)
    return found
