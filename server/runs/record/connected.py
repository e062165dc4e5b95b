"""Runs whose program was connected over the network: nobody can compute them again."""

from seamark.server.database.tables import Run

ROSBRIDGE = "rosbridge"  # the controller of such a run
LABEL = "ROS program (rosbridge)"
IS_CONNECTED = Run.controller == ROSBRIDGE
