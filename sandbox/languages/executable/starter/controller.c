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

enum { HEADER = 8, MAX_BYTES = 65536, MAX_FIELDS = 64 };

static unsigned char message[MAX_BYTES + 1];
static int connection;

/* The fields of an observation, with the index of the first number of each. */
static struct {
    char name[64];
    int index;
} fields[MAX_FIELDS];
static int fields_count;

static double kp = 0.5, ki = 0.02, integral[3];
static const double LIMIT = 0.6; /* m/s */

/* Return the index of the first number of a field, -1 if there is no such field. */
static int index_of(const char *name) {
    for (int i = 0; i < fields_count; i++)
        if (!strcmp(fields[i].name, name)) return fields[i].index;
    return -1;
}

/* The file of the third argument: a line "NAME COUNT" for each field in the order of an
 * observation, then the configuration as one line of JSON. */
static void begin(const char *path) {
    static char text[MAX_BYTES];
    int index = 0;
    FILE *file = fopen(path, "r");
    while (file && fgets(text, sizeof text, file) && text[0] != '{') {
        int count = 0;
        if (fields_count == MAX_FIELDS) break;
        if (sscanf(text, "%63s %d", fields[fields_count].name, &count) != 2) continue;
        fields[fields_count++].index = index;
        index += count ? count : 1;
    }
    if (file) fclose(file);
    const char *found = strstr(text, "\"kp\": ");
    if (found) kp = strtod(found + 6, NULL);
    found = strstr(text, "\"ki\": ");
    if (found) ki = strtod(found + 6, NULL);
}

static void answer(char type, const void *body, size_t size) {
    message[0] = (unsigned char)type; /* version and number of the request stay as they are */
    memcpy(message + HEADER, body, size);
    if (write(connection, message, HEADER + size) < 0) _exit(1);
}

static void step(void) {
    double values[(MAX_BYTES - HEADER) / 8], command[4] = {0.0, 0.0, 0.0, 0.0};
    memcpy(values, message + HEADER, sizeof values);
    if (values[index_of("target_visible")] != 0.0) {
        for (int axis = 0; axis < 3; axis++) { /* m: forward, starboard, down */
            double error = values[index_of("error") + axis];
            integral[axis] += error * values[index_of("dt")];
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
    connection = atoi(arguments[1]); /* of type SOCK_SEQPACKET: one read is one message */
    number = (uint32_t)strtoul(arguments[2], NULL, 10);
    begin(arguments[3]);
    if (index_of("error") < 0 || index_of("dt") < 0) return 2;
    if (index_of("target_visible") < 0) return 2;
    message[1] = 1; /* version of the protocol */
    memcpy(message + 4, &number, sizeof number);
    answer('k', "", 0); /* ready */
    while (read(connection, message, MAX_BYTES) >= HEADER) {
        if (message[0] == 'O') {
            step();
        } else if (message[0] == 'R') { /* reset: a level begins */
            memset(integral, 0, sizeof integral);
            answer('k', "", 0);
        } else { /* Q: quit */
            answer('q', "", 0);
            return 0;
        }
    }
    return 0;
}
