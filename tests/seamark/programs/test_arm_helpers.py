"""The kinematics that `seamark init` writes agree with the simulated arms, in every language."""

import random
import subprocess
import sys
import types
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from seamark.programs.arm_helpers import helper
from seamark.sim.multibody.assembly import Mounting, assemble
from seamark.sim.multibody.posture import Posture
from seamark.sim.registry import VEHICLES
from seamark.sim.vehicles import load
from seamark.sim.vehicles.linkage_reading import load_linkage

CARRIED = [(name, arm) for name in VEHICLES for arm in load(name).mounts]
FAR_M = (9.0, 0.0, 0.0)
STEP_RAD = 1e-6
each_arm = pytest.mark.parametrize(("vehicle", "arm"), CARRIED)


def module() -> types.ModuleType:
    """Return the file for Python, as a program would import it."""
    made = types.ModuleType("arm")
    exec(helper("python")["arm.py"], made.__dict__)  # noqa: S102  # our own file
    return made


ARM = module()


def postures(vehicle: str, arm: str, count: int) -> list[list[float]]:
    """Return joints of all motors, drawn evenly from most of their ranges."""
    draw = random.Random(f"{vehicle} {arm}")  # noqa: S311  # a test
    ranges = ARM.arm_of({"vehicle": vehicle, "arm": arm}).ranges
    return [
        [low + draw.uniform(0.05, 0.95) * (high - low) for low, high in ranges]
        for _ in range(count)
    ]


@each_arm
def test_the_tool_is_where_the_simulator_has_it(vehicle: str, arm: str) -> None:
    known, linkage = load(vehicle), load_linkage(arm)
    mounting = Mounting(linkage=linkage, place=known.mounts[arm], on_vehicle=True)
    assembly = assemble(known, [mounting], bottom=False)
    posture = Posture(assembly)
    assert assembly.tool is not None
    link = assembly.mechanism.number(assembly.tool.link)
    kinematics = ARM.arm_of({"vehicle": vehicle, "arm": arm})

    for joints in postures(vehicle, arm, 20):
        motion = np.concatenate([np.zeros(12), joints, np.zeros(len(joints))])
        turns, points, _ = posture.place(motion)
        tool = kinematics.tool(joints)

        assert tool.point == pytest.approx(
            turns[link] @ assembly.tool.point + points[link], rel=0.0, abs=1e-9
        )
        assert np.array(tool.turn) == pytest.approx(
            turns[link] @ assembly.tool.turn, rel=0.0, abs=1e-9
        )


@each_arm
def test_the_jacobian_is_the_derivative_of_the_tools_place(vehicle: str, arm: str) -> None:
    kinematics = ARM.arm_of({"vehicle": vehicle, "arm": arm})

    for joints in postures(vehicle, arm, 5):
        tool, columns = kinematics.jacobian(joints)
        assert set(columns) == set(kinematics.reaching)
        for motor, (velocity, axis) in columns.items():
            after = kinematics.tool([q + STEP_RAD * (n == motor) for n, q in enumerate(joints)])
            change = (np.array(after.point) - tool.point) / STEP_RAD
            turned = (np.array(after.turn) - tool.turn) @ np.array(tool.turn).T / STEP_RAD

            assert velocity == pytest.approx(change, abs=1e-5)
            assert axis == pytest.approx([turned[2, 1], turned[0, 2], turned[1, 0]], abs=1e-5)


@each_arm
def test_the_inverse_brings_the_tool_to_points_that_it_can_reach(vehicle: str, arm: str) -> None:
    kinematics = ARM.arm_of({"vehicle": vehicle, "arm": arm})

    for wanted in postures(vehicle, arm, 20):
        point = kinematics.tool(wanted).point
        joints = kinematics.inverse(point, kinematics.home)

        assert joints is not None
        assert kinematics.tool(joints).point == pytest.approx(point, rel=0.0, abs=2e-7)
        within = zip(joints, kinematics.ranges, strict=True)
        assert all(low <= joint <= high for joint, (low, high) in within)


@each_arm
def test_the_inverse_says_when_a_point_is_out_of_reach(vehicle: str, arm: str) -> None:
    kinematics = ARM.arm_of({"vehicle": vehicle, "arm": arm})

    assert kinematics.inverse(FAR_M, kinematics.home) is None


def test_the_inverse_stays_where_it_starts_if_the_tool_is_there() -> None:
    kinematics = ARM.arm_of({"vehicle": "girona500", "arm": "arm-5e-like"})
    (joints,) = postures("girona500", "arm-5e-like", 1)

    assert kinematics.inverse(kinematics.tool(joints).point, joints) == joints


def test_damped_speeds_move_the_tool_as_it_is_asked_to() -> None:
    kinematics = ARM.arm_of({"vehicle": "girona500", "arm": "arm-5e-like"})
    joints = [0.0, 0.45, 0.6, 0.0, 0.6]
    _, columns = kinematics.jacobian(joints)
    ways = [columns[motor][0] for motor in kinematics.reaching]

    speeds = ARM.damped(ways, (0.02, 0.0, 0.05), 0.001)

    assert np.array(ways).T @ speeds == pytest.approx([0.02, 0.0, 0.05], abs=1e-5)


