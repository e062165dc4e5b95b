/* The main function of programs in C and C++: speaks the protocol of docs/protocol.md for the
 * functions of seamark.h. Arguments: the number of the socket's descriptor, the sequence number of
 * the pending request, the file with layout and configuration.
 */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "seamark.h"

#pragma weak seamark_init
#pragma weak seamark_reset
#pragma weak seamark_step
#pragma weak seamark_tracker_start
#pragma weak seamark_tracker_update
#pragma weak seamark_detect

enum { HEADER_BYTES = 8, MAX_BYTES = 65536, MAX_FIELDS = 64, MAX_SENTENCE = 500 };
enum { DETECTION_BYTES = 74 };
enum { MAX_ANSWER_BYTES = 4 + SEAMARK_MOST_DETECTIONS * (DETECTION_BYTES + 64) };
enum { DISCONNECTED = 70 }; /* exit code: the connection is lost */

/* The position of a field in the struct of observations, and how many numbers fit there. */
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
    {"corners", AT(corners), 8, 0},
    {"joints", AT(joints), SEAMARK_MOST_JOINTS, 0},
    {"joint_speeds", AT(joint_speeds), SEAMARK_MOST_JOINTS, 0},
    {"joint_efforts", AT(joint_efforts), SEAMARK_MOST_JOINTS, 0},
    {"wrist_force", AT(wrist_force), 3, 0},
    {"wrist_torque", AT(wrist_torque), 3, 0},
    {"touch", AT(touch), SEAMARK_MOST_JOINTS, 0},
    {"told", AT(told), 2, 0},
    {"confidence", AT(confidence), 1, 0},
    {"route", AT(route), 96, 0},
    {"fix", AT(fix), 2, 0},
    {"fix_age", AT(fix_age), 1, 0},
    {"fix_sigma", AT(fix_sigma), 1, 0},
    {"pipe_offset", AT(pipe_offset), 1, 0},
    {"pipe_angle", AT(pipe_angle), 1, 0},
    {"dock", AT(dock), 3, 0},
    {"dock_age", AT(dock_age), 1, 0},
    {"dock_sigma", AT(dock_sigma), 1, 0},
    {"dock_heading", AT(dock_heading), 1, 0},
    {"light", AT(light), 2, 0},
    {"light_visible", AT(light_visible), 1, 0},
    {"image_t", AT(image_t), 1, 0},
};

/* One field of the received layout: its numbers, and where they are copied to if it is known. */
struct copy {
    const struct field *field;
    int count;
};

void seamark_report_crashes(void (*reporter)(const char *sentence)); /* crash.c */

static int connection;
static uint32_t sequence;
static char *configuration;
static seamark_observation observation;
static struct copy copies[MAX_FIELDS];
static int copies_count;
static unsigned char incoming[MAX_BYTES];
static char role = 'c'; /* controller, tracker or detector: its first letter */
static const unsigned char *images;
static double target[8]; /* its last known corners */
static int joints;       /* of the vehicle's arm */
static double joint_limits[SEAMARK_MOST_JOINTS];
static seamark_image *shown[2]; /* what becomes of a controller's images, in their order */
static int shown_count;

static void send_message(char type, const void *body, size_t size) {
    unsigned char message[HEADER_BYTES + MAX_ANSWER_BYTES] = {(unsigned char)type};
    message[1] = SEAMARK_PROTOCOL;
    memcpy(message + 4, &sequence, sizeof sequence);
    if (size) memcpy(message + HEADER_BYTES, body, size);
    if (write(connection, message, HEADER_BYTES + size) < 0) _exit(DISCONNECTED);
}

static void end_with(char verdict, const char *sentence) {
    unsigned char body[3 + MAX_SENTENCE];
    uint16_t length = (uint16_t)strnlen(sentence, MAX_SENTENCE);
    body[0] = (unsigned char)verdict;
    memcpy(body + 1, &length, sizeof length);
    memcpy(body + 3, sentence, length);
    send_message('x', body, 3 + (size_t)length);
    _exit(1);
}

/* Report in one sentence why the run cannot continue, and exit. `verdict` is u (user error), p
 * (protocol error), s (compile error) or m (memory limit). */
static void give_up(char verdict, const char *sentence) {
    fflush(NULL);
    end_with(verdict, sentence);
}

/* Nothing is flushed: the crashed code may hold the lock of a stream. */
static void end_crashed(const char *sentence) { end_with('u', sentence); }

/* For the adapter of a model's code (inside/embedded_coder.py); not part of seamark.h. */
void seamark_refuse(const char *sentence) { give_up('p', sentence); }

/* Skip the JSON string at `at`; the format is that of Python's json.dumps. */
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

