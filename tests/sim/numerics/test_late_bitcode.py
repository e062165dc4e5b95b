"""What is compiled is loaded without its LLVM code, and can be built into other functions still."""

import subprocess
import sys

from llvmlite import binding

from seamark.sim.numerics import late_bitcode
from seamark.sim.numerics.libm import sin

# A process that loads what others have compiled, and then compiles a function that calls it.
LOADED = """
from llvmlite import binding

parse, parsed = binding.parse_bitcode, []
binding.parse_bitcode = lambda bitcode: parsed.append(parse(bitcode)) or parsed[-1]

from seamark.sim.numerics.libm import sin

print(sin(0.5), sum(sin.stats.cache_hits.values()), len(parsed))

import numba

print(numba.njit(lambda x: sin(x) + 1.0)(0.5), len(parsed))
"""
MODULE = """
@counted = global i64 1
@elsewhere = external global i64
declare i64 @called(i64)
define i64 @calling() {
  %number = load i64, i64* @elsewhere
  %result = call i64 @called(i64 %number)
  ret i64 %result
}
"""


def test_llvm_code_is_read_when_a_function_is_built_into_another_and_not_before() -> None:
    wanted = sin(0.5)  # compiles it, where nothing has

    done = subprocess.run([sys.executable, "-c", LOADED], capture_output=True, check=True)

    loaded, built = done.stdout.decode().splitlines()
    assert loaded == f"{wanted} 1 0"
    assert built == f"{wanted + 1.0} 1"


def test_symbols_are_what_a_file_of_machine_code_defines_itself() -> None:
    module = binding.parse_assembly(MODULE)
    machine = binding.Target.from_default_triple().create_target_machine()

    code = machine.emit_object(module)

    assert code.startswith(late_bitcode.ELF)
    assert {"counted", "calling"} <= set(late_bitcode.symbols(code))
    assert not {"elsewhere", "called"} & set(late_bitcode.symbols(code))
