"""Any kinetic law, regularised at zero slip.

    F_T = tanh(sigma v) f(|v|) N,   f(|v|) = F_T / (sgn(v) N) of the law it regularises

Thesis 2.5 and chapter 5. There is no static coefficient and no stick: the contact creeps. It is
written ``law = "tanh"`` with ``of = "coulomb"`` (or another law) in a case file and named
``tanh of coulomb`` in datasets.
"""

from __future__ import annotations

from fiv_cli.friction.base import Law, Slip
from fiv_cli.models.base import Parameter

SIGMA = Parameter(
    "sigma", r"\sigma", "s m-1", 50.0, "steepness of the regularisation", "2.5", 0.0, exclusive=True
)


def regularised(law: Law) -> Law:
    """`law` with its sign function replaced by tanh(sigma v)."""

    parameters = tuple(p for p in law.parameters if p.name not in law.only_in_stick)
    kept = {parameter.name for parameter in parameters}

    def force(slip: Slip, p):  # type: ignore[no-untyped-def]
        import sympy

        one_sided = law.force(Slip(slip.speed, sympy.Integer(1), slip.speed, slip.N), p)
        return sympy.tanh(p["sigma"] * slip.v) * one_sided

    return Law(
        name=f"tanh of {law.name}",
        title=f"{law.title}, regularised by tanh",
        reference="thesis 2.5",
        numerics_version=1 + law.numerics_version,
        parameters=(*parameters, SIGMA),
        force=force,
        capacity=None,
        structural=law.structural,
        requirements=tuple(r for r in law.requirements if kept.issuperset(r.reads)),
        constant_load=law.constant_load,
        origin=law.origin,
    )
