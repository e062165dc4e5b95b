"""Answers with what is no command, or changes the observation."""

import itertools
import os

import numpy as np


class EndlessList(list):
    def __iter__(self):
        return itertools.repeat(0.0)


class HostileFloat:
    def __float__(self):
        os._exit(0)


class HostileNumber(float):
    def __float__(self):
        raise RuntimeError("gotcha")


def set_observation(observation):
    observation.t = 9.0
    return [0.0, 0.0, 0.0, 0.0]


def unlock_observation(observation):
    observation.error.setflags(write=True)
    observation.error[0] = 9.0
    return [0.0, 0.0, 0.0, 0.0]


def write_observation(observation):
    observation.error[0] = 9.0
    return [0.0, 0.0, 0.0, 0.0]


ANSWERS = {
    "array_complex": lambda observation: np.zeros(4, complex),
    "array_nan": lambda observation: np.full(4, np.nan),
    "array_objects": lambda observation: np.array([None] * 4),
    "array_row": lambda observation: np.zeros((1, 4)),
    "bytes": lambda observation: b"0000",
    "complex": lambda observation: [1j, 0, 0, 0],
    "dictionary": lambda observation: {"surge": 0},
    "endless_list": lambda observation: EndlessList([0.0] * 4),
    "five": lambda observation: [0.0] * 5,
    "generator": lambda observation: (0.0 for _ in range(4)),
    "hostile_float": lambda observation: [HostileFloat()] * 4,
    "hostile_number": lambda observation: [HostileNumber(1.0)] * 4,
    "huge": lambda observation: [1e300, 0, 0, 0],
    "huge_integer": lambda observation: [10**400, 0, 0, 0],
    "inf": lambda observation: [0, float("inf"), 0, 0],
    "nan": lambda observation: [float("nan"), 0, 0, 0],
    "nested": lambda observation: [[0, 0], [0, 0], 0, 0],
    "none": lambda observation: None,
    "number": lambda observation: 0.0,
    "object": lambda observation: [object()] * 4,
    "set_observation": set_observation,
    "string": lambda observation: "0000",
    "strings": lambda observation: ["0", "0", "0", "0"],
    "three": lambda observation: [0.0, 0.0, 0.0],
    "unknown_field": lambda observation: observation.truth,
    "unlock_observation": unlock_observation,
    "write_observation": write_observation,
}


class Controller:
    def __init__(self, config):
        self.answer = ANSWERS[config["attack"]]

    def step(self, observation):
        return self.answer(observation)
