"""The rosbridge v2 protocol on a WebSocket, in lock step with the simulation."""
