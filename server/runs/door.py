"""Everything one can do with runs: the door to the modules behind it."""

from seamark.server.accounts.permissions import Viewer
from seamark.server.runs.queue import (
    Beat,
    Claim,
    SweepReport,
    claim,
    give_back,
    heartbeat,
    look,
    sweep,
    waiting,
)
from seamark.server.runs.results import (
    Report,
    ResultInvalid,
    finish,
    publish,
    request_cancel,
    withdraw,
)
from seamark.server.runs.states import FINAL, LIVE, IllegalMove, Kind, RunState, move
from seamark.server.runs.submission import (
    UPLOAD,
    Order,
    OrderRejected,
    Quota,
    QuotaExceeded,
    enqueue,
    quota,
    rerun,
)
from seamark.server.runs.views import LIMIT_MAX, Page, RunView, Wanted, listing, show

__all__ = [
    "FINAL",
    "LIMIT_MAX",
    "LIVE",
    "UPLOAD",
    "Beat",
    "Claim",
    "IllegalMove",
    "Kind",
    "Order",
    "OrderRejected",
    "Page",
    "Quota",
    "QuotaExceeded",
    "Report",
    "ResultInvalid",
    "RunState",
    "RunView",
    "SweepReport",
    "Viewer",
    "Wanted",
    "claim",
    "enqueue",
    "finish",
    "give_back",
    "heartbeat",
    "listing",
    "look",
    "move",
    "publish",
    "quota",
    "request_cancel",
    "rerun",
    "show",
    "sweep",
    "waiting",
    "withdraw",
]
