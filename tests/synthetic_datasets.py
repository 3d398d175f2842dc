"""Datasets in the form that sweeps write, made by hand: what figures and claims are tested on."""

from __future__ import annotations

import json
from dataclasses import asdict

import numpy as np
import xarray as xr

from fiv_cli.case.case import ClaimSpec
from fiv_cli.case.grammar import parse_expect
from fiv_cli.reading.claims import evaluate

STATUS = ("ok", "pending", "failed", "budget", "not_reached", "not_computed")
ATTRACTORS = (
    *("equilibrium", "periodic", "quasiperiodic", "chaotic", "undecided", "diverged"),
    "contact_lost",
)
CONTACT_STATES = ("slip+", "slip-", "stick", "separation")
# Symbol, unit and meaning of the axes.
AXES = {
    "Omega": (r"\Omega", "rad s-1", "disc speed"),
    "N0": ("N_0", "N", "normal preload"),
    "psi_a": (r"\psi_a", "rad", "start of the sector"),
    "mu_k": (r"\mu_k", "1", "coefficient of kinetic friction"),
    "R": ("R", "1", "frequency ratio"),
}


def claim(variable, expect, at=None, holds="all", analysis="", take=None):
    """What a case claims of a variable."""
    expected = parse_expect(expect)
    take = take or {}
    return ClaimSpec("7.3", "as printed", variable, expected, at or {}, holds, "", analysis, take)


def tried(dataset, *arguments, other=None, **keywords):
    """What becomes of a claim about a dataset; `other` gives those of other cases."""
    return evaluate(claim(*arguments, **keywords), {"": dataset}, other)


def axes(**values):
    """Coordinates of a grid, the labels of its starts called ``initial``."""
    words = ("symbol", "units", "long_name")
    known = {name: dict(zip(words, told, strict=True)) for name, told in AXES.items()}
    return {n: (n, np.asarray(points), known.get(n, {})) for n, points in values.items()}


def codes(table, names):
    """Flag values of an array of names."""
    lookup = {name: code for code, name in enumerate(table)} | {"not_computed": -1}
    return np.vectorize(lookup.__getitem__, otypes=[np.int8])(np.asarray(names))


def flags(dims, names, table, **attributes):
    """A flag variable that is -1 where nothing was computed."""
    named = {
        "units": "1",
        "flag_values": np.arange(-1, len(table), dtype=np.int8),
        "flag_meanings": " ".join(["not_computed", *table]),
    }
    return dims, codes(table, names), named | attributes


def statuses(dims, names):
    """``status``, which always says something."""
    named = {
        "units": "1",
        "long_name": "whether the point was computed",
        "flag_values": np.arange(len(STATUS), dtype=np.int8),
        "flag_meanings": " ".join(STATUS),
    }
    return dims, codes(STATUS, names), named


def attributes(*figures, title="A sweep", reference="Figure 7.6"):
    """Global attributes of a dataset."""
    return {
        "title": title,
        "reference": reference,
        "model": "pin-on-disc",
        "law": "coulomb",
        "solver_json": json.dumps({"rtol": 1e-9}),
        "case": f'schema = 1\ntitle = "{title}"\n',
        "figures_json": json.dumps([asdict(figure) for figure in figures]),
    }


def response(attractor, L_s, coords, status="ok", rows=None, **given):
    """A response dataset over all of its coordinates.

    attractor: names; rows: section values of each point in C order, a list of lists.
    """
    attractor, dims = np.asarray(attractor), tuple(coords)
    variables = {
        "status": statuses(dims, np.broadcast_to(status, attractor.shape)),
        "attractor": flags(dims, attractor, ATTRACTORS, long_name="class of the steady state"),
        "L_s": (dims, np.asarray(L_s, float), {"units": "rad2", "symbol": "L_s"}),
    }
    if rows is not None:
        sizes = np.array([len(row) for row in rows], np.int32).reshape(attractor.shape)
        values = np.array([value for row in rows for value in row], float)
        of_rows = {"sample_dimension": "section_obs", "units": "1"}
        of_values = {"units": "rad", "long_name": "phi at the section"}
        variables["section_row_size"] = (dims, sizes, of_rows)
        variables["section_value"] = (("section_obs",), values, of_values)
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
    return response(attractor, L_s, axes(Omega=omega, initial=["near", "far"]), status, rows)


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
    return response(attractor, L_s, axes(Omega=omega, N0=preload, initial=initial), status)


def basin(count=200, speeds=(1.0, 2.0)):
    """Random starts in x and x_dot: within a circle of radius `speeds` they come to rest."""
    starts = np.random.default_rng(3).uniform(-3.0, 3.0, (len(speeds), count, 2))
    inside = np.hypot(*np.moveaxis(starts, -1, 0)) < np.array(speeds)[:, None]
    attractor = np.where(inside, "equilibrium", "periodic").astype(object)
    coords = axes(Omega=speeds, initial=[f"any-{number:03d}" for number in range(count)])
    dataset = response(attractor, np.zeros(attractor.shape), coords)
    dataset.attrs["starts_json"] = json.dumps({"any": "random"})
    dataset["initial_state"] = ((*coords, "state"), starts, {"units": "1"})
    units = ("state", ["m", "m s-1"])
    return dataset.assign_coords(state=["x", "x_dot"], state_units=units)


