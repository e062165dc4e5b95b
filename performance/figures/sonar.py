"""Draw an image of the sonar for docs/sonar.md: `./run performance sonar_figure`."""

from collections.abc import Sequence

import cv2
import numpy as np

from performance import FIGURES
from performance.perception.sonar_scene import everything
from seamark.sim.sonar.display import in_colour

HEIGHT_PX, GAP_PX, QUALITY = 560, 12, 70


def main(_arguments: Sequence[str]) -> int:
    """Write the figure: on the left what a program gets, on the right the fan."""
    sonar, placed = everything()
    image = sonar.image(placed, 0)
    polar = cv2.resize(image, (image.shape[1], HEIGHT_PX), interpolation=cv2.INTER_AREA)
    fan = in_colour(image, sonar.device, height=HEIGHT_PX)
    gap = np.full((HEIGHT_PX, GAP_PX, 3), 255, np.uint8)
    sheet = np.hstack([cv2.cvtColor(polar, cv2.COLOR_GRAY2BGR), gap, fan])
    path = FIGURES / "sonar.webp"
    cv2.imwrite(str(path), sheet, [cv2.IMWRITE_WEBP_QUALITY, QUALITY])
    print(f"wrote {path}")
    return 0
