"""Request models of lists of runs, and of changes of one."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from seamark.server.api.requests.query import Query
from seamark.server.api.requests.schemas import Text
from seamark.server.runs.record.run_notes import NOTES_MAX, TITLE_MAX
from seamark.server.runs.showing.run_lists import PROGRAMS, SEARCH_MAX, SEEN_MAX, RunOrder
from seamark.server.web.url_converters import ROW_ID_MAX


class RunEdit(BaseModel):
    """What changes of a run; what is left out stays."""

    model_config = ConfigDict(extra="forbid")

    title: Text | None = Field(None, max_length=TITLE_MAX)
    notes: Text | None = Field(None, max_length=NOTES_MAX, description="Plain text")


class RunsQuery(Query):
    """Filters and pagination of the list of runs."""

    which: Literal["mine", "public", "all"] = Field("mine", description="`all` is for admins only")
    state: list[Literal["queued", "running", "succeeded", "failed", "cancelled"]] = Field(
        default_factory=list, description="Can be repeated"
    )
    benchmark: str | None = Field(None, max_length=80)
    kind: Literal["practice", "ranked", "entry", "log"] | None = None
    program: str | None = Field(
        None, pattern=f"^({'|'.join(PROGRAMS)})$", description=f"One of {', '.join(PROGRAMS)}"
    )
    q: str = Field(
        "", max_length=SEARCH_MAX, description="Words in the title, the benchmark or the program"
    )
    sort: RunOrder = Field(RunOrder.NEWEST, description="Order of the runs")
    after: int | None = Field(None, ge=1, le=ROW_ID_MAX, description="`next` of the previous page")
    skip: int = Field(0, ge=0, le=SEEN_MAX, description="`next_skip` of the previous page")
    limit: int = Field(50, ge=1, le=200)
