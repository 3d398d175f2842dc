"""Datasets in the form that sweeps write, made by hand: what figures and claims are tested on."""

from __future__ import annotations

import json
import tomllib

import numpy as np
import xarray as xr

STATUS = ("ok", "pending", "failed", "budget", "not_reached", "not_computed")
ATTRACTORS = (
    *("equilibrium", "periodic", "quasiperiodic", "chaotic", "undecided", "diverged"),
    "contact_lost",
)
CONTACT_STATES = ("slip+", "slip-", "stick", "separation")


def flag(names, units="1"):
    """Attributes of a flag variable that is -1 where nothing was computed."""
    return {
        "units": units,
        "flag_values": np.arange(-1, len(names), dtype=np.int8),
        "flag_meanings": " ".join(["not_computed", *names]),
    }


def status_flag():
    """Attributes of ``status``, which always says something."""
    return {
        "units": "1",
        "long_name": "whether the point was computed",
        "flag_values": np.arange(len(STATUS), dtype=np.int8),
        "flag_meanings": " ".join(STATUS),
    }


def codes(table, names):
    """Flag values of an array of names."""
    lookup = {name: code for code, name in enumerate(table)} | {"not_computed": -1}
    return np.vectorize(lookup.__getitem__, otypes=[np.int8])(np.asarray(names))


def read_figures(text):
    """The figures of a case as a dataset holds them: named, their settings apart."""
    tables = tomllib.loads(text).get("figure", [])
    kinds = [table["kind"] for table in tables]
    return [
        {
            "name": table.get(
                "name", kind + (f"-{1 + kinds[:i].count(kind)}" if i and kind in kinds[:i] else "")
            ),
            "kind": kind,
            "settings": {k: v for k, v in table.items() if k not in ("kind", "name")},
        }
        for i, (table, kind) in enumerate(zip(tables, kinds, strict=True))
    ]


def attributes(figures="", title="A sweep", reference="Figure 7.6"):
    """Global attributes of a dataset."""
    return {
        "title": title,
        "reference": reference,
        "model": "pin-on-disc",
        "law": "coulomb",
        "case": f'schema = 1\ntitle = "{title}"\n{figures}',
        "figures_json": json.dumps(read_figures(figures)),
    }


def axis(name, values, symbol, units, long_name):
    """A numeric axis of the grid."""
    return (
        name,
        np.asarray(values, float),
        {"symbol": symbol, "units": units, "long_name": long_name},
    )


def response(attractor, L_s, coords, dims, status=None, rows=None, **given):
    """A response dataset.

    attractor: names over the dims; rows: section values of each point in C order, a list of lists.
    """
    attractor = np.asarray(attractor)
    status = np.full(attractor.shape, "ok") if status is None else np.asarray(status)
    variables = {
        "status": (dims, codes(STATUS, status), status_flag()),
        "attractor": (
            dims,
            codes(ATTRACTORS, attractor),
            flag(ATTRACTORS) | {"long_name": "class of the steady state"},
        ),
        "L_s": (dims, np.asarray(L_s, float), {"units": "rad2", "symbol": "L_s"}),
    }
    if rows is not None:
        sizes = np.array([len(row) for row in rows], np.int32).reshape(attractor.shape)
        values = np.array([value for row in rows for value in row], float)
        variables["section_row_size"] = (
            dims,
            sizes,
            {"sample_dimension": "section_obs", "units": "1"},
        )
        variables["section_value"] = (
            ("section_obs",),
            values,
            {"units": "rad", "long_name": "phi at the section"},
        )
    return xr.Dataset(variables | given, coords, attributes())


def bifurcation():
    """phi at the section against Omega for two starts: one point failed, one undecided."""
    omega = np.linspace(0.5, 5.0, 46)
    attractor = np.full((46, 2), "periodic", dtype=object)
    attractor[30:, 0] = "equilibrium"
    attractor[10, 1] = "undecided"
    status = np.full((46, 2), "ok", dtype=object)
    status[20, 1] = "failed"
    attractor[20, 1] = "not_computed"
    L_s = np.stack([np.where(omega < 3.5, 1e-4 * omega, 0.0), 2e-4 * omega], axis=-1)
    L_s[20, 1] = np.nan
    rows = [
        _section_points(o, k, c)
        for o, pair in zip(omega, attractor, strict=True)
        for k, c in enumerate(pair)
    ]
    return response(
        attractor,
        L_s,
        {
            "Omega": axis("Omega", omega, r"\Omega", "rad s-1", "disc speed"),
            "initial": ("initial", np.array(["near", "far"])),
        },
        ("Omega", "initial"),
        status,
        rows,
    )


