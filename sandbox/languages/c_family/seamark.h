/* The interface for Seamark programs in C and C++. You may use, modify and distribute this file
 * freely; it comes without any warranty.
 *
 * A controller defines seamark_step, a tracker seamark_tracker_start and seamark_tracker_update, a
 * detector seamark_detect; seamark_init and seamark_reset are optional. Body frame:
 * x forward, y starboard, z down. Image: x right, y down, the centre of the first pixel is 0, 0.
 * SI units, angles in rad, images in px.
 */
#ifndef SEAMARK_H
#define SEAMARK_H

#define SEAMARK_PROTOCOL 1

#ifdef __cplusplus
extern "C" {
#endif

enum { SEAMARK_MOST_JOINTS = 16 };

/* A read-only image. The pixel of row y and column x is pixels[(y * width + x) * channels]. The image
 * of an update stays valid during the next update, that of the start until the next start; that of a
 * controller's camera until its next image but one. */
typedef struct seamark_image {
    const unsigned char *pixels; /* 0 to 255, row by row from the top, without padding */
    int width, height;           /* [px] */
    int channels;                /* 1 (grey) or 3 (red, green, blue) */
} seamark_image;

/* The newest images of a controller's cameras; pixels is NULL where none are asked for. */
typedef struct seamark_images {
    seamark_image vehicle; /* of the vehicle's camera, which looks down */
    seamark_image arm;     /* of the camera on its arm */
    seamark_image sonar;   /* of its imaging sonar: rows of range, columns from port to starboard */
} seamark_images;

/* The observation of one control step. It never contains ground truth. */
typedef struct seamark_observation {
    double t;            /* [s] simulated time in the trial */
    double dt;           /* [s] control period */
    double error[3];     /* [m] position error: how far the vehicle has to move, body frame */
    double error_px[2];  /* [px] tracked target minus image centre, x right, y down */
    int target_visible;  /* whether the tracker currently sees the target */
    double target_age;   /* [s] since the tracker last saw the target */
    double velocity[3];  /* [m/s] last velocity over ground from the DVL, body frame */
    int velocity_valid;  /* whether the last DVL measurement was valid */
    double depth;        /* [m] of the vehicle */
    double altitude;     /* [m] above the bottom */
    double attitude[3];  /* [rad] roll, pitch, yaw */
    double rates[3];     /* [rad/s] p, q, r */
    double thrust[8];    /* [N] last commanded thrust of each thruster; 0 if there is none */
    int thrusters;       /* number of thrusters */
    /* For a vehicle with an arm, in the order of the command: */
    double corners[8];                          /* [px] of the target by the tracker, x0 y0 to x3 y3 */
    int joints_count;                           /* number of joints with a motor; 0 without an arm */
    double joints[SEAMARK_MOST_JOINTS];         /* [rad or m] */
    double joint_speeds[SEAMARK_MOST_JOINTS];   /* [rad/s or m/s] */
    double joint_efforts[SEAMARK_MOST_JOINTS];  /* [N m or N] of the motors, from their currents */
    double wrist_force[3];                      /* [N] of the arm on its hand, axes of the sensor */
    double wrist_torque[3];                     /* [N m] of the same */
    double touch[SEAMARK_MOST_JOINTS];          /* 1 for each part of the hand that touches, else 0 */
    /* Where the target has to be found first: */
    double told[2];    /* [m] about where it is: north and east of where the vehicle started */
    double confidence; /* by the detector, that what the tracker has is the target; 0 to 1 */
    /* Where a route has to be followed: */
    double route[96]; /* [m] 32 points joined by straight lines, the same over a level: north and east
                         of where the vehicle is said to have started, and depth of each */
    double fix[2];    /* [m] position by the last acoustic fix, north and east of the same place */
    double fix_age;   /* [s] since it was there; -1 before the first fix */
    double fix_sigma; /* [m] standard deviation of each of its two numbers */
    double pipe_offset; /* [m] how far to starboard of its own direction the pipe is, by where the
                           detector last saw it; 0 on another route */
    double pipe_angle;  /* [rad] of this direction from the bow, clockwise */
    /* Where a dock has to be entered: */
    double dock[3];       /* [m] where it is by its last acoustic answer: north, east and down of where
                             the vehicle was then */
    double dock_age;      /* [s] since it was asked; -1 before the first answer */
    double dock_sigma;    /* [m] standard deviation of each of the first two numbers */
    double dock_heading;  /* [rad] in which the dock takes a vehicle, from north, clockwise */
    double light[2];      /* [px] its lamps in the image, minus its centre; the last ones seen */
    double light_visible; /* 1 while they are in the image and bright enough, else 0 */
    /* With the setting `images` or `sonar`: */
    double image_t;        /* [s] simulated time at which the newest images were taken */
    seamark_images images; /* grey; all their cameras take them at once */
} seamark_observation;

/* The command: finite numbers of magnitude 1e6 at most. All are 0 before each step. */
typedef struct seamark_command {
    double surge;    /* [m/s] */
    double sway;     /* [m/s] */
    double heave;    /* [m/s] */
    double yaw_rate; /* [rad/s] */
    double arm[SEAMARK_MOST_JOINTS]; /* [rad/s or m/s] of each joint, if the vehicle has an arm */
} seamark_command;

/* The level that begins: the vehicle is moved back and the current changes. */
typedef struct seamark_level {
    int index;         /* from 0 */
    int count;         /* number of levels */
    double duration_s; /* [s] of this level */
    double dt;         /* [s] control period */
    double t;          /* [s] simulated time at its start */
} seamark_level;

enum { SEAMARK_MOST_DETECTIONS = 64, SEAMARK_LABEL_BYTES = 65 };

/* One detection. All members are 0 before each call. */
typedef struct seamark_detection {
    double corners[8];               /* [px] x and y of the four corners */
    double confidence;               /* 0 to 1 */
    char label[SEAMARK_LABEL_BYTES]; /* 1 to 64 bytes of printable UTF-8, then 0 */
} seamark_detection;

/* Define the functions you need. seamark_init, seamark_step and seamark_tracker_start return 0 on
 * success; any other value ends the run. */
int seamark_init(void);                         /* called once, first; optional */
void seamark_reset(const seamark_level *level); /* at each level; optional */

int seamark_step(const seamark_observation *observation, seamark_command *command);

/* The target's corners: x and y of upper left, upper right, lower right, lower left. */
int seamark_tracker_start(const seamark_image *image, const double corners[8]);

/* Write the corners of the target to `corners` and return 1; return 0 if the target is lost. Negative
 * values end the run. On entry, `corners` holds the last known corners. Corners that are not finite or
 * beyond 1e6 count as a loss. */
int seamark_tracker_update(const seamark_image *image, double corners[8]);

/* Return the number of detections written to `found`; negative values end the run. */
int seamark_detect(const seamark_image *image, seamark_detection found[SEAMARK_MOST_DETECTIONS]);

/* These functions can be called at any time from seamark_init on. */

/* A number in the configuration ("kp", "ki" ...; true is 1, false is 0), or `fallback`. */
double seamark_config_number(const char *key, double fallback);

/* The configuration as JSON, for settings that are not numbers. */
const char *seamark_config_json(void);

#ifdef __cplusplus
}
#endif

#endif
