"""The trackers compared, with settings that are fair to each."""

from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class Contender:
    """A tracker with its options."""

    label: str
    tracker: str
    options: dict[str, object] = field(default_factory=dict)


def _visp(
    label: str, criterion: str, method: str, warp: str, iterations: int, *, sampling_px: int = 2
) -> Contender:
    # Sampling 2 is what ViSP's examples and UWSim use. In the bridge, its pyramid goes down to full
    # resolution, its ESM gets the gain that undoes its half steps, and its template leaves out the
    # target's rim as ours does: without any of these it would perform worse. Its ZNCC and MI lose
    # this target on a coarser pyramid level, so they have one.
    options: dict[str, object] = {
        "criterion": criterion,
        "method": method,
        "warp": warp,
        "sampling_px": sampling_px,
        "visp_iterations": iterations,
        "pyramid_levels": 2 if criterion == "ssd" else 1,
    }
    return Contender(f"ViSP {label}", "visp", options)


CONTENDERS = (
    Contender("ours ZNCC ESM homography", "esm"),
    Contender("ours SSD ESM homography", "esm", {"criterion": "ssd"}),
    Contender("ours MI ESM homography", "esm", {"criterion": "mi"}),
    Contender("ours ZNCC ESM affine", "esm", {"warp": "affine"}),
    Contender("ours ZNCC ESM srt", "esm", {"warp": "srt"}),
    _visp("SSD IC homography", "ssd", "inverse_compositional", "homography", 200),
    _visp("SSD FC homography", "ssd", "forward_compositional", "homography", 200),
    _visp("SSD ESM homography", "ssd", "esm", "homography", 200),
    _visp("ZNCC IC homography", "zncc", "inverse_compositional", "homography", 60),
    _visp("MI IC homography", "mi", "inverse_compositional", "homography", 30, sampling_px=1),
    _visp("MI IC srt", "mi", "inverse_compositional", "srt", 30),
    _visp("SSD IC affine", "ssd", "inverse_compositional", "affine", 200),
    _visp("SSD IC srt", "ssd", "inverse_compositional", "srt", 200),
    Contender("OpenCV ECC homography", "ecc"),
    Contender("OpenCV KLT homography", "klt"),
    Contender("OpenCV KLT srt", "klt", {"warp": "srt"}),
    Contender("OpenCV box by correlation", "box"),
)
# Raced separately: 30 of their images take a second, after which fast trackers took twice as long.
FILTERS = (Contender("OpenCV CSRT", "csrt"), Contender("OpenCV KCF", "kcf"))
PEERS = ("ViSP", "homography")  # start and end of the labels of the reference: the fastest of these
