"""What both distributions say to a registry beside what stands in their pyproject.toml.

A README is read there without the checkout: its links and pictures lead to SEAMARK_SOURCE_URL, the
address of the source that a release names (`./run release`). Without one they become text.
"""

import os
import re
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface
from hatchling.metadata.plugin.interface import MetadataHookInterface

SOURCE = "SEAMARK_SOURCE_URL"
_PATH = r"\((?![a-z]+:|#)([^)\s]+)\)"  # relative, in brackets
_PICTURE = re.compile(rf"!\[([^\]]*)\]{_PATH}")
_LINK = re.compile(rf"(?<!!)\[((?:!\[[^\]]*\]\([^)]*\)|[^\[\]])*)\]{_PATH}")


def readme_for_registry(text: str, source: str) -> str:
    """Return a README whose relative links and pictures work outside of the checkout."""
    picture = rf"![\1]({source}/raw/HEAD/\2)" if source else r"*\1*"
    link = rf"[\1]({source}/blob/HEAD/\2)" if source else r"\1"
    return _LINK.sub(link, _PICTURE.sub(picture, text))


class RegistryMetadata(MetadataHookInterface):
    """Fills in `urls`, and `readme` where that is dynamic."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Change the metadata of a project."""
        source = os.environ.get(SOURCE, "").rstrip("/")
        pages = {"Source": "", "Changelog": "/blob/HEAD/CHANGELOG.md"}
        pages["Documentation"] = "/blob/HEAD/docs"
        metadata["urls"] = {name: source + path for name, path in pages.items() if source}
        if "readme" in metadata.get("dynamic", ()):
            text = Path(self.root, "README.md").read_text("utf-8")
            shown = readme_for_registry(text, source)
            metadata["readme"] = {"content-type": "text/markdown", "text": shown}


class PublishedWheel(BuildHookInterface):  # type: ignore[type-arg]  # of hatchling's configuration
    """Sets the `tag` of a wheel and adds `files`; an editable installation needs neither."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Change what is built."""
        if version != "standard":
            return
        if "tag" in self.config:
            build_data["tag"] = self.config["tag"]
        sources = Path(__file__).parents[1] / "seamark"
        files = {str(sources / name): f"seamark/{name}" for name in self.config.get("files", ())}
        build_data["force_include"].update(files)
