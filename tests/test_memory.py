"""The measure of memory tells of the program asked about, and of nothing that ran before it."""

import memory
import numpy as np


def test_the_memory_of_the_tests_themselves_is_not_counted() -> None:
    ours = np.ones(100_000_000)  # 800 MB
    assert memory.taken("pass")[1] < 100_000
    del ours


def test_memory_that_a_program_held_is_counted_once_given_back() -> None:
    numbers, kilobytes = memory.taken("held = bytearray(300_000_000)\ndel held\nprint(7)")
    assert numbers == [7] and 290_000 < kilobytes < 400_000
