"""A box as the simulator uses it: load, reset, step, finish, with real programs."""

import contextlib
import json
import os
import sys
import textwrap
from collections import deque
from collections.abc import Iterator

import numpy as np
import pytest

from seamark.sandbox.box import Box
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import ProgramEnded, SandboxBroken, Verdict
from tests.sandbox.conftest import LAYOUT, VALUES, descriptors, printed, program

pytestmark = pytest.mark.host


@pytest.fixture
def box(isolation: IsolationLevel) -> Iterator[Box]:
    with Box(limits=Limits(), isolation=isolation) as started:
        yield started


def end_of(box: Box, source: bytes) -> ProgramEnded:
    with pytest.raises(ProgramEnded) as end:
        printed(box, source)
    return end.value


@pytest.mark.parametrize(
    "values", [VALUES, tuple(VALUES), np.array(VALUES), np.array(VALUES, "f4")]
)
def test_an_observation_goes_in_and_a_command_comes_out(box, values) -> None:
    box.load(program(step="return [*observation.error, observation.thrust[4]]"), "a.py", {}, LAYOUT)

    assert box.step(values) == (1.0, 2.0, 3.0, 0.5)


def test_a_program_sees_the_same_descriptors_however_many_files_the_worker_has_open(
    isolation,
) -> None:
    source = (
        b"import os\n\n\ndef is_open(number):\n    try:\n        return bool(os.fstat(number))\n"
    )
    source += b"    except OSError:\n        return False\n\n\n"
    source += program(step="print([number for number in range(256) if is_open(number)])")
    outputs = []
    with contextlib.ExitStack() as held:
        for _ in range(2):
            with Box(limits=Limits(), isolation=isolation) as box:
                outputs.append(printed(box, source))
            for number in [os.dup(0) for _ in range(40)]:
                held.callback(os.close, number)

    assert outputs[0] == outputs[1] == "[0, 1, 2, 3]\n"


@pytest.mark.parametrize("make", [list, np.array])
def test_the_same_buffer_is_sent_with_its_current_values(box, make) -> None:
    box.load(program(step="return [*observation.error, observation.thrust[4]]"), "a.py", {}, LAYOUT)
    values = make(VALUES)
    box.step(values)

    values[1] = 7.0

    assert box.step(values) == (7.0, 2.0, 3.0, 0.5)


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        ("observation.t", "0.25"),
        ("observation['t']", "0.25"),
        ("observation.target_visible", "True"),
        ("observation.error", "[1. 2. 3.]"),
        ("type(observation.error).__name__", "ndarray"),
        ("observation.error.flags.writeable", "False"),
        ("list(observation)", "['t', 'error', 'target_visible', 'thrust']"),
        ("observation.error is observation['error']", "True"),
        ("'truth' in observation", "False"),
    ],
)
def test_an_observation_is_a_mapping_with_attributes(box, expression, expected) -> None:
    assert printed(box, program(step=f"print({expression})")) == expected + "\n"


@pytest.mark.parametrize(
    "answer",
    [
        "(0, 1, 2, 3)",
        "np.arange(4)",
        "np.arange(4.0, dtype='f4')",
        "[np.float64(0), 1, np.int8(2), 3]",
        "[np.array(0.0), 1, 2, 3]",
        "[False, 1, 2, 3]",
    ],
)
def test_any_sequence_of_four_numbers_is_a_command(box, answer) -> None:
    source = b"import numpy as np\n" + program(step=f"return {answer}")
    box.load(source, "a.py", {}, LAYOUT)

    assert box.step(VALUES) == (0.0, 1.0, 2.0, 3.0)


def test_a_program_keeps_its_state_over_levels_and_gets_its_configuration(box) -> None:
    source = textwrap.dedent("""
        class Controller:
            def __init__(self, config):
                self.seen = [config["kp"]]
            def reset(self, level):
                self.seen.append(level["index"])
            def step(self, observation):
                return [*self.seen, 0.0]
    """)
    box.load(source.encode(), "a.py", {"kp": 0.5}, LAYOUT)
    box.reset({"index": 1})
    box.reset({"index": 2})

    assert box.step(VALUES) == (0.5, 1.0, 2.0, 0.0)


