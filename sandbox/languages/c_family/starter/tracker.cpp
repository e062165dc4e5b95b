// A minimal template tracker as a starting point.
//
// It stores some pixels of the target and searches around the last position for the smallest sum of
// absolute differences. Means are subtracted, since turbid water adds scattered light. Integer
// arithmetic gives the same result on every machine.
#include "seamark.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

namespace {

constexpr int points = 1200;  // maximum number of template pixels
constexpr int reach = 8;      // search radius [px]

struct Tracker {
    int left = 0, top = 0, columns = 0, rows = 0, pitch = 1;  // sampling grid on the target [px]
    std::vector<int> patch;  // template pixels minus their mean, times their number
    long long contrast = 0;  // sum of their absolute values

    bool start(const seamark_image& image, const double* corners) {
        double low[2] = {corners[0], corners[1]}, high[2] = {corners[0], corners[1]};
        for (int i = 2; i < 8; i++) {
            low[i % 2] = std::min(low[i % 2], corners[i]);
            high[i % 2] = std::max(high[i % 2], corners[i]);
        }
        left = std::max(0, static_cast<int>(std::ceil(low[0])));
        top = std::max(0, static_cast<int>(std::ceil(low[1])));
        const int width = std::min(image.width - 1, static_cast<int>(std::floor(high[0]))) - left;
        const int height = std::min(image.height - 1, static_cast<int>(std::floor(high[1]))) - top;
        for (pitch = 1; width / pitch * (height / pitch) > points;) pitch++;
        columns = width / pitch, rows = height / pitch;
        if (width < 1 || height < 1 || columns * rows == 0) return false;
        patch = look(image, left, top);
        contrast = 0;
        for (int value : patch) contrast += std::abs(value);
        return true;
    }

    // Moves the grid to the target; returns false if it is not found.
    bool update(const seamark_image& image) {
        long long best = -1;
        int best_x = 0, best_y = 0;
        for (int y = top - reach; y <= top + reach; y++) {
            if (y < 0 || y + rows * pitch > image.height) continue;
            for (int x = left - reach; x <= left + reach; x++) {
                if (x < 0 || x + columns * pitch > image.width) continue;
                const std::vector<int> seen = look(image, x, y);
                long long difference = 0;
                for (std::size_t i = 0; i < seen.size(); i++)
                    difference += std::abs(seen[i] - patch[i]);
                if (best >= 0 && difference >= best) continue;
                best = difference, best_x = x, best_y = y;
            }
        }
        if (best < 0 || 10 * best > 9 * contrast) return false;
        left = best_x, top = best_y;
        return true;
    }

    // Returns the pixels of the grid at a position minus their mean, times their number.
    std::vector<int> look(const seamark_image& image, int at_x, int at_y) const {
        const int count = columns * rows;
        std::vector<int> to(count);
        int sum = 0;
        for (int i = 0; i < count; i++) {
            const int x = at_x + i % columns * pitch, y = at_y + i / columns * pitch;
            to[i] = image.pixels[(y * image.width + x) * image.channels];
            sum += to[i];
        }
        for (int& value : to) value = count * value - sum;
        return to;
    }
};

Tracker tracker;

}  // namespace

// called at the start of each level: x and y of the upper left, upper right, lower right and lower
// left corner; anything but 0 ends the run
int seamark_tracker_start(const seamark_image* image, const double corners[8]) {
    return tracker.start(*image, corners) ? 0 : 1;
}

// called with each following image, 20 per simulated second; returns 0 if the target is lost
int seamark_tracker_update(const seamark_image* image, double corners[8]) {
    const int left = tracker.left, top = tracker.top;
    if (!tracker.update(*image)) return 0;
    for (int i = 0; i < 8; i++)  // `corners` holds the previous result
        corners[i] += i % 2 ? tracker.top - top : tracker.left - left;
    return 1;
}