def history(labels=("far", "near"), omega=9.0, t_end=8.0, sample=0.01):
    """Motions with stick, one per label; the last sample lies off the raster."""
    time = np.append(np.arange(0.0, t_end, sample), t_end + 0.3 * sample)
    amplitude = np.array([1.0, 0.3])[: len(labels), None]
    phi = 0.02 + 0.01 * amplitude * np.cos(omega * time)
    phi_dot = -0.01 * omega * amplitude * np.sin(omega * time)
    sticking = phi_dot > 0.05 * amplitude
    states = np.where(sticking, "stick", np.where(phi_dot < -0.08, "slip-", "slip+"))
    dims = ("initial", "time")
    return xr.Dataset(
        {
            "status": statuses(("initial",), ["ok"] * len(labels)),
            "phi": (dims, phi, {"units": "rad", "symbol": r"\varphi", "long_name": "rotation"}),
            "phi_dot": (dims, phi_dot, {"units": "rad s-1", "symbol": r"\dot{\varphi}"}),
            "theta": (dims, -0.5 * phi, {"units": "rad", "symbol": r"\theta"}),
            "theta_dot": (dims, -0.5 * phi_dot, {"units": "rad s-1", "symbol": r"\dot{\theta}"}),
            "F_T": (dims, 6.0 + 0 * phi, {"units": "N", "symbol": "F_T"}),
            "contact_state": flags(dims, states, CONTACT_STATES),
            **ledger(time, states),
        },
        {
            "time": ("time", time, {"units": "s", "symbol": "t", "long_name": "time"}),
            **axes(initial=labels),
        },
        attributes(title="Two motions", reference="Figure 7.2"),
    )


def ledger(time, states):
    """Events midway between the samples at which each motion's contact state (a row) changes."""
    motion, sample = np.nonzero(states[:, 1:] != states[:, :-1])
    of_event = "event_obs"
    sizes = np.bincount(motion, minlength=len(states)).astype(np.int32)
    return {
        "event_row_size": ("initial", sizes, {"sample_dimension": of_event}),
        "event_time": (of_event, 0.5 * (time[sample] + time[sample + 1]), {"units": "s"}),
        "event_contact": (of_event, np.ones(motion.size), {"units": "1"}),
        "event_from": flags(of_event, states[motion, sample], CONTACT_STATES),
        "event_to": flags(of_event, states[motion, sample + 1], CONTACT_STATES),
    }


def spectra(labels=("near", "far"), points=12):
    """Spectra of x along mu_k: a line at 25 Hz, an eigenfrequency that grows from 0.5 on; one point
    diverged."""
    mu, frequency = np.linspace(0.1, 1.2, points), np.linspace(0.0, 40.0, 81)
    dims = ("mu_k", "initial")
    amplitude = np.zeros((points, len(labels), frequency.size))
    amplitude[:, :, 50] = 1e-3 * mu[:, None]
    amplitude[:, :, 10] = 1e-5
    attractor = np.full((points, len(labels)), "periodic", dtype=object)
    amplitude[-1, 0], attractor[-1, 0] = np.nan, "diverged"
    growing = np.stack([np.where(mu > 0.5, 20.0 + mu, np.nan), np.full(points, np.nan)], axis=-1)
    growing = np.repeat(growing[:, None], len(labels), axis=1)
    of_x = {"units": "m", "long_name": "amplitude of x"}
    return xr.Dataset(
        {
            "status": statuses(dims, np.full(attractor.shape, "ok")),
            "attractor": flags(dims, attractor, ATTRACTORS),
            "amplitude": ((*dims, "frequency"), amplitude, of_x),
            "unstable_frequency": ((*dims, "mode"), growing, {"units": "Hz"}),
        },
        {
            **axes(mu_k=mu, initial=labels),
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
    dims, named = ("R", "crossing"), {"units": "N", "long_name": "critical value of A_b"}
    return xr.Dataset(
        {
            "status": statuses(("R",), ["ok"] * 3),
            "critical_value": (dims, value, named),
            "crossing_kind": flags(dims, kind, ("root", "jump", "end")),
            "crossing_direction": flags(dims, direction, ("to_stable", "to_unstable")),
            "crossing_mode": (dims, np.full((3, 3), 2, np.int32)),
        },
        axes(R=ratio),
        attributes(title="Suppression", reference="Figure 5.6"),
    )


def boundaries():
    """Stick-slip ends in an equilibrium; at the last point in something undecided."""
    dims, rate = ("N0", "crossing"), {"units": "rad s-1"}
    above = [["equilibrium"], ["equilibrium"], ["undecided"]]
    place = rate | {"long_name": "Omega at which the answer changes"}
    return xr.Dataset(
        {
            "status": statuses(("N0",), ["ok"] * 3),
            "boundary": (dims, np.array([[4.0], [7.0], [10.0]]), place),
            "boundary_width": (dims, [[0.5], [0.5], [2.0]], rate | {"long_name": "width"}),
            "boundary_error": (dims, [[0.1], [0.2], [np.nan]], rate),
            "class_below": flags(dims, [["periodic"]] * 3, ATTRACTORS),
            "class_above": flags(dims, above, ATTRACTORS),
        },
        axes(N0=[20.0, 30.0, 40.0]),
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
    dims, rate = ("mu_k", "mode"), {"units": "rad s-1"}
    hertz = {"units": "Hz", "long_name": "frequency of the mode"}
    return xr.Dataset(
        {
            "status": statuses(("mu_k",), status),
            "eigenvalue_real": (dims, real, rate | {"long_name": "real part of the eigenvalue"}),
            "eigenvalue_imag": (dims, imag, rate),
            "mode_frequency": (dims, np.abs(imag) / (2 * np.pi), hertz),
            "growth_rate": (("mu_k",), real.max(axis=-1), rate),
        },
        axes(mu_k=mu),
        attributes(title="Flutter", reference="Figure 5.3"),
    )
