"""What a benchmark is; one file per benchmark beside this one."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any

from seamark.sim.metrics.metric import Metric, MetricGroup
from seamark.sim.settings.configuration import Configuration, ConfigurationInvalid, schema_of
from seamark.sim.settings.setting import schema_extras

if TYPE_CHECKING:
    from seamark.sim.engine.experiment import Experiment
    from seamark.sim.recording.telemetry import Rows


@dataclass(frozen=True, slots=True)
class Chart:
    """A chart that the run page offers: title, unit and the telemetry's columns in it."""

    title: str
    unit: str
    columns: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Curve:
    """A chart over the levels: metrics in one unit, and the limit that ends the score.

    `values` gives the levels' own values in the unit of the score, for a configuration; `measure`
    makes a level's metrics from its rows of telemetry, so that the chart can grow while the run
    goes on.
    """

    metrics: tuple[Metric, ...]
    limit: float
    values: Callable[[Any], tuple[float, ...]]
    measure: Callable[["Rows"], Mapping[str, Any]]


@dataclass(frozen=True, slots=True)
class Baseline:
    """A built-in entry of the leaderboard: title, what is built in, and its settings."""

    title: str
    built_in: str
    config: Mapping[str, object] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Table:
    """A table of the run page: metrics by level, their names in the metrics with a prefix.

    Settings in braces in the title are filled in.
    """

    title: str
    metrics: tuple[Metric, ...]
    prefix: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Benchmark:
    """A benchmark version. Its numbers never change after release; a change is a new version."""

    name: str
    title: str
    summary: str
    participants: str
    role: str  # of the programs that take part: "controller" or "tracker"
    built_in: Mapping[str, str]  # name -> label of what takes part without a program
    experiment: str  # path, module:attribute, of a seamark.sim.engine.experiment.Experiment
    headline: Metric
    score_bar_max: float  # where a bar of the score ends
    level_held_unit: str  # of the highest level held
    charts: tuple[Chart, ...]
    tables: tuple[Table, ...]
    key_metrics: tuple[Metric, ...]  # of the tables, at each level of each trial and in short lists
    metric_groups: tuple[MetricGroup, ...]  # what is computed of a level, for the documentation
    overall: tuple[Metric, ...] = ()  # metrics over all levels
    baselines: Mapping[str, Baseline] = field(default_factory=dict)  # by the end of the user's name
    # settings -> name of the built-in solution that they make, where `built_in` does not say it
    solution_label: Callable[[Mapping[str, object]], str] | None = None
    configuration: type[Configuration]
    groups: tuple[str, ...]  # of settings, in the form's order
    # setting -> its value -> values of other settings that come with the choice; the later one wins
    presets: Mapping[str, Mapping[str, Mapping[str, object]]] = field(default_factory=dict)
    quick_settings: Mapping[str, object] = field(default_factory=dict)  # settings of a quick run
    ranked_trials: int = 10
    curve: Curve | None = None

    def load(self) -> "Experiment":
        """Return what runs the levels; loads the simulator with Numba and OpenCV."""
        loaded: Experiment = resolve_name(self.experiment)
        return loaded

    def read(self, values: Mapping[str, object]) -> Configuration:
        """Return the checked configuration; what is left out comes with what was chosen.

        Raises
        ------
        ConfigurationInvalid
            One sentence per wrong setting, all at once.
        """
        preset: dict[str, object] = {}
        for name, choices in self.presets.items():
            preset |= choices.get(str(values.get(name)), {})
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
        """Return what a ranked run uses: the benchmark's scenario, the user's solution.

        Raises
        ------
        ConfigurationInvalid
            If a solution's setting may not rank, such as ground truth in the tracker's place.
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

    def charts_of(self, config: Configuration) -> tuple[Chart, ...]:
        """Return the charts of a run, without the columns in which nothing happens."""
        idle = config.unused_columns()
        shown = (
            Chart(chart.title, chart.unit, tuple(c for c in chart.columns if c not in idle))
            for chart in self.charts
        )
        return tuple(chart for chart in shown if chart.columns)

    def solution_label_of(self, controller: str, config: Mapping[str, object]) -> str:
        """Return what people call the built-in solution of a run."""
        if self.solution_label is not None:
            return self.solution_label(config)
        return self.built_in.get(controller, controller)

    def level_held_unit_of(self, config: Configuration) -> str:
        """Return the unit of the highest level held."""
        own = config.headline()
        return self.level_held_unit if own is None else own.unit

    def headline_of(self, config: Configuration) -> Metric:
        """Return what the score of a run with this configuration is."""
        return config.headline() or self.headline

    def trial_duration_s(self, config: Configuration) -> float:
        """Return the simulated length of one trial."""
        return config.trial_duration_s()
