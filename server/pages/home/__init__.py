"""The home page, the demo and the state of the service: what guests see first."""
