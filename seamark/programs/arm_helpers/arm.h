/* Kinematics of the arms of Seamark: forward, its Jacobian, and inverse.
 *
 * `seamark init` wrote this file. You may use, modify and distribute it freely; it comes without any
 * warranty. Upload it beside your program, in one archive with controller.c or controller.cpp:
 *
 *     arm_data arm;                           of the run; in seamark_init:
 *     arm_of(seamark_config_json(), &arm);    0 if it is known
 *     arm_frame tool = arm_tool(&arm, observation->joints);
 *     double joints[ARM_MOST_JOINTS], columns[6][ARM_MOST_JOINTS];
 *     arm_inverse(&arm, point, observation->joints, joints);       0 if it got there
 *     arm_jacobian(&arm, observation->joints, columns);
 *
 * The base frame is that of the vehicle's body: origin as its file has it, x forward, y starboard,
 * z down. p = R q + t takes a point of the inner axes to the outer ones. Lengths in m, angles in rad.
 */
#ifndef ARM_H
#define ARM_H

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { ARM_MOST_JOINTS = 16, ARM_MOST_LINKS = 16 };

/* Where axes are in outer ones: point [m]; roll, then pitch, then yaw [rad]. */
typedef struct {
    double point[3], turn[3];
} arm_place;

/* A joint with a motor, in the order of commands and observations. */
typedef struct {
    const char *name;
    double low, high; /* [rad] */
    double fastest;   /* [rad/s] */
    double home;      /* [rad] */
} arm_motor;

/* A link on the way from the mount to the tool; its joint turns it about a unit vector. */
typedef struct {
    const char *name;
    arm_place place; /* of its joint, in the link before */
    double axis[3];
    int motor; /* number of its joint among the motors, or -1 if it is fixed */
} arm_link;

typedef struct {
    const char *name;
    int motors, links;
    arm_place tool; /* the tool centre point, in the last link; the tool points along its x axis */
    arm_motor motor[ARM_MOST_JOINTS];
    arm_link chain[ARM_MOST_LINKS];
    arm_place mount; /* of the arm's base in the body; `arm_of` sets it */
} arm_data;

/* Axes in outer ones. */
typedef struct {
    double turn[3][3]; /* rows; a column is an inner axis in outer axes */
    double point[3];   /* [m] */
} arm_frame;

/* NUMBERS */

/* Return whether the configuration has a text for a key: "arm": "arm-5e-like". */
static inline int arm_has(const char *config, const char *key, const char *value) {
    char wanted[128];
    snprintf(wanted, sizeof wanted, "\"%s\": \"%s\"", key, value);
    return strstr(config, wanted) != NULL;
}

/* Take the arm of a run and its mount, given the configuration as JSON; return 0 if it is known. */
static inline int arm_of(const char *config, arm_data *arm) {
    for (size_t i = 0; i < sizeof arm_mounts / sizeof *arm_mounts; i++) {
        if (!arm_has(config, "vehicle", arm_mounts[i].vehicle)) continue;
        if (!arm_has(config, "arm", arm_mounts[i].arm)) continue;
        for (size_t j = 0; j < sizeof arm_known / sizeof *arm_known; j++)
            if (!strcmp(arm_known[j].name, arm_mounts[i].arm)) *arm = arm_known[j];
        arm->mount = arm_mounts[i].place;
        return 0;
    }
    return -1;
}

/* Return the axes of a place that is in others. */
static inline arm_frame arm_inner(const arm_frame *outer, const arm_place *place) {
    double sr = sin(place->turn[0]), cr = cos(place->turn[0]), sp = sin(place->turn[1]);
    double cp = cos(place->turn[1]), sy = sin(place->turn[2]), cy = cos(place->turn[2]);
    double turn[3][3] = {{cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr},
                         {sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr},
                         {-sp, cp * sr, cp * cr}};
    arm_frame frame = *outer;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            frame.point[i] += outer->turn[i][j] * place->point[j];
            frame.turn[i][j] = 0.0;
            for (int k = 0; k < 3; k++) frame.turn[i][j] += outer->turn[i][k] * turn[k][j];
        }
    return frame;
}

