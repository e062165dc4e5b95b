from pathlib import Path

import numpy as np
import pytest

from seamark.sim.camera import seabed


@pytest.mark.parametrize("channel", seabed.STORED_TILES)
def test_the_stored_tile_is_what_is_painted(channel: int) -> None:
    stored = seabed._stored(channel)

    assert stored is not None
    assert np.array_equal(stored, seabed.painted(seabed.SEABED_SEED, channel))


@pytest.mark.parametrize("damage", ["missing", "empty", "one byte"])
def test_a_damaged_tile_is_painted_again(
    damage: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    content = bytearray(seabed.STORED_TILES[1].read_bytes())
    content[len(content) // 2] ^= 1
    copy = tmp_path / "sand.png"
    if damage != "missing":
        copy.write_bytes(b"" if damage == "empty" else content)
    expected = seabed.texels(seabed.SEABED_SEED, 1)

    monkeypatch.setitem(seabed.STORED_TILES, 1, copy)

    assert seabed._stored(1) is None
    assert np.array_equal(seabed.texels(seabed.SEABED_SEED, 1), expected)