static void map_images(int descriptor, size_t bytes) {
    void *memory = mmap(NULL, bytes, PROT_READ, MAP_SHARED, descriptor, 0);
    if (memory == MAP_FAILED) give_up('m', "There is not enough memory for the images.");
    close(descriptor);
    images = memory;
}

static void add_camera(const char *name) {
    static seamark_image unknown; /* of a later version */
    if (shown_count == 2) return;
    shown[shown_count] = &unknown;
    if (!strcmp(name, "vehicle")) shown[shown_count] = &observation.images.vehicle;
    if (!strcmp(name, "arm")) shown[shown_count] = &observation.images.arm;
    if (!strcmp(name, "sonar")) shown[shown_count] = &observation.images.sonar;
    shown_count++;
}

/* Read the lines "NAME COUNT" of the layout; the last line is the configuration. */
static void begin(const char *path) {
    char *line = NULL;
    size_t room = 0;
    int descriptor = -1;
    FILE *file = fopen(path, "r");
    if (!file) _exit(DISCONNECTED);
    while (getline(&line, &room, file) > 0 && line[0] != '{') {
        char name[64];
        int count;
        double limit;
        if (sscanf(line, "joint_limit %lf", &limit) == 1 && joints < SEAMARK_MOST_JOINTS) {
            joint_limits[joints++] = limit;
            continue;
        }
        if (sscanf(line, "camera %63s", name) == 1) add_camera(name);
        if (sscanf(line, "%63s %d", name, &count) != 2 || copies_count == MAX_FIELDS) continue;
        if (!strcmp(name, "tracker") || !strcmp(name, "detector")) role = name[0];
        if (!strcmp(name, "images_descriptor")) descriptor = count;
        if (!strcmp(name, "images_bytes")) map_images(descriptor, (size_t)count);
        if (role != 'c' || !strncmp(name, "images_", 7)) continue;
        if (!count) count = 1;
        copies[copies_count].field = known(name, count);
        copies[copies_count++].count = count;
        if (!strcmp(name, "thrust")) observation.thrusters = count;
        if (!strcmp(name, "joints")) observation.joints_count = count;
    }
    fclose(file);
    unlink(path);
    configuration = line;
}

static seamark_image image_of(const unsigned char *body) {
    uint32_t words[4]; /* offset, height, width, channels */
    seamark_image image;
    memcpy(words, body, sizeof words);
    image.pixels = images + words[0];
    image.width = (int)words[2], image.height = (int)words[1], image.channels = (int)words[3];
    return image;
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
    for (int i = 0; i < shown_count; i++, from += 4 * sizeof(uint32_t)) {
        if ((size_t)(end - from) < 4 * sizeof(uint32_t)) return;
        *shown[i] = image_of(from);
    }
}

static void step(size_t size) {
    seamark_command command;
    double answer[4 + SEAMARK_MOST_JOINTS];
    char sentence[MAX_SENTENCE];
    observe(incoming + HEADER_BYTES, size - HEADER_BYTES);
    memset(&command, 0, sizeof command);
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
    memcpy(answer + 4, command.arm, sizeof command.arm);
    for (int i = 0; i < joints; i++) {
        if (fabs(command.arm[i]) <= joint_limits[i]) continue;
        snprintf(sentence, sizeof sentence,
                 "The command of seamark_step at t = %g s has %g for arm[%d]; it must be a finite "
                 "number within +-%g.", observation.t, command.arm[i], i, joint_limits[i]);
        give_up('p', sentence);
    }
    send_message('c', answer, (size_t)(4 + joints) * sizeof(double));
}

static void end_with_code(const char *function, int code) {
    char sentence[MAX_SENTENCE];
    snprintf(sentence, sizeof sentence, "%s returned %d.", function, code);
    give_up('u', sentence);
}

/* Return the index of the first coordinate that is out of range, 8 if none is. */
static int first_out_of_range(const double *corners) {
    int i = 0;
    while (i < 8 && fabs(corners[i]) <= 1e6) i++; /* NaN compares false */
    return i;
}

static void track_from(void) {
    seamark_image image = image_of(incoming + HEADER_BYTES);
    memcpy(target, incoming + HEADER_BYTES + 4 * sizeof(uint32_t), sizeof target);
    int code = seamark_tracker_start(&image, target);
    if (code) end_with_code("seamark_tracker_start", code);
    send_message('k', NULL, 0);
}

static void track(void) {
    seamark_image image = image_of(incoming + HEADER_BYTES);
    double corners[8];
    memcpy(corners, target, sizeof corners);
    int code = seamark_tracker_update(&image, corners);
    if (code < 0) end_with_code("seamark_tracker_update", code);
    /* The simulator counts wild corners as a loss; the next search starts at the last good ones. */
    if (code && first_out_of_range(corners) == 8) memcpy(target, corners, sizeof target);
    send_message('t', corners, code ? sizeof corners : 0);
}

