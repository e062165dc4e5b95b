"""The filter, call by call, in a BPF interpreter; the hostile programs test it in the kernel."""

import errno
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from seamark.sandbox.isolation import argument_rules, seccomp
from seamark.sandbox.isolation.argument_rules import REFUSALS
from seamark.sandbox.isolation.seccomp import ALLOW, ERRNO, KILL_PROCESS, REFUSE
from seamark.sandbox.isolation.system_calls import (
    ALLOWED,
    NOT_SUPPORTED,
    NOT_THERE,
    NUMBERS,
    WITHOUT_EFFECT,
)

X86_64, I386 = 0xC000003E, 0x40000003
REFUSED = sorted(
    set(NUMBERS) - ALLOWED - set(REFUSALS) - {*NOT_SUPPORTED, *NOT_THERE, *WITHOUT_EFFECT}
)
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


@pytest.mark.parametrize("name", REFUSED)
def test_any_other_call_that_has_a_name_is_refused(name) -> None:
    assert decide(NUMBERS[name]) == REFUSE


@pytest.mark.parametrize("name", NOT_THERE)
def test_a_call_whose_arguments_the_filter_cannot_read_appears_to_be_missing(name) -> None:
    assert decide(NUMBERS[name]) == ERRNO | errno.ENOSYS


@pytest.mark.parametrize("name", WITHOUT_EFFECT)
def test_a_call_without_effect_succeeds_without_reaching_the_kernel(name) -> None:
    assert decide(NUMBERS[name]) == ERRNO


@pytest.mark.parametrize("name", NOT_SUPPORTED)
def test_files_appear_to_have_no_extended_attributes(name) -> None:
    assert decide(NUMBERS[name]) == ERRNO | errno.EOPNOTSUPP


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
    namespaces = flags & argument_rules.CLONE_NEW_NAMESPACES

    assert decide(NUMBERS["clone"], flags) == (REFUSE if namespaces else ALLOW)


@pytest.mark.parametrize(
    ("name", "position", "listed", "match", "other"),
    [
        ("socketpair", 0, (1,), ALLOW, REFUSE),
        (
            "getsockopt",
            2,
            argument_rules.SOCKET_OPTIONS_ALLOWED,
            ALLOW,
            ERRNO | errno.ENOPROTOOPT,
        ),
        ("ioctl", 1, argument_rules.IOCTL_ALLOWED, ALLOW, ERRNO | errno.ENOTTY),
        ("prctl", 0, argument_rules.PRCTL_ALLOWED, ALLOW, REFUSE),
        ("fcntl", 1, argument_rules.FCNTL_ALLOWED, ALLOW, REFUSE),
        ("prlimit64", 0, (0,), ALLOW, REFUSE),
        ("prlimit64", 1, (4,), REFUSE, ALLOW),
        ("setrlimit", 0, (4,), REFUSE, ALLOW),
        ("madvise", 2, argument_rules.MADVISE_ALLOWED, ALLOW, ERRNO | errno.EINVAL),
        ("preadv2", 5, (0,), ALLOW, ERRNO | errno.EOPNOTSUPP),
        ("pwritev2", 5, (0,), ALLOW, ERRNO | errno.EOPNOTSUPP),
    ],
)
def test_a_call_is_decided_by_its_argument(name, position, listed, match, other) -> None:
    values = (*range(128), 1024, 1026, 1031, 0x5401, 0x5412, 0x53564D41)

    decided = {
        value: decide(NUMBERS[name], *[0] * position, value, *[0] * (5 - position))
        for value in values
    }

    assert decided == {value: match if value in listed else other for value in values}


@pytest.mark.parametrize(
    ("name", "position", "bits", "error"),
    [
        ("open", 1, 0x4000, errno.EINVAL),  # O_DIRECT
        ("openat", 2, 0x4000, errno.EINVAL),
        ("mmap", 3, 0x40000, errno.EPERM),  # MAP_HUGETLB
        ("sendto", 3, 0x1, errno.EOPNOTSUPP),  # MSG_OOB
        ("recvfrom", 3, 0x1, errno.EOPNOTSUPP),
        ("recvfrom", 3, 0x2000, errno.EOPNOTSUPP),  # MSG_ERRQUEUE
        ("sendto", 3, 0x4000000, errno.EOPNOTSUPP),  # MSG_ZEROCOPY
    ],
)
@pytest.mark.parametrize("others", [0, 0x20, 0x40, 0x8000])
def test_a_call_is_refused_for_one_flag_among_others(name, position, bits, error, others) -> None:
    def decided(flags: int) -> int:
        return decide(NUMBERS[name], *[0] * position, flags)

    assert (decided(others), decided(others | bits)) == (ALLOW, ERRNO | error)


def test_a_flag_of_fcntl_counts_only_when_flags_are_set() -> None:
    f_getfl, f_setfl, o_direct, o_nonblock = 3, 4, 0x4000, 0x800

    assert decide(NUMBERS["fcntl"], 0, f_setfl, o_direct | o_nonblock) == ERRNO | errno.EINVAL
    assert decide(NUMBERS["fcntl"], 0, f_setfl, o_nonblock) == ALLOW
    assert decide(NUMBERS["fcntl"], 0, f_getfl, o_direct) == ALLOW


@pytest.mark.parametrize(
    "name",
    "socket connect sendmsg recvmsg bind ptrace process_vm_readv memfd_create keyctl add_key "
    "io_uring_setup bpf userfaultfd perf_event_open unshare setns mount symlink mknod flock "
    "shmget semget msgget mq_open setuid pidfd_open pidfd_getfd splice inotify_init "
    "clock_settime sched_setaffinity seccomp kexec_load init_module fadvise64 readahead mincore "
    "cachestat sync_file_range statfs utimensat utimes setxattr setsid".split(),
)
def test_a_dangerous_call_is_not_on_the_list(name) -> None:
    assert name not in ALLOWED
