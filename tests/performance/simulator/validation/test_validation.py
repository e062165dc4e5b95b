"""The validation: its closed forms, its independent parts, and the page in the repository."""

from types import ModuleType

import numpy as np
import pytest

from performance import DOCS
from performance.simulator.validation import (
    analytic,
    convergence,
    drag_tests,
    independent,
    offset,
    page,
    published,
    summary,
    thrust_tests,
    vehicles,
    water_tests,
)
from performance.simulator.validation.determinism import differing_columns
from performance.simulator.validation.facts import late_rms
from performance.simulator.validation.reference import thrust_of
from performance.tables import below, markdown_table, signed
from seamark.sim.camera.optics import CURRENTS
from seamark.sim.camera.target import Target
from seamark.sim.physics.plant import Plant
from seamark.sim.recording.telemetry import INDEX, WIDTH
from seamark.sim.vehicles import load

PAGE = (DOCS / "validation.md").read_text(encoding="utf-8")
NAMES = vehicles.names()


@pytest.mark.parametrize("title", page.titles())
def test_the_page_has_every_section(title: str) -> None:
    assert f"\n### {title}\n" in PAGE


def test_the_page_says_which_part_is_validation_and_which_verification() -> None:
    headings = [line for line in PAGE.splitlines() if line.startswith("## ")]

    assert headings == ["## Validation", "## Verification", "## Parameters"]


@pytest.mark.parametrize("name", NAMES)
def test_the_page_has_every_number_of_every_vehicle(name: str) -> None:
    assert vehicles.vehicle_text(load(name)).replace("### ", "#### ") in PAGE


def test_the_page_has_all_six_facts() -> None:
    headings = [line for line in PAGE.splitlines() if line.startswith("#### ")]

    assert [heading[5] for heading in headings if heading[5].isdigit()] == list("123456")


def test_every_source_of_a_measurement_is_on_the_page() -> None:
    missing = [source.name for source in published.SOURCES if source.text() not in PAGE]

    assert missing == []


@pytest.mark.parametrize("module", [thrust_tests, drag_tests])
def test_the_page_has_the_present_comparison_with_measurements(module: ModuleType) -> None:
    comparisons = [(each.what, " | ".join(each.cells())) for each in module.comparisons()]
    missing = [what for what, cells in comparisons if f"| {cells} |" not in PAGE]

    assert missing == []


def test_every_measurement_not_found_is_named() -> None:
    assert [entry for entry in summary.MISSING if entry not in PAGE] == []


def test_the_error_is_relative_to_the_measurement() -> None:
    comparison = published.Comparison("drag", 150.0, 100.0, "N", published.LI)

    assert comparison.error_percent == pytest.approx(50.0)
    assert comparison.cells()[4] == "+50"


def test_with_the_published_pull_the_vehicle_pulls_as_published() -> None:
    weaker = drag_tests.with_measured_pull(load(thrust_tests.VEHICLE))

    pull = thrust_tests.bollard_pull(weaker, 0)

    assert pull == pytest.approx(9.0 * published.KGF_N, rel=1e-6)


def test_the_top_speed_balances_drag_and_thrust() -> None:
    vehicle = load(thrust_tests.VEHICLE)

    speed = drag_tests.top_speed(vehicle)

    pull = thrust_tests.bollard_pull(vehicle, 0)
    assert drag_tests.drag(vehicle, 0, speed) == pytest.approx(pull, rel=0.02)


def test_full_commands_ahead_use_the_horizontal_thrusters_alone() -> None:
    commands = thrust_tests.full_commands(load(thrust_tests.VEHICLE), 0)

    assert commands.tolist() == [1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0]


def test_the_dvl_of_the_first_version_has_no_bias_and_that_of_the_second_one_has() -> None:
    assert water_tests.dvl_bias_mm_s("currents-v1") == 0.0
    assert water_tests.dvl_bias_mm_s("currents-v2") > 0.0


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_every_closed_form_is_met_within_half_a_percent(name: str) -> None:
    cases = analytic.cases(name)

    assert len(cases) > 10
    assert {case.what: case.error_percent for case in cases if case.error_percent > 0.5} == {}