/* Turn axes about a unit vector in them (Rodrigues). */
static inline void arm_turn(arm_frame *frame, const double axis[3], double angle) {
    double s = sin(angle), c = cos(angle), x = axis[0], y = axis[1], z = axis[2], d = 1.0 - c;
    double turn[3][3] = {{c + d * x * x, d * x * y - s * z, d * x * z + s * y},
                         {d * x * y + s * z, c + d * y * y, d * y * z - s * x},
                         {d * x * z - s * y, d * y * z + s * x, c + d * z * z}};
    for (int i = 0; i < 3; i++) {
        double row[3] = {frame->turn[i][0], frame->turn[i][1], frame->turn[i][2]};
        for (int j = 0; j < 3; j++)
            frame->turn[i][j] = row[0] * turn[0][j] + row[1] * turn[1][j] + row[2] * turn[2][j];
    }
}

/* Return the axes of the tool in the body, and write the geometric Jacobian: of each joint, velocity
 * of the tool centre point [m/rad] in rows 0 to 2, axis in rows 3 to 5; 0 where it has no part. */
static inline arm_frame arm_jacobian(const arm_data *arm, const double *joints,
                                     double columns[6][ARM_MOST_JOINTS]) {
    static const arm_frame body = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 0, 0}};
    double origins[ARM_MOST_JOINTS][3];
    arm_frame frame = arm_inner(&body, &arm->mount);
    memset(columns, 0, 6 * sizeof *columns);
    for (int link = 0; link < arm->links; link++) {
        const double *axis = arm->chain[link].axis;
        int motor = arm->chain[link].motor;
        frame = arm_inner(&frame, &arm->chain[link].place);
        if (motor < 0) continue;
        for (int i = 0; i < 3; i++) {
            origins[motor][i] = frame.point[i];
            for (int j = 0; j < 3; j++) columns[3 + i][motor] += frame.turn[i][j] * axis[j];
        }
        arm_turn(&frame, axis, joints[motor]);
    }
    frame = arm_inner(&frame, &arm->tool);
    for (int link = 0; link < arm->links; link++) {
        int motor = arm->chain[link].motor;
        if (motor < 0) continue;
        for (int i = 0; i < 3; i++) {
            int j = (i + 1) % 3, k = (i + 2) % 3;
            columns[i][motor] = columns[3 + j][motor] * (frame.point[k] - origins[motor][k]) -
                                columns[3 + k][motor] * (frame.point[j] - origins[motor][j]);
        }
    }
    return frame;
}

/* Return the axes of the tool in the body: forward kinematics; it points along x. */
static inline arm_frame arm_tool(const arm_data *arm, const double *joints) {
    double columns[6][ARM_MOST_JOINTS];
    return arm_jacobian(arm, joints, columns);
}

/* Write speeds of the joints [rad/s] that give the tool centre point about a velocity [m/s]: damped
 * least squares (Nakamura 1986). The larger the damping [m/rad], the slower the joints where their
 * ways are nearly parallel. Joints with `still` stay. */
static inline void arm_damped(const arm_data *arm, double columns[6][ARM_MOST_JOINTS],
                              const double velocity[3], double damping,
                              const int still[ARM_MOST_JOINTS], double speeds[ARM_MOST_JOINTS]) {
    /* (J J^T + damping^2 1) w = velocity, by Gauss; then speeds = J^T w */
    double rows[3][4], w[3];
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            rows[i][j] = i == j ? damping * damping : 0.0;
            for (int n = 0; n < arm->motors; n++)
                if (!still[n]) rows[i][j] += columns[i][n] * columns[j][n];
        }
        rows[i][3] = velocity[i];
    }
    for (int i = 0; i < 3; i++)
        for (int j = i + 1; j < 3; j++) {
            double factor = rows[j][i] / rows[i][i];
            for (int k = i; k < 4; k++) rows[j][k] -= factor * rows[i][k];
        }
    for (int i = 2; i >= 0; i--) {
        w[i] = rows[i][3];
        for (int j = i + 1; j < 3; j++) w[i] -= rows[i][j] * w[j];
        w[i] /= rows[i][i];
    }
    for (int n = 0; n < arm->motors; n++)
        speeds[n] = still[n] ? 0.0
                             : columns[0][n] * w[0] + columns[1][n] * w[1] + columns[2][n] * w[2];
}

