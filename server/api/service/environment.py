"""What uploaded programs find in their boxes, as the living workers report it."""

from __future__ import annotations

from typing import Any, Literal

from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag
from pydantic import BaseModel, Field

from seamark.sandbox.languages import LANGUAGES
from seamark.server.api.requests.operation_ids import operation_id
from seamark.server.messaging import workers
from seamark.server.web.services import services

api = APIBlueprint(
    "api_environment",
    __name__,
    url_prefix="/api/v1",
    operation_id_callback=operation_id,
    abp_tags=[Tag(name="Environment", description="What uploaded programs can use.")],
)


class ComponentVersion(BaseModel):
    """A version of a component."""

    version: str
    workers: int = Field(description="Number of living workers that have this version")


class EnvironmentComponent(BaseModel):
    """An interpreter, a compiler or a library."""

    kind: Literal["interpreter", "compiler", "library"]
    name: str
    versions: list[ComponentVersion]
    everywhere: bool = Field(description="Whether all these workers have the same version")


class EnvironmentLanguage(BaseModel):
    """What programs in one language find."""

    language: str = Field(description="Its name in the field `language` of runs")
    label: str
    workers: int = Field(description="Number of living workers that run programs in it")
    components: list[EnvironmentComponent]


class EnvironmentResponse(BaseModel):
    """What programs find, by language; empty while no worker is alive."""

    languages: list[EnvironmentLanguage]


@api.get("/environment", responses={200: EnvironmentResponse})
def show() -> dict[str, Any]:
    """Return interpreters, compilers and libraries with the versions on the living workers."""
    with services().database.reading() as session:
        environments = workers.environments(session)
    return {"languages": [_language(one) for one in environments]}


def _language(environment: workers.Environment) -> dict[str, Any]:
    components = [
        {
            "kind": component.kind,
            "name": component.name,
            "versions": [
                {"version": version, "workers": count}
                for version, count in component.versions.items()
            ],
            "everywhere": component.is_everywhere(environment.workers),
        }
        for component in environment.components
    ]
    return {
        "language": environment.language,
        "label": LANGUAGES[environment.language].label,
        "workers": environment.workers,
        "components": components,
    }
