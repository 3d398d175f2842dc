"""Damaged datasets and mutated cases, thrown at the commands in this process, under limits.

``python attacks.py datasets|cases SEED FIRST COUNT`` prints a line of JSON for each attack whose
exit code, time or memory was out of bounds, and at the end a count of the exit codes. Every attack
depends on the seed and its number alone.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import random
import resource
import shutil
import signal
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from fiv_cli.cli.main import run as fiv

SECONDS = 10  # that no command may take
MEMORY = 1024**3  # bytes that no command may take

START = '[[initial]]\nlabel = "fast"\nkind = "state"\nstate = { x_dot = "v" }\n'
BELT = f"""
schema = 1
title = "a belt"
[model]
name = "belt-1dof"
parameters = {{ c = 0.1 }}
[grid]
v = [0.5, 1.0, 1.5]
mu_k = [0.2, 0.3]
{START}"""
CLAIMS = """
[[claim]]
source = "here"
text = "it slides or not"
variable = "VARIABLE"
at = { v = ". >= 0.9" }
expect = EXPECT
holds = 0.5
"""
CASES = {
    "response": BELT
    + '[[analysis]]\nkind = "response"\nt_max = 60.0\n'
    + '[[figure]]\nkind = "curve"\nx = "v"\nvariable = ["L_s", "period"]\n'
    + 'select = { mu_k = 0.3 }\n[[figure]]\nkind = "bifurcation"\nx = "v"\n'
    + '[[figure]]\nkind = "map"\ntitle = "classes of $\\\\mu_k$"\n'
    + CLAIMS.replace("VARIABLE", "attractor").replace("EXPECT", '"periodic"')
    + CLAIMS.replace("VARIABLE", "section_value").replace("EXPECT", "{ less_than = 9 }"),
    "history": BELT
    + '[[analysis]]\nkind = "history"\nt_end = 10.0\nsample = 0.1\n'
    + '[[figure]]\nkind = "phase"\noverlay = true\n[[figure]]\nkind = "history"\n'
    + "select = { v = 1.0, mu_k = 0.2 }\n"
    + CLAIMS.replace("VARIABLE", "x").replace(
        "EXPECT", '{ less_than = 9 }\ntake = { over = "time", what = "spread" }'
    ),
    "linear": 'schema = 1\n[model]\nname = "flutter-2dof"\n'
    + "[grid]\nmu_k = { start = 3.0, stop = 5.0, num = 9 }\n"
    + '[[analysis]]\nkind = "eigenvalues"\n[[analysis]]\nkind = "equilibrium"\n'
    + CLAIMS.replace("VARIABLE", "stable")
    .replace("EXPECT", '"stable"')
    .replace("v = ", "mu_k = ")
    .replace("0.9", "4.5"),
    "refined": BELT
    + '[sweep]\nrefine = { levels = 1, along = ["v"] }\n'
    + '[[analysis]]\nkind = "response"\nt_max = 20.0\n'
    + CLAIMS.replace("VARIABLE", "attractor").replace(
        "EXPECT", '"increasing"\ntake = { what = "share", of = "periodic", over = ["mu_k"] }'
    ),
    "boundary": BELT.replace("v = [0.5, 1.0, 1.5]\n", "")
    + '[[analysis]]\nkind = "boundary"\nparameter = "v"\nbracket = [0.1, 3.0]\n'
    + 'scan = 3\nwidth = 0.5\nof = { variable = "attractor", expect = "periodic" }\nt_max = 40.0\n',
    "cycles": BELT
    + '[[analysis]]\nkind = "response"\nt_max = 60.0\n[[analysis]]\nkind = "cycle"\n'
    + '[[figure]]\nkind = "bifurcation"\nx = "v"\nselect = { mu_k = 0.3 }\n',
    "branch": BELT.replace("v = [0.5, 1.0, 1.5]\n", "")
    + '[[analysis]]\nkind = "cycle"\nparameter = "v"\nbracket = [0.5, 1.5]\nwidth = 1e-2\n',
}


# --- the ground -----------------------------------------------------------------------------------
def prepare(folder: Path) -> None:
    """A sound dataset of each case, with its journal, in `folder`."""
    os.chdir(folder)
    for name, text in CASES.items():
        Path(f"{name}.toml").write_text(text)
        code, said, _, _ = called(["run", f"{name}.toml", "--workers", "1", "-q"])
        assert code in (0, 4), f"{name}: {code} {said}"
        Path(f"sweep-{name}").mkdir(exist_ok=True)
        shutil.copyfile(f"{name}.toml", f"sweep-{name}/case.toml")
        shutil.copyfile(f"runs/{name}.nc", f"whole-{name}.nc")


def called(arguments: Sequence[str]) -> tuple[int, str, float, int]:
    """Exit code, what was said, seconds and bytes of one command."""
    said = io.StringIO()
    begun, before = time.monotonic(), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    signal.alarm(3 * SECONDS)
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        code = fiv(arguments)
    signal.alarm(0)
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    return code, said.getvalue(), time.monotonic() - begun, 1024 * grown


def limit_memory() -> None:
    """Let nothing be allocated far beyond what is allowed."""
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    most = pages * resource.getpagesize() + MEMORY
    resource.setrlimit(resource.RLIMIT_AS, (most, most))


# --- damage to bytes ------------------------------------------------------------------------------
def flip_bits(path: Path, rng: random.Random) -> None:
    content = bytearray(path.read_bytes())
    for _ in range(rng.choice((1, 1, 3, 30))):
        content[rng.randrange(len(content))] ^= 1 << rng.randrange(8)
    path.write_bytes(content)


def truncate(path: Path, rng: random.Random) -> None:
    content = path.read_bytes()
    path.write_bytes(content[: rng.randrange(len(content))])


def overwrite(path: Path, rng: random.Random) -> None:
    content = bytearray(path.read_bytes())
    at, length = rng.randrange(len(content)), rng.choice((4, 8, 64, 512))
    content[at : at + length] = rng.choice((bytes(length), b"\xff" * length, rng.randbytes(length)))
    path.write_bytes(content)


def replace_file(path: Path, rng: random.Random) -> None:
    path.write_bytes(rng.choice((b"", b"\x89HDF\r\n\x1a\n", b"CDF\x01" + bytes(60), b"schema = 1")))


# --- damage to what stands in the file ------------------------------------------------------------
TEXTS = ("", "x", "ok", "a b c", "[", '{"a": 3}', "[[]]", "schema = ", "\x1b[31m", "$\\mu_k^$", "1",
         "mu_k", "../../x", "a" * 60_000, "=" * 3, "NaN", "m s-1 kg", "\u00b2", "-1", "section_obs",
         '[{"name": "../x", "kind": "curve", "settings": {}}]',
         '[{"name": "x", "kind": "no", "settings": {}}]',
         '[{"name": "x", "kind": "curve", "settings": {"xlim": 3}}]',
         '[{"name": "x", "kind": "curve", "settings": {"x": "no", "select": {"v": "12 kg"}}}]',
         '[{"name": "x", "kind": "map", "settings": {"level": [1e308], "variable": "status"}}]',
         '[{"name": "x", "kind": "map", "settings": {"share": {"of": "up", "over": ["v"]}}}]',
         '[{"name": "x", "kind": "phase", "settings": {"window": [1, 0], "contact": 7}}]',
         '[{"name": "x", "kind": "curve", "settings": {"log": true, "ylim": [-1, "3 kg"]}}]',
         '[{"name": "x", "kind": "spectrogram", "settings": {"resolution": "0 Hz"}}]')  # fmt: skip
NUMBERS = (0, -1, 3, 127, 2**31 - 1, -(2**31), 1e308, -1e308, 5e-324, float("nan"), float("inf"))


def attribute_value(rng: random.Random) -> Any:
    values: list[Any] = [*TEXTS, *NUMBERS]
    values += [np.array([], np.int8), np.arange(3), np.array([1.5, 2.5]), np.bytes_(b"\xff\xfe")]
    values += [np.array([b"a", b"b"]), np.int8(3), np.float64(2.5)]
    values += [h5py.Empty("S1"), h5py.Empty("f8")]
    return values[rng.randrange(len(values))]


def variables(file: h5py.File) -> list[h5py.Dataset]:
    found: list[h5py.Dataset] = []
    file.visititems(lambda _, node: found.append(node) if isinstance(node, h5py.Dataset) else None)
    return found


def edit_attribute(file: h5py.File, rng: random.Random) -> None:
    node = file if rng.random() < 0.4 else rng.choice(variables(file))
    names = list(node.attrs)
    if not names:
        return
    name = rng.choice(names)
    if rng.random() < 0.3:
        del node.attrs[name]
    else:
        node.attrs[name] = attribute_value(rng)


def edit_known_attribute(file: h5py.File, rng: random.Random) -> None:
    """One that something is read from."""
    names = ("case", "title", "reference", "figures_json", "analyses_json", "overrides", "law",
             "parameters_json", "starts_json", "solver_json", "options_json", "refined_of",
             "points_run", "sample_size", "fingerprint")  # fmt: skip
    file.attrs[rng.choice(names)] = attribute_value(rng)


def edit_flags(file: h5py.File, rng: random.Random) -> None:
    node = rng.choice([v for v in variables(file) if "flag_values" in v.attrs])
    values, names = node.attrs["flag_values"], node.attrs["flag_meanings"].decode().split()
    choice = rng.randrange(6)
    if choice == 0:
        node.attrs["flag_values"] = values[:-1]
    elif choice == 1:
        node.attrs["flag_meanings"] = " ".join(names[:-1])
    elif choice == 2:
        rng.shuffle(names)
        node.attrs["flag_meanings"] = " ".join(names)
    elif choice == 3:
        node.attrs["flag_values"] = values[::-1]
    elif choice == 4:
        node.attrs["flag_values"] = np.zeros_like(values)
    else:
        node[...] = rng.choice((-128, -1, 99, 127))


def edit_values(file: h5py.File, rng: random.Random) -> None:
    nodes = [v for v in variables(file) if v.size and v.dtype.kind in "fiS"]
    node = rng.choice(nodes)
    content = node[...]
    if node.dtype.kind == "S":
        content.flat[rng.randrange(content.size)] = rng.choice((b"\xff", b"\x1b", b"", b"$", b"\\"))
    else:
        where = slice(None) if rng.random() < 0.3 else rng.randrange(content.size)
        with np.errstate(all="ignore"):
            wanted = np.float64(rng.choice(NUMBERS))
            content.flat[where] = wanted if node.dtype.kind == "f" else np.nan_to_num(wanted) % 256
    node[...] = content


def edit_rows(file: h5py.File, rng: random.Random) -> None:
    nodes = [v for v in variables(file) if "sample_dimension" in v.attrs]
    if not nodes:
        return edit_values(file, rng)
    node = rng.choice(nodes)
    content = node[...]
    if rng.random() < 0.3:
        node.attrs["sample_dimension"] = attribute_value(rng)
        return None
    content.flat[rng.randrange(content.size)] = rng.choice((-1, -(2**31), 2**31 - 1, 7, 0))
    if rng.random() < 0.5 and content.size > 1:  # the sum is right
        content.flat[-1] = int(node[...].sum()) - int(content[...].sum()) + int(content.flat[-1])
    node[...] = content
    return None


def remove_variable(file: h5py.File, rng: random.Random) -> None:
    del file[rng.choice(variables(file)).name]


def rename_variable(file: h5py.File, rng: random.Random) -> None:
    node = rng.choice(variables(file))
    other = rng.choice([*(v.name for v in variables(file)), "x", "status2", "$\\alpha^$"])
    name = node.name
    if other in file:
        if rng.random() < 0.5:
            file.move(name, f"{name}_away")
            file.move(other, name)
            file.move(f"{name}_away", other)
        return
    file.move(name, other)


def retype_variable(file: h5py.File, rng: random.Random) -> None:
    """The same attributes and dims with another type, or another number of dims."""
    node = rng.choice(variables(file))
    attributes, name, shape = dict(node.attrs), node.name, node.shape
    kind = rng.choice(("i1", "i4", "u8", "f4", "f8", "S3", "i8", "c16", "f2"))
    content = np.zeros(shape, kind)
    if rng.random() < 0.3:
        content = np.zeros(rng.choice(((), (3,), (0,), (2, 3), (1, 1, 1, 1))), kind)
    scale = node.is_scale
    del file[name]
    made = file.create_dataset(name, data=content)
    if scale:
        made.make_scale(name.split("/")[-1])
    for key, value in attributes.items():
        with contextlib.suppress(Exception):
            if key not in ("DIMENSION_LIST", "REFERENCE_LIST", "CLASS", "NAME", "_FillValue"):
                made.attrs[key] = value


def claim_a_size(file: h5py.File, rng: random.Random) -> None:
    """A variable of a size that nothing backs."""
    node = rng.choice(variables(file))
    name, attributes = node.name, dict(node.attrs)
    del file[name]
    shape = tuple(10 ** rng.randrange(3, 7) for _ in range(rng.choice((1, 2, 2, 3))))
    made = file.create_dataset(name, shape, "f8", chunks=tuple(min(s, 100) for s in shape))
    made.attrs.update({k: v for k, v in attributes.items() if k in ("units", "long_name")})


def edit_dims(file: h5py.File, rng: random.Random) -> None:
    node = rng.choice(
        [v for v in variables(file) if "DIMENSION_LIST" in v.attrs] or variables(file)
    )
    if rng.random() < 0.5 and "DIMENSION_LIST" in node.attrs:
        del node.attrs["DIMENSION_LIST"]
    else:
        node.attrs["_Netcdf4Dimid"] = np.int32(rng.choice((0, 1, -1, 99)))


def remove_group(file: h5py.File, rng: random.Random) -> None:
    groups = [name for name, node in file.items() if isinstance(node, h5py.Group)]
    if groups and rng.random() < 0.5:
        del file[rng.choice(groups)]
    else:
        file.create_group(rng.choice(("x", "status group", "a/b/c")))


BYTES = (flip_bits, flip_bits, truncate, overwrite, replace_file)
CONTENT = (edit_attribute, edit_known_attribute, edit_flags, edit_values, edit_rows,
           remove_variable, rename_variable, retype_variable, claim_a_size, edit_dims,
           remove_group)  # fmt: skip


def damage(path: Path, rng: random.Random) -> str:
    """Damage the dataset at `path` in one to three ways; says how."""
    if rng.random() < 0.25:
        way = rng.choice(BYTES)
        way(path, rng)
        return way.__name__
    ways = [rng.choice(CONTENT) for _ in range(rng.choice((1, 1, 1, 2, 3)))]
    for edit in ways:
        # the library itself may refuse an edit; the file is then as it was, or half edited
        with contextlib.suppress(Exception), h5py.File(path, "r+") as file:
            edit(file, rng)
    return " ".join(edit.__name__ for edit in ways)


def attacks_on_datasets(rng: random.Random) -> Iterator[tuple[str, list[str], set[int]]]:
    """(what was done, command line, exit codes that are right)."""
    name = rng.choice(list(CASES))
    bad, whole = Path("bad.nc"), Path(f"whole-{name}.nc")
    shutil.copyfile(whole, bad)
    how = f"{name}: {damage(bad, rng)}"
    right = {0, 2, 3, 5}
    yield how, ["show", *(["--json"] if rng.random() < 0.5 else []), "bad.nc"], right
    yield how, ["diff", *rng.sample(["bad.nc", str(whole)], 2)], right
    drawn = [] if rng.random() < 0.7 else ["--figure", rng.choice(KINDS)]
    yield how, ["plot", "bad.nc", *drawn], right
    if name in ("response", "branch"):
        other = f"whole-{'branch' if name == 'response' else 'response'}.nc"
        yield how, ["plot", "bad.nc", other, "--figure", "bifurcation"], right
    place = Path(f"runs/{name}.nc")
    shutil.copyfile(bad, place)
    yield how, ["claims", f"{name}.toml", "--strict"], right
    yield how, ["run", f"{name}.toml", "--workers", "1", "-q"], right | {4, 6}
    shutil.copyfile(whole, place)
    if rng.random() < 0.1:
        shutil.copyfile(bad, f"sweep-{name}/reference.nc")
        yield how, ["regress", f"sweep-{name}", "--workers", "1"], right


KINDS = ("map", "basin", "bifurcation", "curve", "eigenvalues", "history", "phase", "spectrum",
         "spectrogram", "mode-shape", "branch")  # fmt: skip


# --- mutated cases --------------------------------------------------------------------------------
SPLICES = ("[", "]", "{", "}", "=", ".", '"', "'", "\n", "#", "[[", "]]", ",", "a.b = 1\n", "\x00",
           "\x1b[2J", "1e999", "nan", "-inf", '"1 kg"', "1" * 400, "[[figure]]\n", "[grid]\n",
           "[[claim]]\n", '"$\\\\mu^$"', "mu_k", "v = [1, 2]\n", "true", "1979-05-27", "0x7f",
           '". == 0.3"', "friction.", "[sweep]\n", "zip = [['v', 'mu_k']]\n", "\u00b5", "\ud7ff",
           "x = " + "[" * 40, "a" + ".a" * 60 + " = 1\n", "schema = 2\n", "num = 9999999\n",
           )  # fmt: skip


def mutated(text: str, rng: random.Random) -> str:
    """`text` with one to six edits of lines and characters."""
    for _ in range(rng.choice((1, 1, 2, 3, 6))):
        lines = text.split("\n")
        i, j = rng.randrange(len(lines)), rng.randrange(len(lines))
        at = rng.randrange(len(text) + 1)
        edit = rng.randrange(8)
        if edit == 0:
            del lines[i]
        elif edit == 1:
            lines.insert(i, lines[j])
        elif edit == 2:
            lines[i], lines[j] = lines[j], lines[i]
        if edit < 3:
            text = "\n".join(lines)
        elif edit == 3:
            text = text[:at] + rng.choice(SPLICES) + text[at:]
        elif edit == 4:
            text = text[:at] + text[at + rng.randrange(1, 12) :]
        elif edit == 5:
            words = text.split(" ")
            place = rng.randrange(len(words))
            words[place] = rng.choice(SPLICES)
            text = " ".join(words)
        elif edit == 6:
            text = text[:at] + chr(rng.choice((9, 27, 34, 39, 127, 0x85, 0x202E, 0xE9))) + text[at:]
        else:
            k = rng.choice([k for k, c in enumerate(text) if c.isdigit()] or [0])
            number = rng.choice(("0", "-1", "1e9", "1e-300", "9" * 20, "inf"))
            text = text[:k] + number + text[k + 1 :]
    return text


def attacks_on_cases(rng: random.Random) -> Iterator[tuple[str, list[str], set[int]]]:
    """(what was done, command line, exit codes that are right)."""
    sources = sorted(Path(os.environ["FIV_ATTACK_CASES"]).glob("ch*/*.toml"))
    source = rng.choice(sources)
    text = mutated(source.read_text(encoding="utf-8"), rng)
    Path("bad.toml").write_text(text, encoding="utf-8", errors="replace")
    yield source.name, ["check", "bad.toml", *(["--json"] if rng.random() < 0.2 else [])], {0, 2, 3}


# --- the campaign ---------------------------------------------------------------------------------
def campaign(
    attacks: Callable[[random.Random], Iterator[tuple[str, list[str], set[int]]]],
    seed: int,
    numbers: range,
) -> None:
    """Carry out the attacks of these numbers; tell what was out of bounds, and count the rest."""
    codes: Counter[str] = Counter()
    longest = most = 0.0
    for number in numbers:
        for how, arguments, right in attacks(random.Random(f"{seed}/{number}")):
            print(f"{number} {arguments[0]}", file=sys.stderr, flush=True)
            code, said, seconds, grown = called(arguments)
            longest, most = max(longest, seconds), max(most, grown)
            codes[f"{arguments[0]} {code}"] += 1
            told = [line for line in said.splitlines() if "internal error" in line]
            if code not in right or seconds > SECONDS or grown > MEMORY or told:
                found = {"number": number, "how": how, "command": " ".join(arguments)}
                found |= {"code": code, "seconds": round(seconds, 1), "bytes": grown}
                print(json.dumps(found | {"said": said[-400:]}), flush=True)
    summary = {"codes": dict(sorted(codes.items())), "longest": round(longest, 2), "most": most}
    print(json.dumps({"summary": summary}), flush=True)


def main() -> None:
    what, seed, first, count = sys.argv[1], *map(int, sys.argv[2:5])
    # what every command needs is there before memory is counted
    import matplotlib.backends.backend_agg  # noqa: F401

    if what == "datasets":
        prepare(Path.cwd())
        called(["plot", "whole-response.nc", "-o", "first.png"])
    limit_memory()
    attacks = {"datasets": attacks_on_datasets, "cases": attacks_on_cases}[what]
    campaign(attacks, seed, range(first, first + count))


if __name__ == "__main__":
    main()
