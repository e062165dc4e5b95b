/* As self_test.c, with the standard library of C++, which must be there too. */
#include <gnu/libc-version.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "seamark.h"

#if __has_include(<Eigen/src/Core/util/Macros.h>)
#include <Eigen/src/Core/util/Macros.h>
#endif
#if __has_include(<opencv2/core/version.hpp>)
#include <opencv2/core/version.hpp>
namespace cv {
int getVersionMajor();  // to load the library: its other headers would take a second to compile
}
#endif

static const std::string opencv_modules = ""
#if __has_include(<opencv2/core.hpp>)
    " core"
#endif
#if __has_include(<opencv2/imgproc.hpp>)
    ", imgproc"
#endif
#if __has_include(<opencv2/flann.hpp>)
    ", flann"
#endif
#if __has_include(<opencv2/features2d.hpp>)
    ", features2d"
#endif
#if __has_include(<opencv2/calib3d.hpp>)
    ", calib3d"
#endif
#if __has_include(<opencv2/video.hpp>)
    ", video"
#endif
#if __has_include(<opencv2/dnn.hpp>)
    ", dnn"
#endif
#if __has_include(<opencv2/ml.hpp>)
    ", ml"
#endif
#if __has_include(<opencv2/objdetect.hpp>)
    ", objdetect"
#endif
#if __has_include(<opencv2/photo.hpp>)
    ", photo"
#endif
#if __has_include(<opencv2/tracking.hpp>)
    ", tracking"
#endif
    ;

int seamark_init(void) {
    if (seamark_config_number("contents", 0.0) == 0.0) return 0;
    std::printf("compiler\tGCC\t%s\n", __VERSION__);
    std::printf("library\tGNU C library\t%s\n", gnu_get_libc_version());
#ifdef EIGEN_WORLD_VERSION
    std::printf("library\tEigen\t%d.%d.%d\n", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION,
                EIGEN_MINOR_VERSION);
#endif
#ifdef CV_VERSION
    if (cv::getVersionMajor() == CV_VERSION_MAJOR)
        std::printf("library\tOpenCV\t%s (modules:%s)\n", CV_VERSION, opencv_modules.c_str());
#endif
    return 0;
}

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    const std::vector<double> error(observation->error, observation->error + 3);
    command->surge = 0.5 * error.at(0);
    command->sway = 0.5 * error.at(1);
    command->heave = 0.5 * error.at(2);
    return 0;
}

static std::vector<double> at_start;

int seamark_tracker_start(const seamark_image *, const double corners[8]) {
    at_start.assign(corners, corners + 8);
    return 0;
}

int seamark_tracker_update(const seamark_image *image, double corners[8]) {
    for (int i = 0; i < 8; i++) corners[i] = at_start.at(i) + image->pixels[image->width];
    return 1;
}

int seamark_detect(const seamark_image *image, seamark_detection found[SEAMARK_MOST_DETECTIONS]) {
    const std::string label = "row";
    for (int i = 0; i < 8; i++) found->corners[i] = image->pixels[image->width] + i;
    found->confidence = 0.5;
    std::copy(label.begin(), label.end(), found->label);
    return 1;
}
