"""What lies on the bottom in pattern recognition: classes to find, and decoys among them.

Light, so that forms need not load the camera, and below it, since painter, telemetry and metrics
need the same names in the same order: a recorded number is the index of a class.
"""

CLASSES: dict[str, str] = {  # name -> title; one object of each on the bottom of a level
    "box": "Black box with lettering",
    "amphora": "Amphora",
    "pipe": "Pipe piece",
    "panel": "Valve panel",
    "connector": "Connector",
    "anode": "Anode",
    "aruco": "ArUco marker",
    "apriltag": "AprilTag",
}
MARKERS = ("aruco", "apriltag")  # classes
DECOYS: dict[str, str] = {  # likewise; none of them may be reported
    "rock": "Rock",
    "shell": "Shell",
    "bottle": "Bottle",
    "can": "Can",
    "plank": "Plank",
    "slab": "Black slab without letters",
    "starfish": "Starfish",
    "false-marker": "Pattern of no dictionary",
}
