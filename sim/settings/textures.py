"""What targets and seabeds can be covered with; light, so that forms need not load the camera."""

LETTERS, SAND = "letters", "sand"  # drawn by the camera itself; the others are pictures
PICTURES = {
    "mosaic": "Painted: mosaic",
    "mottle": "Painted: mottled",
    "brick": "Photograph: bricks",
    "camera": "Photograph: man with a camera",
    "coffee": "Photograph: coffee cup",
    "grass": "Photograph: grass",
    "gravel": "Photograph: gravel",
}
TARGET_TEXTURES = {LETTERS: "Painted: letters", **PICTURES}
SEABED_TEXTURES = {
    SAND: "Painted: sand",
    **{name: PICTURES[name] for name in ("brick", "grass", "gravel")},
}
