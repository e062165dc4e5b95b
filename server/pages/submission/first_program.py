"""The first controller: an editor with five lines that run, and what to know beside it."""

from flask import Blueprint, g, render_template

from seamark.programs.setting_values import text_of
from seamark.sandbox.languages import DEFAULT_LANGUAGE, LANGUAGES, editor_starters, kinds
from seamark.server.accounts.permissions import Action, can
from seamark.server.messaging import workers
from seamark.server.runs.showing import recorded_demo
from seamark.server.web.services import services
from seamark.sim import registry

TITLE = "My first controller"
TEXT = """\
class Controller:
    def __init__(self, config): self.gain = 0.8  # m/s for each metre of error
    def reset(self, level): pass  # called at the start of each level
    def step(self, observation):  # called 20 times per simulated second
        return [*(self.gain * observation.error[:2]), 0.0, 0.0]
"""
page = Blueprint("first_program", __name__)


@page.get("/first-controller")
def show() -> str:
    """Show the editor; the run that it starts is that of the demo, with this program."""
    benchmark = registry.benchmark(recorded_demo.BENCHMARK)
    with services().database.reading() as session:
        refusal = workers.upload_refusal(session, DEFAULT_LANGUAGE, services().settings)
    return render_template(
        "submit/first_program.html",
        benchmark=benchmark,
        title=TITLE,
        text=TEXT,
        language=LANGUAGES[DEFAULT_LANGUAGE],
        other_kinds=kinds(name for name in LANGUAGES if name != DEFAULT_LANGUAGE),
        file_name=editor_starters(benchmark.role)[DEFAULT_LANGUAGE].upload_name,
        settings=recorded_demo.SETTINGS,
        fields={name: text_of(value) for name, value in recorded_demo.SETTINGS.items()},
        seed=recorded_demo.SEED,
        uploads=can(g.viewer, Action.UPLOAD),
        upload_refusal=refusal,
    )
