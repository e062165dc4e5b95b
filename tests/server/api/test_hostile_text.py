"""What programs print is shown to people, and must not act on what shows it."""

from seamark.server.runs.data.files import RunFiles
from tests.server.api.conftest import Site

RUNS = "/api/v1/runs"


def test_a_log_is_shown_without_what_acts_on_a_terminal_or_reader(site: Site) -> None:
    run_id = site.recorded()
    log = "\x1b]52;c;cm0gLXJm\x07 \u202eabc\n"
    RunFiles(site.settings.data, run_id, 1).append_log(log.encode())

    for path in (f"{RUNS}/{run_id}/log", f"{RUNS}/{run_id}/events", f"/runs/{run_id}"):
        text = site.call("owner", "GET", path).text
        assert "cm0gLXJm" in text
        assert not {"\x1b", "\x07", "\u202e"} & set(text)
        assert "\\\\u202e" in text if path.endswith("/events") else r"\u202e" in text
