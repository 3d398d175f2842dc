"""What holds for the whole suite."""

from __future__ import annotations

import functools
import gc
from collections import defaultdict
from pathlib import Path

import matplotlib as mpl
import pytest
import synthetic_datasets as data
from hypothesis import settings
from matplotlib.mathtext import MathTextParser

# The same examples in every run; a first example may compile code, so there is no deadline.
settings.register_profile("suite", derandomize=True, deadline=None)
settings.load_profile("suite")

# What sympy, numba and matplotlib have loaded stays: looking through it again and again for garbage
# takes a tenth of the time of the tests.
gc.set_threshold(50_000, 20, 10)

# Each figure of matplotlib sets its formulas anew, a fifth of the time of a drawing: here those of
# one look are set once.
set_formula = MathTextParser._parse_cached.__wrapped__  # type: ignore[attr-defined]
FONTS = [name for name in mpl.rcParams if name.startswith(("font.", "mathtext."))]


@functools.cache
def formula(output: str, look: tuple[str, ...], *key: object) -> object:
    """A formula as it is set in some fonts."""
    return set_formula(MathTextParser(output), *key)


def formula_of(parser: MathTextParser, *key: object) -> object:
    """What takes the place of the memory of one parser, which each figure has of its own."""
    output = {"vector": "path", "raster": "agg"}[parser._output_type]
    return formula(output, tuple(str(mpl.rcParams[name]) for name in FONTS), *key)


MathTextParser._parse_cached = formula_of  # type: ignore[method-assign,assignment]

