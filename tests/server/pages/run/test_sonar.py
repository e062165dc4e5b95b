"""The page of a run offers the fan of its sonar, if it has one."""

import pytest

from tests.server.pages.conftest import Site


@pytest.mark.parametrize(("chosen", "offered"), [({"sonar": "forward"}, True), ({}, False)])
def test_the_fan_can_be_chosen_where_there_is_a_sonar(
    site: Site, chosen: dict[str, str], offered: bool
) -> None:
    config = {"levels": [0.1], "level_duration_s": 5.0} | chosen
    claim = site.running("ann", benchmark="track-v1", controller="ilos", config=config)

    page = site.browser("ann").get(f"/runs/{claim.run_id}").text

    assert ("data-sonar" in page) is offered
    assert ("Forward-looking" in page) is offered
