"""The licences under which the program of a published run may be offered."""

from collections.abc import Mapping

# SPDX identifier -> what it means, in a few words. What is not here belongs into the program.
LICENCES: Mapping[str, str] = {
    "MIT": "use it for anything, keep the notice",
    "BSD-3-Clause": "use it for anything, keep the notice, do not advertise with the author",
    "Apache-2.0": "use it for anything, keep the notice, with a grant of patents",
    "MPL-2.0": "changes to its files stay open, what is built around them need not be",
    "LGPL-3.0-or-later": "changes stay open, programs that link to it need not be",
    "GPL-3.0-or-later": "whatever is built from it stays open",
    "EUPL-1.2": "what is built from it stays open; in all languages of the European Union",
    "CC0-1.0": "no conditions at all",
}
NONE = "Choose none: the files of the program say how it may be used"
NO_PROGRAM = "A licence is for the program, and this publication has none."
