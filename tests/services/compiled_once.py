"""What an application compiles at its start and for its pages, once in a process of tests.

Each test has an application and a database of its own; the service has one. Compiling took most of
their time.
"""

import atexit
import tempfile
from collections.abc import Callable, Iterable
from types import CodeType
from typing import Any, ClassVar

from flask import Flask
from flask.sansio.app import App
from flask.sansio.blueprints import Blueprint, BlueprintSetupState
from jinja2 import BytecodeCache
from jinja2.bccache import Bucket
from sqlalchemy import Engine
from sqlalchemy.dialects import registry
from sqlalchemy.dialects.postgresql.psycopg import PGDialect_psycopg
from sqlalchemy.dialects.sqlite.pysqlite import SQLiteDialect_pysqlite
from sqlalchemy.util import LRUCache
from werkzeug.routing import BaseConverter, Map, Rule
from werkzeug.routing.matcher import StateMachineMatcher
from werkzeug.routing.rules import RuleFactory, RulePart

from seamark.server.settings import Settings

Builder = Callable[..., tuple[str, str]]


class CompiledTemplates(BytecodeCache):
    """The compiled templates of this process."""

    def __init__(self) -> None:
        self._code: dict[tuple[str, str], CodeType] = {}

    def load_bytecode(self, bucket: Bucket) -> None:
        """Load what was compiled from the same source."""
        if (code := self._code.get((bucket.key, bucket.checksum))) is not None:
            bucket.code = code

    def dump_bytecode(self, bucket: Bucket) -> None:
        """Keep what has been compiled."""
        assert bucket.code is not None
        self._code[bucket.key, bucket.checksum] = bucket.code


class CompiledRule(Rule):
    """A route with the parts, and the functions that build addresses, of an equal route."""

    _builders: ClassVar[dict[tuple[object, ...], Builder]] = {}
    _parsed: ClassVar[
        dict[str, tuple[list[RulePart], list[tuple[bool, str]], dict[str, BaseConverter]]]
    ] = {}

    def _parse_rule(self, rule: str) -> Iterable[RulePart]:
        if rule not in self._parsed:
            before = len(self._trace)
            parts = list(super()._parse_rule(rule))
            self._parsed[rule] = parts, self._trace[before:], dict(self._converters)
            return parts
        parts, trace, converters = self._parsed[rule]
        self._trace += trace
        self._converters |= converters
        self.arguments |= converters.keys()
        return parts

    def _compile_builder(self, append_unknown: bool = True) -> Builder:
        if self.defaults:  # they are written into the function
            return super()._compile_builder(append_unknown)
        key = (self.rule, append_unknown, *self._trace)
        if key not in self._builders:
            self._builders[key] = super()._compile_builder(append_unknown)
        return self._builders[key]


class CompiledMap(Map):
    """The routes of an application; what finds them is that of one with equal routes."""

    _matchers: ClassVar[dict[tuple[object, ...], StateMachineMatcher]] = {}

    def add(self, rulefactory: RuleFactory) -> None:
        """Add a route or several; `update` makes them found."""
        for rule in rulefactory.get_rules(self):
            rule.bind(self)
            self._rules_by_endpoint.setdefault(rule.endpoint, []).append(rule)
        self._remap = True

    def add_bound(self, rule: Rule) -> None:
        """Add a route that is one of another application too."""
        self._rules_by_endpoint.setdefault(rule.endpoint, []).append(rule)
        self._remap = True

    def update(self) -> None:
        """Do what must be done before the next route is found, if any was added."""
        if not self._remap:
            return
        rules = [rule for rules in self._rules_by_endpoint.values() for rule in rules]
        key = (self.merge_slashes, *map(_of_route, rules))
        if key not in self._matchers:
            self._matchers[key] = StateMachineMatcher(self.merge_slashes)
            for rule in rules:
                if not rule.build_only:
                    self._matchers[key].add(rule)
        self._matcher = self._matchers[key]
        super().update()


