"""Which system calls a program may make: data for the filter.

Numbers: Linux, x86_64 (arch/x86/entry/syscalls/syscall_64.tbl); they never change. Calls that are
not listed are refused, those of `argument_rules.py` by their arguments. Left out on purpose:
`socket`, `connect` and the message calls (a network namespace does not stop AF_VSOCK and netlink;
descriptors could be passed), `ptrace`, `process_vm_*`, `pidfd_*`, `memfd_create` (memory outside
RLIMIT_AS), `keyctl`, `io_uring_*`, `bpf`, `userfaultfd`, `perf_event_open`, `unshare`, `setns`, the
mount calls, `symlink` and `mknod` (they could redirect file accesses of the host), file locks and
System V objects (a channel between boxes), `fadvise64`, `readahead`, `mincore` and `cachestat`
(they change or show the page cache, which all boxes share), `statfs` (the host's disk),
`sched_set*`, `setsid` (Linux gives each session a CPU share of its own), `inotify_*`, `splice`,
`vmsplice`, `prlimit64` on other processes.

`sysinfo` is allowed although it shows the host's memory and load: the C library takes no notice of
its failure, and `sysconf` and `qsort` would calculate with an arbitrary size of the memory.
"""

NUMBERS = {
    name: number
    for number, name in enumerate(
        """read write open close stat fstat lstat poll lseek mmap mprotect munmap brk rt_sigaction
rt_sigprocmask rt_sigreturn ioctl pread64 pwrite64 readv writev access pipe select sched_yield
mremap msync mincore madvise shmget shmat shmctl dup dup2 pause nanosleep getitimer alarm setitimer
getpid sendfile socket connect accept sendto recvfrom sendmsg recvmsg shutdown bind listen
getsockname getpeername socketpair setsockopt getsockopt clone fork vfork execve exit wait4 kill
uname semget semop semctl shmdt msgget msgsnd msgrcv msgctl fcntl flock fsync fdatasync truncate
ftruncate getdents getcwd chdir fchdir rename mkdir rmdir creat link unlink symlink readlink chmod
fchmod chown fchown lchown umask gettimeofday getrlimit getrusage sysinfo times ptrace getuid syslog
getgid setuid setgid geteuid getegid setpgid getppid getpgrp setsid setreuid setregid getgroups
setgroups setresuid getresuid setresgid getresgid getpgid setfsuid setfsgid getsid capget capset
rt_sigpending rt_sigtimedwait rt_sigqueueinfo rt_sigsuspend sigaltstack utime mknod uselib
personality ustat statfs fstatfs sysfs getpriority setpriority sched_setparam sched_getparam
sched_setscheduler sched_getscheduler sched_get_priority_max sched_get_priority_min
sched_rr_get_interval mlock munlock mlockall munlockall vhangup modify_ldt pivot_root _sysctl prctl
arch_prctl adjtimex setrlimit chroot sync acct settimeofday mount umount2 swapon swapoff reboot
sethostname setdomainname iopl ioperm create_module init_module delete_module get_kernel_syms
query_module quotactl nfsservctl getpmsg putpmsg afs_syscall tuxcall security gettid""".split()
    )
} | {
    "readahead": 187,
    "tkill": 200,
    "time": 201,
    "futex": 202,
    "sched_setaffinity": 203,
    "sched_getaffinity": 204,
    "io_setup": 206,
    "epoll_create": 213,
    "getdents64": 217,
    "set_tid_address": 218,
    "restart_syscall": 219,
    "fadvise64": 221,
    "timer_create": 222,
    "timer_settime": 223,
    "timer_gettime": 224,
    "timer_getoverrun": 225,
    "timer_delete": 226,
    "clock_settime": 227,
    "clock_gettime": 228,
    "clock_getres": 229,
    "clock_nanosleep": 230,
    "exit_group": 231,
    "epoll_wait": 232,
    "epoll_ctl": 233,
    "tgkill": 234,
    "utimes": 235,
    "get_mempolicy": 239,
    "mq_open": 240,
    "kexec_load": 246,
    "waitid": 247,
    "add_key": 248,
    "request_key": 249,
    "keyctl": 250,
    "inotify_init": 253,
    "openat": 257,
    "mkdirat": 258,
    "mknodat": 259,
    "newfstatat": 262,
    "unlinkat": 263,
    "renameat": 264,
    "linkat": 265,
    "symlinkat": 266,
    "readlinkat": 267,
    "fchmodat": 268,
    "faccessat": 269,
    "pselect6": 270,
    "ppoll": 271,
    "unshare": 272,
    "set_robust_list": 273,
    "get_robust_list": 274,
    "splice": 275,
    "sync_file_range": 277,
    "vmsplice": 278,
    "listxattr": 194,
    "llistxattr": 195,
    "flistxattr": 196,
    "utimensat": 280,
    "epoll_pwait": 281,
    "eventfd": 284,
    "fallocate": 285,
    "accept4": 288,
    "eventfd2": 290,
    "epoll_create1": 291,
    "dup3": 292,
    "pipe2": 293,
    "inotify_init1": 294,
    "preadv": 295,
    "pwritev": 296,
    "perf_event_open": 298,
    "fanotify_init": 300,
    "prlimit64": 302,
    "open_by_handle_at": 304,
    "setns": 308,
    "getcpu": 309,
    "process_vm_readv": 310,
    "process_vm_writev": 311,
    "kcmp": 312,
    "renameat2": 316,
    "seccomp": 317,
    "getrandom": 318,
    "memfd_create": 319,
    "bpf": 321,
    "userfaultfd": 323,
    "membarrier": 324,
    "copy_file_range": 326,
    "preadv2": 327,
    "pwritev2": 328,
    "statx": 332,
    "rseq": 334,
    "pidfd_send_signal": 424,
    "io_uring_setup": 425,
    "move_mount": 429,
    "fsopen": 430,
    "fsmount": 432,
    "pidfd_open": 434,
    "clone3": 435,
    "close_range": 436,
    "openat2": 437,
    "pidfd_getfd": 438,
    "faccessat2": 439,
    "epoll_pwait2": 441,
    "landlock_create_ruleset": 444,
    "memfd_secret": 447,
    "cachestat": 451,
}

