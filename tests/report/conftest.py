"""Fixtures of the report's tests."""

import handmade_results
import pytest


@pytest.fixture(scope="session")
def make():
    """Function (scenario's name, changes of every phase) -> result."""
    return handmade_results.handmade


@pytest.fixture(scope="session")
def resting():
    """A penalty answer that does nothing, with another that reaches."""
    return handmade_results.resting()