class SharedRoutes(BlueprintSetupState):
    """Gives an application the routes of a blueprint that another one has, rather than its own."""

    _rules: ClassVar[dict[tuple[object, ...], Rule]] = {}

    def add_url_rule(
        self,
        rule: str,
        endpoint: str | None = None,
        view_func: Callable[..., Any] | None = None,
        **options: Any,
    ) -> None:
        """Add a route, and what answers its requests."""
        routes = self.app.url_map
        assert isinstance(routes, CompiledMap)
        where = (self.url_prefix, self.subdomain, self.name_prefix, self.name)
        how = (repr(sorted(self.url_defaults.items())), repr(sorted(options.items())))
        key = (self.blueprint, *where, rule, endpoint, view_func, *how)
        if (known := self._rules.get(key)) is None:
            super().add_url_rule(rule, endpoint, view_func, **options)
            own = endpoint or getattr(view_func, "__name__", "")
            name = f"{self.name_prefix}.{self.name}.{own}".lstrip(".")
            self._rules[key] = routes._rules_by_endpoint[name][-1]
            return
        routes.add_bound(known)
        if view_func is not None:
            answers = self.app.view_functions.setdefault(known.endpoint, view_func)
            assert answers == view_func, f"two functions answer {known.endpoint}"


def _of_route(rule: Rule) -> tuple[object, ...]:
    """Return all by which a route is found, and what is found."""
    methods = frozenset(rule.methods or ())
    automatic = getattr(rule, "provide_automatic_options", None)  # Flask sets it
    how = (rule.build_only, rule.websocket, rule.strict_slashes, rule.redirect_to)
    return rule.endpoint, methods, automatic, *how, repr(rule.defaults), *rule._trace


class _CompiledStatements:
    """Makes the dialects of one kind equal, and their engines share the statements they compile."""

    _compiled: ClassVar[LRUCache[Any, Any]] = LRUCache(5000)

    @classmethod
    def engine_created(cls, engine: Engine) -> None:
        engine.update_execution_options(compiled_cache=cls._compiled)

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other)

    def __hash__(self) -> int:
        return hash(type(self))


class CompiledSqlite(_CompiledStatements, SQLiteDialect_pysqlite):
    """SQLite, all of whose databases are of one version here."""

    supports_statement_cache = True


class CompiledPostgresql(_CompiledStatements, PGDialect_psycopg):
    """PostgreSQL, all of whose databases are of one version here."""

    supports_statement_cache = True


def _shared_routes(blueprint: Blueprint, app: App, options: Any, first: bool) -> SharedRoutes:
    return SharedRoutes(blueprint, app, options, first)


def share() -> None:
    """Let the applications that are created from now on share what they compile."""
    registry.register("sqlite", __name__, CompiledSqlite.__name__)
    registry.register("postgresql.psycopg", __name__, CompiledPostgresql.__name__)
    Flask.jinja_options = {"bytecode_cache": CompiledTemplates()}
    Flask.url_rule_class = CompiledRule
    Flask.url_map_class = CompiledMap
    Blueprint.make_setup_state = _shared_routes  # type: ignore[assignment, method-assign]


def prepare() -> None:
    """Compile what every process of tests would compile for itself, before they are forked."""
    # Not above: most of what is tested does without the web application.
    from seamark.server.app import create_app
    from tests.services import tables

    with tempfile.TemporaryDirectory() as folder:
        values = {"data": folder, "database_url": f"sqlite:///{folder}/seamark.db"}
        # Nothing listens there.
        values |= {"broker_url": "redis://127.0.0.1:1", "secret_key": "only-for-tests"}
        settings = Settings.model_validate(values)
        tables.create(settings).close()
        app = create_app(settings)
        for name in app.jinja_env.list_templates(extensions=["html"]):
            app.jinja_env.get_template(name)
        answer = app.test_client().get("/docs/search?q=thruster")  # indexes the documentation
        assert answer.status_code == 200, answer.text
        services = app.extensions["seamark"]
        services.close()
        atexit.unregister(services.close)
