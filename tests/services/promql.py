"""What the expressions of the board and of the rules refer to."""

import json
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import promql_parser
import yaml
from prometheus_client.metrics_core import Metric
from promql_parser import AggregateExpr, MatchOp, VectorSelector

DEPLOY = Path(__file__).parents[2] / "deploy"
BOARD, RULES = DEPLOY / "grafana" / "seamark.json", DEPLOY / "prometheus" / "alerts.yml"
WORDS = re.compile(r"[a-z_]+(\|[a-z_]+)*")  # values, and no pattern or variable
Exported = dict[str, dict[str, set[str]]]
OF_PROMETHEUS = {"job", "instance", "le"}  # labels that it adds, or that buckets have


def rules() -> list[dict[str, Any]]:
    """Return the recording rules and the alerts."""
    groups = yaml.safe_load(RULES.read_text("utf-8"))["groups"]
    return [rule for group in groups for rule in group["rules"]]


def expressions() -> list[str]:
    """Return all expressions, with the variables of Grafana replaced."""
    panels = json.loads(BOARD.read_text("utf-8"))["panels"]
    queries = [target["expr"] for panel in panels for target in panel.get("targets", [])]
    of_board = [query.replace("$__rate_interval", "5m") for query in queries]
    return of_board + [rule["expr"] for rule in rules()]


def labels_and_values(metrics: Iterable[Metric]) -> Exported:
    """Return the labels of each series that a service exports, with their values."""
    found: Exported = {}
    for metric in metrics:
        for sample in metric.samples:
            labels = found.setdefault(sample.name, {})
            for label, value in sample.labels.items():
                labels.setdefault(label, set()).add(value)
    return found


def unknown_in(expression: str, exported: Exported) -> list[str]:
    """Return the metrics, labels and values of labels that no series has."""
    recorded: Exported = {rule["record"]: {"lane": set()} for rule in rules() if "record" in rule}
    known = exported | recorded | {"up": {}}
    nodes = list(_below(promql_parser.parse(expression)))
    selectors = [node for node in nodes if isinstance(node, VectorSelector)]
    grouped = {
        label
        for node in nodes
        if isinstance(node, AggregateExpr) and node.modifier is not None
        for label in node.modifier.labels
    }
    unknown = [str(selector.name) for selector in selectors if selector.name not in known]
    labels = {label for selector in selectors for label in known.get(str(selector.name), {})}
    unknown += grouped - labels - OF_PROMETHEUS
    for selector in selectors:
        unknown += _unknown_matchers(selector, known.get(str(selector.name), {}))
    return unknown


def _unknown_matchers(selector: VectorSelector, labels: dict[str, set[str]]) -> list[str]:
    unknown = []
    for matcher in selector.matchers.matchers:
        if matcher.name in OF_PROMETHEUS:
            continue
        if matcher.name not in labels:
            unknown.append(f"{selector.name}{{{matcher.name}}}")
        elif matcher.op in (MatchOp.Equal, MatchOp.Re) and WORDS.fullmatch(matcher.value):
            missing = set(matcher.value.split("|")) - labels[matcher.name]
            unknown += [f'{selector.name}{{{matcher.name}="{word}"}}' for word in missing]
    return unknown


def _below(node: Any) -> Iterator[Any]:
    yield node
    for name in ("lhs", "rhs", "expr", "vector_selector"):
        if (child := getattr(node, name, None)) is not None:
            yield from _below(child)
    for child in getattr(node, "args", None) or ():
        yield from _below(child)
