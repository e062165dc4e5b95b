"""Settings of a route to follow, and of the acoustic fixes on the way.

Tags of the defaults: S sourced, D derived from sourced, E our estimate.
"""

from functools import partial

from seamark.sim.control.observation import PIPE
from seamark.sim.settings.experiment import ExperimentSettings, multiple
from seamark.sim.settings.setting import setting

GROUP, FIXES = "Route", "Acoustic fixes"
EACH = "each"
WAYPOINTS, HELIX, LEMNISCATE = "waypoints", "helix", "lemniscate"
KINDS = {WAYPOINTS: "Waypoints", HELIX: "Helix", LEMNISCATE: "Lemniscate", PIPE: "Pipe"}
_OF_PIPE = frozenset({"tracked_x", "tracked_y", "tracker_ok", *(f"corner_{at}" for at in range(8))})
_OF_TARGET = _OF_PIPE | {
    *("target_x", "target_y", "tracker_error"),
    *("error_x", "error_y", "error_z", "error_x_px", "error_y_px", "distance", "distance_px"),
}
route_setting = partial(setting, group=GROUP, role="scenario")
fix_setting = partial(setting, group=FIXES, role="scenario", advanced=True)


class RouteSettings(ExperimentSettings):
    """What is followed, and how well the vehicle is told where it is."""

    route: str = route_setting(
        EACH,
        title="Route",
        help="What is followed; each in turn: another kind from trial to trial.",
        choices={EACH: "Each in turn"} | KINDS,
    )
    route_length_m: float = route_setting(
        30.0,
        title="Length of the route",
        help="Of every kind.",
        unit="m",
        low=5,
        high=100,
        tag="E",
        source="0.25 m/s on average over the time of a level",
    )
    pipe_height_m: float = route_setting(
        2.4,
        title="Height above the pipe",
        help="Of the camera above the top of the pipe, on the route that is to be followed there.",
        unit="m",
        low=1.5,
        high=4,
        tag="E",
        source="visual inspection: the width of the image is seven times that of the pipe",
        advanced=True,
    )
    pipe_turbidity_1_m: float = route_setting(
        0.8,
        title="Turbidity above a pipe",
        help="Largest attenuation of the water where a pipe is followed; drawn evenly for each "
        "trial, from 0.2 1/m or this, if that is less.",
        unit="1/m",
        low=0,
        high=3,
        tag="E",
        source="clear coast; a seventh of the contrast is left from that height",
        advanced=True,
    )
    pipe_covered: int = route_setting(
        3,
        title="Covered stretches",
        help="How many stretches of a pipe lie under sand.",
        low=0,
        high=6,
        tag="E",
        source="a few of 1 to 2.5 m on 30 m",
        advanced=True,
    )
    start_error_m: float = fix_setting(
        1.5,
        title="Error of the start",
        help="How far the position at which the vehicle is said to start may be from the true one; "
        "drawn evenly over the disc.",
        unit="m",
        low=0,
        high=20,
        tag="E",
        source="a dive from where satellites last gave a position",
    )
    boat_least_m: float = fix_setting(
        15.0,
        title="Nearest transceiver",
        help="Least level distance of the boat with the acoustic transceiver from the start.",
        unit="m",
        low=0,
        high=200,
        tag="E",
        source="a boat that keeps off the work",
    )
    boat_most_m: float = fix_setting(
        40.0,
        title="Farthest transceiver",
        help="Largest level distance of the boat from the start; drawn evenly, in any direction.",
        unit="m",
        low=0,
        high=400,
        tag="E",
        source="inshore work",
    )
    fix_period_s: float = fix_setting(
        4.0,
        title="Time between fixes",
        help="From one acoustic ping to the next.",
        unit="s",
        low=0.5,
        high=60,
        tag="E",
        source="one acoustic channel for positions and messages",
    )
    fix_delay_s: float = fix_setting(
        1.0,
        title="Delay of fixes",
        help="From the answer of the beacon to when the vehicle has its position, beside the way "
        "of the sound.",
        unit="s",
        low=0,
        high=10,
        tag="E",
        source="position computed on the boat and sent back by sound",
    )
    fix_range_sigma_m: float = fix_setting(
        0.1,
        title="Range noise",
        help="Standard deviation of the measured range.",
        unit="m",
        low=0,
        high=5,
        tag="E",
        source="the resolution at which small transceivers report it",
    )
    fix_angle_sigma_rad: float = fix_setting(
        0.0175,
        title="Angle noise",
        help="Standard deviation of the measured bearing and elevation.",
        unit="rad",
        low=0,
        high=0.3,
        tag="E",
        source="1°, a small transceiver; 0.5 m at 30 m",
    )
    fix_dropout: float = fix_setting(
        0.2,
        title="Missing fixes",
        help="Share of the pings that give no position.",
        low=0,
        high=1,
        tag="E",
        source="noise of the thrusters, and echoes in shallow water",
    )

    def has_route(self) -> bool:
        """Return whether there is a route to follow: always."""
        return True

    def unused_columns(self) -> frozenset[str]:
        """Return those of a camera above its target too: nobody looks at the weight."""
        seen = self.route in {EACH, PIPE}
        return super().unused_columns() | (_OF_TARGET - _OF_PIPE if seen else _OF_TARGET)

    def route_kind(self, trial: int) -> str:
        """Return the kind of the route of a trial."""
        kinds = tuple(KINDS)
        return (
            kinds[trial // len(self.vehicles()) % len(kinds)] if self.route == EACH else self.route
        )

    def cross_field_errors(self) -> dict[str, str]:
        """Return setting -> message for the rules between several settings."""
        errors: dict[str, str] = {}
        if self.boat_most_m < self.boat_least_m:
            errors["boat_most_m"] = (
                "boat_most_m (Farthest transceiver) must not be less than boat_least_m (Nearest "
                f"transceiver) of {self.boat_least_m:g} m."
            )
        if not multiple(self.fix_period_s, self.control_period_s):
            errors["fix_period_s"] = (
                f"fix_period_s (Time between fixes) must be a whole multiple of the control period "
                f"of {self.control_period_s:g} s, not {self.fix_period_s:g} s."
            )
        return errors | super().cross_field_errors()
