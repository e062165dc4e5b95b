#define _GNU_SOURCE
#include <stdio.h>
#include <sys/syscall.h>
#include <unistd.h>
#include "seamark.h"

/* calls that must be refused whatever their arguments */
static const int CALLS[] = {
    SYS_ptrace, SYS_process_vm_readv, SYS_bpf, SYS_userfaultfd, SYS_keyctl, SYS_mount, SYS_unshare,
    SYS_setns, SYS_perf_event_open, SYS_io_uring_setup, SYS_memfd_create, SYS_pidfd_open, SYS_symlink,
};

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    (void)observation, (void)command;
    for (unsigned i = 0; i < sizeof CALLS / sizeof *CALLS; i++)
        if (syscall(CALLS[i], 0, 0, 0, 0, 0) >= 0) printf("GOT call %d\n", CALLS[i]);
    return 0;
}
