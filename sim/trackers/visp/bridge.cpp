// Runs ViSP's template trackers for Seamark in a separate process, over a pipe.
//
// ViSP is licensed under the GPL; this program only calls its interface, and Seamark talks to this
// program alone. Messages, all numbers in the processor's (little-endian) order:
//   start:  'S', 8 int32 (criterion, method, warp, levels, sampling, iterations, width, height),
//           8 double (corners u, v), 8 double (corners of the template), pixels
//                                              -> 'K', or 'E' + int32 length + text
//   next:   'T', 8 double (where the corners are expected; NaN: where they were), pixels
//                                              -> 'K', 8 double corners, int32 iterations,
//                                                 double CPU seconds of track(); or 'E' ...
// The program ends when its input does.

#include <cmath>
#include <cstdint>
#include <ctime>
#include <exception>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <csignal>
#include <sys/prctl.h>
#include <unistd.h>

#include <visp3/core/vpImage.h>
#include <visp3/tt/vpTemplateTrackerSSDESM.h>
#include <visp3/tt/vpTemplateTrackerSSDForwardAdditional.h>
#include <visp3/tt/vpTemplateTrackerSSDForwardCompositional.h>
#include <visp3/tt/vpTemplateTrackerSSDInverseCompositional.h>
#include <visp3/tt/vpTemplateTrackerWarpAffine.h>
#include <visp3/tt/vpTemplateTrackerWarpHomography.h>
#include <visp3/tt/vpTemplateTrackerWarpHomographySL3.h>
#include <visp3/tt/vpTemplateTrackerWarpRT.h>
#include <visp3/tt/vpTemplateTrackerWarpSRT.h>
#include <visp3/tt/vpTemplateTrackerWarpTranslation.h>
#include <visp3/tt/vpTemplateTrackerZNCCForwardAdditional.h>
#include <visp3/tt/vpTemplateTrackerZNCCInverseCompositional.h>
#include <visp3/tt_mi/vpTemplateTrackerMIESM.h>
#include <visp3/tt_mi/vpTemplateTrackerMIForwardAdditional.h>
#include <visp3/tt_mi/vpTemplateTrackerMIForwardCompositional.h>
#include <visp3/tt_mi/vpTemplateTrackerMIInverseCompositional.h>

namespace {

enum Setting { Criterion, Method, Warp, Levels, Sampling, Iterations, Width, Height, Settings };
enum { Ssd, Zncc, Mi };
enum { Esm, Inverse, Additional, Compositional };

const int kLargestSide = 8192;
const int kFitIterations = 4;   // the warp is nearly linear over the motion of one image
const double kFitStep = 1e-6;   // of a parameter, for the slope

bool read_all(void *to, size_t bytes) {
  char *position = static_cast<char *>(to);
  while (bytes > 0) {
    const ssize_t got = ::read(0, position, bytes);
    if (got <= 0) return false;
    position += got;
    bytes -= static_cast<size_t>(got);
  }
  return true;
}

void add(std::string &message, const void *from, size_t bytes) {
  message.append(static_cast<const char *>(from), bytes);
}

bool write_all(const std::string &message) {
  size_t done = 0;
  while (done < message.size()) {
    const ssize_t put = ::write(1, message.data() + done, message.size() - done);
    if (put <= 0) return false;
    done += static_cast<size_t>(put);
  }
  return true;
}

bool refuse(const std::string &why) {
  std::string message = "E";
  const int32_t length = static_cast<int32_t>(why.size());
  add(message, &length, sizeof length);
  return write_all(message + why);
}

double cpu_seconds() {
  timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return now.tv_sec + 1e-9 * now.tv_nsec;
}

std::unique_ptr<vpTemplateTrackerWarp> make_warp(int kind) {
  switch (kind) {
    case 0: return std::make_unique<vpTemplateTrackerWarpTranslation>();
    case 1: return std::make_unique<vpTemplateTrackerWarpRT>();
    case 2: return std::make_unique<vpTemplateTrackerWarpSRT>();
    case 3: return std::make_unique<vpTemplateTrackerWarpAffine>();
    case 4: return std::make_unique<vpTemplateTrackerWarpHomography>();
    case 5: return std::make_unique<vpTemplateTrackerWarpHomographySL3>();
  }
  throw std::runtime_error("unknown warp");
}

std::unique_ptr<vpTemplateTracker> make_tracker(int kind, vpTemplateTrackerWarp *warp) {
  switch (kind) {
    case 10 * Ssd + Esm: return std::make_unique<vpTemplateTrackerSSDESM>(warp);
    case 10 * Ssd + Inverse: return std::make_unique<vpTemplateTrackerSSDInverseCompositional>(warp);
    case 10 * Ssd + Additional: return std::make_unique<vpTemplateTrackerSSDForwardAdditional>(warp);
    case 10 * Ssd + Compositional:
      return std::make_unique<vpTemplateTrackerSSDForwardCompositional>(warp);
    case 10 * Zncc + Inverse:
      return std::make_unique<vpTemplateTrackerZNCCInverseCompositional>(warp);
    case 10 * Zncc + Additional: return std::make_unique<vpTemplateTrackerZNCCForwardAdditional>(warp);
    case 10 * Mi + Esm: return std::make_unique<vpTemplateTrackerMIESM>(warp);
    case 10 * Mi + Inverse: return std::make_unique<vpTemplateTrackerMIInverseCompositional>(warp);
    case 10 * Mi + Additional: return std::make_unique<vpTemplateTrackerMIForwardAdditional>(warp);
    case 10 * Mi + Compositional:
      return std::make_unique<vpTemplateTrackerMIForwardCompositional>(warp);
  }
  throw std::runtime_error("ViSP has no such tracker");
}

// One target: ViSP's tracker, its warp, and the corners it started from.
class Target {
 public:
  // Reads everything of a start message; false when the input ends.
  bool read() {
    if (!read_all(settings_, sizeof settings_)) return false;
    for (const int side : {settings_[Width], settings_[Height]})
      if (side < 1 || side > kLargestSide) return false;
    image_.resize(settings_[Height], settings_[Width]);
    return read_all(corners_, sizeof corners_) && read_all(template_, sizeof template_) &&
           read_image();
  }