static inline double arm_clamped(const arm_motor *motor, double angle) {
    return angle < motor->low ? motor->low : angle > motor->high ? motor->high : angle;
}

static inline double arm_off(const arm_data *arm, const double *joints, const double point[3],
                             double error[3]) {
    arm_frame tool = arm_tool(arm, joints);
    for (int i = 0; i < 3; i++) error[i] = point[i] - tool.point[i];
    return sqrt(error[0] * error[0] + error[1] * error[1] + error[2] * error[2]);
}

/* Bring the tool as close to a point as steps from these joints can; return how far it is [m].
 * Levenberg and Marquardt; joints at their ends go no further. */
static inline double arm_descend(const arm_data *arm, const double point[3], double *joints) {
    double error[3], damping = 0.1, off = arm_off(arm, joints, point, error);
    for (int step = 0; step < 100 && off > 1e-7 && damping < 50.0; step++) {
        double columns[6][ARM_MOST_JOINTS], moves[ARM_MOST_JOINTS], tried[ARM_MOST_JOINTS];
        int still[ARM_MOST_JOINTS] = {0}, stuck = 1;
        arm_jacobian(arm, joints, columns);
        arm_off(arm, joints, point, error);
        while (stuck) {
            arm_damped(arm, columns, error, damping, still, moves);
            stuck = 0;
            for (int n = 0; n < arm->motors; n++) {
                const arm_motor *motor = &arm->motor[n];
                int over = (joints[n] >= motor->high && moves[n] > 0.0) ||
                           (joints[n] <= motor->low && moves[n] < 0.0);
                if (over) still[n] = stuck = 1;
            }
        }
        for (int n = 0; n < arm->motors; n++)
            tried[n] = arm_clamped(&arm->motor[n], joints[n] + moves[n]);
        double left = arm_off(arm, tried, point, error);
        if (left < 0.99 * off) {
            memcpy(joints, tried, (size_t)arm->motors * sizeof *joints);
            off = left;
            damping = damping > 5e-4 ? 0.2 * damping : 1e-4;
        } else {
            damping *= 5.0;
        }
    }
    return off;
}

/* Write joints within their ranges that bring the tool centre point to a point in the body [m], near
 * `start` where a way leads on from there; return 0, or -1 if no way does, from there, from home, or
 * from postures all over the ranges. The tool's direction is what it is then. */
static inline int arm_inverse(const arm_data *arm, const double point[3], const double *start,
                              double joints[ARM_MOST_JOINTS]) {
    int reaching[ARM_MOST_LINKS], count = 0;
    for (int link = 0; link < arm->links; link++)
        if (arm->chain[link].motor >= 0) reaching[count++] = arm->chain[link].motor;
    for (int posture = -2; posture < 1 << count; posture++) {
        for (int n = 0; n < arm->motors; n++)
            joints[n] = arm_clamped(&arm->motor[n], posture == -1 ? arm->motor[n].home : start[n]);
        for (int i = 0; posture >= 0 && i < count; i++) {
            const arm_motor *motor = &arm->motor[reaching[i]];
            double share = posture >> i & 1 ? 0.75 : 0.25;
            joints[reaching[i]] = motor->low + share * (motor->high - motor->low);
        }
        if (arm_descend(arm, point, joints) <= 1e-7) return 0;
    }
    return -1;
}

#endif