def _section_points(omega, start, attractor):
    if attractor in ("equilibrium", "not_computed"):
        return []
    base = 0.03 + 0.002 * omega + 0.01 * start
    return [base, base + 0.004 * omega] if omega > 2.0 else [base]


def stability_map(initial=("reached", "exists"), nx=21, ny=17):
    """Attractor over Omega and N0, for two starts; a corner was not computed."""
    omega, preload = np.linspace(0.5, 10.0, nx), np.linspace(2.0, 50.0, ny)
    x, y = np.meshgrid(omega, preload, indexing="ij")
    periodic = np.stack([x < (1 + k) * y / 10.0 for k in range(len(initial))], axis=-1)
    attractor = np.where(periodic, "periodic", "equilibrium").astype(object)
    attractor[0, 0] = "undecided"
    status = np.full(attractor.shape, "ok", dtype=object)
    status[-3:, -2:] = "not_reached"
    attractor[-3:, -2:] = "not_computed"
    L_s = np.where(periodic, (x * y)[..., None] * 1e-5, 0.0)
    L_s[-3:, -2:] = np.nan
    return response(
        attractor,
        L_s,
        {
            "Omega": axis("Omega", omega, r"\Omega", "rad s-1", "disc speed"),
            "N0": axis("N0", preload, "N_0", "N", "normal preload"),
            "initial": ("initial", np.array(initial)),
        },
        ("Omega", "N0", "initial"),
        status,
    )


def history(labels=("far", "near"), omega=9.0, t_end=8.0, sample=0.01):
    """Motions with stick, one per label; the last sample lies off the raster."""
    time = np.append(np.arange(0.0, t_end, sample), t_end + 0.3 * sample)
    amplitude = np.array([1.0, 0.3])[: len(labels), None]
    phi = 0.02 + 0.01 * amplitude * np.cos(omega * time)
    phi_dot = -0.01 * omega * amplitude * np.sin(omega * time)
    sticking = phi_dot > 0.05 * amplitude
    states = np.where(sticking, 2, np.where(phi_dot < -0.08, 1, 0)).astype(np.int8)
    dims = ("initial", "time")
    ok = np.zeros(len(labels), np.int8)
    return xr.Dataset(
        {
            "status": (("initial",), ok, status_flag()),
            "phi": (dims, phi, {"units": "rad", "symbol": r"\varphi", "long_name": "rotation"}),
            "phi_dot": (dims, phi_dot, {"units": "rad s-1", "symbol": r"\dot{\varphi}"}),
            "theta": (dims, -0.5 * phi, {"units": "rad", "symbol": r"\theta"}),
            "theta_dot": (dims, -0.5 * phi_dot, {"units": "rad s-1", "symbol": r"\dot{\theta}"}),
            "F_T": (dims, 6.0 + 0 * phi, {"units": "N", "symbol": "F_T"}),
            "contact_state": (dims, states, flag(CONTACT_STATES)),
        },
        {
            "time": ("time", time, {"units": "s", "symbol": "t", "long_name": "time"}),
            "initial": ("initial", np.array(labels)),
        },
        attributes(title="Two motions", reference="Figure 7.2"),
    )


def spectra(labels=("near", "far"), points=12):
    """Spectra of x along mu_k: a line at 25 Hz, an eigenfrequency that grows from 0.5 on; one point
    diverged."""
    mu, frequency = np.linspace(0.1, 1.2, points), np.linspace(0.0, 40.0, 81)
    dims = ("mu_k", "initial")
    amplitude = np.zeros((points, len(labels), frequency.size))
    amplitude[:, :, 50] = 1e-3 * mu[:, None]
    amplitude[:, :, 10] = 1e-5
    attractor = np.full((points, len(labels)), "periodic", dtype=object)
    if points > 1:
        amplitude[-1, 0], attractor[-1, 0] = np.nan, "diverged"
    growing = np.stack([np.where(mu > 0.5, 20.0 + mu, np.nan), np.full(points, np.nan)], axis=-1)
    growing = np.repeat(growing[:, None], len(labels), axis=1)
    return xr.Dataset(
        {
            "status": (dims, np.zeros((points, len(labels)), np.int8), status_flag()),
            "attractor": (dims, codes(ATTRACTORS, attractor), flag(ATTRACTORS)),
            "amplitude": (
                (*dims, "frequency"),
                amplitude,
                {"units": "m", "long_name": "amplitude of x"},
            ),
            "unstable_frequency": ((*dims, "mode"), growing, {"units": "Hz"}),
        },
        {
            "mu_k": axis("mu_k", mu, r"\mu_k", "1", "coefficient of kinetic friction"),
            "initial": ("initial", np.array(labels)),
            "frequency": ("frequency", frequency, {"units": "Hz", "long_name": "frequency"}),
        },
        attributes(title="Spectra", reference="Figure 6.18"),
    )


