/* The main program of controllers in C and C++: speaks the protocol of docs/protocol.md for the
 * functions of seamark.h. Arguments: the number of the protocol's descriptor, the sequence number
 * of the question that waits for an answer, the file with layout and configuration.
 */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "seamark.h"

#pragma weak seamark_init
#pragma weak seamark_reset

enum { HEADER_BYTES = 8, MOST_BYTES = 65536, MOST_FIELDS = 64, MOST_SENTENCE = 500 };
enum { DISCONNECTED = 70 }; /* exit code: the connection is gone */

/* Where a field of an observation stands in its struct, and the most numbers that fit there. */
struct field {
    const char *name;
    size_t offset;
    int count;
    int boolean;
};

#define AT(name) offsetof(seamark_observation, name)

static const struct field FIELDS[] = {
    {"t", AT(t), 1, 0},
    {"dt", AT(dt), 1, 0},
    {"error", AT(error), 3, 0},
    {"error_px", AT(error_px), 2, 0},
    {"target_visible", AT(target_visible), 1, 1},
    {"target_age", AT(target_age), 1, 0},
    {"velocity", AT(velocity), 3, 0},
    {"velocity_valid", AT(velocity_valid), 1, 1},
    {"depth", AT(depth), 1, 0},
    {"altitude", AT(altitude), 1, 0},
    {"attitude", AT(attitude), 3, 0},
    {"rates", AT(rates), 3, 0},
    {"thrust", AT(thrust), 8, 0},
};

/* One field of the layout that came: numbers to take, and where they go if this program knows it. */
struct copy {
    const struct field *field;
    int count;
};

static int connection;
static uint32_t sequence;
static char *configuration;
static seamark_observation observation;
static struct copy copies[MOST_FIELDS];
static int copies_count;
static unsigned char incoming[MOST_BYTES];

static void send_frame(char kind, const void *body, size_t size) {
    unsigned char frame[HEADER_BYTES + 3 + MOST_SENTENCE] = {(unsigned char)kind, SEAMARK_PROTOCOL};
    memcpy(frame + 4, &sequence, sizeof sequence);
    if (size) memcpy(frame + HEADER_BYTES, body, size);
    if (write(connection, frame, HEADER_BYTES + size) < 0) _exit(DISCONNECTED);
}

/* Say in one sentence why the run cannot go on, and end. `verdict` is u (its error) or p (answer). */
static void give_up(char verdict, const char *sentence) {
    unsigned char body[3 + MOST_SENTENCE];
    uint16_t length = (uint16_t)strnlen(sentence, MOST_SENTENCE);
    body[0] = (unsigned char)verdict;
    memcpy(body + 1, &length, sizeof length);
    memcpy(body + 3, sentence, length);
    fflush(NULL);
    send_frame('x', body, 3 + (size_t)length);
    _exit(1);
}

/* For the file that connects the code of a model (inside/embedded.py); not part of seamark.h. */
void seamark_refuse(const char *sentence) { give_up('p', sentence); }

/* Skip a JSON string that begins at `at`; the layout of what comes is json.dumps of Python. */
static const char *after_string(const char *at) {
    for (at++; *at && *at != '"'; at++)
        if (*at == '\\' && at[1]) at++;
    return *at ? at + 1 : at;
}

/* Return where the value of a key of the outermost object begins, or NULL. */
static const char *value_of(const char *json, const char *key) {
    size_t length = strlen(key);
    int depth = 0;
    while (*json) {
        if (*json == '"') {
            const char *end = after_string(json);
            int same = (size_t)(end - json) == length + 2 && !strncmp(json + 1, key, length);
            if (depth == 1 && same && *end == ':') return end + 1 + strspn(end + 1, " ");
            json = end;
            continue;
        }
        if (*json == '{' || *json == '[') depth++;
        if (*json == '}' || *json == ']') depth--;
        json++;
    }
    return NULL;
}

static double number_of(const char *json, const char *key, double fallback) {
    const char *value = json ? value_of(json, key) : NULL;
    char *end;
    double number;
    if (!value) return fallback;
    if (!strncmp(value, "true", 4)) return 1.0;
    if (!strncmp(value, "false", 5)) return 0.0;
    number = strtod(value, &end);
    return end == value ? fallback : number;
}

double seamark_config_number(const char *key, double fallback) {
    return number_of(configuration, key, fallback);
}

const char *seamark_config_json(void) { return configuration ? configuration : "{}"; }

