"""What the answers of a tracker are worth if wrong ones cost: from visibility-v3 on.

A right answer counts 1, an admitted loss 0, and a wrong answer -1. With any cost c of a wrong one,
it pays to answer exactly if the answer is right with a probability of more than c / (1 + c) (Chow
1970, On Optimum Recognition Error and Reject Tradeoff): at 1, if it is right more often than not.
"""

from seamark.sim.metrics.metric import LevelMetric, MetricGroup
from seamark.sim.metrics.tracking import FAR_PX, Images, percent
from seamark.sim.metrics.tracking_losses import METRICS as LOSS_METRICS

WRONG_COST = 1.0  # E: as much as a right answer gains; a vehicle would follow a wrong one


def _wrong(images: Images) -> float:
    return percent(images.reported & ~images.within(FAR_PX))


WRONG: LevelMetric[Images] = LevelMetric(
    name="wrong_percent",
    label="Wrong answers",
    unit="%",
    better="lower",
    meaning=f"it reports corners that are more than {FAR_PX:g} px off",
    formula=f"100 x images in which the tracker reports corners more than {FAR_PX:g} px from the "
    "true ones / all",
    compute=_wrong,
)
NET: LevelMetric[Images] = LevelMetric(
    name="net_percent",
    label="Right less wrong",
    unit="%",
    better="higher",
    meaning="share of right answers less that of wrong ones; an admitted loss counts nothing",
    formula=f"p@{FAR_PX:g} - {WRONG_COST:g} x the share of wrong answers",
    compute=lambda images: percent(images.within(FAR_PX)) - WRONG_COST * _wrong(images),
)
ANSWERS: tuple[LevelMetric[Images], ...] = (NET, WRONG)
METRICS = (*ANSWERS, *LOSS_METRICS)
ANSWER_GROUP = MetricGroup("Trackers: answers in visibility-v3", ANSWERS)
