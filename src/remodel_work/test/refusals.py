"""What tests expect when an ability refuses."""

from contextlib import contextmanager

import pytest

from remodel_work.errors import AbilityError


@contextmanager
def refused(code, words=None):
    """Expect a refusal with this code and words, a regular expression; return what was raised."""
    with pytest.raises(AbilityError, match=words) as caught:
        yield caught
    assert caught.value.code is code
