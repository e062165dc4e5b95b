"""ArduPilot's JSON interface for physics over UDP, with ArduSub's motors on a BlueROV2 Heavy."""
