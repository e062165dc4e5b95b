"""Runs as ROS 2 messages in an MCAP file, in the frames that ROS uses."""
