"""Roll and pitch of a BlueROV2 that floats and moves its arm, measured and predicted."""

from pathlib import Path

import numpy as np

from performance.plots import COLOURS, figure
from performance.simulator.validation.floating_arm import fit, frames
from performance.simulator.validation.floating_arm.model import NAMES, UNITS
from performance.simulator.validation.floating_arm.records import FITTED, OTHERS, Trial, trials
from performance.simulator.validation.published import HINSDALE
from performance.tables import markdown_table, signed
from seamark.sim.numerics.arrays import Array

TITLE = "A BlueROV2 that floats and moves its arm"
SHOWN = tuple(name for name in OTHERS if name.startswith("traj"))
_ANGLES = ("roll", "pitch")
_Errors = dict[str, dict[str, Array]]  # by predictor and trial


def verdict(errors: _Errors) -> str:
    """Return the result in one sentence, whatever it is."""
    engine, balance, start = ([kind[name] for name in OTHERS] for kind in errors.values())
    own, low_high = fit.rms(engine), fit.interval(engine)
    share = 100.0 * own / fit.rms(start)
    less, more = fit.interval(engine, balance)
    if (more < 0.0).all():
        beside = "and better than a mere balance of moments"
    elif (less > 0.0).any():
        beside = "but worse than a mere balance of moments"
    else:
        beside = "but no better than a mere balance of moments"
    parts = (
        f"{angle} within {own[i]:.1f}° rms (95 % interval {low_high[0, i]:.1f} to "
        f"{low_high[1, i]:.1f}°; {share[i]:.0f} % of the error of no prediction)"
        for i, angle in enumerate(_ANGLES)
    )
    return (
        f"**Verdict: in trials that no number was fitted to, the engine predicts "
        f"{' and '.join(parts)}, {beside}: weights, geometry and their moments are confirmed, and "
        "the dynamics hardly tested, because the arm moves slowly.**"
    )


def errors_table(errors: _Errors) -> str:
    """Return the errors of each trial and of all others together."""
    rows = []
    for name in (*FITTED, *OTHERS):
        cells = (fit.rms([kind[name]]) for kind in errors.values())
        rows.append([name, "fitted" if name in FITTED else "other", *map(_pair, cells)])
    together, limits = ["all others", "other"], ["95 % interval", "other"]
    for kind in errors.values():
        chosen = [kind[name] for name in OTHERS]
        low, high = fit.interval(chosen)
        together.append(f"**{_pair(fit.rms(chosen))}**")
        limits.append(" / ".join(f"{low[i]:.2f} to {high[i]:.2f}" for i in range(2)))
    return markdown_table(["trial", "used", *errors], [*rows, together, limits])


def hypotheses_table(attitude: Array, joints: Array) -> str:
    """Return how well each arrangement of the joints fits, the best first."""
    ranked = frames.hypotheses(attitude, joints)
    rows = [
        (
            "vertical" if one.upright else "ahead",
            "port" if one.base_sign < 0 else "starboard",
            "against the shoulder" if one.elbow_sign < 0 else "with the shoulder",
            f"{one.rms_deg:.2f}",
        )
        for one in ranked
    ]
    header = ["axis of the base", "larger angle turns to", "elbow turns", "rms error [°]"]
    return markdown_table(header, rows)


def numbers_table(values: Array, deviations: Array) -> str:
    """Return what the balance of moments says about the arm."""
    lengths = [(name, "share of the righting moment") for name in frames.NAMES[:3]]
    angles = [(name, "rad") for name in frames.NAMES[3:6]]
    trims = [(name, "share of the righting moment") for name in frames.NAMES[6:]]
    rows = [
        (name, signed(values[i], 3), f"{deviations[i]:.3f}", unit)
        for i, (name, unit) in enumerate((*lengths, *angles, *trims))
    ]
    return markdown_table(["number", "value", "standard error", "unit"], rows)


def parameters_table(fitted: fit.Fitted) -> str:
    """Return the fitted parameters."""
    rows = [
        (name.replace("_", " "), f"{value:.3g}", f"{deviation:.2g}", unit)
        for name, value, deviation, unit in zip(
            NAMES, fitted.dynamic.values(), fitted.errors, UNITS, strict=True
        )
    ]
    return markdown_table(["parameter", "value", "standard error", "unit"], rows)


