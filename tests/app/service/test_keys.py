"""Clients by their keys."""

from primfit.app.service.keys import Keys
from tests.app.serving import ALICE, NAMELESS


def test_the_name_of_a_client_says_whose_key_it_is() -> None:
    keys = Keys.read([f"alice:{ALICE}", NAMELESS])
    assert (keys.owner(ALICE), keys.owner(NAMELESS), keys.owner("")) == ("alice", "key-3eb1bd43", None)
    assert ALICE not in repr(keys) and not Keys()
