// A minimal detector as a starting point.
//
// It reports long dark rectangles on brighter sand as boxes: it finds blocks of pixels that are
// much darker than the mean, joins neighbours to regions, and puts a rectangle around each region,
// along its principal axes. All numbers are sums, products, quotients and square roots, which are
// the same on every machine.
#include "seamark.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

namespace {

constexpr int block = 3;                          // [px] side of a block
constexpr double dark_by = 2.0;                   // standard deviations below the mean
constexpr double narrowest = 8.0;                 // [px] minimum width of a box
constexpr double plumpest = 2.0, slimmest = 4.5;  // length / width
constexpr double fullest = 0.5;                   // minimum share of the rectangle that is dark
constexpr double infinity = std::numeric_limits<double>::infinity();

struct Point {
    double x, y;
};

// The blocks of an image: which of them are dark, and in no region yet.
struct Blocks {
    int columns, rows;
    std::vector<bool> dark;

    explicit Blocks(const seamark_image& image)
        : columns(image.width / block), rows(image.height / block), dark(columns * rows) {
        // of a colour image the green channel: water absorbs red light first
        const unsigned char* pixels = image.pixels + image.channels / 2;
        std::vector<double> sums(dark.size());
        double sum = 0.0, squares = 0.0;
        for (std::size_t i = 0; i < sums.size(); i++) {
            for (int j = 0; j < block * block; j++) {
                const int x = static_cast<int>(i) % columns * block + j % block;
                const int y = static_cast<int>(i) / columns * block + j / block;
                sums[i] += pixels[(y * image.width + x) * image.channels];
            }
            sum += sums[i];
            squares += sums[i] * sums[i];
        }
        const double count = static_cast<double>(sums.size()), mean = sum / count;
        const double deviation = std::sqrt(squares / count - mean * mean);
        for (std::size_t i = 0; i < sums.size(); i++)
            dark[i] = sums[i] < mean - dark_by * deviation;
    }

    // Takes the dark blocks that are connected with the one at a position.
    std::vector<Point> take(int column, int row) {
        std::vector<Point> region;
        const auto add = [&](int x, int y) {
            if (x < 0 || y < 0 || x >= columns || y >= rows || !dark[y * columns + x]) return;
            dark[y * columns + x] = false;
            region.push_back({static_cast<double>(x), static_cast<double>(y)});
        };
        add(column, row);
        for (std::size_t i = 0; i < region.size(); i++) {
            const int x = static_cast<int>(region[i].x), y = static_cast<int>(region[i].y);
            add(x - 1, y), add(x + 1, y), add(x, y - 1), add(x, y + 1);
        }
        return region;
    }
};

// Returns the first principal axis of a region: an eigenvector of the covariance, of length 1.
Point axis_of(const std::vector<Point>& region) {
    const double count = static_cast<double>(region.size());
    double sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0, syy = 0.0;
    for (const auto& [x, y] : region) sx += x, sy += y, sxx += x * x, sxy += x * y, syy += y * y;
    const double xx = sxx / count - sx / count * (sx / count);
    const double xy = sxy / count - sx / count * (sy / count);
    const double yy = syy / count - sy / count * (sy / count);
    const double half = (xx - yy) / 2.0;
    Point u{half + std::sqrt(half * half + xy * xy), xy};
    if (u.x == 0.0 && u.y == 0.0) u.y = 1.0;
    const double norm = std::sqrt(u.x * u.x + u.y * u.y);
    return {u.x / norm, u.y / norm};
}

// Puts a rectangle around a region; returns false if it is not that of a box.
bool enclose(const std::vector<Point>& region, seamark_detection& found) {
    const Point u = axis_of(region);
    double left = infinity, right = -infinity, top = infinity, bottom = -infinity;
    for (const auto& [x, y] : region) {
        const double along = x * u.x + y * u.y, across = y * u.x - x * u.y;
        left = std::min(left, along - 0.5), right = std::max(right, along + 0.5);
        top = std::min(top, across - 0.5), bottom = std::max(bottom, across + 0.5);
    }
    const double length = right - left, width = bottom - top;
    const double share = static_cast<double>(region.size()) / (length * width);
    if (width * block < narrowest || share < fullest) return false;
    if (length < plumpest * width || length > slimmest * width) return false;
    const Point corners[4] = {{left, top}, {right, top}, {right, bottom}, {left, bottom}};
    for (int i = 0; i < 4; i++) {  // clockwise
        const auto [along, across] = corners[i];
        found.corners[2 * i] = block * (along * u.x - across * u.y) + (block - 1) / 2.0;
        found.corners[2 * i + 1] = block * (along * u.y + across * u.x) + (block - 1) / 2.0;
    }
    found.confidence = std::min(share, 1.0);
    std::strcpy(found.label, "box");
    return true;
}

}  // namespace

// called with each image; returns the number of detections
int seamark_detect(const seamark_image* image, seamark_detection found[SEAMARK_MOST_DETECTIONS]) {
    Blocks blocks(*image);
    int number = 0;
    for (int y = 0; y < blocks.rows; y++)
        for (int x = 0; x < blocks.columns && number < SEAMARK_MOST_DETECTIONS; x++) {
            const std::vector<Point> region = blocks.take(x, y);
            if (!region.empty() && enclose(region, found[number])) number++;
        }
    return number;
}
