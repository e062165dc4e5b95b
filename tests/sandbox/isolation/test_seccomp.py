"""The filter, call by call, in a BPF interpreter; the hostile programs test it in the kernel."""

import errno
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from seamark.sandbox.isolation import seccomp, system_calls
from seamark.sandbox.isolation.seccomp import ALLOW, ERRNO, KILL_PROCESS, REFUSE
from seamark.sandbox.isolation.system_calls import ALLOWED, NOT_THERE, NUMBERS

X86_64, I386 = 0xC000003E, 0x40000003
BY_ARGUMENT = {"clone", "socketpair", "ioctl", "prctl", "fcntl", "prlimit64"}
FILTER = seccomp.build()
PROGRAM = [struct.unpack_from("=HBBI", FILTER, offset) for offset in range(0, len(FILTER), 8)]


def decide(number: int, *arguments: int, architecture: int = X86_64) -> int:
    """Run the filter as the kernel would and return its action."""
    padded = (*arguments, *[0] * (6 - len(arguments)))
    data = struct.pack("<IIQ6Q", number & 0xFFFFFFFF, architecture, 0, *padded)
    accumulator = position = 0
    tests = {
        seccomp.EQUAL: lambda value: accumulator == value,
        seccomp.AT_LEAST: lambda value: accumulator >= value,
        seccomp.ANY_BIT: lambda value: bool(accumulator & value),
    }
    while True:
        code, if_true, if_false, operand = PROGRAM[position]
        position += 1
        if code == seccomp.RETURN:
            return operand
        if code == seccomp.LOAD:
            accumulator = struct.unpack_from("<I", data, operand)[0]
        else:
            position += if_true if tests[code](operand) else if_false


@pytest.mark.parametrize("name", sorted(ALLOWED))
def test_an_allowed_call_passes(name) -> None:
    assert decide(NUMBERS[name]) == ALLOW


@pytest.mark.parametrize("name", sorted(set(NUMBERS) - ALLOWED - BY_ARGUMENT - set(NOT_THERE)))
def test_any_other_call_that_has_a_name_is_refused(name) -> None:
    assert decide(NUMBERS[name]) == REFUSE


@pytest.mark.parametrize("name", NOT_THERE)
def test_a_call_whose_arguments_the_filter_cannot_read_appears_to_be_missing(name) -> None:
    assert decide(NUMBERS[name]) == ERRNO | errno.ENOSYS


@given(number=st.integers(0, 0x3FFFFFFF), arguments=st.lists(st.integers(0, 2**64 - 1), max_size=6))
def test_a_number_without_a_name_is_refused_whatever_its_arguments(number, arguments) -> None:
    if number not in NUMBERS.values():
        assert decide(number, *arguments) == REFUSE


@given(number=st.integers(0, 2**32 - 1))
def test_a_call_of_another_architecture_ends_the_process(number) -> None:
    assert decide(number, architecture=I386) == KILL_PROCESS


@given(number=st.integers(0x40000000, 2**32 - 1))
def test_an_x32_call_ends_the_process(number) -> None:
    assert decide(number) == KILL_PROCESS


@given(high=st.integers(0, 2**32 - 1))
def test_high_bits_of_an_argument_change_nothing_cve_2019_10063(high) -> None:
    tiocsti, new_user, unix = 0x5412, 0x10000000, 1

    assert decide(NUMBERS["ioctl"], 0, high << 32 | tiocsti) == ERRNO | errno.ENOTTY
    assert decide(NUMBERS["clone"], high << 32 | new_user) == REFUSE
    assert decide(NUMBERS["socketpair"], high << 32 | unix) == ALLOW


@given(flags=st.integers(0, 2**32 - 1))
def test_clone_creates_no_namespace(flags) -> None:
    namespaces = flags & system_calls.CLONE_NEW_NAMESPACES

    assert decide(NUMBERS["clone"], flags) == (REFUSE if namespaces else ALLOW)


@pytest.mark.parametrize(
    ("name", "position", "listed", "match", "other"),
    [
        ("socketpair", 0, (1,), ALLOW, REFUSE),
        ("ioctl", 1, system_calls.IOCTL_ALLOWED, ALLOW, ERRNO | errno.ENOTTY),
        ("prctl", 0, system_calls.PRCTL_ALLOWED, ALLOW, REFUSE),
        ("fcntl", 1, system_calls.FCNTL_REFUSED, REFUSE, ALLOW),
        ("prlimit64", 0, (0,), ALLOW, REFUSE),
    ],
)
@pytest.mark.parametrize("value", [*range(64), 1024, 1026, 1031, 0x5401, 0x5412, 0x53564D41])
def test_a_call_is_decided_by_its_argument(name, position, listed, match, other, value) -> None:
    arguments = [0, 0]
    arguments[position] = value

    assert decide(NUMBERS[name], *arguments) == (match if value in listed else other)


@pytest.mark.parametrize(
    "name",
    "socket connect sendmsg recvmsg bind ptrace process_vm_readv memfd_create keyctl add_key "
    "io_uring_setup bpf userfaultfd perf_event_open unshare setns mount symlink mknod flock "
    "shmget semget msgget mq_open setuid pidfd_open pidfd_getfd splice inotify_init "
    "clock_settime sched_setaffinity seccomp kexec_load init_module".split(),
)
def test_a_dangerous_call_is_not_on_the_list(name) -> None:
    assert name not in ALLOWED
