"""Grey images as H.264 in MP4, and such files behind each other without encoding again.

One thread, no frames that depend on later ones, and no time of day: the same images give the same
bytes, whatever was in memory before.
"""

from __future__ import annotations

import io
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamark.demonstrations.layouts.rolling import FILES_A_CHUNK, path_of

CODEC, PIXELS = "h264", "yuv420p"
KEY_EVERY = 10  # frames that have to be decoded at most to get one
_OPTIONS = {
    "crf": "23",
    "preset": "veryfast",
    "g": str(KEY_EVERY),
    "bf": "0",
    "threads": "1",
    "x264-params": "mbtree=0",  # its vectorised code reads memory that nobody has written
}


def encoded(images: Iterable[NDArray[np.uint8]], rate_hz: int) -> bytes:
    """Return a video of grey images, (height, width) each, with even sides."""
    import av

    whole = io.BytesIO()
    with av.open(whole, "w", format="mp4") as container:
        stream: Any = None
        for image in images:
            if stream is None:
                stream = container.add_stream("libx264", rate=rate_hz, options=_OPTIONS)
                stream.height, stream.width = image.shape
                stream.pix_fmt = PIXELS
            container.mux(stream.encode(av.VideoFrame.from_ndarray(image, format="gray")))
        container.mux(stream.encode())
    return whole.getvalue()


class RollingVideo:
    """Joins videos of one kind in `chunk-000/file-000.mp4` and so on; a context manager."""

    def __init__(self, folder: Path, *, limit_bytes: int, rate_hz: int) -> None:
        self._folder, self._limit, self._rate = folder, limit_bytes, rate_hz
        self._number = 0
        self._bytes = 0  # in the present file
        self._frames = 0
        self._container: Any = None
        self._stream: Any = None

    def __enter__(self) -> RollingVideo:
        """Begin."""
        return self

    def __exit__(self, *_: object) -> None:
        """Complete the last file."""
        self._close()

    def add(self, video: bytes, frames: int) -> dict[str, float]:
        """Add a video and return where it is: file, and begin and end in it [s]."""
        import av

        with av.open(io.BytesIO(video), "r") as source:
            if self._container is None:
                self._open(source.streams.video[0])
            for packet in source.demux(video=0):
                if packet.pts is None or packet.dts is None:  # marks the end
                    continue
                ticks = round(self._frames / self._rate / float(packet.time_base))
                packet.pts, packet.dts = packet.pts + ticks, packet.dts + ticks
                packet.stream = self._stream
                self._container.mux(packet)
        chunk, file = divmod(self._number, FILES_A_CHUNK)
        begin, self._frames = self._frames, self._frames + frames
        where = {
            "chunk_index": chunk,
            "file_index": file,
            "from_timestamp": begin / self._rate,
            "to_timestamp": self._frames / self._rate,
        }
        self._bytes += len(video)
        if self._bytes >= self._limit:
            self._close()
            self._number, self._frames, self._bytes = self._number + 1, 0, 0
        return where

    def _open(self, like: Any) -> None:
        import av

        path = self._folder / path_of(*divmod(self._number, FILES_A_CHUNK), "mp4")
        path.parent.mkdir(parents=True, exist_ok=True)
        self._container = av.open(str(path), "w", format="mp4")
        self._stream = self._container.add_stream_from_template(like)

    def _close(self) -> None:
        if self._container is not None:
            self._container.close()
            self._container = None
