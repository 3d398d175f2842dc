"""What tests of figures share: small datasets, and what is drawn of them."""

import numpy as np
import synthetic_datasets as data
import xarray as xr
from click.testing import CliRunner
from matplotlib.colors import to_hex

from fiv_cli.case.case import FigureSpec

AT_A_JUMP = "a mode turns stable, at a jump"
SLIP_PLUS, SLIP_MINUS = r"slip+ ($v_\mathrm{rel} > 0$)", r"slip$-$ ($v_\mathrm{rel} < 0$)"
REST_ABOVE = "periodic below, equilibrium above"
UNDECIDED_ABOVE = "periodic below, undecided above"


def figure(kind, **settings):
    return FigureSpec(kind, kind, settings)


def marks(ax, label):
    """Points of the line with this label, shape (n, 2)."""
    (line,) = [line for line in ax.lines if line.get_label() == label]
    return line.get_xydata()


def legend_texts(owner):
    """Entries of the legend of a panel or, where it has none of its own, of the figure."""
    own = None if hasattr(owner, "legends") else owner.get_legend()
    return [text.get_text() for text in (own or owner.figure.legends[0]).get_texts()]


def marked(drawn):
    """Size of the first marks that are there."""
    return next(line.get_markersize() for line in drawn.axes[0].lines if len(line.get_xdata()))


def resting():
    """`bifurcation`, with where the motions rest: at 0.01 rad per rad/s, above 3.5 rad/s."""
    dataset = data.bifurcation()
    extreme = 0.01 * dataset["Omega"] * xr.ones_like(dataset["L_s"])
    return dataset.assign(phi_max=extreme.transpose("Omega", "initial"))


def branch_along_the_speed(parameter="Omega", preloads=(30.0,)):
    """The dataset of branches that turn unstable at 2.2 rad/s, one for each preload."""
    count, of_branch, of_ends = len(preloads), "branch_obs", "cycle_end_obs"
    value = np.tile([3.0, 2.0, 1.5, 1.0], count)
    stable = ["stable", "unstable", "unstable", "unstable"] * count
    sizes = np.full((count, 1), 4, np.int32)
    return xr.Dataset(
        {
            "status": data.statuses(("N0", "initial"), np.full((count, 1), "ok")),
            "branch_row_size": (("N0", "initial"), sizes, {"sample_dimension": of_branch}),
            "section_row_size": (("N0", "initial"), 0 * sizes, {"sample_dimension": "section_obs"}),
            "section_value": ("section_obs", np.zeros(0), {"long_name": "phi at the section"}),
            "branch_value": (of_branch, value, {"long_name": f"{parameter} along the branch"}),
            "branch_min": (of_branch, 0.0 * value, {"long_name": "least phi of the cycle"}),
            "branch_max": (of_branch, value, {"long_name": "greatest phi of the cycle"}),
            "branch_stable": data.flags(of_branch, stable, ("unstable", "stable")),
            "cycle_end_row_size": (("N0", "initial"), sizes // 2, {"sample_dimension": of_ends}),
            "cycle_end": (of_ends, np.tile([3.5, 2.2], count), {"units": "rad s-1"}),
        },
        data.axes(N0=list(preloads), initial=["followed"]),
        data.attributes(),
    )


def dashed(ax, dashes="--"):
    """What is drawn so; not what stands for it in the legend."""
    lines = [line for line in ax.lines if line.get_linestyle() == dashes]
    return [line.get_xydata() for line in lines if len(line.get_xdata())]


def crossing_lines(**heights):
    """A curve for each start, a straight line from one height to another."""
    omega = data.bifurcation()["Omega"].values
    share = (omega - omega[0]) / np.ptp(omega)
    lines = [begin + (end - begin) * share for begin, end in heights.values()]
    dataset = data.bifurcation().drop_dims("section_obs").drop_vars("section_row_size")
    dataset = dataset.isel(initial=[0] * len(lines))
    dataset = dataset.assign_coords(initial=[*heights])
    dataset["L_s"] = dataset["L_s"].copy(data=np.stack(lines, axis=-1))
    return dataset.assign(attractor=dataset["attractor"] * 0 + 1, status=dataset["status"] * 0)


def corners(ax, colour):
    """Corners (x, y) of every line drawn in a colour, shape (n, 2)."""
    drawn = [c for c in ax.collections if to_hex(c.get_edgecolor()[0]) == colour.lower()]
    return np.concatenate([path.vertices for c in drawn for path in c.get_paths()])


def run(command, *arguments):
    result = CliRunner().invoke(command, [str(argument) for argument in arguments])
    if result.exception and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result