ALLOWED = frozenset(
    """read write close stat fstat lstat poll lseek mprotect munmap brk rt_sigaction rt_sigprocmask
rt_sigreturn pread64 pwrite64 readv writev access pipe select sched_yield mremap msync dup dup2
pause nanosleep getitimer alarm setitimer getpid sendfile shutdown getsockname getpeername fork
vfork execve exit wait4 kill uname truncate ftruncate getdents getcwd chdir fchdir rename mkdir
rmdir creat link unlink readlink chmod fchmod umask gettimeofday getrlimit getrusage sysinfo times
getuid getgid geteuid getegid setpgid getppid getpgrp getgroups getresuid getresgid getpgid getsid
capget rt_sigpending rt_sigtimedwait rt_sigsuspend sigaltstack getpriority sched_getparam
sched_getscheduler sched_get_priority_max sched_get_priority_min arch_prctl gettid tkill time futex
sched_getaffinity epoll_create getdents64 set_tid_address restart_syscall timer_create
timer_settime timer_gettime timer_getoverrun timer_delete clock_gettime clock_getres
clock_nanosleep exit_group epoll_wait epoll_ctl tgkill waitid mkdirat newfstatat unlinkat renameat
linkat readlinkat fchmodat faccessat pselect6 ppoll set_robust_list get_robust_list epoll_pwait
eventfd fallocate eventfd2 epoll_create1 dup3 pipe2 preadv pwritev getcpu renameat2 getrandom
membarrier copy_file_range statx rseq close_range faccessat2 epoll_pwait2 get_mempolicy""".split()
)

# glibc then falls back to variants whose arguments the filter can see.
NOT_THERE = ("clone3", "openat2")

# Refused as by a file system without extended attributes: `shutil.copy2` then does without them.
NOT_SUPPORTED = ("listxattr", "llistxattr", "flistxattr")

# They succeed, so that programs that copy files need not care. What a program may write to is
# memory, but flushing a library it has opened would have the disk of the host write its cache; and
# whoever may write to /dev/null may set its times, which all boxes see.
WITHOUT_EFFECT = ("fsync", "fdatasync", "utimensat")
