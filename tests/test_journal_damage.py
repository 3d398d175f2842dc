"""Journals made by hand or damaged: refused as another case's, or their points are run again."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fiv_cli.cli.main import run as fiv
from fiv_cli.data.block import Block
from fiv_cli.data.netcdf import read_datasets
from fiv_cli.data.shard import read_shard, write_shard

CASE = """
schema = 1
[model]
name = "belt-1dof"
[grid]
v = [0.5, 1.0, 1.5]
[[initial]]
label = "fast"
kind = "state"
state = { x_dot = "v" }
[[initial]]
label = "up"
kind = "continue"
along = "v"
direction = "up"
from = "fast"
[[analysis]]
kind = "response"
t_max = 20.0
"""
RUN = ["run", "s.toml", "-o", "s.nc", "--workers", "1", "-q"]


@pytest.fixture(autouse=True)
def shards(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """The shards of a finished run, whose dataset is away."""
    monkeypatch.chdir(tmp_path)
    Path("s.toml").write_text(CASE)
    assert fiv(RUN) == 0
    Path("s.nc").rename("whole.nc")
    return sorted(Path("s.run/shards").glob("*.h5"))


def assert_whole() -> None:
    """The same command makes the same dataset."""
    assert fiv(RUN) == 0
    assert Path("s.nc").read_bytes() == Path("whole.nc").read_bytes()


@pytest.mark.parametrize(
    "document",
    ["3", '{"analyses": 3}', '{"analyses": null}', '{"analyses": []}', '{"model": {}}', "{}"],
)
def test_an_identity_made_by_hand_is_another_cases_or_none(document: str) -> None:
    Path("s.run/identity.json").write_text(document)
    expected = 0 if document == "3" else 6  # what is no table says nothing
    assert fiv(RUN) == expected
    assert fiv(["status", "s.toml", "-o", "s.nc"]) == 0
    assert fiv([*RUN, "--fresh"]) == 0


@pytest.mark.parametrize(
    "content", ["[" * 100_000, "", "\0", '"\ud800"'.encode("utf-8", "replace")]
)
def test_an_identity_that_cannot_be_read_says_nothing(content: Any) -> None:
    path = Path("s.run/identity.json")
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    assert_whole()


def test_a_pipe_in_the_place_of_a_file_is_not_waited_for(shards: list[Path]) -> None:
    shards[0].unlink()
    os.mkfifo(shards[0])
    assert_whole()


@pytest.mark.parametrize("name", ["\u00b2.h5", "\u0663.h5", "9" * 200 + ".h5", "x.h5"])
def test_a_shard_is_counted_by_plain_digits_only(shards: list[Path], name: str) -> None:
    shards[-1].rename(shards[-1].with_name(name))
    assert_whole()


def short_column(block: Block) -> Block:
    return replace(block, values={**block.values, "L_s": block.values["L_s"][:-1]})


def retyped_column(block: Block) -> Block:
    return replace(block, values={**block.values, "L_s": block.values["L_s"].astype("S8")})


def strange_status(block: Block) -> Block:
    return replace(block, status=np.full_like(block.status, 77))


def strange_reason(block: Block) -> Block:
    return replace(block, reason=np.full_like(block.reason, -4))


def strange_class(block: Block) -> Block:
    attractor = np.full_like(block.values["attractor"], 99)
    return replace(block, values={**block.values, "attractor": attractor})


def unknown_column(block: Block) -> Block:
    return replace(block, values={**block.values, "x_y_z": block.values["L_s"]})


def negative_rows(block: Block) -> Block:
    sizes = block.row_sizes["section"].copy()
    sizes[0] = -1
    return replace(block, row_sizes={"section": sizes})


def lost_rows(block: Block) -> Block:
    return replace(block, row_sizes={})


def short_keys(block: Block) -> Block:
    return replace(block, keys=block.keys[:, :31])


def rows_beyond(block: Block) -> Block:
    return replace(block, messages={99: "who is this?"})


def number_as_message(block: Block) -> Block:
    return replace(block, messages={0: 3})  # type: ignore[dict-item]


def strange_carry(block: Block) -> Block:
    return replace(block, carries={0: {"lost": "perhaps", "carry": 3, "attractor": None}})


def foreign_carry(block: Block) -> Block:
    return replace(block, carries={0: {"x": 1}})


@pytest.mark.parametrize(
    "change",
    [short_column, retyped_column, strange_status, strange_reason, strange_class, unknown_column,
     negative_rows, lost_rows, short_keys, rows_beyond, number_as_message, strange_carry,
     foreign_carry],
)  # fmt: skip
def test_a_shard_whose_checksum_is_right_and_whose_content_is_not(
    shards: list[Path], change: Callable[[Block], Block], capsys: pytest.CaptureFixture[str]
) -> None:
    block, name = read_shard(shards[0])
    write_shard(shards[0], change(block), name)
    assert fiv(["status", "s.toml", "-o", "s.nc", "--json"]) == 0
    (ignored,) = json.loads(capsys.readouterr().out)["ignored_shards"]
    assert ignored.startswith(str(shards[0]))
    assert_whole()


def test_a_folder_where_a_worker_beats_is_no_harm() -> None:
    for number in range(3):
        Path(f"s.run/.beat-{number}").mkdir()
    assert fiv([*RUN[:-3], "--workers", "2", "--fresh"]) == 0
    left, right = (read_datasets(Path(name))[""] for name in ("s.nc", "whole.nc"))
    assert left.equals(right)
