"""The setting for a custom score, shown next to the benchmark's."""

from collections.abc import Iterable
from typing import Any

from seamark.sim.metrics import uwsim_metrics
from seamark.sim.metrics.metric import Metric
from seamark.sim.settings.setting import setting


def custom_score_setting(metrics: Iterable[Metric], *, group: str) -> Any:  # as setting itself
    """Return the setting: an expression over these metrics and those of the original module."""
    names = ("score", *(metric.name for metric in metrics), *uwsim_metrics.NAMES)
    return setting(
        "",
        title="Custom score",
        help="Shown next to the benchmark's: an expression such as objectCenteredOnCam + corners.",
        group=group,
        role="scenario",
        advanced=True,
        names=names,
    )
