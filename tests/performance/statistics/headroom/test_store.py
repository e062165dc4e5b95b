"""What the entries of the benchmarks scored, in a file that shows what has changed."""

from pathlib import Path

from performance.statistics.headroom.store import store, stored


def test_storing_a_benchmark_changes_no_line_of_another_one(tmp_path: Path) -> None:
    file = tmp_path / "headroom.json"
    file.write_text("{}")
    store("a", {"pi": {"seed": 1, "scores": [0.5, 0.25]}}, file=file)
    before = file.read_text().splitlines()[2:-2]
    store("b", {"esm": {"scores": [3.0]}, "klt": {"scores": []}}, file=file)

    assert before == [' "pi": {"seed": 1, "scores": [0.5, 0.25]}']
    assert set(before) < set(file.read_text().splitlines())
    assert stored("a", file=file) == {"pi": {"seed": 1, "scores": [0.5, 0.25]}}
    assert [*stored("b", file=file)] == ["esm", "klt"]
    assert stored("c", file=file) == {}