# Of tests whose cases take long together: how many `make test` runs, from the first to the last of
# them at equal distances, or which by their names. The others are campaigns, of `make test-all`.
KEPT: dict[str, dict[str, int | tuple[str, ...]]] = {
    "test_analyses.py": {
        "test_steady_states_told_side_by_side_are_those_told_alone": 5,
        "test_points_run_at_once_are_answered_as_alone": 2,
    },
    "test_averaged.py": {
        "test_the_averaged_exponential_law_by_any_fall": 2,
        "test_an_averaged_law_is_its_integral": 2,
        "test_slope_of_the_averaged_exponential_law": 1,
    },
    "test_boundary.py": {
        "test_a_branch_is_said_to_end_where_newtons_method_finds_its_end": 3,
        "test_the_error_of_a_boundary_is_bounded": 10,
    },
    "test_branch_round_a_corner.py": {
        "test_a_branch_is_the_same_however_closely_its_changes_are_looked_for": 2,
        "test_a_branch_leads_to_the_corner_it_is_gone_on_from_in_steps": 1,
    },
    "test_characteristics.py": {"test_loops_are_drawn": 2},
    "test_classes.py": {
        "test_classes_of_the_pin_all_over_its_basins": 1,
        "test_classes_on_both_sides_of_the_unstable_cycle": 2,
        "test_classes_all_over_both_basins": 4,
        "test_the_share_of_resting_starts": 0,
    },
    "test_cli_case.py": {
        "test_every_line_behind_a_mark_may_be_taken_in": 20,
        "test_sliding_changes_its_stability_in_the_first_case_of_a_model": 2,
        "test_usage": 8,
    },
    "test_cluster.py": {
        "test_a_cluster_leaves_no_trace": 1,
        "test_a_scheduler_that_stays_away_ends_the_run": 0,
        "test_that_it_may_take_hours_is_told_for_as_many_workers_as_have_joined": 0,
    },
    "test_codegen.py": {
        "test_a_function_cut_into_pieces_gives_the_same_bits": 4,
        "test_compiled_code_computes_what_its_text_says": (
            "belt-1dof hyperbolic",
            "pin-on-disc coulomb",
        ),
        "test_every_lane_of_tangents_is_what_the_text_says": (
            "belt-1dof hyperbolic",
            "pin-on-disc coulomb",
        ),
        "test_recurrences": 20,
    },
    "test_configs.py": {"test_claims_on_a_few_points_of_a_large_case": 14},
    "test_critical.py": {
        "test_what_lies_beside_a_belt_at_standstill_is_found_in_any_bracket": 6,
    },
    "test_cycles.py": {
        "test_stick_slip_under_a_falling_law_ends_within_the_error": 2,
        "test_a_cycle_shrinks_to_rest_within_the_error": 1,
        "test_a_branch_does_not_step_aside_where_its_multiplier_grows_without_bound": 1,
        "test_the_end_of_a_branch_that_runs_along_a_grazing_lies_within_its_error": 1,
        "test_a_branch_that_rounding_opens_on_its_way_to_rest_ends_at_the_hopf_point": 1,
        "test_a_branch_of_unstable_slip_turns_into_stick_slip_from_whichever_start": 2,
        "test_the_end_of_a_branch_is_one_whatever_its_bracket": 2,
    },
    "test_data_cf.py": {
        "test_a_checker_of_others_passes": 3,
        "test_joined_runs_of_every_kind_are_written_without_a_warning": 6,
    },
    "test_discs.py": {
        "test_a_contact_spring_against_the_independent_program": (
            "states=slip+reverse+separation",
        ),
        "test_a_rigid_contact_against_the_saddle_point": ("lightly-pressed",),
        "test_stick_on_a_disc_whose_speed_changes": ("accelerating",),
        "test_the_excited_disc_against_the_independent_program": 1,
    },
    "test_dynamics_random.py": {"test_random_motions": 3},
    "test_equilibria.py": {
        "test_a_disc_at_its_critical_speed_has_no_equilibrium_and_beyond_it_one_again": (
            "disc-rigid-contact-options0",
            "excited-disc-options2",
            "disc-nonlinear-contact-options3",
        ),
        "test_where_the_equilibrium_leaves_by_infinity_is_told_to_rounding": 4,
    },
    "test_estimate.py": {"test_an_estimate_holds_the_time_where_few_points_cost_nearly_all": 2},
    "test_excitation.py": {"test_the_energies_of_excited_models_balance": 3},
    "test_imports.py": {"test_what_computes_nothing_loads_no_engine": 3},
    "test_journal_damage.py": {
        "test_a_shard_whose_checksum_is_right_and_whose_content_is_not": 6,
    },
    "test_kill.py": {"test_the_parent_ends": 1},
    "test_lumped_2mass.py": {"test_events_against_an_independent_program": 4},
    "test_lumped_5dof.py": {"test_options_against_an_independent_program": 4},
    "test_models.py": {
        "test_every_law_of_a_model_moves_it": tuple(
            f"two laws-{name}"
            for name in (
                "belt-1dof",
                "belt-2mass",
                "belt-5dof",
                "excited-2dof",
                "flutter-2dof",
                "pin-on-disc",
                "excited-disc",
            )
        ),
    },
    "test_modes_converge.py": {
        "test_modes_beyond_the_seven_bring_instabilities_of_their_own": 0,
    },
    "test_own.py": {
        "test_a_mistake_is_told_with_its_line": 6,
        "test_a_mistake_in_a_law_with_a_state_of_its_own_is_told_with_its_line": 2,
        "test_a_law_that_shares_a_name_with_the_model_is_refused_with_it": 2,
        "test_damping_that_gives_energy_is_remarked": 0,
        "test_pieces_of_a_law_fit_together": 3,
    },
    "test_parts.py": {"test_parts_leave_no_trace": 2},
    "test_pieces.py": {
        "test_it_is_the_same_whether_the_case_or_a_contact_names_a_law": 2,
    },
    "test_plate.py": {
        "test_no_mode_is_skipped": 2,
        "test_frequencies_to_ten_digits_against_many_digit_arithmetic": 3,
    },
    "test_plots_bifurcation.py": {
        "test_lines_of_equilibria_meet_where_a_critical_value_says_or_midway": 2,
        "test_motions_that_ended_stand_among_the_gaps": 2,
        "test_only_branches_at_the_fixed_parameters_of_a_diagram_are_laid_over_it": 2,
    },
    "test_plots_commands.py": {"test_plot_refuses_what_cannot_be_drawn": 5},
    "test_plots_curve.py": {
        "test_a_legend_stands_where_nothing_is_drawn_or_below": 3,
        "test_histories_beside_one_another_have_one_range_of_each_variable": 2,
        "test_lines_too_many_for_colours_are_told": 2,
        "test_the_ordinate_reaches_over_what_lies_between_the_limits": 1,
        "test_what_has_no_logarithm_is_counted_and_no_limit_reaches_for_it": 2,
        "test_where_dashes_tell_nothing_each_line_has_its_colour": 2,
    },
    "test_plots_files.py": {"test_the_same_data_gives_the_same_bytes": 2},
    "test_plots_map.py": {
        "test_a_figure_is_written_in_words_of_ones_own": 3,
        "test_a_figure_too_narrow_for_its_panels_says_how_wide_it_may_be": 1,
        "test_a_dashed_line_begins_on_both_sides_of_its_level": 2,
        "test_a_level_is_written_away_from_the_nose_of_its_line": 2,
        "test_gaps_of_a_line_where_points_are_undecided_are_told": 1,
        "test_levels_are_written_on_lines_whose_dashes_are_finer": 2,
        "test_shades_of_a_map_may_be_logarithmic": 1,
        "test_which_undecided_motions_have_numbers_for_lines": 2,
    },
    "test_plots_motions.py": {
        "test_a_force_is_drawn_of_every_contact_that_is_not_left_out_each_by_its_name": 2,
        "test_a_motion_that_ended_before_its_time_has_a_mark_where_it_did": 1,
        "test_of_several_contacts_a_figure_says_which_one_is_selected": 1,
        "test_of_several_contacts_the_legend_says_which_one_is_shown": 1,
        "test_sticks_of_other_contacts_are_marked_where_no_panel_is_about_one": 1,
        "test_ticks_along_x_leave_each_other_room_however_long_they_are": 3,
    },
    "test_powers.py": {
        "test_slip_begins_with_what_stick_bears_however_steeply_friction_rises": 1,
        "test_contacts_that_let_go_together_do_not_take_turns": 2,
    },
    "test_readme.py": {"test_parts_from_batch_queues_join_to_the_dataset_of_one_run": 0},
    "test_sampling.py": {"test_many_samples_too_few_for_a_curve_are_drawn_as_their_range": 0},
    "test_signals.py": {
        "test_signals_at_any_instant": 3,
        "test_a_second_ctrl_c": 1,
        "test_while_the_dataset_is_written": 1,
        "test_a_long_integration_is_ended": 1,
        "test_how_fast_it_goes_is_told_elsewhere_while_it_runs_and_afterwards": 0,
    },
    "test_sound_datasets.py": {
        "test_a_sample_of_damaged_datasets": 0,
        "test_what_is_wrong_is_said_by_every_command": 8,
    },
    "test_starts_in_contact.py": {
        "test_a_gap_of_rounding_is_none": ("belt-5dof", "disc-nonlinear-contact", "excited-disc"),
    },
    "test_sweep_run.py": {
        "test_a_point_that_kills_its_worker_twice_is_one_failed_point": 1,
        "test_a_run_in_two_goes_is_the_run_in_one": 4,
        "test_a_stop_at_any_write_loses_only_what_was_in_flight": 8,
        "test_workers_and_chunks_leave_no_trace": 2,
    },
    "test_tangents.py": {"test_tangents_follow_neighbours_through_contact_and_flight": 3},
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
        asked = KEPT[file][name]
        if isinstance(asked, int):
            count = min(asked, len(own))
            numbers = {round(n * (len(own) - 1) / max(count - 1, 1)) for n in range(count)}
            kept = [own[number] for number in numbers]
        else:
            kept = [item for item in own if item.callspec.id in asked]
            if len(kept) < len(asked) < len(own):
                raise pytest.UsageError(f"KEPT in {__file__}: {name} has not all of {asked}")
        for item in own:
            if item not in kept:
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
