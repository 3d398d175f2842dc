"""A shard holds what was put in, or says that it does not."""

from __future__ import annotations

import zlib
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fiv_cli.analyses.base import Outcome
from fiv_cli.analyses.catalogue import variables_of
from fiv_cli.analyses.variables import INT_FILL
from fiv_cli.data.block import Block, joined, pack
from fiv_cli.data.shard import (
    BEFORE,
    DIGEST_BYTES,
    UnreadableShard,
    from_plain,
    read_shard,
    shard_parts,
    to_plain,
    write_shard,
)
from fiv_cli.errors import StorageError
from fiv_cli.flags import STATUS
from fiv_cli.models import get_model

VARIABLES = variables_of("response", get_model("belt-1dof"), {}, {})


def keys(count: int) -> list[bytes]:
    """Distinct keys."""
    return [bytes([i]) * 32 for i in range(count)]


def block() -> Block:
    """Three points: a full one, an empty one, a failed one."""
    full = Outcome(
        values={"attractor": "periodic", "L_s": 0.1, "n_steps": 7, "floquet_multiplier": [1.0]},
        ragged={"section_value": [0.3, 0.1]},
    )
    failed = Outcome("failed", "diverged", message="boom")
    carried = {2: {"carry": {"x": np.array([0.1, np.nan]), "phase": 0.2}, "lost": False}}
    return pack([full, Outcome(), failed], keys(3), VARIABLES, carried)


def assert_equal(left: Block, right: Block) -> None:
    """Two blocks hold the same."""
    for name in ("keys", "status", "reason"):
        np.testing.assert_array_equal(getattr(left, name), getattr(right, name))
    for name in ("values", "row_sizes", "ragged"):
        a, b = getattr(left, name), getattr(right, name)
        assert a.keys() == b.keys()
        for key in a:
            np.testing.assert_array_equal(a[key], b[key])
            assert a[key].dtype == b[key].dtype
    assert left.messages == right.messages


def test_a_coordinate_is_stored_once_where_its_points_share_it() -> None:
    """Of points that do not, as after another question, each keeps its own."""
    history = variables_of("history", get_model("belt-1dof"), {}, {})
    fine, coarse, odd = np.linspace(0, 1, 5), np.linspace(0, 1, 3), np.linspace(0, 2, 3)

    def of(*times: Any) -> Block:
        outcomes = [Outcome(values={"time": one, "x": 2 * np.array(one)}) for one in times]
        return pack(outcomes, keys(len(times)), history)

    assert of(fine, fine).values["time"].shape == (1, 5)
    rows = np.array([0, 3])
    same = joined([of(fine, fine), of(fine, fine)], rows, history)
    np.testing.assert_array_equal(same.values["time"], [fine])
    np.testing.assert_array_equal(of(coarse, odd).values["time"], [coarse, odd])
    apart = joined([of(coarse, coarse), of(odd, odd)], rows, history)
    np.testing.assert_array_equal(apart.values["time"], [coarse, odd])
    np.testing.assert_array_equal(apart.values["x"], [2 * coarse, 2 * odd])


def test_what_goes_in_comes_out(tmp_path: Path) -> None:
    path = tmp_path / "000001.h5"
    write_shard(path, block(), "response")
    back, analysis = read_shard(path)
    assert analysis == "response"
    assert_equal(back, block())
    np.testing.assert_array_equal(back.carries[2]["carry"]["x"], [0.1, np.nan])
    assert list(tmp_path.iterdir()) == [path]


def test_points_are_padded_with_what_means_not_computed() -> None:
    packed = block()
    assert packed.status.tolist() == [0, 0, 2]
    assert packed.values["attractor"].tolist() == [1, -1, -1]
    assert packed.values["n_steps"].tolist() == [7, INT_FILL, INT_FILL]
    np.testing.assert_array_equal(packed.values["L_s"], [0.1, np.nan, np.nan])
    assert packed.row_sizes["section"].tolist() == [2, 0, 0]
    assert "period" not in packed.values