/* Write one detection to an answer; return its number of bytes. */
static size_t packed(unsigned char *to, const seamark_detection *one) {
    uint16_t length = (uint16_t)strnlen(one->label, SEAMARK_LABEL_BYTES);
    int wrong = first_out_of_range(one->corners);
    if (wrong < 8) {
        char sentence[MAX_SENTENCE];
        snprintf(sentence, sizeof sentence,
                 "The corners of seamark_detect have %g as %s of corner %d; they must be four "
                 "points in px.", one->corners[wrong], wrong % 2 ? "y" : "x", wrong / 2 + 1);
        give_up('p', sentence);
    }
    if (!(one->confidence >= 0.0 && one->confidence <= 1.0))
        give_up('p', "A confidence of seamark_detect is not a number from 0 to 1.");
    if (!length || length == SEAMARK_LABEL_BYTES)
        give_up('p', "A label of seamark_detect is not a text of 1 to 64 bytes.");
    memcpy(to, one->corners, sizeof one->corners);
    memcpy(to + 64, &one->confidence, sizeof one->confidence);
    memcpy(to + 72, &length, sizeof length);
    memcpy(to + DETECTION_BYTES, one->label, length);
    return DETECTION_BYTES + (size_t)length;
}

static void detect(void) {
    static seamark_detection found[SEAMARK_MOST_DETECTIONS];
    static unsigned char answer[MAX_ANSWER_BYTES];
    seamark_image image = image_of(incoming + HEADER_BYTES);
    size_t size = sizeof(uint32_t);
    memset(found, 0, sizeof found);
    int count = seamark_detect(&image, found);
    if (count < 0) end_with_code("seamark_detect", count);
    if (count > SEAMARK_MOST_DETECTIONS)
        give_up('p', "seamark_detect returned more than the 64 detections that fit.");
    memcpy(answer, &(uint32_t){(uint32_t)count}, sizeof(uint32_t));
    for (int i = 0; i < count; i++) size += packed(answer + size, &found[i]);
    send_message('d', answer, size);
}

static void reset(const char *json) {
    seamark_level level;
    level.index = (int)number_of(json, "index", 0.0);
    level.count = (int)number_of(json, "count", 1.0);
    level.duration_s = number_of(json, "duration_s", 0.0);
    level.dt = number_of(json, "dt", 0.0);
    level.t = number_of(json, "t", 0.0);
    if (seamark_reset) seamark_reset(&level);
    send_message('k', NULL, 0);
}

/* Exit with a message unless the program defines what its role needs. */
static void check_role(const char *program) {
    const char *wants = "a controller defines int seamark_step(const seamark_observation *, "
                        "seamark_command *)";
    const char *missing = seamark_step ? NULL : "seamark_step";
    char sentence[MAX_SENTENCE];
    if (role == 't') {
        wants = "a tracker defines int seamark_tracker_start(const seamark_image *, const double "
                "corners[8]) and int seamark_tracker_update(const seamark_image *, double "
                "corners[8])";
        missing = seamark_tracker_start ? NULL : "seamark_tracker_start";
        if (!seamark_tracker_update) missing = "seamark_tracker_update";
    } else if (role == 'd') {
        wants = "a detector defines int seamark_detect(const seamark_image *, seamark_detection "
                "found[])";
        missing = seamark_detect ? NULL : "seamark_detect";
    }
    if (!missing) return;
    snprintf(sentence, sizeof sentence,
             "%.100s does not define %s: %s, as seamark.h declares it.", program, missing, wants);
    give_up('s', sentence);
}

static void quit(void) {
    fflush(NULL);
    send_message('q', NULL, 0);
    _exit(0); /* no destructor and no atexit handler runs after the last message */
}

int main(int count, char **arguments) {
    if (count < 4) return DISCONNECTED;
    connection = atoi(arguments[1]);
    sequence = (uint32_t)strtoul(arguments[2], NULL, 10);
    begin(arguments[3]);
    check_role(arguments[0]);
    setvbuf(stdout, NULL, _IOLBF, 4096); /* each line is logged as soon as it is printed */
    seamark_report_crashes(end_crashed);
    int code = seamark_init ? seamark_init() : 0;
    if (code) end_with_code("seamark_init", code);
    send_message('k', NULL, 0);
    for (;;) {
        ssize_t size = read(connection, incoming, sizeof incoming - 1);
        if (size < HEADER_BYTES) _exit(0); /* the simulator is gone */
        incoming[size] = 0;
        memcpy(&sequence, incoming + 4, sizeof sequence);
        if (incoming[0] == 'O')
            step((size_t)size);
        else if (incoming[0] == 'T')
            track_from();
        else if (incoming[0] == 'U')
            track();
        else if (incoming[0] == 'D')
            detect();
        else if (incoming[0] == 'R')
            reset((const char *)incoming + HEADER_BYTES);
        else
            quit();
    }
}
