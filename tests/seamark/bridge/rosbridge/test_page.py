"""docs/bridges.md has the topics that a bridge publishes."""

from pathlib import Path

from seamark.bridge.rosbridge.server import RESULT_TOPIC
from seamark.bridge.rosbridge.topics import RESULT, TOPICS, Ros

PAGE = Path(__file__).parents[4] / "docs" / "bridges.md"
BEGIN, END = "test_page.py -->\n", "<!-- end -->"


def _table() -> str:
    rows = [
        f"| `{name}` | `{topic.type_in(Ros.ONE)}` | {topic.meaning} |"
        for name, topic in [*TOPICS.items(), (RESULT, RESULT_TOPIC)]
    ]
    return "\n".join(["| topic | type | message |", "|---|---|---|", *rows, ""])


def test_the_page_has_the_table_of_the_topics() -> None:
    text = PAGE.read_text("utf-8")

    found = text.partition(BEGIN)[2].partition(END)[0]

    assert found == _table(), f"write this into {PAGE}:\n{_table()}"