def draw(records: dict[str, Trial], errors: _Errors, out: Path) -> None:
    """Write the figure: trials in which the arm moves and which no number was fitted to."""
    engine, balance = (errors[name] for name in list(errors)[:2])
    with figure(out, rows=len(SHOWN), height=8.0, share_x=False) as axes:
        for name, panel in zip(SHOWN, axes, strict=True):
            trial = records[name]
            measured = np.degrees(trial.attitude)
            for i, angle in enumerate(_ANGLES):
                line = {"color": COLOURS[i]}
                panel.plot(trial.time_s, measured[:, i], label=f"{angle}, measured", **line)
                ours = measured[:, i] + engine[name][:, i]
                panel.plot(trial.time_s, ours, "--", label="engine", **line)
                weights = measured[:, i] + balance[name][:, i]
                panel.plot(trial.time_s, weights, ":", label="balance of moments", **line)
            panel.set_title(name, fontsize="medium")
            panel.set_ylabel("[°]")
        axes[0].legend(fontsize="small", ncols=2)
        axes[-1].set_xlabel("time [s]")


def section(_names: list[str], figures: Path) -> str:
    """Return the section's text."""
    records = trials()
    fitted = fit.fit(records)
    errors = {
        name: fit.residuals(predictor, records)
        for name, predictor in fit.predictors(fitted).items()
    }
    others = {name: records[name] for name in OTHERS}
    clocked = [
        list(fit.residuals_by_best_clock(predictor, others).values())
        for predictor in list(fit.predictors(fitted).values())[:2]
    ]
    draw(records, errors, figures / "floating-arm.png")
    attitude, joints = frames.samples(records)
    values, deviations = frames.identify(attitude, joints)
    share, share_error = frames.height_share(attitude, joints)
    seen = [np.degrees(records[name].seen - records[name].attitude) for name in records]
    disagreement = np.nanmedian(np.abs(np.concatenate(seen)), axis=0)
    return "\n\n".join(
        [
            "A BlueROV2 with a Reach Alpha 5 floated in still water while its arm followed "
            f"trajectories and nothing else drove it ({HINSDALE.text()}). The arm like the "
            "Reach Alpha 5 on our BlueROV2 Heavy repeats the measured motion of the joints, and "
            f"roll and pitch of the vehicle are compared. {', '.join(FITTED)}, the first three by "
            "name in which the arm moves, fit the parameters; the other five judge them.",
            verdict(errors),
            errors_table(errors),
            "Root mean squares of roll / pitch [°] against the vehicle's own attitude filter. "
            "*Balance of moments* has no dynamics: at each instant the attitude at which all "
            "weights balance, with its own fit of the first three parameters. *Attitude at the "
            "start* is what a predictor without an arm says. Intervals are of a bootstrap over "
            f"trials and blocks of {fit.BLOCK_S:g} s. Motion capture disagrees with the attitude "
            f"filter by {_pair(disagreement)}° (median), partly a constant: errors below that "
            "mean nothing.",
            "![Roll and pitch of three trials](figures/floating-arm.png)",
            "The clocks of the files do not agree: in traj030-0 the vehicle moves before the "
            "weights do. With the clock of the joints that suits each of the other trials best, "
            f"within a second, the engine has {_pair(fit.rms(clocked[0]))}° and the balance of "
            f"moments {_pair(fit.rms(clocked[1]))}°.",
            "**Parameters.** Of the vehicle with the arm's base, without the moving links; "
            "quadratic drag is the vehicle's own. Roll inertia and damping come from motions of "
            "two degrees, and take up what the clocks are wrong by. The mass of the arm cannot be "
            "found beside the righting moment: slow tilt gives their ratio alone. An eighth "
            "parameter, a factor of the quadratic drag, was tried: it ended on its bound, and the "
            "other trials were predicted no better.",
            parameters_table(fitted),
            "**Frames and mounting** are not stated with the data. The accelerometer reads "
            "+9.8 m/s² along z at rest, so the attitudes are of axes x forward, y port, z up. The "
            "tilt while the arm moves slowly tells how the joints are arranged: of eight "
            "arrangements, a balance of moments fits one clearly better.",
            hypotheses_table(attitude, joints),
            "Its zero positions and the ratio of its moments, which the arm's file has, follow "
            "from the same three trials by least squares. With heights of the weights scaled by a "
            f"factor, that is {share:.2f} ± {share_error:.2f}: positive, so a larger angle of the "
            "shoulder raises the arm; its mirror image would have -1. Standard errors here and "
            "above count one sample each second, or each five, as independent.",
            numbers_table(values, deviations),
        ]
    )


def _pair(values: Array) -> str:
    return " / ".join(f"{value:.2f}" for value in values)
