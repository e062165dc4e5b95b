"""The protocol between the simulator and a program in a box (docs/protocol.md), our end."""
