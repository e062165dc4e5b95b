/* A PI position controller that implements the protocol, as a starting point in any language.
 *
 * Compile it for 64-bit Linux and upload the executable:
 *   gcc -O2 -static controller.c -o controller.elf
 * The documentation describes the protocol.
 */
#include <fcntl.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { HEADER = 8, MOST = 65536, FIELDS = 64 };

static unsigned char frame[MOST + 1];
static int connection;

/* Return the index of the first number of a field in an observation, -1 if there is no such field. */
static struct {
    char name[64];
    int at;
} fields[FIELDS];
static int fields_count;

static double kp = 0.5, ki = 0.02, integral[3];
static const double LIMIT = 0.6; /* m/s */

static int place(const char *name) {
    for (int i = 0; i < fields_count; i++)
        if (!strcmp(fields[i].name, name)) return fields[i].at;
    return -1;
}

/* The file of the third argument: a line "NAME COUNT" for each field in the order of an
 * observation, then the configuration as one line of JSON. */
static void begin(const char *path) {
    static char text[MOST];
    int at = 0;
    FILE *file = fopen(path, "r");
    while (file && fgets(text, sizeof text, file) && text[0] != '{') {
        int count = 0;
        if (fields_count == FIELDS) break;
        if (sscanf(text, "%63s %d", fields[fields_count].name, &count) != 2) continue;
        fields[fields_count++].at = at;
        at += count ? count : 1;
    }
    if (file) fclose(file);
    const char *found = strstr(text, "\"kp\": ");
    if (found) kp = strtod(found + 6, NULL);
    found = strstr(text, "\"ki\": ");
    if (found) ki = strtod(found + 6, NULL);
}

static void answer(char kind, const void *body, size_t size) {
    frame[0] = (unsigned char)kind; /* version and number of the question stay as they came */
    memcpy(frame + HEADER, body, size);
    if (write(connection, frame, HEADER + size) < 0) _exit(1);
}

static void step(void) {
    double values[(MOST - HEADER) / 8], command[4] = {0.0, 0.0, 0.0, 0.0};
    memcpy(values, frame + HEADER, sizeof values);
    if (values[place("target_visible")] != 0.0) {
        for (int axis = 0; axis < 3; axis++) { /* m: forward, starboard, down */
            double error = values[place("error") + axis];
            integral[axis] += error * values[place("dt")];
            command[axis] = kp * error + ki * integral[axis];
            if (command[axis] > LIMIT) command[axis] = LIMIT;
            if (command[axis] < -LIMIT) command[axis] = -LIMIT;
        }
    }
    answer('c', command, sizeof command); /* surge, sway, heave m/s and yaw rate rad/s */
}

int main(int count, char **arguments) {
    uint32_t number;
    if (count < 4) return 2;
    connection = atoi(arguments[1]); /* of type SOCK_SEQPACKET: one read is one frame */
    number = (uint32_t)strtoul(arguments[2], NULL, 10);
    begin(arguments[3]);
    if (place("error") < 0 || place("dt") < 0 || place("target_visible") < 0) return 2;
    frame[1] = 1; /* version of the protocol */
    memcpy(frame + 4, &number, sizeof number);
    answer('k', "", 0); /* ready */
    while (read(connection, frame, MOST) >= HEADER) {
        if (frame[0] == 'O') {
            step();
        } else if (frame[0] == 'R') { /* reset: a level begins */
            memset(integral, 0, sizeof integral);
            answer('k', "", 0);
        } else { /* Q: quit */
            answer('q', "", 0);
            return 0;
        }
    }
    return 0;
}
