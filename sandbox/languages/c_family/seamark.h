/* The interface of Seamark's programs in C and C++. You may use, change and pass on this file as
 * you like; it comes without any warranty.
 *
 * A controller defines seamark_step, a tracker seamark_tracker_start and seamark_tracker_update, a
 * detector seamark_detect; each also seamark_init and seamark_reset if it needs them. Body frame:
 * x forward, y starboard, z down. Image: x right, y down, the centre of the first pixel is 0, 0.
 * SI units, angles in rad, images in px.
 */
#ifndef SEAMARK_H
#define SEAMARK_H

#define SEAMARK_PROTOCOL 1

#ifdef __cplusplus
extern "C" {
#endif

/* What the vehicle knows at one step. Ground truth is never part of it. */
typedef struct seamark_observation {
    double t;            /* [s] simulated time since the trial began */
    double dt;           /* [s] from one step to the next */
    double error[3];     /* [m] how far the vehicle has to move, body frame */
    double error_px[2];  /* [px] tracked target minus image centre, x right, y down */
    int target_visible;  /* whether the tracker has the target now */
    double target_age;   /* [s] since the tracker last had the target */
    double velocity[3];  /* [m/s] last velocity over ground from the DVL, body frame */
    int velocity_valid;  /* whether the last DVL measurement was good */
    double depth;        /* [m] of the vehicle */
    double altitude;     /* [m] above the bottom */
    double attitude[3];  /* [rad] roll, pitch, yaw */
    double rates[3];     /* [rad/s] p, q, r */
    double thrust[8];    /* [N] last thrust of each thruster; 0 where there is none */
    int thrusters;       /* how many the vehicle has */
} seamark_observation;

/* What the program asks for: finite numbers, at most 1e6 in size. All are 0 before each step. */
typedef struct seamark_command {
    double surge;    /* [m/s] */
    double sway;     /* [m/s] */
    double heave;    /* [m/s] */
    double yaw_rate; /* [rad/s] */
} seamark_command;

/* What begins: the vehicle is put back and the current changes. */
typedef struct seamark_level {
    int index;         /* from 0 */
    int count;         /* how many levels there are */
    double duration_s; /* [s] of this level */
    double dt;         /* [s] from one step to the next */
    double t;          /* [s] simulated time at which it begins */
} seamark_level;

/* A picture, for reading alone. The pixel of row y and column x is pixels[(y * width + x) * channels].
 * That of the last update stays readable during the next one, that of the start until the next. */
typedef struct seamark_image {
    const unsigned char *pixels; /* 0 to 255, row after row from the top, without gaps */
    int width, height;           /* [px] */
    int channels;                /* 1 (grey) or 3 (red, green, blue) */
} seamark_image;

enum { SEAMARK_MOST_DETECTIONS = 64, SEAMARK_LABEL_BYTES = 65 };

/* One thing that a detector found. All are 0 before each call. */
typedef struct seamark_detection {
    double corners[8];               /* [px] x and y of the four corners */
    double confidence;               /* 0 to 1 */
    char label[SEAMARK_LABEL_BYTES]; /* 1 to 64 bytes of printable UTF-8, then 0 */
} seamark_detection;

/* You write those that you need. seamark_init, seamark_step and seamark_tracker_start return 0 when
 * all is well; anything else ends the run. */
int seamark_init(void);                         /* once, before all else; may be left out */
void seamark_reset(const seamark_level *level); /* at each level; may be left out */

int seamark_step(const seamark_observation *observation, seamark_command *command);

/* The target is at these corners: x and y of upper left, upper right, lower right, lower left. */
int seamark_tracker_start(const seamark_image *image, const double corners[8]);

/* Return 1 and put into `corners` where the target is, 0 if it is lost; less than 0 ends the run.
 * What `corners` had last is there at the call: of the start or of the last 1. */
int seamark_tracker_update(const seamark_image *image, double corners[8]);

/* Return how many things are in `found`; less than 0 ends the run. */
int seamark_detect(const seamark_image *image, seamark_detection found[SEAMARK_MOST_DETECTIONS]);

/* You may call these, at any time from seamark_init on. */

/* A number of the configuration ("kp", "ki" ...; true is 1, false is 0), or `fallback`. */
double seamark_config_number(const char *key, double fallback);

/* The whole configuration as JSON, for what is no number. */
const char *seamark_config_json(void);

#ifdef __cplusplus
}
#endif

#endif
