"""What holds for the whole suite."""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path

import pytest
import synthetic_datasets as data
from hypothesis import settings

# The same examples in every run; a first example may compile code, so there is no deadline.
settings.register_profile("suite", derandomize=True, deadline=None)
settings.load_profile("suite")

# Of tests whose cases take long together: how many `make test` runs, from the first to the last of
# them at equal distances. The others are campaigns, of `make test-all`.
KEPT = {
    "test_signals.py": {
        "test_signals_at_any_instant": 4,
        "test_a_second_ctrl_c": 1,
        "test_while_the_dataset_is_written": 1,
        "test_a_long_integration_is_ended": 1,
        "test_how_fast_it_goes_is_told_elsewhere_while_it_runs_and_afterwards": 0,
    },
    "test_kill.py": {"test_the_parent_ends": 2},
    "test_cluster.py": {
        "test_a_cluster_leaves_no_trace": 1,
        "test_a_scheduler_that_stays_away_ends_the_run": 0,
        "test_that_it_may_take_hours_is_told_for_as_many_workers_as_have_joined": 0,
    },
    "test_sweep_run.py": {"test_a_point_that_kills_its_worker_twice_is_one_failed_point": 1},
    "test_parts.py": {"test_parts_leave_no_trace": 4},
    "test_configs.py": {"test_claims_on_a_few_points_of_a_large_case": 40},
    "test_cli_case.py": {
        "test_every_line_behind_a_mark_may_be_taken_in": 40,
        "test_sliding_changes_its_stability_in_the_first_case_of_a_model": 4,
        "test_usage": 14,
    },
    "test_own.py": {
        "test_a_mistake_is_told_with_its_line": 20,
        "test_a_mistake_in_a_law_with_a_state_of_its_own_is_told_with_its_line": 4,
        "test_damping_that_gives_energy_is_remarked": 0,
    },
    "test_averaged.py": {
        "test_the_averaged_exponential_law_by_any_fall": 8,
        "test_an_averaged_law_is_its_integral": 8,
    },
    "test_discs.py": {
        "test_a_contact_spring_against_the_independent_program": 3,
        "test_a_rigid_contact_against_the_saddle_point": 2,
        "test_the_excited_disc_against_the_independent_program": 1,
    },
    "test_codegen.py": {
        "test_a_function_cut_into_pieces_gives_the_same_bits": 8,
        "test_compiled_code_computes_what_its_text_says": 4,
        "test_every_lane_of_tangents_is_what_the_text_says": 4,
    },
    "test_cycles.py": {
        "test_stick_slip_under_a_falling_law_ends_within_the_error": 3,
        "test_a_cycle_shrinks_to_rest_within_the_error": 2,
    },
    "test_classes.py": {
        "test_classes_of_the_pin_all_over_its_basins": 2,
        "test_classes_on_both_sides_of_the_unstable_cycle": 4,
        "test_the_share_of_resting_starts": 1,
    },
    "test_plots_files.py": {"test_the_same_data_gives_the_same_bytes": 3},
    "test_plots_map.py": {"test_a_figure_too_narrow_for_its_panels_says_how_wide_it_may_be": 1},
    "test_data_cf.py": {"test_a_checker_of_others_passes": 5},
    "test_readme.py": {"test_parts_from_batch_queues_join_to_the_dataset_of_one_run": 0},
    "test_sound_datasets.py": {"test_a_sample_of_damaged_datasets": 0},
    "test_sampling.py": {"test_many_samples_too_few_for_a_curve_are_drawn_as_their_range": 0},
    "test_dynamics_random.py": {"test_random_motions": 6},
    "test_modes_converge.py": {
        "test_modes_beyond_the_seven_bring_instabilities_of_their_own": 0,
    },
    "test_plate.py": {
        "test_no_mode_is_skipped": 2,
        "test_frequencies_to_ten_digits_against_many_digit_arithmetic": 3,
    },
}


@pytest.hookimpl(tryfirst=True)  # before those that are not asked for are left out
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the cases of tests that are `KEPT` in part."""
    cases: dict[tuple[str, str], list[pytest.Item]] = defaultdict(list)
    for item in items:
        name = getattr(item, "originalname", item.name)
        if name in KEPT.get(item.path.name, ()) and not item.get_closest_marker("campaign"):
            cases[item.path.name, name].append(item)
    for (file, name), own in cases.items():
        count = min(KEPT[file][name], len(own))
        kept = {round(n * (len(own) - 1) / max(count - 1, 1)) for n in range(count)}
        for number, item in enumerate(own):
            if number not in kept:
                item.add_marker(pytest.mark.campaign)


@pytest.fixture
def own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache folder for this test."""
    monkeypatch.setenv("FIV_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.fixture
def stored(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a dataset of each form that figures have."""
    monkeypatch.chdir(tmp_path)
    for name in ("bifurcation", "stability_map", "history", "eigenvalues"):
        getattr(data, name)().to_netcdf(tmp_path / f"{name}.nc")
    return tmp_path
