"""Places in a file: a point, and how the axes there are turned."""

from seamark.sim.vehicles.fields import Fields, Table, not_given, vector
from seamark.sim.vehicles.model import Place

PLACE_KEYS = ("place", "turn")
_POINT, _TURN = vector("place", "m"), vector("turn", "rad")


def read_place(fields: Fields, path: str, table: Table) -> Place:
    """Return the place that a table has among its keys; what is not given is zero."""
    point, turn = (
        fields.quantity(path, table, key, slot) if key in table else not_given(slot)
        for key, slot in zip(PLACE_KEYS, (_POINT, _TURN), strict=True)
    )
    return Place(point=point, turn=turn)
