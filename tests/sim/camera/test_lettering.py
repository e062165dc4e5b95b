"""The letters on boxes: which text a face has, and texts that are none of it."""

from dataclasses import replace

import numpy as np

from seamark.sim.camera import lettering
from seamark.sim.camera.bodies import UPPER, lettered_face
from seamark.sim.vehicles.linkage_reading import load_linkage

(BOX,) = (solid for solid in load_linkage("black-box").links[0].solids if solid.lettered)


def test_another_text_differs_at_every_place_and_can_be_painted() -> None:
    random = np.random.default_rng(1)

    texts = {lettering.other_text(random) for _ in range(200)}

    assert len(texts) > 150
    for text in texts:
        assert len(text) == len(lettering.TEXT)
        assert set(text) <= set(lettering.GLYPHS)
        assert all(one != usual for one, usual in zip(text, lettering.TEXT, strict=True))


def test_a_seed_gives_the_same_text_again() -> None:
    once, again = (lettering.other_text(np.random.default_rng(7)) for _ in range(2))

    assert once == again


def test_a_box_without_a_text_has_the_usual_one() -> None:
    usual = lettered_face(BOX, 1, UPPER)

    named = lettered_face(replace(BOX, text=lettering.TEXT), 1, UPPER)

    assert usual.tobytes() == named.tobytes()


def test_another_text_changes_the_letters_alone() -> None:
    usual = lettered_face(BOX, 1, UPPER)

    other = lettered_face(replace(BOX, text="KRAMSES"), 1, UPPER)
    rows, columns = np.nonzero(usual != other)

    middle = 0.42 * usual.shape[0]
    assert rows.size > 100
    assert np.abs(rows - middle).max() < 0.18 * usual.shape[0]
    assert columns.min() > 0.07 * usual.shape[1]
    assert columns.max() < 0.93 * usual.shape[1]
