"""The queue process: claims runs, wires simulator and sandbox, stores results."""
