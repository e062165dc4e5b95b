"""Request and response models of publications."""

from __future__ import annotations

import re

from pydantic import BaseModel, ConfigDict, Field

from seamark.programs.licences import LICENCES
from seamark.server.api.requests.schemas import ResponseModel
from seamark.server.runs.publication.publications import Terms
from seamark.server.runs.recomputation.verifications import Outcome
from seamark.server.runs.record.method_names import METHOD_MAX


class PublicationRequest(BaseModel):
    """On which terms a run is published."""

    model_config = ConfigDict(extra="forbid")

    method: str = Field(
        "",
        max_length=4 * METHOD_MAX,
        description=f"Name of the method, of at most {METHOD_MAX} characters: what leaderboards, "
        "badges and citations call the run. Required for an uploaded program; without it, a "
        "built-in solution has its label and a log its title",
    )
    program: bool = Field(True, description="With the uploaded program and its log; false: results")
    licence: str | None = Field(
        None,
        pattern=f"^({'|'.join(map(re.escape, LICENCES))})$",
        description="Of the program, an SPDX identifier; null: other, or none is granted",
    )
    anonymous: bool = Field(
        False, description="For review: nobody sees whose run it is, until `reveal`"
    )

    def terms(self) -> Terms:
        """Return the terms."""
        return Terms(**self.model_dump())


class VerificationRequested(ResponseModel):
    """A verification that has been queued."""

    run: int
    publication: str = Field(description="Where its result will be")


class VerificationResponse(ResponseModel):
    """What came out when the service evaluated a published run again on fresh trials."""

    outcome: Outcome = Field(description="Whether the score agrees with the published one")
    at: float
    version: str = Field(description="Of Seamark")
    digest: str | None = Field(description="Of the telemetry")
    cause: str | None = Field(description="Why the program failed")
    score: float | None
    score_low: float | None
    score_high: float | None
    expected_low: float | None = Field(description="Scores between these agree (99 %)")
    expected_high: float | None


class PublicationResponse(ResponseModel):
    """A publication and where it is found for ever."""

    run: int
    address: str = Field(description="Permanent, with the host of the service")
    method: str = Field(description="Its name; empty: published before methods had names")
    author: str = Field(description='"Anonymous author" while it is published for review')
    anonymous: bool
    program_public: bool
    licence: str | None
    published_at: float
    verification_pending: bool
    verifications: list[VerificationResponse] = Field(description="The newest first")
    first_published_at: float
