"""The compiled part of `exact_sums.py`: the service does without Numba, and sums little."""

from numba import njit

from seamark.sim.numerics.arrays import Integers

# A finite float64 is a whole number of at most 53 bits times a power of two, of which there are
# 2046. Its bits are added to words of 32 bits each, wide enough for two thousand million addends.
BINS = 2046 // 32 + 3


@njit(cache=True, error_model="numpy")
def add_bits(bits: Integers, bins: Integers) -> bool:
    """Add numbers, given as their bits, (n,), to bins; return whether all are finite."""
    for i in range(bits.size):
        word = bits[i]
        exponent = (word >> 52) & 0x7FF
        if exponent == 0x7FF:
            return False
        whole = word & 0xFFFFFFFFFFFFF
        if exponent > 0:
            whole |= 0x10000000000000
            exponent -= 1
        at, shift = exponent >> 5, exponent & 31
        low = (whole & 0xFFFFFFFF) << shift
        high = ((whole >> 32) << shift) + (low >> 32)
        low, middle, top = low & 0xFFFFFFFF, high & 0xFFFFFFFF, high >> 32
        if word < 0:
            low, middle, top = -low, -middle, -top
        bins[at] += low
        bins[at + 1] += middle
        bins[at + 2] += top
    return True
