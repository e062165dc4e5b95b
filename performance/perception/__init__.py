"""The camera and the trackers beside others, and in turbid water."""