def test_a_program_of_two_mebibytes_is_loaded(box) -> None:
    source = program(step="return [1.0, 2.0, 3.0, 4.0]")
    box.load(source + b"#" * (2 * 1024 * 1024 - len(source)), "a.py", {}, LAYOUT)

    assert box.step(VALUES) == (1.0, 2.0, 3.0, 4.0)


def test_scipy_is_there(isolation) -> None:
    source = b"from scipy import linalg, signal\n" + program(step="print(linalg.det([[2.0]]))")

    with Box(limits=Limits(start_wall_s=60.0), isolation=isolation) as box:
        assert printed(box, source) == "2.0\n"


def test_two_boxes_have_the_same_hash_seed_so_that_sets_have_one_order(isolation) -> None:
    source = program(step="print(hash('seamark'), {'a', 'b', 'c', 'd'})")

    texts = []
    for _ in range(2):
        with Box(limits=Limits(), isolation=isolation) as box:
            texts.append(printed(box, source))

    assert texts[0] == texts[1]


def test_a_program_stays_on_its_core(isolation) -> None:
    core = max(os.sched_getaffinity(0))
    source = b"import os\n" + program(step="print(os.sched_getaffinity(0))")

    with Box(limits=Limits(), isolation=isolation, core=core) as box:
        assert printed(box, source) == f"{{{core}}}\n"


def test_the_file_has_its_uploaded_name_without_folders(box) -> None:
    end = end_of(box, program(step="print(1)\n        raise ValueError('deep')"))

    assert end.outcome.sentence == "ValueError: deep (line 8 of mine.py)"
    assert end.outcome.traceback.splitlines()[-3:] == [
        '  File "mine.py", line 8, in step',
        "    raise ValueError('deep')",
        "ValueError: deep",
    ]


def test_a_path_in_the_name_of_the_file_is_dropped(box) -> None:
    with pytest.raises(ProgramEnded) as end:
        box.load(b"raise ValueError", "../../etc/mine.py", {}, LAYOUT)

    assert "line 1 of mine.py" in end.value.outcome.sentence


def test_a_chain_of_exceptions_is_shown_with_the_programs_frames_only(box) -> None:
    source = b"import json\n" + program(
        step="try:\n            json.loads('{')\n        except ValueError as e:\n"
        "            raise RuntimeError('no plan') from e"
    )

    trace = end_of(box, source).outcome.traceback

    assert "JSONDecodeError" in trace
    assert "direct cause" in trace
    assert {line.split('"')[1] for line in trace.splitlines() if "File" in line} == {"mine.py"}


def test_a_wrong_answer_is_explained_with_its_line(box) -> None:
    outcome = end_of(box, program(step="return None")).outcome

    assert outcome.verdict is Verdict.PROTOCOL_ERROR
    assert "returned None" in outcome.sentence
    assert "four finite numbers" in outcome.sentence
    assert "line 6 of mine.py" in outcome.sentence


def test_output_is_read_piece_by_piece_and_kept_as_a_whole(box) -> None:
    box.load(program(step="print(observation.t)"), "a.py", {}, LAYOUT)
    pieces = []
    for t in (1.0, 2.0):
        box.step([t, *VALUES[1:]])
        pieces.append(box.take_output())

    assert pieces == [b"1.0\n", b"2.0\n"]
    assert box.take_output() == b""
    assert box.finish().output == b"1.0\n2.0\n"


