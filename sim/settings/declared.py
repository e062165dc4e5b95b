"""Settings that are made of the options that trackers or detectors declare.

A setting that the chosen one does not have is ignored. The names are those of the options, so
nothing is translated in between.
"""

from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar

from pydantic import create_model

from seamark.sim.settings.configuration import Configuration
from seamark.sim.trackers.declaration import Declaration, Option

Settings = TypeVar("Settings", bound=type[Configuration])
Declared = Mapping[str, Declaration[Any]]  # name -> declaration, in the form's order


def labels(declared: Declared) -> dict[str, str]:
    """Return name -> label, with its restrictions."""
    found = {}
    for name, one in declared.items():
        inexact = "" if one.exact else "; not bit-identical on all processors"
        missing = "; not on this machine" if one.unavailable() else ""
        found[name] = f"{one.label}{inexact}{missing}"
    return found


def declared_options(what: str, declared: Declared) -> dict[str, Option]:
    """Return name -> option of all of them, in the form's order.

    Raises
    ------
    ValueError
        If two declare different options of the same name.
    """
    options: dict[str, Option] = {}
    for name, one in declared.items():
        for option in one.options:
            if options.setdefault(option.name, option) != option:
                raise ValueError(f"{what} {name}: another {what}'s {option.name} differs")
    return options


def with_options(
    what: str, declared: Declared, make_setting: Callable[..., Any]
) -> Callable[[Settings], Settings]:
    """Return a decorator that adds a setting for each option that one of them declares.

    `what` is the setting that chooses among them.
    """

    def extend(settings: Settings) -> Settings:
        fields: Mapping[str, Any] = {
            name: (
                type(option.default),
                make_setting(
                    option.default,
                    title=option.title,
                    help=option.help,
                    unit=option.unit,
                    low=option.low,
                    high=option.high,
                    choices=option.choices or None,
                    tag=option.tag,
                    source=option.source,
                    advanced=option.advanced,
                    applies={what: _having(name, declared), **option.applies},
                ),
            )
            for name, option in declared_options(what, declared).items()
        }
        extended: Any = create_model(
            settings.__name__,
            __base__=settings,
            __doc__=settings.__doc__,
            __module__=settings.__module__,
            **fields,
        )
        return extended  # type: ignore[no-any-return]  # pydantic's stubs do not know the class

    return extend


def _having(option: str, declared: Declared) -> list[str]:
    """Return the names of those that have an option."""
    return [name for name, one in declared.items() if option in one.option_names]


def declarations(names: Iterable[str], declaration: Callable[[str], Declaration[Any]]) -> Declared:
    """Return the declarations of the names of a registry."""
    return {name: declaration(name) for name in names}
