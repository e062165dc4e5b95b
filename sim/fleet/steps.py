"""One control step of every vehicle, compiled: the functions of the closed loop of one vehicle.

The vehicles are independent of each other, so it changes no bit how they are shared among threads.
Eight of them move at a time (`blocks.py`).
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from seamark.sim.camera.geometry import camera_pose, project
from seamark.sim.control import velocity_law
from seamark.sim.control.velocity_law import DEPTH, HEADING
from seamark.sim.engine.delay import arriving
from seamark.sim.engine.perception import (
    LevelConstants,
    Moving,
    SensorNoises,
    SensorRecords,
    StepInputs,
    StepOutputs,
    Tracked,
    perceive,
)
from seamark.sim.engine.reward import Goal, reward_of
from seamark.sim.engine.tracking_error import TargetView
from seamark.sim.fleet.blocks import (
    Work,
    advance_block,
    load_vehicle,
    store_vehicle,
    water_of,
    work_for,
)
from seamark.sim.fleet.tables import COMMAND_NUMBERS, Controllers, Motion, Progress, Tables
from seamark.sim.numerics.arrays import Array, Flags, Integers
from seamark.sim.numerics.borrowed import borrowed
from seamark.sim.numerics.lanes import LANES
from seamark.sim.physics.pose import read_pose
from seamark.sim.recording.telemetry import INDEX, STEP_US

_REFERENCE = INDEX["ref_u"]
_CORNERS = 8


class Shared(NamedTuple):
    """What all vehicles have in common."""

    physics_steps: int  # per control step
    physics_step_s: float
    dt: float  # [s] control period
    below_camera: float  # [m] altitude at which the camera would touch the target
    bottom_m: float  # [m] depth of the bottom
    width_px: float
    height_px: float
    target_view: TargetView
    station: Array  # (3,) [m] where the camera should be
    goal: int  # kind of reward
    tool: Array  # (3,) [m], see reward.Goal
    tool_station: Array  # (3,) [m] where the tool should be
    by_thrusters: bool  # whether actions are commands of the thrusters
    truth: bool  # whether the tracker is the ground truth


@njit(cache=True, nogil=True, error_model="numpy")
def sense_all(first: int, last: int, chosen: Flags, shared: Shared, tables: Tables) -> None:
    """Write observation, telemetry and reward of the chosen vehicles (n,) of some blocks."""
    shared, tables = borrowed(shared), borrowed(tables)
    for i in range(first * LANES, min(last * LANES, chosen.size)):
        if chosen[i]:
            _sense(i, shared, tables)


@njit(cache=True, nogil=True, error_model="numpy")
def step_all(
    first: int,
    last: int,
    chosen: Flags,
    actions: Array,
    shared: Shared,
    tables: Tables,
) -> None:
    """Take the actions (n, numbers) of the chosen vehicles (n,) and simulate a control step.

    It is for the blocks from first to last. Afterwards all but those in contact, or with a tracker
    of their own, have sensed the new state.
    """
    actions, shared, tables = borrowed(actions), borrowed(shared), borrowed(tables)
    own = work_for(tables.motion.state.shape[1])
    work = borrowed(own)
    for block in range(first, last):
        _step_block(block, chosen, actions, shared, tables, work)
    own.state[0, 0] = 0.0  # the owner of `work` must live until here


@njit(cache=True, error_model="numpy")
def _step_block(
    block: int,
    chosen: Flags,
    actions: Array,
    shared: Shared,
    tables: Tables,
    work: Work,
) -> None:
    # Borrowed again: only inside one function the compiler knows that nothing is counted.
    actions, tables, work = borrowed(actions), borrowed(tables), borrowed(work)
    shared = borrowed(shared)
    motion, progress, outputs = tables.motion, tables.progress, tables.outputs
    begin = block * LANES
    end = min(begin + LANES, chosen.size)
    law = -1
    work.moves[:] = False  # also the lanes without a vehicle: nothing is read for them
    for i in range(begin, end):
        moves = chosen[i] and _act(i, actions, shared, tables)
        work.moves[i - begin] = moves
        if moves:
            law = motion.law[i]  # the same in all of them, since it is a setting
            load_vehicle(i, motion, progress.step[i] * shared.physics_steps, work)
    if law < 0:
        return
    steps = (shared.physics_steps, shared.physics_step_s)
    advance_block(block, law, steps, tables.bodies, motion, work)
    for i in range(begin, end):
        if work.moves[i - begin]:
            progress.step[i] += 1
            outputs.contact_n[i] = 0.0
            outputs.touching[i] = store_vehicle(i, motion, work)
            if shared.truth and not outputs.touching[i]:
                _sense(i, shared, tables)


@njit(cache=True, error_model="numpy", inline="always")
def _act(i: int, actions: Array, shared: Shared, tables: Tables) -> bool:
    """Write the commands of one vehicle; False, and `diverged`, if one is not finite."""
    motion, controllers = tables.motion, tables.controllers
    progress, outputs = tables.progress, tables.outputs
    arriving = _delayed(i, actions[i], progress)
    command, row = motion.command[i], outputs.rows[i]
    if shared.by_thrusters:
        for j in range(command.size):
            command[j] = arriving[j] if j < controllers.thruster_count[i] else 0.0
    else:
        for j in range(COMMAND_NUMBERS):
            row[_REFERENCE + j] = actions[i, j]
        _control(i, arriving, shared.dt, motion, controllers, progress)
    for j in range(command.size):
        if not math.isfinite(command[j]):
            outputs.diverged[i] = True
            return False
    return True


@njit(cache=True, error_model="numpy", inline="always")
def _delayed(i: int, action: Array, progress: Progress) -> Array:
    """Keep an action and return the one that arrives now; zeros before the first."""
    commands: Array = progress.commands[i]
    step, slots = progress.step[i], commands.shape[0]
    commands[step % slots][:] = action
    late = progress.late[i, 1]
    if step < late:
        return np.zeros(action.size)
    arriving: Array = commands[(step - late) % slots]
    return arriving


@njit(cache=True, error_model="numpy", inline="always")
def _control(
    i: int,
    reference: Array,
    dt: float,
    motion: Motion,
    controllers: Controllers,
    progress: Progress,
) -> None:
    """Run the velocity controller, which begins a level by holding what it measures."""
    measured, holds = controllers.measured, controllers.holds[i]
    if progress.step[i] == 0:
        for at in range(holds.size):
            holds[at].target, holds[at].force = 0.0, 0.0
        holds[DEPTH].target = measured[i].depth
        holds[HEADING].target = measured[i].yaw
    thrusters = controllers.thrusters
    velocity_law.step(
        velocity_law.Reference(reference[0], reference[1], reference[2], reference[3]),
        measured[i : i + 1],
        dt,
        controllers.settings[i : i + 1],
        controllers.axes[i],
        holds,
        velocity_law.Thrusters(
            allocator=thrusters.allocator[i],
            directions=thrusters.directions[i],
            efforts=thrusters.efforts[i],
            curve=thrusters.curve[i],
        ),
        velocity_law.Outputs(thrust=motion.thrust[i], command=motion.command[i]),
    )


@njit(cache=True, error_model="numpy", inline="always")
def _sense(i: int, shared: Shared, tables: Tables) -> None:
    """Sample the sensors of one vehicle; sets `diverged` if its state is not finite."""
    motion, instruments, controllers = tables.motion, tables.instruments, tables.controllers
    progress, outputs = tables.progress, tables.outputs
    state, pose = motion.state[i], outputs.pose[i]
    if not read_pose(state, pose):
        outputs.diverged[i] = True
        return
    corners, row = outputs.corners[i], outputs.rows[i]
    if shared.truth:
        outputs.visible[i] = _track_truth(pose, shared, progress, i, corners)
    step, late = progress.step[i], progress.late[i, 0]
    seen = arriving(progress.images[i], step, late, corners, outputs.visible[i])
    records, noises = instruments.records, instruments.noises
    numbers = motion.water[i // LANES, :, i % LANES]
    perceive(
        StepInputs(
            step=step * shared.physics_steps,
            t=progress.start_s[i] + step * shared.dt,
            ok=bool(outputs.visible[i]),
            seen=seen[_CORNERS] != 0.0,
            altitude=shared.bottom_m - pose[2],
            echoes=4,
            contact_n=outputs.contact_n[i],
        ),
        LevelConstants(
            trial=progress.trial_level[i, 0],
            level=progress.trial_level[i, 1],
            physics_step_s=shared.physics_step_s,
            dt=shared.dt,
            below_camera=shared.below_camera,
        ),
        Tracked(
            target_view=shared.target_view,
            station=shared.station,
            corners=corners,
            seen_corners=seen,
        ),
        Moving(state=state, pose=pose, water=water_of(numbers, motion.law[i], motion.drift[i])),
        SensorRecords(
            dvl=records.dvl[i : i + 1],
            depth=records.depth[i : i + 1],
            ahrs=records.ahrs[i : i + 1],
            altimeter=records.altimeter[i : i + 1],
        ),
        SensorNoises(
            dvl=noises.dvl[i],
            depth=noises.depth[i],
            ahrs=noises.ahrs[i],
            altimeter=noises.altimeter[i],
        ),
        instruments.keeper[i : i + 1],
        StepOutputs(
            row=row,
            observation=outputs.observation[i],
            measured=controllers.measured[i : i + 1],
        ),
    )
    row[STEP_US] = 0.0
    goal = Goal(
        kind=shared.goal,
        tool=shared.tool,
        station=shared.tool_station,
        forward=controllers.limits[i, 0],
        reverse=controllers.limits[i, 1],
        thrusters=controllers.thruster_count[i],
    )
    outputs.reward[i] = reward_of(row, goal)


@njit(cache=True, error_model="numpy", inline="always")
def _track_truth(pose: Array, shared: Shared, progress: Progress, i: int, corners: Array) -> bool:
    """Write the true corners unless their mean is outside the image; as `trackers.truth`."""
    rotation, position, images = np.empty((3, 3)), np.empty(3), np.empty((6, 2))
    camera_pose(pose, shared.target_view.mount, rotation, position)
    project(shared.target_view.points, rotation, position, shared.target_view.intrinsics, images)
    if progress.step[i] == 0:
        for at in range(_CORNERS):
            corners[at] = images[at // 2, at % 2] + progress.start_error[i, at]
        return True
    u = (((images[0, 0] + images[1, 0]) + images[2, 0]) + images[3, 0]) / 4.0
    v = (((images[0, 1] + images[1, 1]) + images[2, 1]) + images[3, 1]) / 4.0
    inside: bool = 0.0 <= u <= shared.width_px - 1.0 and 0.0 <= v <= shared.height_px - 1.0
    if inside:
        for at in range(_CORNERS):
            corners[at] = images[at // 2, at % 2]
    return inside


@njit(cache=True, nogil=True, error_model="numpy")
def copy_columns(first: int, last: int, columns: Integers, rows: Array, out: Array) -> None:
    """Copy columns (k,) of the rows (n, width) of some blocks of vehicles to `out`, (n, k)."""
    columns, rows, out = borrowed(columns), borrowed(rows), borrowed(out)
    for i in range(first * LANES, min(last * LANES, out.shape[0])):
        for j in range(columns.size):
            out[i, j] = rows[i, columns[j]]
