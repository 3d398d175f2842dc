"""Every shipped case means what it has always meant: what is stored stays valid.

A fingerprint that changes on purpose (a numerics version, a setting that decides an answer) is
written anew: `python tests/test_frozen_fingerprints.py`.
"""

from __future__ import annotations

import json
from pathlib import Path

from fiv_cli.case.identity import fingerprint
from fiv_cli.case.load import load_case
from fiv_cli.own.probe import use_files

ROOT = Path(__file__).parents[1]
FROZEN = Path(__file__).with_suffix(".json")


def fingerprints() -> dict[str, str]:
    """Case file -> fingerprint, of all cases in configs/ and sweeps/."""
    use_files([ROOT / "configs" / "own"])
    paths = sorted([*ROOT.glob("configs/**/*.toml"), *ROOT.glob("sweeps/*/case.toml")])
    found = {str(path.relative_to(ROOT)): fingerprint(load_case(path)) for path in paths}
    use_files(())
    return found


def test_shipped_cases_have_the_fingerprints_that_they_had() -> None:
    assert fingerprints() == json.loads(FROZEN.read_text())


if __name__ == "__main__":
    FROZEN.write_text(json.dumps(fingerprints(), indent=1) + "\n")
