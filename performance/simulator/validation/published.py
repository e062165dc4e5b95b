"""Published measurements: their values, where they are published, and how far off we are."""

from typing import NamedTuple

KGF_N = 9.80665  # [N] one kilogram-force


class Source(NamedTuple):
    """A publication, and how its numbers reached us."""

    name: str
    url: str
    remark: str = ""

    def text(self) -> str:
        """Return the entry of a list of sources."""
        return f"{self.name}, <{self.url}>" + (f". {self.remark}" if self.remark else "")


T200 = Source(
    "Blue Robotics, T200 Public Performance Data 10-20 V, September 2019",
    "https://cad.bluerobotics.com/T200-Public-Performance-Data-10-20V-September-2019.xlsx",
    "Bollard thrust of one thruster by pulse width, with the Basic ESC R3; read from a "
    "transcription of the spreadsheet at steps of 100 µs",
)
BLUEROV2 = Source(
    "Blue Robotics, BlueROV2 documentation",
    "https://github.com/bluerobotics/bluerobotics.github.io/blob/"
    "010fce3d4c773d9905404d9e13e679cc79d67f4a/brov2/specifications.md",
    "The vehicle with six thrusters; older revisions of the page give 14 kgf ahead and abeam, "
    "the sum of the thrusters' bench values",
)
HEAVY = Source(
    "Blue Robotics, BlueROV2 Heavy documentation",
    "https://github.com/bluerobotics/bluerobotics.github.io/blob/master/brov2-heavy/index.md",
)
LI = Source(
    "Li, Cao, Li, Ingram and Kiprakis 2020, J. Mar. Sci. Eng. 8(9) 688",
    "https://doi.org/10.3390/jmse8090688",
    "A BlueROV2 with six thrusters held by load cells in a current tank. Only the abstract was "
    "open to us; the forces are those that a public report read off the paper's plots, the "
    "coefficients (from CFD) those that public code quotes",
)
WU = Source(
    "Wu 2018, 6-DoF Modelling and Control of a Remotely Operated Vehicle, Flinders University",
    "https://flex.flinders.edu.au/file/27aa0064-9de2-441c-8a17-655405d5fc2e/1/ThesisWu2018.pdf",
    "Coefficients as public code quotes them; the quotations disagree whether they belong to the "
    "vehicle with six or with eight thrusters",
)
TIDE = Source(
    "Thomson et al. 2012, IEEE J. Oceanic Eng. 37(3)",
    "https://www.osti.gov/scitech/biblio/1047397",
)
KIM = Source(
    "Kim and Hong 2014, J. Korean Soc. Fish. Technol. 50(4) 435",
    "https://doi.org/10.3796/KSFT.2014.50.4.435",
    "Near the bottom of a coastal trench: 50 % at 0.2 m/s, falling to 10 % at 0.9 m/s",
)
A50 = Source("Water Linked, DVL A50", "https://waterlinked.github.io/docs/dvl/dvl-a50/")
HINSDALE = Source(
    "Kolano et al., UVMS-SysID-with-EAs, data/hinsdale-data-2023, commit 18d9b2f",
    "https://github.com/hkolano/UVMS-SysID-with-EAs",
    "MIT licence; eight of its trials are kept here, ten samples a second. Related paper: arXiv "
    "2209.13577",
)
ZANEVELD = Source(
    "Zaneveld and Pegau 2003, Opt. Express 11, 2997",
    "https://doi.org/10.1364/OE.11.002997",
    "4.6 according to the summary of WET Labs "
    "(<http://www.wetlabs.com/appdescs/visibility.htm>), 4.8 as others quote it",
)
SOURCES = (T200, BLUEROV2, HEAVY, LI, WU, TIDE, KIM, A50, ZANEVELD)


class Comparison(NamedTuple):
    """A quantity as our simulator has it and as it was measured, in the same unit."""

    what: str
    ours: float
    measured: float
    unit: str
    source: Source

    @property
    def error_percent(self) -> float:
        """Return how far we are off; positive if ours is larger."""
        return 100.0 * (self.ours / self.measured - 1.0)

    def cells(self) -> tuple[str, ...]:
        """Return the cells of a table: what, ours, measured, unit, error, number of the source."""
        return (
            self.what,
            f"{self.ours:.3g}",
            f"{self.measured:.3g}",
            self.unit,
            f"{self.error_percent:+.0f}",
            f"[{SOURCES.index(self.source) + 1}]",
        )


HEADER = ("quantity", "ours", "measured", "unit", "error %", "source")