static const struct field *known(const char *name, int count) {
    for (size_t i = 0; i < sizeof FIELDS / sizeof *FIELDS; i++)
        if (!strcmp(FIELDS[i].name, name) && FIELDS[i].count >= count) return &FIELDS[i];
    return NULL;
}

/* Read the lines "NAME COUNT" of the layout; the last line is the configuration. */
static void begin(const char *path) {
    char *line = NULL;
    size_t room = 0;
    FILE *file = fopen(path, "r");
    if (!file) _exit(DISCONNECTED);
    while (getline(&line, &room, file) > 0 && line[0] != '{') {
        char name[64];
        int count;
        if (sscanf(line, "%63s %d", name, &count) != 2 || copies_count == MOST_FIELDS) continue;
        if (!count) count = 1;
        copies[copies_count].field = known(name, count);
        copies[copies_count++].count = count;
        if (!strcmp(name, "thrust")) observation.thrusters = count;
    }
    fclose(file);
    unlink(path);
    configuration = line;
}

static void observe(const unsigned char *from, size_t size) {
    const unsigned char *end = from + size;
    for (int i = 0; i < copies_count; i++) {
        const struct field *field = copies[i].field;
        size_t bytes = (size_t)copies[i].count * sizeof(double);
        if ((size_t)(end - from) < bytes) return;
        if (field && field->boolean) {
            double value;
            memcpy(&value, from, sizeof value);
            *(int *)((char *)&observation + field->offset) = value != 0.0;
        } else if (field) {
            memcpy((char *)&observation + field->offset, from, bytes);
        }
        from += bytes;
    }
}

static void step(size_t size) {
    seamark_command command = {0.0, 0.0, 0.0, 0.0};
    double answer[4];
    char sentence[MOST_SENTENCE];
    observe(incoming + HEADER_BYTES, size - HEADER_BYTES);
    int code = seamark_step(&observation, &command);
    if (code) {
        snprintf(sentence, sizeof sentence, "seamark_step returned %d at t = %g s.", code,
                 observation.t);
        give_up('u', sentence);
    }
    answer[0] = command.surge, answer[1] = command.sway;
    answer[2] = command.heave, answer[3] = command.yaw_rate;
    for (int i = 0; i < 4; i++) {
        if (fabs(answer[i]) <= 1e6) continue; /* NaN compares false */
        snprintf(sentence, sizeof sentence,
                 "The command of seamark_step at t = %g s is (%g, %g, %g, %g); it must be four "
                 "finite numbers: surge, sway, heave in m/s and yaw rate in rad/s.",
                 observation.t, answer[0], answer[1], answer[2], answer[3]);
        give_up('p', sentence);
    }
    send_frame('c', answer, sizeof answer);
}

static void reset(const char *json) {
    seamark_level level;
    level.index = (int)number_of(json, "index", 0.0);
    level.count = (int)number_of(json, "count", 1.0);
    level.duration_s = number_of(json, "duration_s", 0.0);
    level.dt = number_of(json, "dt", 0.0);
    level.t = number_of(json, "t", 0.0);
    if (seamark_reset) seamark_reset(&level);
    send_frame('k', NULL, 0);
}

static void leave(void) {
    fflush(NULL);
    send_frame('q', NULL, 0);
    _exit(0); /* no destructor and no atexit of the program runs after the last word */
}

int main(int count, char **arguments) {
    if (count < 4) return DISCONNECTED;
    connection = atoi(arguments[1]);
    sequence = (uint32_t)strtoul(arguments[2], NULL, 10);
    begin(arguments[3]);
    setvbuf(stdout, NULL, _IOLBF, 4096); /* a line is seen as soon as it is printed */
    int code = seamark_init ? seamark_init() : 0;
    if (code) {
        char sentence[64];
        snprintf(sentence, sizeof sentence, "seamark_init returned %d.", code);
        give_up('u', sentence);
    }
    send_frame('k', NULL, 0);
    for (;;) {
        ssize_t size = read(connection, incoming, sizeof incoming - 1);
        if (size < HEADER_BYTES) _exit(0); /* the other side is gone */
        incoming[size] = 0;
        memcpy(&sequence, incoming + 4, sizeof sequence);
        if (incoming[0] == 'O')
            step((size_t)size);
        else if (incoming[0] == 'R')
            reset((const char *)incoming + HEADER_BYTES);
        else
            leave();
    }
}
