"""The numbers of the protocol (docs/protocol.md), little endian: the same file on both ends."""

import struct

VERSION = 1
HEADER = struct.Struct("<cB2xI")  # type, version, sequence number
SIZES = struct.Struct("<II")  # [B] of the program's header, of the program
COMMAND = struct.Struct("<4d")  # surge, sway, heave [m/s], yaw rate [rad/s]
IMAGE = struct.Struct("<4I")  # offset [B], height, width [px], channels
CORNERS = struct.Struct("<8d")  # [px] x and y of the four corners
COUNT = struct.Struct("<I")  # of detections
DETECTION = struct.Struct("<9dH")  # corners, confidence, bytes of the label that follows
ERROR = struct.Struct("<cH")  # letter of the verdict, bytes of the sentence

MAX_MESSAGE_BYTES = 65536  # [B] the longest one is an error with its traceback
MAX_VALUE = 1e6  # [m/s, rad/s, px] a number beyond is a mistake
MAX_DETECTIONS = 64
MAX_LABEL_BYTES = 64