  // Reads everything of a message with the next image.
  bool read_next() { return read_all(expected_, sizeof expected_) && read_image(); }

  bool read_image() { return read_all(image_.bitmap, image_.getSize()); }

  void start() {
    warp_ = make_warp(settings_[Warp]);
    tracker_ = make_tracker(10 * settings_[Criterion] + settings_[Method], warp_.get());
    tracker_->setSampling(settings_[Sampling], settings_[Sampling]);
    tracker_->setIterationMax(settings_[Iterations]);
    tracker_->setPyramidal(settings_[Levels], 0);  // down to the full resolution
    // Its SSD-ESM adds both gradients without the half, so its steps are half of ESM's.
    if (settings_[Criterion] == Ssd && settings_[Method] == Esm) tracker_->setGain(2.0);
    std::vector<vpImagePoint> outline;
    for (const int corner : {0, 1, 2, 0, 2, 3})  // two triangles
      outline.emplace_back(template_[2 * corner + 1], template_[2 * corner]);
    tracker_->initFromPoints(image_, outline, false);
  }

  std::string track() {
    if (!tracker_) throw std::runtime_error("no target yet");
    if (std::isfinite(expected_[0])) expect();
    const double before = cpu_seconds();
    tracker_->track(image_);
    const double spent = cpu_seconds() - before;
    std::string answer = "K";
    const vpColVector corners = warped(tracker_->getp());
    add(answer, corners.data, 8 * sizeof(double));
    const int32_t iterations = static_cast<int32_t>(tracker_->getNbIteration());
    add(answer, &iterations, sizeof iterations);
    add(answer, &spent, sizeof spent);
    return answer;
  }

  void drop() { tracker_.reset(); }

 private:
  // Starts the search from the warp that moves the corners to where they are expected, if the warp
  // is able to: by Gauss-Newton, since findWarp() throws in ViSP 3.5.0.
  void expect() {
    vpColVector p = tracker_->getp();
    for (int iteration = 0; iteration < kFitIterations; ++iteration) {
      vpColVector off = warped(p);
      for (int k = 0; k < 8; ++k) off[k] = expected_[k] - off[k];
      vpMatrix slopes(8, p.size());
      for (unsigned int j = 0; j < p.size(); ++j) {
        vpColVector moved = p;
        moved[j] += kFitStep;
        const vpColVector slope = (warped(moved) - warped(p)) / kFitStep;
        for (unsigned int k = 0; k < 8; ++k) slopes[k][j] = slope[k];
      }
      p += slopes.pseudoInverse() * off;
    }
    for (unsigned int k = 0; k < p.size(); ++k)
      if (!std::isfinite(p[k])) return;
    tracker_->setp(p);
  }

  // The corners (u, v of each) under the warp with these parameters.
  vpColVector warped(const vpColVector &p) {
    vpColVector all(8), from(2), to(2);
    warp_->computeCoeff(p);
    for (int corner = 0; corner < 4; ++corner) {
      from[0] = corners_[2 * corner];
      from[1] = corners_[2 * corner + 1];
      warp_->computeDenom(from, p);
      warp_->warpX(from, to, p);
      all[2 * corner] = to[0];
      all[2 * corner + 1] = to[1];
    }
    return all;
  }

  int32_t settings_[Settings];
  double corners_[8];
  double template_[8];  // corners of what is compared
  double expected_[8];
  vpImage<unsigned char> image_;
  std::unique_ptr<vpTemplateTrackerWarp> warp_;
  std::unique_ptr<vpTemplateTracker> tracker_;
};

}  // namespace

int main() {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // also during an image that never ends
  Target target;
  char kind;
  while (read_all(&kind, 1)) {
    if (kind == 'S') {
      if (!target.read()) return 1;
    } else if (kind != 'T' || !target.read_next()) {
      return 1;
    }
    try {
      std::string answer = "K";
      if (kind == 'S') {
        target.drop();
        target.start();
      } else {
        answer = target.track();
      }
      if (!write_all(answer)) return 1;
    } catch (const vpException &error) {
      if (!refuse(error.getStringMessage())) return 1;
    } catch (const std::exception &error) {
      if (!refuse(error.what())) return 1;
    }
  }
  return 0;
}