def test_the_file_for_python_imports_nothing_but_the_standard_library() -> None:
    lines = helper("python")["arm.py"].decode().splitlines()
    imported = {line.split()[1].split(".")[0] for line in lines if line.startswith(IMPORTS)}

    assert imported
    assert imported <= set(sys.stdlib_module_names)


IMPORTS = ("import ", "from ")
C_PROGRAM = r"""
#include "arm.h"

int main(int count, char **words) {
    char config[200];
    arm_data arm;
    double joints[ARM_MOST_JOINTS], columns[6][ARM_MOST_JOINTS], found[ARM_MOST_JOINTS];
    double start[ARM_MOST_JOINTS];
    snprintf(config, sizeof config, "{\"vehicle\": \"%s\", \"arm\": \"%s\"}", words[1], words[2]);
    if (arm_of(config, &arm)) return 1;
    while (1) {
        for (int n = 0; n < arm.motors; n++)
            if (scanf("%lf", joints + n) != 1) return 0;
        arm_frame tool = arm_jacobian(&arm, joints, columns);
        for (int i = 0; i < 3; i++) printf("%.17g ", tool.point[i]);
        for (int i = 0; i < 9; i++) printf("%.17g ", tool.turn[i / 3][i % 3]);
        for (int i = 0; i < 6; i++)
            for (int n = 0; n < arm.motors; n++) printf("%.17g ", columns[i][n]);
        for (int n = 0; n < arm.motors; n++) start[n] = arm.motor[n].home;
        int missed = arm_inverse(&arm, tool.point, start, found);
        arm_frame there = arm_tool(&arm, found);
        double off = 0.0, far[3] = {9.0, 0.0, 0.0};
        for (int i = 0; i < 3; i++) off += fabs(there.point[i] - tool.point[i]);
        printf("%d %.17g %d\n", missed, off, arm_inverse(&arm, far, joints, found));
    }
}
"""
M_PROGRAM = r"""
words = argv();
addpath(words{1});
arm = arm_kinematics(words{2}, words{3});
values = str2num(fileread(words{4}));
for row = values'
    [turn, point] = arm.tool(row);
    jacobian = arm.jacobian(row);
    [joints, found] = arm.inverse(point, arm.home);
    [~, there] = arm.tool(joints);
    [~, far] = arm.inverse([9; 0; 0], row);
    last = [-(!found), norm(there - point, 1), -(!far)];
    printf('%.17g ', point, turn', jacobian', last);
    printf('\n');
end
"""


def c_answer(folder: Path, vehicle: str, arm: str, values: str, compiler: str = "gcc") -> str:
    (folder / "arm.h").write_bytes(helper("c")["arm.h"])
    source = folder / ("main.c" if compiler == "gcc" else "main.cpp")
    source.write_text(C_PROGRAM)
    options = ["-O2", "-Wall", "-Werror"]
    subprocess.run([compiler, *options, str(source), "-o", str(folder / "main"), "-lm"], check=True)
    command = [str(folder / "main"), vehicle, arm]
    return subprocess.run(command, input=values, check=True, capture_output=True, text=True).stdout


def cpp_answer(folder: Path, vehicle: str, arm: str, values: str) -> str:
    return c_answer(folder, vehicle, arm, values, "g++")


def matlab_answer(folder: Path, vehicle: str, arm: str, values: str) -> str:
    (folder / "arm_kinematics.m").write_bytes(helper("matlab")["arm_kinematics.m"])
    (folder / "main.m").write_text(M_PROGRAM)
    (folder / "values").write_text(values)
    command = ["octave-cli", "--no-gui", str(folder / "main.m"), str(folder), vehicle, arm]
    command += [str(folder / "values")]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


@pytest.mark.host
@pytest.mark.parametrize("answer", [c_answer, cpp_answer, matlab_answer])
@pytest.mark.parametrize(
    ("vehicle", "arm"), [("girona500", "arm-5e-like"), ("bluerov2-heavy-v2", "alpha-like")]
)
def test_other_languages_compute_what_python_computes(
    vehicle: str, arm: str, answer: Callable[..., str], tmp_path: Path
) -> None:
    kinematics = ARM.arm_of({"vehicle": vehicle, "arm": arm})
    drawn = postures(vehicle, arm, 3)
    values = "".join(" ".join(map(repr, joints)) + "\n" for joints in drawn)

    lines = answer(tmp_path, vehicle, arm, values).splitlines()

    assert len(lines) == len(drawn)
    for line, joints in zip(lines, drawn, strict=True):
        tool, columns = kinematics.jacobian(joints)
        jacobian = np.zeros((6, kinematics.motors))
        for motor, parts in columns.items():
            jacobian[:, motor] = np.concatenate(parts)
        *numbers, missed, off, far = map(float, line.split())

        expected = [*tool.point, *np.ravel(tool.turn), *jacobian.ravel()]
        assert numbers == pytest.approx(expected, rel=0.0, abs=1e-12)
        assert (missed, far) == (0.0, -1.0)
        assert off < 3e-7