def test_terminal_speed_solves_the_balance_of_drag_and_thrust() -> None:
    v = analytic.terminal_speed(40.0, 163.0, -50.0)

    assert v < 0.0
    assert 40.0 * v + 163.0 * abs(v) * v == pytest.approx(-50.0)


@pytest.mark.parametrize("linear", [0.0, 40.0])
def test_coasting_speed_solves_its_equation(linear: float) -> None:
    at = [analytic.coasting_speed(linear, 163.0, 300.0, 1.0, t) for t in (1.999, 2.0, 2.001)]

    slope = (at[2] - at[0]) / 0.002
    assert 300.0 * slope == pytest.approx(-(linear * at[1] + 163.0 * at[1] ** 2), rel=1e-5)


def test_the_order_of_a_fourth_order_error_is_four() -> None:
    steps = convergence.STEPS_S

    assert convergence.order_of(steps, tuple(h**4 for h in steps)) == pytest.approx(4.0)


def test_with_smooth_forces_the_plant_converges_with_the_fourth_order() -> None:
    smooth = convergence.with_linear_drag(load("girona500"))

    assert convergence.curve(smooth, "smooth", gusts=False).order == pytest.approx(4.0, abs=0.3)


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("leg_s", [2.0, pytest.param(4.0, marks=pytest.mark.long)])
def test_a_free_motion_agrees_with_the_reference(name: str, leg_s: float) -> None:
    difference = independent.difference(name, force=False, leg_s=leg_s)

    assert difference.travelled_m > 1.0
    assert difference.position_mm < 1e-3


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("command", [-1.0, -0.4, -0.01, 0.0, 0.2, 0.9, 1.0])
def test_the_reference_reads_thrust_curves_as_the_plant_does(name: str, command: float) -> None:
    vehicle = load(name)
    plant = Plant(vehicle, analytic.STILL)

    plant.advance(0, np.full(len(vehicle.thrusters), command), 1000)

    assert plant.thrust() == pytest.approx(thrust_of(vehicle, command), abs=1e-6)


def test_the_rectangle_around_the_box_is_the_top_face_for_a_camera_above_it() -> None:
    target = Target()
    above = target.top_centre() + np.array([0.0, 0.0, -2.27])
    beside = above + np.array([0.5, 0.0, 0.0])

    assert offset.rectangle_shift(above, target) == pytest.approx(np.zeros((4, 2)))
    assert np.abs(offset.rectangle_shift(beside, target)).max() > 3.0


def test_the_parallax_of_the_origin_is_that_of_the_visibility_view() -> None:
    pixels = offset.projected(np.eye(3), np.array([0.0, 0.0, -1.0]), CURRENTS.focal_px)

    assert np.abs(offset.visibility_parallax()) == pytest.approx([4.77, 2.09], abs=0.01)
    assert pixels.shape == (3, 2)


def test_columns_that_differ_in_one_bit_are_named() -> None:
    first = np.ones((5, WIDTH))
    second = first.copy()
    second[3, INDEX["roll"]] = np.nextafter(1.0, 2.0)

    assert differing_columns(first, first) == []
    assert differing_columns(first, second) == ["roll"]


def test_late_rms_counts_the_end_of_its_own_level_alone() -> None:
    rows = np.zeros((4800, WIDTH))
    rows[:, INDEX["t"]] = 0.05 * np.arange(4800)
    rows[:, INDEX["level"]] = np.arange(4800) // 2400
    rows[1900:2400, INDEX["error_x_px"]] = -3.0

    assert late_rms(rows, 0, "x") == pytest.approx(3.0 * np.sqrt(500 / 600), rel=2e-3)
    assert late_rms(rows, 1, "x") == 0.0


def test_a_rounding_error_is_given_as_the_power_of_ten_above_it() -> None:
    texts = [below(error) for error in (3.0e-5, 9.9e-6, 1.1e-5, 0.0)]

    assert texts == ["< 1e-04", "< 1e-05", "< 1e-04", "0"]


def test_cells_with_bars_do_not_break_a_table() -> None:
    assert markdown_table(("a",), [("|v|",)]).splitlines() == ["| a |", "|---|", "| \\|v\\| |"]
    assert [signed(-0.04), signed(-0.06), signed(0.3)] == ["0.0", "-0.1", "0.3"]