def test_a_count_that_is_not_a_number_is_not_computed() -> None:
    outcome = Outcome(values={"multiplicity": float("nan"), "n_events": 3.0})
    packed = pack([outcome], keys(1), VARIABLES)
    assert packed.values["multiplicity"].tolist() == [INT_FILL]
    assert packed.values["n_events"].tolist() == [3]


def test_rows_given_as_a_value_fail_their_point() -> None:
    """They were dropped: what an analysis of one's own has computed was not there."""
    packed = pack([Outcome(values={"section_value": np.zeros(3)})], keys(1), VARIABLES)
    assert packed.status.tolist() == [STATUS.codes["failed"]]
    assert "section_value is ragged: it goes into Outcome.ragged" in packed.messages[0]


@pytest.mark.parametrize("keep", [0, 1, 100, 0.5, 0.9, -1])
def test_a_truncated_shard_is_unreadable(tmp_path: Path, keep: float) -> None:
    path = tmp_path / "a.h5"
    content = b"".join(shard_parts(block(), "response"))
    path.write_bytes(content[: int(keep * len(content)) if 0 < keep < 1 else int(keep)])
    with pytest.raises(UnreadableShard):
        read_shard(path)


def test_no_flipped_byte_changes_an_answer(tmp_path: Path) -> None:
    """Nor does one reach HDF5, which may never return from what it damages."""
    path, content = tmp_path / "a.h5", b"".join(shard_parts(block(), "response"))
    for place in range(0, len(content), 7):
        damaged = bytearray(content)
        damaged[place] ^= 1 + place % 255
        path.write_bytes(damaged)
        if DIGEST_BYTES <= place < BEFORE:  # nobody reads these
            assert_equal(read_shard(path)[0], block())
            continue
        with pytest.raises(UnreadableShard, match="its digest does not match"):
            read_shard(path)


def test_foreign_files_are_unreadable(tmp_path: Path) -> None:
    text = tmp_path / "a.h5"
    text.write_text("hello")
    other = tmp_path / "b.h5"
    with h5py.File(other, "w") as file:
        file["x"] = 1.0
    for path in (text, other, tmp_path / "missing.h5", tmp_path):
        with pytest.raises(UnreadableShard):
            read_shard(path)


@pytest.mark.parametrize("change", [{"format": "another"}, {"version": 2}])
def test_what_is_whole_and_no_shard_is_unreadable(tmp_path: Path, change: dict[str, Any]) -> None:
    path = tmp_path / "a.h5"
    write_shard(path, block(), "response")
    with h5py.File(path, "r+") as file:
        file.attrs.update(change)
    content = path.read_bytes()
    path.write_bytes(zlib.crc32(content[BEFORE:]).to_bytes(4, "little") + content[DIGEST_BYTES:])
    with pytest.raises(UnreadableShard, match="not a shard of this version"):
        read_shard(path)


def test_a_folder_that_is_not_there_is_a_storage_error(tmp_path: Path) -> None:
    with pytest.raises(StorageError, match="No such file"):
        write_shard(tmp_path / "gone" / "a.h5", block(), "response")


plain = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(2**53), 2**53)
    | st.floats(allow_nan=False)
    | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner),
    max_leaves=8,
)


@given(value=plain)
@settings(max_examples=100, deadline=None)
def test_plain_data_survives(value: object) -> None:
    assert from_plain(to_plain(value)) == value


@pytest.mark.parametrize(
    ("outcome", "why"),
    [
        (Outcome(values={"nonsense": 1.0}), "nonsense"),
        (Outcome(values={"L_s": [1.0, 2.0]}), "L_s has 1 dims"),
        (Outcome(values={"attractor": "wobbly"}), "wobbly"),
        (Outcome(status="great"), "great"),
        (Outcome(reason="bad luck"), "bad luck"),
        (Outcome(ragged={"L_s": [1.0]}), "L_s"),
        (Outcome(ragged={"section_value": 1.0}), "section_value has 0 dims"),
    ],
)
def test_what_cannot_be_stored_fails_alone_and_says_why(outcome: Outcome, why: str) -> None:
    packed = pack([outcome, Outcome(values={"L_s": 1.0})], keys(2), VARIABLES)
    assert packed.status.tolist() == [2, 0]
    assert why in packed.messages[0]
    assert packed.values["L_s"][1] == 1.0
