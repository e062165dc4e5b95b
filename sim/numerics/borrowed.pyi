from typing import TypeVar

A = TypeVar("A")

def borrowed(array: A) -> A: ...
