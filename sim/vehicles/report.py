"""What a check of a vehicle says: on the command line and in the form of a run."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

from seamark.sim.vehicles import AXES, Quantity, Vehicle
from seamark.sim.vehicles import capabilities as of
from seamark.sim.vehicles.plausibility import DRAG_AT, FLAT_PLATE, drag_coefficients

_SPREAD = 2.0  # sources that differ by a greater factor are told


def figures(vehicle: Vehicle) -> dict[str, Any]:
    """Return what follows from the vehicle's numbers, as plain JSON values; None: never."""
    return {
        "weight_n": vehicle.weight.scalar,
        "net_buoyancy_n": vehicle.buoyancy.scalar - vehicle.weight.scalar,
        "righting_n_m_per_rad": of.righting_n_m(vehicle),
        "roll_period_s": _finite(of.period_s(vehicle, of.ROLL)),
        "pitch_period_s": _finite(of.period_s(vehicle, of.PITCH)),
        "munk_speed_m_s": _finite(of.munk_speed(vehicle)),
        "drag_coefficients": list(drag_coefficients(vehicle)),
        "full_thrust": {
            name: {
                "force": response.force,
                "speed": _finite(response.speed),
                "time_s": _finite(response.time_s),
            }
            for name, response in ((name, of.response(vehicle, name)) for name in of.DIRECTIONS)
        },
        "spreads": [
            {"place": place, "low": low, "value": value, "high": high, "unit": quantity.unit}
            for place, quantity, low, value, high in _wide_spreads(vehicle)
        ],
    }


def lines(vehicle: Vehicle, errors: Sequence[str], warnings: Sequence[str]) -> Iterator[str]:
    """Yield the lines of the report; the figures only if the vehicle can exist."""
    yield f"{vehicle.title} ({vehicle.name}), {len(vehicle.thrusters)} thrusters"
    yield from (f"error    {text}" for text in errors)
    yield from (f"warning  {text}" for text in warnings)
    if not errors:
        yield ""
        yield from figure_lines(vehicle)
    yield ""
    yield f"{_counted(len(errors), 'error')}, {_counted(len(warnings), 'warning')}."


def figure_lines(vehicle: Vehicle) -> Iterator[str]:
    """Yield the lines about what follows from the numbers of a vehicle that can exist."""
    yield from _balance(vehicle)
    yield ""
    yield from _responses(vehicle)
    yield from _spreads(vehicle)


def _balance(vehicle: Vehicle) -> Iterator[str]:
    net = vehicle.buoyancy.scalar - vehicle.weight.scalar
    does = f"floats up with {net:.3g} N" if net > 0.0 else f"sinks with {-net:.3g} N"
    yield f"weight            {vehicle.weight.scalar:.4g} N; in water it " + (
        "neither sinks nor floats up" if net == 0.0 else does
    )
    stiffness = of.righting_n_m(vehicle)
    if stiffness > 0.0:
        roll, pitch = (of.period_s(vehicle, axis) for axis in (of.ROLL, of.PITCH))
        yield (
            f"righting moment   {stiffness:.3g} N m for a radian; undamped, roll swings in "
            f"{roll:.2g} s and pitch in {pitch:.2g} s"
        )
        if math.isfinite(speed := of.munk_speed(vehicle)):
            yield f"                  weaker than the Munk moment from {speed:.2g} m/s on"
    x, y, z = drag_coefficients(vehicle)
    yield (
        f"drag coefficient  {x:.2g} ahead, {y:.2g} abeam, {z:.2g} up, on the rectangle around the "
        f"hull at {DRAG_AT:g} m/s; a flat plate has {FLAT_PLATE}"
    )


def _responses(vehicle: Vehicle) -> Iterator[str]:
    yield f"{'full thrust':<22}{'force':>12}{'speed':>13}{'63 % of it after':>19}"
    for name, (axis, _sign) in of.DIRECTIONS.items():
        response = of.response(vehicle, name)
        force, speed = ("N m", "rad/s") if axis == of.YAW else ("N", "m/s")
        yield (
            f"{name:<22}{_number(response.force, 3):>8} {force:<3}{_number(response.speed, 2):>7} "
            f"{speed:<5}{_number(response.time_s, 2):>15} s"
        )
    yield "A speed in m/s is also the current against which it can hold its place that way, level."


def _number(value: float, digits: int) -> str:
    return f"{value:#.{digits + 1}g}".rstrip(".") if math.isfinite(value) else "-"


def _spreads(vehicle: Vehicle) -> Iterator[str]:
    wide = list(_wide_spreads(vehicle))
    if wide:
        yield ""
        yield f"Sources differ by more than a factor of {_SPREAD:g}:"
    for place, quantity, low, value, high in wide:
        yield f"  {place:<34} {value:g} {quantity.unit}, from {low:g} to {high:g}"


def _wide_spreads(vehicle: Vehicle) -> Iterator[tuple[str, Quantity, float, float, float]]:
    """Yield place, quantity, lowest, own and greatest value of what sources disagree on."""
    for place, quantity in vehicle.quantities():
        if quantity.spread is None:
            continue
        names = [axis for axis in quantity.meaning.replace(",", "").split() if axis in AXES]
        for at, (low, value, high) in enumerate(
            zip(quantity.spread[0], quantity.value, quantity.spread[1], strict=True)
        ):
            small, large = sorted((abs(low), abs(high)))
            if large > _SPREAD * small:
                which = names[at] if len(names) == len(quantity.value) else "xyz"[at]
                which = "" if len(quantity.value) == 1 and not names else f" {which}"
                yield f"{place.replace('_', ' ')}{which}", quantity, low, value, high


def _counted(count: int, what: str) -> str:
    return f"{count} {what}" if count == 1 else f"{count} {what}s"


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
