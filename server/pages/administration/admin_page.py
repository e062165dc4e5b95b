"""A page of the administration: its place in the navigation, and a blueprint for admins alone."""

from dataclasses import dataclass

from flask import Blueprint

from seamark.server.accounts.permissions import Action
from seamark.server.web import access

ROOT = "/admin"


@dataclass(frozen=True, slots=True)
class AdminPage:
    """A page; `view` is the function of the blueprint to which the navigation leads."""

    label: str
    blueprint: Blueprint
    view: str

    @property
    def endpoint(self) -> str:
        """The endpoint to which the navigation leads."""
        return f"{self.blueprint.name}.{self.view}"


def admin_page(
    name: str, module: str, *, label: str, path: str = "", view: str = "show"
) -> AdminPage:
    """Return a page below `ROOT` whose routes are closed to everybody but admins."""
    blueprint = Blueprint(name, module, url_prefix=ROOT + path)
    blueprint.before_request(_only_admins)
    return AdminPage(label, blueprint, view)


def _only_admins() -> None:
    access.require(Action.ADMINISTER)
