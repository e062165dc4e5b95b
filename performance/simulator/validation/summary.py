"""All comparisons with measurements at a glance, and what could not be compared."""

from pathlib import Path

from performance.plots import COLOURS, figure
from performance.simulator.validation import drag_tests, thrust_tests, water_tests
from performance.simulator.validation.published import SOURCES, Comparison

TITLE = "Summary and sources"
MISSING = (
    "**Girona 500.** Its drag, thrust and thruster curve come from the configuration of the real "
    "vehicle's controller; no independent measurement of speed, drag or bollard pull was open to "
    "us, and the paper that describes it (Ribas et al. 2012, IEEE/ASME Trans. Mechatronics 17(1)) "
    "neither. Mass, inertia and added mass rest on the geometry of another simulator. So this "
    "vehicle is *not validated*.",
    "**Responses in time.** Free decay in heave and yaw was measured on other open-frame vehicles "
    "(Chin, Lin and Lin 2018, <https://doi.org/10.1007/s00773-017-0469-3>), and data of a "
    "restrained BlueROV2 in waves and current exist (Gabl et al. 2020, "
    "<https://doi.org/10.3390/data5030057>); we did not find their numbers in a comparable form. "
    "So added mass and the thrusters' lag are not validated for any vehicle.",
    "**Trackers in real turbid water.** Data sets of features under turbidity exist (TURBID, "
    "Codevilla et al. 2015); we found no figures of template trackers over a measured optical "
    "depth. The contrast law itself is Duntley's, with attenuations measured by others "
    "([camera](camera.md)).",
    "**The published experiment** was itself a simulation. Agreement with it is verification, "
    "below.",
)


def comparisons() -> list[Comparison]:
    """Return the comparisons of all sections, without those of zero, which have no ratio."""
    quantities = [
        one for section in (thrust_tests, drag_tests, water_tests) for one in section.comparisons()
    ]
    return [one for one in quantities if one.ours]


def draw(quantities: list[Comparison], out: Path) -> None:
    """Write the figure: ours over measured for every quantity, on a logarithmic axis."""
    with figure(out, height=0.3 * len(quantities) + 1.2) as axes:
        ratios = [one.ours / one.measured for one in quantities]
        rows = list(range(len(quantities)))[::-1]
        axes.hlines(rows, [1.0] * len(rows), ratios, color="0.7")
        axes.plot(ratios, rows, "o", color=COLOURS[1])
        axes.axvline(1.0, color="0.3", linewidth=1.0)
        axes.set_xscale("log")
        ticks = [0.1, 0.2, 0.5, 1.0, 2.0, 4.0]
        axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
        axes.minorticks_off()
        axes.set_yticks(rows, [one.what for one in quantities])
        axes.set_xlabel("ours / measured")


def section(_names: list[str], figures: Path) -> str:
    """Return the section's text."""
    quantities = comparisons()
    draw(quantities, figures / "validation.png")
    close = sum(abs(one.error_percent) <= 20.0 for one in quantities)
    sources = "\n".join(f"{at}. {source.text()}" for at, source in enumerate(SOURCES, start=1))
    return "\n\n".join(
        [
            f"{close} of {len(quantities)} quantities are within 20 % of the measurement.",
            "![Ours over measured, for every quantity](figures/validation.png)",
            "We could not compare:",
            "\n".join(f"- {entry}" for entry in MISSING),
            "Sources of the measurements:",
            sources,
        ]
    )