def crossings():
    """A jump everywhere and, but for the last point, two roots behind it."""
    ratio = np.array([5.0, 10.0, 20.0])
    value = np.stack([0.3 * ratio, 0.31 * ratio, 0.4 * ratio], axis=-1)
    kind = np.array([["jump", "root", "root"]] * 3, dtype=object)
    direction = np.array([["to_stable", "to_unstable", "to_stable"]] * 3, dtype=object)
    value[2, 1:], kind[2, 1:], direction[2, 1:] = np.nan, "not_computed", "not_computed"
    dims, kinds, ways = ("R", "crossing"), ("root", "jump", "end"), ("to_stable", "to_unstable")
    named = {"units": "N", "long_name": "critical value of A_b"}
    return xr.Dataset(
        {
            "status": (("R",), codes(STATUS, ["ok"] * 3), status_flag()),
            "critical_value": (dims, value, named),
            "crossing_kind": (dims, codes(kinds, kind), flag(kinds)),
            "crossing_direction": (dims, codes(ways, direction), flag(ways)),
            "crossing_mode": (dims, np.full((3, 3), 2, np.int32)),
        },
        {"R": axis("R", ratio, "R", "1", "frequency ratio")},
        attributes(title="Suppression", reference="Figure 5.6"),
    )


def boundaries():
    """Stick-slip ends in an equilibrium; at the last point in something undecided."""
    preload = np.array([20.0, 30.0, 40.0])
    dims, below = ("N0", "crossing"), np.full((3, 1), "periodic", dtype=object)
    above = np.array([["equilibrium"], ["equilibrium"], ["undecided"]], dtype=object)
    named = {"units": "rad s-1", "long_name": "Omega at which the answer changes"}
    width = np.array([[0.5], [0.5], [2.0]])
    return xr.Dataset(
        {
            "status": (("N0",), codes(STATUS, ["ok"] * 3), status_flag()),
            "boundary": (dims, np.array([[4.0], [7.0], [10.0]]), named),
            "boundary_width": (dims, width, {"units": "rad s-1", "long_name": "width"}),
            "class_below": (dims, codes(ATTRACTORS, below), flag(ATTRACTORS)),
            "class_above": (dims, codes(ATTRACTORS, above), flag(ATTRACTORS)),
        },
        {"N0": axis("N0", preload, "N_0", "N", "normal preload")},
        attributes(title="Existence of stick-slip"),
    )


def eigenvalues():
    """Two modes that lock in at mu_k = 0.5; one point was not computed."""
    mu = np.linspace(0.0, 1.0, 41)
    gap = np.sqrt(np.clip(0.5 - mu, 0, None))
    growth = np.sqrt(np.clip(mu - 0.5, 0, None))
    real = np.stack([growth, growth, -growth, -growth], axis=-1) - 0.05
    imag = np.stack([5 + gap, -5 - gap, 5 - gap, gap - 5], axis=-1)
    real[7] = imag[7] = np.nan
    status = np.full(mu.shape, "ok", dtype=object)
    status[7] = "failed"
    dims = ("mu_k", "mode")
    return xr.Dataset(
        {
            "status": (("mu_k",), codes(STATUS, status), status_flag()),
            "eigenvalue_real": (
                dims,
                real,
                {"units": "rad s-1", "long_name": "real part of the eigenvalue"},
            ),
            "eigenvalue_imag": (dims, imag, {"units": "rad s-1"}),
            "mode_frequency": (
                dims,
                np.abs(imag) / (2 * np.pi),
                {"units": "Hz", "long_name": "frequency of the mode"},
            ),
            "growth_rate": (("mu_k",), real.max(axis=-1), {"units": "rad s-1"}),
        },
        {"mu_k": axis("mu_k", mu, r"\mu_k", "1", "coefficient of kinetic friction")},
        attributes(title="Flutter", reference="Figure 5.3"),
    )
