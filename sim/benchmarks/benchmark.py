"""The declaration of a benchmark: settings, experiment, score and presentation."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any

from seamark.sim.metrics.metric import LevelMetric, Metric, MetricGroup, over_whole_run
from seamark.sim.metrics.stages import Stage
from seamark.sim.settings.configuration import Configuration, schema_of
from seamark.sim.settings.refusal import ConfigurationInvalid
from seamark.sim.settings.setting import schema_extras

if TYPE_CHECKING:
    from seamark.sim.engine.experiment import Experiment
    from seamark.sim.recording.telemetry import Rows


@dataclass(frozen=True, slots=True)
class Chart:
    """A chart of the run page: title, unit and columns of the telemetry."""

    title: str
    unit: str
    columns: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Curve:
    """A chart over levels: metrics in one unit, and the limit at which a level fails.

    `values` returns the value of each level of a configuration; `measure` computes the metrics of a
    level from its telemetry, so that the chart grows during the run.
    """

    metrics: tuple[Metric, ...]
    limit: float
    values: Callable[[Any], tuple[float, ...]]
    measure: Callable[["Rows"], Mapping[str, Any]]
    # the levels that belong to it, such as those of one axis of difficulty; None: all
    levels: Callable[[Any], tuple[int, ...]] | None = None
    # the area under the first metric, which the chart marks: the headline or one of `overall`.
    # None: the headline is where the first metric falls below the limit
    area: Metric | None = None
    x_label: str = ""  # of the values with their unit; empty: the unit of the headline


@dataclass(frozen=True, slots=True)
class Midpoint:
    """A midpoint fitted to all trials of a run together (`numerics.psychometric`).

    `point` returns the value of a level, given its metrics, and the share of success there from 0
    to 1; None for a level that does not count.
    """

    metric: Metric
    point: Callable[[Mapping[str, Any]], tuple[float, float] | None]


@dataclass(frozen=True, slots=True)
class Stages:
    """How far a level may get, step by step: `reached` finds in its rows when it did.

    It returns the row at which each stage was reached, as far as they were, given the rows of a
    level so far and the time from one to the next [s]. `before` is what the way to the first one
    is called, if it is to be seen like a stage.
    """

    stages: tuple[Stage, ...]
    reached: Callable[["Rows", float], tuple[int, ...]]
    before: str = ""


@dataclass(frozen=True, slots=True)
class Baseline:
    """A built-in entry of the leaderboard: title, built-in solution, its settings, and notes."""

    title: str
    built_in: str
    config: Mapping[str, object] = field(default_factory=dict)
    notes: str = ""  # of its run, such as how it was trained


@dataclass(frozen=True, slots=True)
class StartingPoint:
    """A preset of the form: fills in several settings at once. It has no part in any score.

    `built_in` is the solution that it selects; empty: it leaves the user's choice.
    """

    title: str
    summary: str
    config: Mapping[str, object] = field(default_factory=dict)
    built_in: str = ""


@dataclass(frozen=True, slots=True)
class Table:
    """A table of the run page: metrics by level; `prefix` is that of their names in metrics.json.

    Settings in braces in the title are replaced by their values.
    """

    title: str
    metrics: tuple[Metric, ...]
    prefix: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class RankedProtocol:
    """The trials of a ranked run: first the reference trials, then the fresh ones.

    Reference trials use the public seed `reference_seed`,
    so every entry has the same trials and a practice run can repeat them. Fresh trials decide the
    score; their seeds follow from the server's secret and the submission, so nobody can know them.
    """

    reference_trials: int
    fresh_trials: int
    block: int = 1  # consecutive trials that are averaged before the interval is computed
    reference_seed: int = 2026
    # Whether the fresh trials of a run have one seed together, by which they divide what is drawn
    # among themselves. A trial's number is part of what its seed gives: they differ all the same.
    shared_seed: bool = False
    excused_share: float = 0.25  # of the fresh trials: may break a rule without barring the run; E

    @property
    def excused_trials(self) -> int:
        """Number of fresh trials that may break a rule, such as in exceptionally bad conditions."""
        return int(self.excused_share * self.fresh_trials)

    @property
    def trials(self) -> int:
        """Number of all trials."""
        return self.reference_trials + self.fresh_trials


@dataclass(frozen=True, slots=True, kw_only=True)
class Benchmark:
    """A benchmark version. Its numbers never change after release; a change is a new version."""

    name: str
    title: str
    summary: str
    participants: str  # in the plural, such as "trackers"
    role: str  # of uploaded programs: "controller", "tracker" or "detector"
    # roles of further programs that may be uploaded beside it; else the settings choose built-in
    # ones. The experiment then gets a `seamark.sim.engine.team.Team`
    parts: tuple[str, ...] = ()
    moves_arm: bool = False  # whether its programs move an arm: they start from other ones
    follows_route: bool = False  # whether its programs follow a route
    enters_dock: bool = False  # whether its programs enter a dock
    built_in: Mapping[str, str]  # name -> label of the built-in solutions
    # name -> label of built-in solutions that only baselines may use: marks such as an oracle
    reference_built_in: Mapping[str, str] = field(default_factory=dict)
    experiment: str  # path, module:attribute, of a seamark.sim.engine.experiment.Experiment
    headline: Metric
    score_bar_max: float  # right end of the score bars of the leaderboard
    level_held_unit: str  # of the highest level held
    # of its environments: seamark/<family>-v1 for <name>-v1; empty: the name in capitals
    gym_family: str = ""
    question: str = ""  # that its leaderboard answers, where the summary does not say it
    # of the telemetry: the error that it is about; None: no single column says it
    error_column: str | None = "distance"
    charts: tuple[Chart, ...]
    tables: tuple[Table, ...]
    key_metrics: tuple[Metric, ...]  # of the tables, for each trial and in short lists
    metric_groups: tuple[MetricGroup, ...]  # all metrics of a level, for the documentation
    overall: tuple[Metric, ...] = ()  # metrics over all levels
    # which levels `overall` takes its means from, where it is not all: "turbidity levels"
    overall_levels: str = ""
    # by which the leaderboard can be sorted beside the score; of `overall` or of the levels
    board_metrics: tuple[Metric, ...] = ()
    # two of them: an error and what it costs, for the plot of entries that nobody beats in both
    pareto: tuple[Metric, Metric] | None = None
    midpoint: Midpoint | None = None  # its metric is one of `overall`
    scale: tuple[float, float] | None = None  # scores of doing nothing and of the oracle
    baselines: Mapping[str, Baseline] = field(
        default_factory=dict
    )  # keyed by the suffix of the user name
    # label of a built-in solution, if it depends on the settings
    solution_label: Callable[[Mapping[str, object]], str] | None = None
    configuration: type[Configuration]
    groups: tuple[str, ...]  # of settings, in the form's order
    # setting -> its value -> values of other settings that come with it; later ones win
    presets: Mapping[str, Mapping[str, Mapping[str, object]]] = field(default_factory=dict)
    starting_points: Mapping[str, StartingPoint] = field(default_factory=dict)  # by name
    quick_settings: Mapping[str, object] = field(
        default_factory=dict
    )  # settings of the shortest run
    # None: the first versions, whose ranked runs all have the same hidden seeds
    protocol: RankedProtocol | None = None
    shared_trials: int = 10  # of a ranked run without a protocol
    curves: tuple[Curve, ...] = ()
    stages: Stages | None = None

    @property
    def ranked_trials(self) -> int:
        """Number of trials of a ranked run."""
        return self.shared_trials if self.protocol is None else self.protocol.trials

    @property
    def lacks_images(self) -> str:
        """Why the images of a run of its programs are no data set; empty if they are one."""
        if self.follows_route:
            return "nothing in it is done by images"
        return "its marker is out of view for most of the way" if self.enters_dock else ""

    @property
    def has_data_sets(self) -> bool:
        """Whether a data set can be made of the images of a trial."""
        return self.role != "detector" and not self.lacks_images

    @property
    def stage_labels(self) -> tuple[str, ...]:
        """Labels of the stages of a level, if it has some."""
        return tuple(stage.label for stage in self.stages.stages) if self.stages else ()

    @property
    def before_stages(self) -> str | None:
        """What comes before the first stage, if that is to be seen."""
        return (self.stages.before or None) if self.stages else None

    @property
    def gym_id(self) -> str:
        """Return the name of its environments in Gymnasium's registry."""
        name, _, version = self.name.rpartition("-")
        return f"seamark/{self.gym_family or name.title().replace('-', '')}-{version}"

    def load(self) -> "Experiment":
        """Return the experiment; loads the simulator with Numba and OpenCV."""
        loaded: Experiment = resolve_name(self.experiment)
        return loaded

    def read(self, values: Mapping[str, object]) -> Configuration:
        """Return the validated configuration; presets of the chosen values fill in what is missing.

        Raises
        ------
        ConfigurationInvalid
            With one message per invalid setting, all at once.
        """
        preset: dict[str, object] = {}
        for name, choices in self.presets.items():
            chosen = values.get(name)
            preset |= choices.get(str(chosen), self.configuration.preset(name, chosen))
        return self.configuration.read({**preset, **values})

    def restore(self, values: Mapping[str, object]) -> Configuration:
        """Return the configuration of a stored run; never refuses one (`Configuration.restore`)."""
        return self.configuration.restore(values)

    def schema(self) -> dict[str, Any]:
        """Return the JSON Schema (2020-12) that the form is generated from."""
        presets = {
            name: {choice: dict(values) for choice, values in choices.items()}
            for name, choices in self.presets.items()
        }
        schema = schema_of(self.configuration, title=self.title, groups=self.groups)
        return schema | {"x-presets": presets}

    def ranked(self, config: Configuration) -> Configuration:
        """Return the configuration of a ranked run: the benchmark's scenario, the user's solution.

        Raises
        ------
        ConfigurationInvalid
            If the solution cannot rank, such as ground truth instead of a tracker.
        """
        fields = self.configuration.model_fields
        solution = {
            name: value
            for name, value in config.model_dump().items()
            if schema_extras(fields[name])["x-role"] == "solution"
        }
        errors = config.ranking_errors()
        if errors:
            raise ConfigurationInvalid(errors)
        return self.configuration.read(solution)

    def changes_scenario(self, config: Configuration) -> bool:
        """Return whether its scenario is another one than that of ranked runs."""
        scenario = (
            (name, field)
            for name, field in self.configuration.model_fields.items()
            if schema_extras(field)["x-role"] == "scenario"
        )
        return any(
            getattr(config, name) != field.get_default(call_default_factory=True)
            for name, field in scenario
        )

    def charts_of(self, config: Configuration) -> tuple[Chart, ...]:
        """Return the charts of a run, without unused columns."""
        unused = config.unused_columns()
        shown = (
            Chart(chart.title, chart.unit, tuple(c for c in chart.columns if c not in unused))
            for chart in self.charts
        )
        return tuple(chart for chart in shown if chart.columns)

    def solution_label_of(self, controller: str, config: Mapping[str, object]) -> str:
        """Return the label of the built-in solution of a run."""
        if controller in self.reference_built_in:
            return self.reference_built_in[controller]
        if self.solution_label is not None:
            return self.solution_label(config)
        return self.built_in.get(controller, controller)

    def overall_label(self, metric: Metric) -> str:
        """Return the name of a metric over the run, with the levels that it is a mean of."""
        of_levels = self.overall_levels and isinstance(metric, LevelMetric)
        return f"{metric.label}, {self.overall_levels}" if of_levels else metric.label

    def board_values(self, metrics: Mapping[str, Any]) -> dict[str, float]:
        """Return name -> value of each of `board_metrics` that the metrics.json of a run has.

        Over the whole run: a metric of levels is combined by its own aggregation.
        """
        overall, levels = metrics.get("overall") or {}, metrics.get("levels") or []
        values = {
            metric.name: over_whole_run(metric, overall, levels) for metric in self.board_metrics
        }
        return {
            name: value
            for name, value in values.items()
            if value is not None and math.isfinite(value)
        }

    def level_held_unit_of(self, config: Configuration) -> str:
        """Return the unit of the highest level held."""
        headline = config.headline()
        return self.level_held_unit if headline is None else headline.unit

    def headline_of(self, config: Configuration) -> Metric:
        """Return the metric that the score of a run with this configuration is."""
        return config.headline() or self.headline

    def percent_of_scale(self, score: float) -> float | None:
        """Return how far a score is from doing nothing (0) to the oracle (100) [%]."""
        if self.scale is None:
            return None
        nothing, oracle = self.scale
        return 100.0 * (score - nothing) / (oracle - nothing)

    def trial_duration_s(self, config: Configuration) -> float:
        """Return the simulated duration of one trial."""
        return config.trial_duration_s()
