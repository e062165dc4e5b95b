"""Everything one can do with runs: the door to the modules behind it."""

from server.access import Viewer
from server.listing import LIMIT_MAX, Page, RunView, Wanted, listing, show
from server.orders import UPLOAD, Order, OrderRejected, Quota, QuotaExceeded, enqueue, quota, rerun
from server.queue import Beat, Claim, SweepReport, claim, give_back, heartbeat, look, sweep, waiting
from server.results import (
    Report,
    ResultInvalid,
    finish,
    publish,
    request_cancel,
    withdraw,
)
from server.states import FINAL, LIVE, IllegalMove, Kind, RunState, move

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