def test_more_than_a_pipe_holds_is_printed_in_one_step_without_a_deadlock(isolation) -> None:
    with Box(limits=Limits(output_kib=4), isolation=isolation) as box:
        box.load(program(step="print('x' * 1_000_000)"), "a.py", {}, LAYOUT)
        box.step(VALUES)
        outcome = box.finish()

    assert outcome.verdict is Verdict.OK
    assert outcome.output_dropped == 1_000_001 - 4096


def test_a_box_that_ended_reports_the_same_outcome_again(box) -> None:
    first = end_of(box, program(step="raise ValueError"))

    for call in (lambda: box.step(VALUES), lambda: box.reset({}), box.finish):
        with pytest.raises(ProgramEnded) as again:
            call()
        assert again.value.outcome == first.outcome


def test_an_observation_of_the_wrong_size_is_our_mistake_not_the_programs(box) -> None:
    box.load(program(), "a.py", {}, LAYOUT)

    with pytest.raises(ValueError, match="in the layout"):
        box.step([1.0])


def test_the_cpu_time_of_the_start_is_not_the_programs(box) -> None:
    box.load(program(), "a.py", {}, LAYOUT)
    box.step(VALUES)

    assert box.finish().cpu_s < 0.05


def test_a_box_without_room_for_the_interpreter_is_our_failure(isolation) -> None:
    if isolation is not IsolationLevel.STRONG:
        pytest.skip("without control groups the limit begins after the interpreter's start")
    with Box(limits=Limits(memory_mib=8), isolation=isolation) as box, pytest.raises(SandboxBroken):
        box.load(program(), "a.py", {}, LAYOUT)


def test_without_isolation_no_box_starts() -> None:
    with pytest.raises(SandboxBroken, match="cannot isolate"):
        Box(limits=Limits(), isolation=IsolationLevel.NONE)


def test_a_box_closed_at_once_leaves_nothing(isolation) -> None:
    before = descriptors()
    Box(limits=Limits(), isolation=isolation).close()

    assert not descriptors() - before


def test_an_answer_may_take_long_while_others_have_the_processor(isolation: IsolationLevel) -> None:
    waits = program(step="import time; time.sleep(0.9)")
    limits = Limits(step_cpu_s=0.3, step_wall_s=20.0)

    with Box(limits=limits, isolation=isolation) as box:
        assert printed(box, waits) == ""


def test_many_short_answers_may_take_no_longer_together_than_the_run(
    isolation: IsolationLevel,
) -> None:
    limits = Limits(cpu_s=1.0, wall_s=1.0)

    with Box(limits=limits, isolation=isolation) as box:
        box.load(program(step="import time; time.sleep(0.015)"), "a.py", {}, LAYOUT)
        with pytest.raises(ProgramEnded) as end:
            deque((box.step(VALUES) for _ in range(200)), maxlen=0)

    assert end.value.outcome.verdict is Verdict.TIME_LIMIT
    assert "all its answers together" in end.value.outcome.sentence
    assert end.value.outcome.suspect_host


def test_an_answer_that_computes_too_long_ends_by_its_cpu_time(isolation: IsolationLevel) -> None:
    computes = program(step="while True: pass")
    limits = Limits(step_cpu_s=0.5, step_wall_s=60.0)

    with Box(limits=limits, isolation=isolation) as box:
        ended = end_of(box, computes).outcome

    assert ended.verdict is Verdict.TIME_LIMIT
    assert "0.5 s of CPU time" in ended.sentence
    assert not ended.suspect_host


def test_a_box_holds_nothing_of_the_host_but_the_interpreter_and_its_libraries(box: Box) -> None:
    seen = printed(
        box,
        program(
            step="import os, sys; print(sorted(os.listdir('/')), os.path.exists(PREFIX))"
        ).replace(b"PREFIX", repr(sys.prefix).encode()),
    )

    names, environment = seen.rsplit(" ", 1)
    assert set(json.loads(names.replace("'", '"'))) <= {
        "box",
        "dev",
        "etc",
        "lib",
        "lib64",
        "tmp",
        "usr",
    }
    assert environment.strip() == "False"
