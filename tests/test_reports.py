"""What a pipeline reads: JUnit XML, a table in Markdown, and sweeps dealt out over its jobs."""

from __future__ import annotations

import shutil
from pathlib import Path
from xml.etree import ElementTree

import pytest
from small_cases import PIN

from fiv_cli.cli.main import run as fiv
from fiv_cli.cli.reports import Verdict, as_junit, as_markdown

NAMES = ("first", "second", "third")
CLAIM = """
[[claim]]
source = "nobody <&>"
text = "it | moves"
variable = "n_solutions"
expect = { value = 7, tolerance = 0 }
"""


@pytest.fixture
def sweeps(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Three regression sweeps, of which the second differs from its reference."""
    monkeypatch.chdir(tmp_path)
    for name in NAMES:
        folder = tmp_path / "sweeps" / name
        folder.mkdir(parents=True)
        (folder / "case.toml").write_text(PIN)
        changed = ["--set", "grid.mu_k=[0.1, 0.3]"] if name == "second" else []
        fiv(["run", str(folder / "case.toml"), "-q", "-o", f"{folder}/reference.nc", *changed])
    return tmp_path


def cases_of(path: Path) -> dict[str | None, bool]:
    """Name -> whether it passed, of the cases of a JUnit document that agrees with its counts."""
    (suite,) = ElementTree.parse(path).getroot()
    cases = list(suite)
    failed = [case.find("failure") is not None for case in cases]
    assert (suite.get("tests"), suite.get("failures")) == (str(len(cases)), str(sum(failed)))
    assert all(float(case.get("time", "")) >= 0.0 for case in cases)
    return {c.get("name"): not wrong for c, wrong in zip(cases, failed, strict=True)}


def test_sweeps_are_dealt_out_and_told(sweeps: Path, capsys: pytest.CaptureFixture[str]) -> None:
    told: dict[str | None, bool] = {}
    for number, code in ((1, 0), (2, 5)):
        options = ["--shard", f"{number}/2", "--junit", f"{number}.xml", "--summary", "all.md"]
        assert fiv(["regress", *options]) == code
        told |= cases_of(sweeps / f"{number}.xml")
    assert told == {"first": True, "second": False, "third": True}
    lines = (sweeps / "all.md").read_text().splitlines()
    assert lines[0] == "### fiv regress: 2 of 2 passed"
    assert next(line for line in lines if "FAILED" in line).startswith(
        "| **FAILED** | sweeps: second"
    )
    assert "first: agrees" in capsys.readouterr().out


def test_claims_that_strict_minds_are_failures(sweeps: Path) -> None:
    shutil.copy("sweeps/first/case.toml", "case.toml")
    with Path("case.toml").open("a") as case:
        case.write(CLAIM + CLAIM + 'note = "known"\n')
    fiv(["run", "case.toml", "-q"])
    assert fiv(["claims", "case.toml", "--strict", "--junit", "c.xml", "--summary", "c.md"]) == 5
    (suite,) = ElementTree.parse("c.xml").getroot()
    assert (suite.get("tests"), suite.get("failures")) == ("2", "1")
    assert [case.get("name") for case in suite] == ["nobody <&>: it | moves"] * 2
    assert Path("c.md").read_text().count("it \\| moves") == 2


def test_what_xml_and_tables_cannot_hold_is_left_out() -> None:
    verdict = Verdict("a", "b\x00\x1b[31m", "one\ntwo | three", False)
    (failure,) = ElementTree.fromstring(as_junit("t", [verdict])).iter("failure")
    assert failure.text == "one\ntwo | three"
    assert "one two \\| three |" in as_markdown("t", [verdict])
