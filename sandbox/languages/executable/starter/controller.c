/* A PI position controller that implements the protocol, as a starting point in any language:
 * the law of the built-in PI.
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

static double kp, ki, limit, integral[3]; /* the integral in m/s */
static int axes;

/* Return the index of the first number of a field, -1 if there is no such field. */
static int index_of(const char *name) {
    for (int i = 0; i < fields_count; i++)
        if (!strcmp(fields[i].name, name)) return fields[i].index;
    return -1;
}

/* Return a number of the configuration; true is 1. */
static double config_number(const char *text, const char *key, double otherwise) {
    char quoted[80];
    snprintf(quoted, sizeof quoted, "\"%s\": ", key);
    const char *found = strstr(text, quoted);
    if (!found) return otherwise;
    found += strlen(quoted);
    return *found == 't' ? 1.0 : strtod(found, NULL); /* "false" is read as 0 */
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
    kp = config_number(text, "kp", 0.5);
    ki = config_number(text, "ki", 0.02);
    limit = config_number(text, "reference_limit_m_s", 1.0);
    axes = config_number(text, "control_heave", 0.0) != 0.0 ? 3 : 2;
}

static void answer(char type, const void *body, size_t size) {
    message[0] = (unsigned char)type; /* version and number of the request stay as they are */
    memcpy(message + HEADER, body, size);
    if (write(connection, message, HEADER + size) < 0) _exit(1);
}

static void step(void) {
    double values[(MAX_BYTES - HEADER) / 8], command[4] = {0.0, 0.0, 0.0, 0.0};
    memcpy(values, message + HEADER, sizeof values);
    int visible = values[index_of("target_visible")] != 0.0;
    for (int axis = 0; axis < axes; axis++) {
        double error = values[index_of("error") + axis]; /* m: forward, starboard, down */
        double change = visible ? ki * error * values[index_of("dt")] : 0.0;
        double wanted = kp * error + integral[axis] + change;
        double given = wanted < -limit ? -limit : wanted > limit ? limit : wanted;
        /* anti-windup: at the limit the integral may only move back inside */
        if (given == wanted || (wanted - given) * change < 0.0) integral[axis] += change;
        command[axis] = given;
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
