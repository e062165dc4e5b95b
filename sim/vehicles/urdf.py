"""A vehicle as URDF, written from its numbers: one rigid link with its hull.

URDF has no water, so this is the dry vehicle. Its frames are the simulator's (x forward,
y starboard, z down), so a viewer with z up shows it upside down.
"""

from xml.etree import ElementTree as Xml

from seamark.sim.vehicles import Vehicle


def urdf_of(vehicle: Vehicle) -> str:
    """Return the URDF document: mass, inertia about the centre of gravity, hull as boxes."""
    robot = Xml.Element("robot", name=vehicle.name)
    link = Xml.SubElement(robot, "link", name="hull")
    inertial = Xml.SubElement(link, "inertial")
    Xml.SubElement(inertial, "origin", xyz=_text(vehicle.centre_of_gravity.value), rpy="0 0 0")
    Xml.SubElement(inertial, "mass", value=_text(vehicle.mass.value))
    ixx, iyy, izz = (_text((value,)) for value in vehicle.inertia_about_gravity())
    Xml.SubElement(inertial, "inertia", ixx=ixx, iyy=iyy, izz=izz, ixy="0", ixz="0", iyz="0")
    for kind in ("collision", "visual"):
        for piece in vehicle.hull:
            part = Xml.SubElement(link, kind, name=piece.name)
            Xml.SubElement(part, "origin", xyz=_text(piece.centre.value), rpy="0 0 0")
            geometry = Xml.SubElement(part, "geometry")
            Xml.SubElement(geometry, "box", size=_text(piece.size.value))
    Xml.indent(robot)
    return Xml.tostring(robot, encoding="unicode", xml_declaration=True) + "\n"


def _text(values: tuple[float, ...]) -> str:
    return " ".join(f"{value!r}" for value in values)
