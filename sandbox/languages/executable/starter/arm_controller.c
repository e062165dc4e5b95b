/* Moves an arm by the protocol, as a starting point in any language: keeps the vehicle above its
 * target, the hand open below it.
 *
 * Compile it for 64-bit Linux and upload the executable:
 *   gcc -O2 -static controller.c -o controller.elf
 * The documentation describes the protocol.
 */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { HEADER = 8, MAX_BYTES = 65536, VEHICLE = 4, JOINTS = 5 };

#define FASTEST 0.3 /* [rad/s] that all motors of the arm-5e-like reach */

/* [rad] its slew, upper arm, forearm, wrist and jaws: the tool points down */
static const double posture[JOINTS] = {0.0, 0.45, 0.6, 0.0, 0.6};

static unsigned char message[MAX_BYTES];
static int connection;

/* Return the index of the first number of a field, from the lines "NAME COUNT" of a file. */
static int index_of(const char *path, const char *wanted) {
    char name[64];
    int index = 0, count = 0;
    FILE *file = fopen(path, "r");
    while (file && fscanf(file, "%63s %d", name, &count) == 2 && strcmp(name, wanted))
        index += count ? count : 1;
    if (file) fclose(file);
    return index;
}

/* Version and number of the request stay as they are. */
static void answer(char type, const void *body, size_t size) {
    message[0] = (unsigned char)type;
    memcpy(message + HEADER, body, size);
    if (write(connection, message, HEADER + size) < 0) _exit(1);
}

static void step(int error, int joints) {
    double values[(MAX_BYTES - HEADER) / 8], command[VEHICLE + JOINTS] = {0.0};
    memcpy(values, message + HEADER, sizeof values);
    command[0] = 0.5 * values[error]; /* m/s: surge, sway */
    command[1] = 0.5 * values[error + 1];
    for (int joint = 0; joint < JOINTS; joint++) {
        double speed = 2.0 * (posture[joint] - values[joints + joint]);
        command[VEHICLE + joint] =
            speed < -FASTEST ? -FASTEST : speed > FASTEST ? FASTEST : speed;
    }
    answer('c', command, sizeof command);
}

int main(int count, char **arguments) {
    uint32_t number;
    if (count < 4) return 2;
    connection = atoi(arguments[1]); /* of type SOCK_SEQPACKET: one read is one message */
    number = (uint32_t)strtoul(arguments[2], NULL, 10);
    int error = index_of(arguments[3], "error"), joints = index_of(arguments[3], "joints");
    message[1] = 1; /* version of the protocol */
    memcpy(message + 4, &number, sizeof number);
    answer('k', "", 0); /* ready */
    while (read(connection, message, MAX_BYTES) >= HEADER) {
        if (message[0] == 'O') {
            step(error, joints);
        } else if (message[0] == 'R') { /* reset: a level begins */
            answer('k', "", 0);
        } else { /* Q: quit */
            answer('q', "", 0);
            return 0;
        }
    }
    return 0;
}
